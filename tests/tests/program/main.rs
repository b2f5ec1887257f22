//! The program as users run it: command lines in, files, texts and exit codes out.

mod absurd;
mod adapters;
mod bench;
mod colors;
mod compare;
mod convert;
mod counters;
mod detail;
mod errors;
mod exposure;
mod films;
mod help;
mod info;
mod interrupt;
mod layers;
mod look;
mod metering;
mod overlays;
mod parameters;
mod playback;
mod report;
mod same_bytes;
mod selection;
mod sequence;
mod shadows;
mod terrain;
mod trace;
mod walls;

use meniscus_tests::Program;

/// The program in an empty folder.
fn program() -> Program {
    Program::new(env!("CARGO_BIN_EXE_meniscus-under-test"))
}

/// The program in a folder with a dam break of some particles: `dam/dam_break.pvd` and its frames `dam/dam_break_0000.vtu`,
/// `_0001`, ...
fn program_with_dam(particles: u32, frames: u32) -> Program {
    let program = program();
    program.run(&format!("make dam-break -o dam --particles {particles} --frames {frames} -q")).ok();
    program
}
