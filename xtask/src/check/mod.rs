//! `cargo xtask check`: what a reviewer should never have to say.

mod benches;
mod graph;
mod hygiene;
mod layers;
mod licences;
mod windowless;

use std::{path::Path, time::Instant};

use clap::{Args, ValueEnum};

use crate::{
    error::{Error, Result},
    process::{cargo, run as run_process},
    table,
};

/// Check formatting, lints, documentation, layers, licences and repository hygiene.
///
/// All checks run, even if one fails; a table closes. Exit code 0 only if all passed.
#[derive(Args)]
#[command(after_help = "Examples:\n  cargo xtask check\n  cargo xtask check layers licences")]
pub struct Options {
    /// The checks to run; all if none is named.
    checks: Vec<Check>,
}

/// One thing that can be checked alone.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Check {
    /// `cargo fmt --check`
    Fmt,
    /// Crates depend downwards only, no GPU in layer 0
    Layers,
    /// Every dependency's licence is on the allow list
    Licences,
    /// No large files, no paths of somebody's machine
    Hygiene,
    /// The program without the viewer has no window system in its dependencies
    Windowless,
    /// A stage's bench builds no other stage, and no window system
    Benches,
    /// Clippy on everything, warnings are errors
    Clippy,
    /// Rustdoc on everything, warnings are errors
    Rustdoc,
}

impl Check {
    fn name(self) -> String {
        self.to_possible_value().map(|value| value.get_name().to_owned()).unwrap_or_default()
    }

    /// The offences found; an error where the check itself could not be done.
    fn offences(self) -> Result<Vec<String>> {
        match self {
            Self::Fmt => passes(&mut cargo(["fmt", "--all", "--", "--check"])),
            Self::Layers => Ok(layers::offences(&graph::read(Path::new("."))?)),
            Self::Licences => Ok(licences::offences(&graph::read(Path::new("."))?)),
            Self::Hygiene => hygiene::offences_in_repository(),
            Self::Windowless => windowless::offences_of_program(),
            Self::Benches => benches::offences_of_benches(),
            Self::Clippy => {
                passes(&mut cargo(["clippy", "--workspace", "--all-targets", "--", "-D", "warnings"]))
            }
            Self::Rustdoc => {
                passes(cargo(["doc", "--workspace", "--no-deps"]).env("RUSTDOCFLAGS", "-D warnings"))
            }
        }
    }
}

/// Runs the chosen checks and prints a summary.
pub fn run(options: &Options) -> Result<()> {
    let chosen = match options.checks.as_slice() {
        [] => Check::value_variants(),
        checks => checks,
    };
    let mut rows = vec![["check", "result", "seconds"].map(String::from)];
    let mut failed = Vec::new();
    for check in chosen {
        let name = check.name();
        println!("== {name}");
        let start = Instant::now();
        let offences = check.offences().unwrap_or_else(|error| vec![error.to_string()]);
        for offence in &offences {
            println!("{name}: {offence}");
        }
        let result = if offences.is_empty() { "ok" } else { "FAILED" };
        rows.push([name.clone(), result.to_owned(), format!("{:.1}", start.elapsed().as_secs_f64())]);
        if !offences.is_empty() {
            failed.push(name);
        }
    }
    println!("\n{}", table::layout(&rows, [false, false, true]));
    match failed.len() {
        0 => Ok(()),
        count => Err(Error::Checks { failed: count, total: chosen.len(), names: failed.join(", ") }),
    }
}

/// A tool that prints its own findings is judged by its exit code.
fn passes(command: &mut std::process::Command) -> Result<Vec<String>> {
    run_process(command).map(|()| Vec::new())
}
