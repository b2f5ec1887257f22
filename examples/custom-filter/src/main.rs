//! `meniscus` with one more surface filter: `--filter plane-fit`.

use std::process::ExitCode;

use custom_filter::PlaneFit;
use meniscus_pipeline::Registry;

fn main() -> ExitCode {
    meniscus_cli::run(Registry::builtin().with_filter(PlaneFit::entry()))
}
