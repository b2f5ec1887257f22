//! `cargo xtask e2e`: is what comes out still right? Pictures, twins, the program, data; with a report to look at.

mod groups;
mod html;
mod images;
mod run;
mod summary;

use std::{path::Path, process::Command};

use cargo_metadata::MetadataCommand;
use clap::Args;

use crate::{
    error::{Error, Result},
    process, sabotage,
    test::report::Totals,
};
use run::{Findings, Plan};

/// Draw the image cases, compare them with what is expected, and run the end-to-end tests.
///
/// Pictures (tests/cases.toml) are compared with tests/expected by FLIP, structural similarity and the
/// area that shows water. Then come the tests of the stages against their twins on the processor, of
/// the chain, of the command line, of memory and of the data. With CASE or --update only pictures are
/// drawn.
///
/// Leaves target/e2e/index.html, one file to open, mail or attach: pictures beside what is expected,
/// differences, limits with their reasons, failed ones first. Prints a table and, alone on the last
/// line, `N passed, N failed, N skipped`. Exit code 0 only if something passed and nothing failed; a
/// missing adapter and a missing expected image are failures.
///
/// --sabotage asks whether the tests can fail: it makes the mistakes listed in tests/sabotage/ one at a
/// time, in a copy of the working tree (target/sabotage), and looks whether a test notices. First the
/// tests have to pass without any mistake; one that does not compile counts as broken, one that makes
/// a test hang as caught. Prints who caught what and, alone on the last line, `N caught, N not caught,
/// N broken`; exit code 0 only if all were caught. The first run compiles for a quarter of an hour,
/// later ones take a few seconds per mistake.
#[derive(Args)]
#[command(
    verbatim_doc_comment,
    after_help = "Examples:\n  \
    cargo xtask e2e\n  \
    cargo xtask e2e dam-break-late dam-break-lod\n  \
    cargo xtask e2e --update dam-break-late\n  \
    cargo xtask e2e --sabotage\n  \
    cargo xtask e2e --sabotage culling-off absorption-sign\n  \
    cargo xtask e2e --sabotage --list"
)]
pub struct Options {
    /// Draw only these cases, and run no tests
    #[arg(value_name = "CASE")]
    cases: Vec<String>,

    /// Make what is drawn the expected images, of CASE or of all; look at them before you commit
    #[arg(long)]
    update: bool,

    /// Make mistakes on purpose and see whether a test notices: only these, or all
    #[arg(long, value_name = "NAME", num_args = 0.., conflicts_with_all = ["cases", "update"])]
    sabotage: Option<Vec<String>>,

    /// With --sabotage: only say what each mistake would break
    #[arg(long, requires = "sabotage")]
    list: bool,

    /// Install missing Debian packages (with sudo, unless root)
    #[arg(long)]
    install: bool,
}

/// Runs it all and reports.
pub fn run(options: &Options) -> Result<()> {
    if let Some(names) = &options.sabotage {
        return sabotage::run(&sabotage::Options {
            names: names.clone(),
            list: options.list,
            install: options.install,
        });
    }
    let metadata = MetadataCommand::new().no_deps().exec()?;
    let folder = metadata.target_directory.join("e2e").into_std_path_buf();
    let page = folder.join("index.html");
    std::fs::create_dir_all(&folder).map_err(|source| Error::File { path: folder.clone(), source })?;
    // A run that is interrupted leaves no report rather than an old one.
    let _ = std::fs::remove_file(&page);
    let plan = Plan {
        workspace: &metadata.workspace_root,
        folder: folder.clone(),
        cases: &options.cases,
        update: options.update,
        install: options.install,
    };
    let findings = plan.run();
    let html = html::page(&findings, &date(), &|name| std::fs::read(folder.join(name)).ok());
    std::fs::write(&page, html).map_err(|source| Error::File { path: page.clone(), source })?;
    conclude(&findings, &page)
}

/// Day and minute, UTC; `unknown` where there is no `date`.
fn date() -> String {
    let text = process::capture(Command::new("date").args(["-u", "+%F %H:%M UTC"]));
    text.map_or("unknown".to_owned(), |text| String::from_utf8_lossy(&text).trim().to_owned())
}

fn conclude(findings: &Findings, page: &Path) -> Result<()> {
    println!("\n{}", summary::table(findings));
    for failure in summary::failures(findings) {
        println!("FAILED  {}", failure.in_words());
    }
    println!("{:.0} s in all; report: {}", findings.elapsed_s, page.display());
    let Totals { passed, failed, skipped } = findings.totals();
    if passed + failed == 0 {
        println!("nothing was checked, which is no success");
    }
    println!("{passed} passed, {failed} failed, {skipped} skipped");
    if findings.is_success() { Ok(()) } else { Err(Error::TestsReported) }
}
