//! Continuous level of detail: chunks, culling, kept ranges.
