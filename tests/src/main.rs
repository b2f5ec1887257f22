//! The program under test: what the `meniscus` package's own `main` does.

use std::process::ExitCode;

fn main() -> ExitCode {
    meniscus::run(meniscus_pipeline::Registry::builtin())
}
