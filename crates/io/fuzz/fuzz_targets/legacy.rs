#![no_main]
//! Legacy files.

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| meniscus_io_fuzz::open("fuzz.vtk", bytes));
