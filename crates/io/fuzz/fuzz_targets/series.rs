#![no_main]
//! Collections, lists and parallel files, beside two sound frames `a.vtu` and `b.vtu` that they may name.

use std::sync::Once;

const SOUND: &str = "<VTKFile type='PolyData'><PolyData><Piece NumberOfPoints='2'><Points>\
    <DataArray type='Float32' NumberOfComponents='3' format='ascii'>0 0 0 1 2 3</DataArray>\
    </Points></Piece></PolyData></VTKFile>";

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        for name in ["a.vtu", "b.vtu"] {
            std::fs::write(meniscus_io_fuzz::folder().join(name), SOUND).expect("a file in memory");
        }
    });
    meniscus_io_fuzz::open("fuzz.pvd", bytes);
});
