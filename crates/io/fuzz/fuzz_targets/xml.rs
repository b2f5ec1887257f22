#![no_main]
//! VTK XML files: grids and poly data in every encoding.

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| meniscus_io_fuzz::open("fuzz.vtu", bytes));
