//! Builds everything once, draws the pictures, runs the groups.

use std::{
    path::{Path, PathBuf},
    process::Command,
    time::Instant,
};

use cargo_metadata::{Message, camino::Utf8Path};

use super::{
    groups,
    images::{self, Images},
};
use crate::{
    error::{Error, Result},
    prerequisites,
    process::{capture, cargo, shown, stream},
    test::report::{Report, Totals},
};

/// Environment for the programs that draw.
type Variables = [(&'static str, String)];

/// Draws and compares the pictures.
const PROGRAM: &str = "image-cases";

/// What is asked for.
pub struct Plan<'a> {
    pub workspace: &'a Utf8Path,
    /// Where pictures go.
    pub folder: PathBuf,
    /// All without.
    pub cases: &'a [String],
    pub update: bool,
    pub install: bool,
}

/// What was found.
#[derive(Debug, Default)]
pub struct Findings {
    /// What was asked for, where that is not everything: a part that is sound is not the whole.
    pub part: Option<String>,
    /// Why something could not be run at all.
    pub problems: Vec<String>,
    pub images: Option<Images>,
    /// `None` where only pictures were asked for.
    pub tests: Option<Report>,
    pub elapsed_s: f64,
}

impl Findings {
    /// Over pictures, tests and what could not be run.
    pub fn totals(&self) -> Totals {
        let (passed, failed) = self.images.as_ref().map_or((0, 0), Images::counts);
        let mut sum = Totals { passed, failed: failed + self.problems.len(), skipped: 0 };
        if let Some(tests) = &self.tests {
            sum.add(tests.totals());
        }
        sum
    }

    /// Whether something was checked and nothing was wrong.
    pub fn is_success(&self) -> bool {
        let Totals { passed, failed, .. } = self.totals();
        passed > 0 && failed == 0
    }
}

impl Plan<'_> {
    /// Runs it. What cannot be run is a finding like any other: the report is to say so.
    pub fn run(&self) -> Findings {
        let start = Instant::now();
        let mut findings = Findings { part: self.part(), ..Findings::default() };
        if let Err(error) = self.fill(&mut findings) {
            findings.problems.push(error.to_string());
        }
        findings.elapsed_s = start.elapsed().as_secs_f64();
        findings
    }

    fn only_pictures(&self) -> bool {
        self.update || !self.cases.is_empty()
    }

    fn part(&self) -> Option<String> {
        let cases = match self.cases {
            [] => "all image cases".to_owned(),
            cases => format!("the image cases {}", cases.join(", ")),
        };
        match self.update {
            true => Some(format!("{cases}, to become what is expected; no tests")),
            false => self.only_pictures().then(|| format!("only {cases}; no other images, no tests")),
        }
    }

    fn fill(&self, findings: &mut Findings) -> Result<()> {
        let variables = prerequisites::ensure(self.workspace.as_std_path(), self.install)?;
        let program = self.build()?;

        self.draw(&program, &variables, findings)?;
        if !self.only_pictures() {
            let mut command = cargo(["test", "--no-fail-fast", "--color", "never"]);
            command.args(groups::arguments()).args(["--", "--show-output"]);
            command.current_dir(self.workspace).envs(variables);
            let report = findings.tests.insert(Report::default());
            let status = stream(&mut command, |line| {
                if let Some(shown) = report.read(line) {
                    println!("{shown}");
                }
            })?;
            report.end_invocation(status.success());
            for group in groups::GROUPS {
                let missing = group.missing(report).into_iter();
                findings
                    .problems
                    .extend(missing.map(|target| format!("{}: {target} did not run", group.title)));
            }
        }
        Ok(())
    }

    fn draw(&self, program: &Path, variables: &Variables, findings: &mut Findings) -> Result<()> {
        // What an earlier run left would pass for this one's.
        let _ = std::fs::remove_file(self.folder.join(images::FILE));
        let mut command = Command::new(program);
        command.arg("--out").arg(&self.folder).args(self.update.then_some("--update")).args(self.cases);
        command.current_dir(self.workspace).envs(variables.iter().cloned());
        let mut said = Vec::new();
        let status = stream(&mut command, |line| {
            println!("{line}");
            said.extend(
                line.strip_prefix(PROGRAM).and_then(|line| line.strip_prefix(": ")).map(String::from),
            );
        })?;
        match Images::read(&self.folder) {
            Ok(images) => {
                // It fails when a picture does, which is in the file.
                let untold = !status.success() && images.counts().1 == 0;
                findings.problems.extend(untold.then(|| format!("{PROGRAM}: {status}, {}", said.join(", "))));
                findings.images = Some(images);
            }
            Err(_) if !said.is_empty() => findings.problems.extend(said),
            Err(error) => findings.problems.push(format!("{PROGRAM} left no figures ({status}): {error}")),
        }
        Ok(())
    }

    /// The program that draws, built by the command that builds the tests.
    fn build(&self) -> Result<PathBuf> {
        let mut command = cargo(["test", "--no-run", "--message-format", "json-render-diagnostics"]);
        match self.only_pictures() {
            true => command.args(groups::arguments_beside_programs()),
            false => command.args(groups::arguments()),
        };
        command.current_dir(self.workspace);
        println!("$ {}", shown(&command));
        let output = capture(&mut command)?;
        let executable = |message| match message {
            Message::CompilerArtifact(artifact)
                if artifact.target.name == PROGRAM && !artifact.profile.test =>
            {
                artifact.executable
            }
            _ => None,
        };
        let found = Message::parse_stream(output.as_slice()).flatten().find_map(executable);
        found.map(PathBuf::from).ok_or(Error::NoProgram(PROGRAM))
    }
}
