//! Same input, same bytes.

use crate::{program, program_with_dam};

#[test]
fn pictures_are_the_same_byte_by_byte_whatever_the_threads() {
    // Enough particles for several chunks and for sums of many splats per pixel.
    let program = program_with_dam(20_000, 2);
    let bytes = |flags: &str| {
        program.run(&format!("render dam/dam_break.pvd --size 160x90 -o o_%d.png {flags}")).ok();
        [0, 1].map(|frame| std::fs::read(program.path(&format!("o_{frame}.png"))).expect("a picture"))
    };
    let first = bytes("");
    assert!(first[0] != first[1], "two frames, two pictures");
    for flags in ["", "--threads 1", "--threads 2", "--report r.json"] {
        assert!(bytes(flags) == first, "{flags}");
    }
    assert!(bytes("--foam 1") == bytes("--foam 1 --threads 1"), "foam");
    assert!(bytes("--lod 0.5") == bytes("--lod 0.5 --threads 1"), "level of detail");
    // No picture depends on those before it.
    program.run("render dam/dam_break.pvd --size 160x90 -o alone.png --frame 1").ok();
    assert!(std::fs::read(program.path("alone.png")).expect("a picture") == first[1]);
}

#[test]
fn made_particles_are_the_same_byte_by_byte_whatever_the_threads() {
    let program = program();
    let bytes = |flags: &str| {
        program.run(&format!("make sphere-entry -o d --particles 5000 -q {flags}")).ok();
        std::fs::read(program.path("d/sphere_entry_0000.vtu")).expect("a frame")
    };
    let first = bytes("");
    assert!(bytes("--threads 1") == first && bytes("--threads 2") == first);
    assert!(bytes("--seed 2") != first);
}
