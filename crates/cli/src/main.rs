//! The `meniscus` program.

use std::process::ExitCode;

fn main() -> ExitCode {
    meniscus_cli::run(meniscus_cli::Registry::builtin())
}
