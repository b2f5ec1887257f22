//! GPU base: adapter, typed buffers, pass recorder, shader imports.
