//! Draws the image cases with the program beside this one, compares them and writes pictures and figures into a folder.
//!
//!     cargo run -p meniscus-tests --bin meniscus-under-test -- --version && \
//!     cargo run -p meniscus-tests --bin image-cases -- --out target/e2e
#![expect(clippy::print_stdout, clippy::print_stderr, reason = "a program; printing is its job")]

use std::{error::Error, path::PathBuf, process::ExitCode};

use clap::Parser;
use meniscus_tests::golden::{CaseOutcome, RunOutcome, Runner, Status};

/// Draw image cases and compare them with the expected images.
#[derive(Parser)]
struct Arguments {
    /// Folder for pictures and `images.json`
    #[arg(long)]
    out: PathBuf,

    /// Make what is drawn the expected images
    #[arg(long)]
    update: bool,

    /// Cases [default: all]
    cases: Vec<String>,
}

fn main() -> ExitCode {
    match run(&Arguments::parse()) {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(error) => {
            eprintln!("image-cases: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run(arguments: &Arguments) -> Result<bool, Box<dyn Error>> {
    let program = std::env::current_exe()?.with_file_name("meniscus-under-test");
    let root = PathBuf::from(env!("CARGO_MANIFEST_DIR"));
    let runner = Runner::new(&root, program, arguments.out.clone())?;
    let mut cases = Vec::new();
    for case in runner.cases.choose(&arguments.cases)? {
        let outcome = if arguments.update { runner.update(case) } else { runner.check(case) };
        print(&outcome);
        cases.push(outcome);
    }
    let stale = runner.stale()?;
    for file in &stale {
        println!("FAILED   tests/expected: {file} belongs to no case; delete it");
    }
    let [driver, version, commit] = runner.machine();
    let outcome = RunOutcome { driver, version, commit, cases, stale };
    std::fs::write(arguments.out.join("images.json"), serde_json::to_string_pretty(&outcome)?)?;
    Ok(outcome.passed())
}

fn print(outcome: &CaseOutcome) {
    let status = match outcome.status {
        Status::Passed => "passed ",
        Status::Failed => "FAILED ",
        Status::Updated => "updated",
    };
    let metrics = outcome.metrics.iter().map(|m| {
        let mark = if m.passed { "" } else { "!" };
        format!("{} {:.4}{mark} ({:.4})", m.name, m.value, m.limit)
    });
    println!("{status}  {:<28} {}", outcome.name, metrics.collect::<Vec<_>>().join("  "));
    if let Some(problem) = &outcome.problem {
        println!("         {problem}");
    }
}
