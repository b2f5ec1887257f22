//! Future frames, loaded ahead as far as free memory allows.
