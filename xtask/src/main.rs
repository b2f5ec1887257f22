//! The commands that people and CI run: `cargo xtask check`, `test`, `e2e`, `bench` and so on.
//!
//! CI has no steps of its own: what it runs can be run, with the same words, on any developer's machine.

#![forbid(unsafe_code)]
#![expect(clippy::print_stdout, clippy::print_stderr, reason = "xtask is a program; printing is its job")]

mod bench;
mod check;
mod demo;
mod drivers;
mod e2e;
mod error;
mod machine;
mod peers;
mod prerequisites;
mod process;
mod sabotage;
mod table;
mod test;

use std::process::ExitCode;

use clap::{Parser, Subcommand};

/// The commands that people and CI run.
#[derive(Parser)]
#[command(name = "cargo xtask", bin_name = "cargo xtask")]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    Bench(bench::Options),
    Check(check::Options),
    Test(test::Options),
    E2e(e2e::Options),
    Demo(demo::Options),
    Peers(peers::Options),
}

fn main() -> ExitCode {
    let outcome = match Arguments::parse().command {
        Command::Bench(options) => bench::run(&options),
        Command::Check(options) => check::run(&options),
        Command::Test(options) => test::run(&options),
        Command::Demo(options) => demo::run(&options),
        Command::Peers(options) => peers::run(&options),
        Command::E2e(options) => e2e::run(&options),
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(error::Error::TestsReported) => ExitCode::FAILURE,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    #[test]
    fn the_command_line_is_well_formed() {
        super::Arguments::command().debug_assert();
    }
}
