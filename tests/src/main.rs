//! The program under test: what the `meniscus` package's own `main` does.

use std::process::ExitCode;

fn main() -> ExitCode {
    meniscus_cli::run(meniscus_cli::Registry::builtin())
}
