//! `cargo xtask test`: everything CI needs to know, in one command.

mod lines;
mod plan;
pub mod report;

pub use lines::Ending;

use std::time::Instant;

use cargo_metadata::MetadataCommand;
use clap::Args;

use crate::{
    error::{Error, Result},
    prerequisites,
    process::{cargo, stream},
};
use report::Report;

/// Run all tests, after making sure that there is a Vulkan driver to run them on.
///
/// Runs `cargo test --workspace --all-targets` and the documentation tests, then prints a table over all test
/// binaries and, alone on the last line, `N passed, N failed, N skipped`. Exit code 0 only if at least one test passed
/// and none failed.
///
/// A test that cannot do its work on this machine prints a line that starts with `SKIPPED:`, with the reason
/// after it, and returns; it then counts as skipped, not as passed.
///
/// Where the driver is missing, the apt-get line is printed; with --install, or as root, it is run.
#[derive(Args)]
#[command(after_help = "Examples:\n  \
    cargo xtask test\n  \
    cargo xtask test --install\n  \
    cargo xtask test -p meniscus-io\n  \
    cargo xtask test -p meniscus-ssfr thickness -- --test-threads 1")]
pub struct Options {
    /// Install missing Debian packages (with sudo, unless root)
    #[arg(long)]
    install: bool,

    /// Passed on to `cargo test`; after `--`, to the test binaries
    #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
    arguments: Vec<String>,
}

/// Runs the tests and reports.
pub fn run(options: &Options) -> Result<()> {
    let start = Instant::now();
    let metadata = MetadataCommand::new().no_deps().exec()?;
    let variables = prerequisites::ensure(metadata.workspace_root.as_std_path(), options.install)?;

    let mut report = Report::default();
    for arguments in plan::invocations(&options.arguments) {
        let mut command = cargo(&arguments);
        command.current_dir(&metadata.workspace_root).envs(variables.iter().cloned());
        let status = stream(&mut command, |line| {
            if let Some(shown) = report.read(line) {
                println!("{shown}");
            }
        })?;
        report.end_invocation(status.success());
        if report.could_not_build() {
            break;
        }
    }

    println!("\n{}{:.0} s in all\n", report.table(), start.elapsed().as_secs_f64());
    let totals = report.totals();
    // Skipped tests have checked nothing: a machine that skips them all must not pass for a sound one.
    let nothing_ran = totals.passed + totals.failed == 0;
    if nothing_ran {
        println!(
            "no test ran to its end, which is no success: is the name filter right, are the data there?"
        );
    }
    println!("{} passed, {} failed, {} skipped", totals.passed, totals.failed, totals.skipped);
    if totals.failed > 0 || nothing_ran { Err(Error::TestsReported) } else { Ok(()) }
}
