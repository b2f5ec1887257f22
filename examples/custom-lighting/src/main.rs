//! `meniscus` with one more lighting model: `--lighting chart`.

use std::process::ExitCode;

use custom_lighting::Chart;
use meniscus_pipeline::Registry;

fn main() -> ExitCode {
    meniscus_cli::run(Registry::builtin().with_lighting(Chart::NAME, Chart::make))
}
