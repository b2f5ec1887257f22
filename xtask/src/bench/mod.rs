//! `cargo xtask bench`: what each stage costs, and whether that has changed.

mod baselines;
mod record;
mod report;

use cargo_metadata::{Metadata, MetadataCommand, TargetKind};
use clap::Args;

use crate::{
    error::{Error, Result},
    prerequisites,
    process::{cargo, run as run_process},
};
use baselines::Baselines;

/// Measure what each stage costs: wall, CPU and GPU time, bytes moved, share of the copy bandwidth.
///
/// Runs the criterion benches of one stage or of all of them, each on its committed inputs
/// (`benches/`), and prints a table:
///
///   wall ms    median over the samples; for GPU passes with submission and waiting
///   CPU ms     user + system time of all threads, the figure to trust on a busy machine
///   GPU ms     time stamps; '-' where the driver's cannot be trusted, and without a GPU
///   MB, GB/s   what the work has to read and write at least; by GPU time, else by wall time
///   % of copy  that rate over the rate of a plain copy on the same device in the same run
///
/// --save keeps the figures under a name, --baseline compares with them: new over old, below 1 is
/// faster, in brackets the range that the middle halves of the samples allow; a change is called
/// one only where that range leaves out 1. Whatever the times, the exit code is 0. Baselines are
/// under target/bench/baselines, criterion's own under target/criterion.
///
/// A STAGE is a package of the workspace with benches, without its `bench-`: also one of yours.
#[derive(Args)]
#[command(
    verbatim_doc_comment,
    after_help = "Examples:\n  \
    cargo xtask bench\n  \
    cargo xtask bench ssfr-filter --save before\n  \
    cargo xtask bench ssfr-filter --baseline before\n  \
    cargo xtask bench io --quick\n  \
    cargo xtask bench custom-filter"
)]
pub struct Options {
    /// The stage to measure; all without
    stage: Option<String>,

    /// Compare with the figures saved under this name
    #[arg(long, value_name = "NAME", value_parser = baselines::name)]
    baseline: Option<String>,

    /// Save the figures under this name
    #[arg(long, value_name = "NAME", value_parser = baselines::name)]
    save: Option<String>,

    /// Measure for a second or less per bench: good for a look, not for a claim
    #[arg(long)]
    quick: bool,

    /// Install missing Debian packages (with sudo, unless root)
    #[arg(long)]
    install: bool,
}

/// A package with benches.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Stage {
    name: String,
    package: String,
    targets: Vec<String>,
}

/// Measures, compares and saves.
pub fn run(options: &Options) -> Result<()> {
    let metadata = MetadataCommand::new().no_deps().exec()?;
    let stages = chosen(stages(&metadata), options.stage.as_deref())?;
    let folder = metadata.target_directory.join("bench");
    let baselines = Baselines(folder.join("baselines").into());
    let names: Vec<_> = stages.iter().map(|stage| stage.name.as_str()).collect();
    // Before anything is built: nobody should wait minutes for a typing error.
    let baseline = options.baseline.as_deref().map(|name| baselines.load(name, &names)).transpose()?;
    let variables = prerequisites::ensure(metadata.workspace_root.as_std_path(), options.install)?;
    run_process(cargo(arguments(&stages)).arg("--no-run").current_dir(&metadata.workspace_root))?;
    println!("{}", crate::machine::state());

    std::fs::create_dir_all(&folder).map_err(|source| Error::File { path: folder.clone().into(), source })?;
    let run = folder.join("run.jsonl");
    // Benches append; what an earlier run left is not of this one.
    std::fs::write(&run, "").map_err(|source| Error::File { path: run.clone().into(), source })?;
    let mut command = cargo(arguments(&stages));
    command.arg("--").args(options.criterion_arguments());
    command.current_dir(&metadata.workspace_root).envs(variables.iter().cloned());
    run_process(command.env("MENISCUS_BENCH_RECORDS", &run))?;
    let records = baselines::read(run.as_std_path())?;
    if let Some(stage) = stages.iter().find(|stage| records.iter().all(|record| record.stage != stage.name)) {
        return Err(Error::NothingMeasured { package: stage.package.clone(), stage: stage.name.clone() });
    }
    if let Some(name) = &options.save {
        baselines.save(name, &records)?;
    }

    println!("\n{}\n\n{}", report::devices(&records), report::table(&records));
    if let (Some(name), Some(baseline)) = (&options.baseline, &baseline) {
        println!("over '{name}', below 1 is faster:\n\n{}", report::comparison(&records, baseline));
    }
    if let Some(name) = &options.save {
        println!("saved as '{name}'; compare with: cargo xtask bench --baseline {name}");
    }
    Ok(())
}

impl Options {
    /// Criterion can save or compare, not both; our own table compares in any case.
    fn criterion_arguments(&self) -> Vec<&str> {
        let mut arguments = match (&self.save, &self.baseline) {
            (Some(name), _) => vec!["--save-baseline", name],
            // Lenient: benches that are new have nothing to be compared with.
            (None, Some(name)) => vec!["--baseline-lenient", name],
            (None, None) => vec![],
        };
        if self.quick {
            arguments.push("--quick");
        }
        arguments
    }
}

/// One command, so that what the stages share is built once. Targets are named one by one: the unit tests of a package are
/// benches too, as far as cargo is concerned.
fn arguments(stages: &[Stage]) -> Vec<&str> {
    let of_stage = |stage| {
        let Stage { package, targets, .. }: &Stage = stage;
        let targets = targets.iter().flat_map(|target| ["--bench", target.as_str()]);
        ["--package", package.as_str()].into_iter().chain(targets)
    };
    std::iter::once("bench").chain(stages.iter().flat_map(of_stage)).collect()
}

/// Every package of the workspace with benches, by name.
fn stages(metadata: &Metadata) -> Vec<Stage> {
    let benches = |package: &cargo_metadata::Package| -> Vec<String> {
        let targets = package.targets.iter().filter(|target| target.kind.contains(&TargetKind::Bench));
        targets.map(|target| target.name.clone()).collect()
    };
    let mut stages: Vec<Stage> = metadata
        .workspace_packages()
        .into_iter()
        .map(|package| Stage {
            name: package.name.strip_prefix("bench-").unwrap_or(&package.name).to_owned(),
            package: package.name.to_string(),
            targets: benches(package),
        })
        .filter(|stage| !stage.targets.is_empty())
        .collect();
    stages.sort_by(|a, b| a.name.cmp(&b.name));
    stages
}

/// The stage called `name`, or all of them.
fn chosen(stages: Vec<Stage>, name: Option<&str>) -> Result<Vec<Stage>> {
    let Some(name) = name else { return Ok(stages) };
    let is_named = |stage: &&Stage| stage.name == name || stage.package == name;
    match stages.iter().find(is_named) {
        Some(stage) => Ok(vec![stage.clone()]),
        None => Err(Error::NoSuchStage {
            name: name.to_owned(),
            stages: stages.iter().map(|stage| stage.name.as_str()).collect::<Vec<_>>().join(", "),
        }),
    }
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::*;

    #[derive(Parser)]
    struct Line {
        #[command(flatten)]
        options: Options,
    }

    fn criterion_arguments(line: &str) -> String {
        let line = Line::parse_from(format!("bench {line}").split_whitespace());
        line.options.criterion_arguments().join(" ")
    }

    fn stage(name: &str) -> Stage {
        Stage { name: name.into(), package: format!("bench-{name}"), targets: vec![name.into()] }
    }

    #[test]
    fn criterion_saves_or_compares() {
        assert_eq!(criterion_arguments("io"), "");
        assert_eq!(criterion_arguments("--save a --quick"), "--save-baseline a --quick");
        assert_eq!(criterion_arguments("--baseline a"), "--baseline-lenient a");
        assert_eq!(criterion_arguments("--baseline a --save b"), "--save-baseline b");
    }

    #[test]
    fn stages_are_found_by_either_name_and_others_are_listed() {
        let all = vec![stage("io"), stage("lod")];
        assert_eq!(chosen(all.clone(), None).unwrap(), all);
        assert_eq!(chosen(all.clone(), Some("lod")).unwrap(), [stage("lod")]);
        assert_eq!(chosen(all.clone(), Some("bench-io")).unwrap(), [stage("io")]);
        let error = chosen(all, Some("foam")).unwrap_err().to_string();
        assert!(error.contains("foam") && error.contains("io, lod"), "{error}");
        assert_eq!(arguments(&[stage("io")]), ["bench", "--package", "bench-io", "--bench", "io"]);
    }

    #[test]
    fn this_workspace_has_a_bench_for_every_stage() {
        let stages = stages(&MetadataCommand::new().no_deps().exec().unwrap());
        let names: Vec<_> = stages.iter().map(|stage| stage.name.as_str()).collect();
        for expected in [
            "io",
            "prefetch",
            "lod",
            "anisotropy",
            "ssfr-splat",
            "raster",
            "ssfr-filter",
            "shading",
            "compositor",
            "export",
        ] {
            assert!(names.contains(&expected), "no bench for {expected} among {names:?}");
        }
    }
}
