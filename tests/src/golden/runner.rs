//! Draws cases and judges them.

use std::{
    path::{Path, PathBuf},
    process::Command,
    time::Instant,
};

use serde_json::Value;

use super::{
    Case, CaseOutcome, Cases, CompareError, Comparison, Expected, GoldenError, Origin, Pictures, StageTime,
    Status, compare, heat_map,
};
use crate::{Mask, Pixels, Program, read_json};

/// The cases, their expectations and a program to draw them with.
pub struct Runner {
    /// What there is to draw.
    pub cases: Cases,
    expected: Expected,
    program: Program,
    out: PathBuf,
}

/// A drawn case.
struct Drawn {
    picture: Pixels,
    mask: Mask,
    report: Value,
}

impl Runner {
    /// `root`: this package's folder. `out`: where pictures for people go; made if missing.
    ///
    /// # Errors
    /// [`GoldenError::File`].
    pub fn new(root: &Path, binary: impl Into<PathBuf>, out: PathBuf) -> Result<Self, GoldenError> {
        let cases = Cases::read(&root.join("cases.toml"))?;
        let program = Program::new(binary);
        std::fs::create_dir_all(&out)
            .map_err(|e| GoldenError::File { path: out.clone(), message: e.to_string() })?;
        // Scene files, by the name that the flags of the cases give them.
        let scenes = root.join("scenes");
        let entries = std::fs::read_dir(&scenes)
            .map_err(|e| GoldenError::File { path: scenes.clone(), message: e.to_string() })?;
        for entry in entries.flatten() {
            let text = std::fs::read(entry.path())
                .map_err(|e| GoldenError::File { path: entry.path(), message: e.to_string() })?;
            program.write(&entry.file_name().to_string_lossy(), text);
        }
        Ok(Self { cases, expected: Expected::new(root.join("expected")), program, out })
    }

    /// Expected files that belong to no case.
    ///
    /// # Errors
    /// [`GoldenError::File`].
    pub fn stale(&self) -> Result<Vec<String>, GoldenError> {
        self.expected.stale(&self.cases.cases.iter().map(|case| case.name.as_str()).collect::<Vec<_>>())
    }

    /// Draws a case and compares it.
    pub fn check(&self, case: &Case) -> CaseOutcome {
        self.outcome(case, |outcome| {
            let drawn = self.draw(case)?;
            self.show(outcome, &drawn)?;
            match self.judge(case, &drawn, outcome)?.passed() {
                true => outcome.status = Status::Passed,
                false => outcome.status = Status::Failed,
            }
            Ok(())
        })
    }

    /// Draws a case and makes the picture what is expected from now on. The metrics are those against what was expected
    /// so far.
    pub fn update(&self, case: &Case) -> CaseOutcome {
        self.outcome(case, |outcome| {
            let drawn = self.draw(case)?;
            self.show(outcome, &drawn)?;
            if drawn.mask.area() == 0 {
                return Err(CompareError::NoWater.into());
            }
            // Without an old expectation, or with one of another size, there is nothing to compare with.
            if let Err(error) = self.judge(case, &drawn, outcome) {
                outcome.problem = Some(format!("was: {error}"));
            }
            let origin = Origin {
                name: case.name.clone(),
                command: case.render_arguments(&self.cases.size),
                driver: driver(&drawn.report),
                version: drawn.report["version"].as_str().unwrap_or_default().to_owned(),
                commit: commit(),
                date: said(Command::new("date").args(["-u", "+%F"])),
            };
            self.expected.store(&drawn.picture, &drawn.mask, origin.clone())?;
            outcome.made_by = Some(origin);
            outcome.status = Status::Updated;
            Ok(())
        })
    }

    fn outcome(
        &self,
        case: &Case,
        work: impl FnOnce(&mut CaseOutcome) -> Result<(), GoldenError>,
    ) -> CaseOutcome {
        let start = Instant::now();
        let commands = [case.make_arguments(), case.render_arguments(&self.cases.size)];
        let mut outcome = CaseOutcome {
            name: case.name.clone(),
            why: case.why.clone(),
            commands: commands.map(|arguments| format!("meniscus {arguments}")),
            status: Status::Failed,
            problem: None,
            metrics: Vec::new(),
            pictures: Pictures::default(),
            stages: Vec::new(),
            made_by: None,
            same_driver: false,
            elapsed_s: 0.0,
        };
        if let Err(error) = work(&mut outcome) {
            outcome.status = Status::Failed;
            outcome.problem = Some(error.to_string());
        }
        outcome.elapsed_s = start.elapsed().as_secs_f64();
        outcome
    }

    /// The picture as users get it, and a second one that shows where its water is.
    fn draw(&self, case: &Case) -> Result<Drawn, GoldenError> {
        if !self.program.path(&case.folder()).exists() {
            self.succeed(&case.make_arguments())?;
        }
        let render = case.render_arguments(&self.cases.size);
        let file = self.program.path(&format!("{}.png", case.name));
        let read =
            || Pixels::try_read(&file).map_err(|message| GoldenError::File { path: file.clone(), message });
        self.succeed(&format!("{render} --param post.transparent=true --param scene.floor=false -q"))?;
        let mask = Mask::of_alpha(&read()?);
        self.succeed(&format!("{render} --report report.json -q"))?;
        Ok(Drawn { picture: read()?, mask, report: read_json(&self.program.path("report.json")) })
    }

    fn succeed(&self, arguments: &str) -> Result<(), GoldenError> {
        let outcome = self.program.run(arguments);
        if outcome.code == Some(0) {
            return Ok(());
        }
        Err(GoldenError::Program {
            command: format!("meniscus {arguments}"),
            code: outcome.code.map_or("a signal".to_owned(), |code| format!("exit code {code}")),
            message: outcome.stderr.trim().to_owned(),
        })
    }

    fn judge(
        &self,
        case: &Case,
        drawn: &Drawn,
        outcome: &mut CaseOutcome,
    ) -> Result<Comparison, GoldenError> {
        let (picture, mask, origin) = self.expected.load(&case.name)?;
        outcome.pictures.expected = Some(self.put(&picture, &format!("{}.expected.png", case.name))?);
        outcome.same_driver = driver(&drawn.report) == origin.driver;
        outcome.made_by = Some(origin);
        let criteria = if outcome.same_driver { &self.cases.same_driver } else { &self.cases.other_driver };
        let comparison = compare((&drawn.picture, &drawn.mask), (&picture, &mask), criteria)?;
        let heat = heat_map(&comparison.flip, picture.size);
        outcome.pictures.flip = Some(self.put(&heat, &format!("{}.flip.png", case.name))?);
        outcome.metrics.clone_from(&comparison.metrics);
        Ok(comparison)
    }

    fn show(&self, outcome: &mut CaseOutcome, drawn: &Drawn) -> Result<(), GoldenError> {
        outcome.pictures.ours = Some(self.put(&drawn.picture, &format!("{}.png", outcome.name))?);
        let stages = drawn.report["frames"][0]["stages"].as_array().cloned().unwrap_or_default();
        let time = |stage: &Value| {
            let ms = stage["gpu_ms"].as_f64().or(stage["wall_ms"].as_f64())?;
            Some(StageTime { name: stage["name"].as_str()?.to_owned(), ms })
        };
        outcome.stages = stages.iter().filter_map(time).collect();
        Ok(())
    }

    fn put(&self, picture: &Pixels, name: &str) -> Result<String, GoldenError> {
        let path = self.out.join(name);
        picture.write(&path).map_err(|message| GoldenError::File { path, message })?;
        Ok(name.to_owned())
    }

    /// What every report says about driver and version.
    pub fn machine(&self) -> [String; 3] {
        let report = self.program.path("report.json");
        let report = if report.is_file() { read_json(&report) } else { Value::Null };
        let version = report["version"].as_str().unwrap_or_default().to_owned();
        [driver(&report), version, commit()]
    }
}

fn driver(report: &Value) -> String {
    let part = |key: &str| report["adapter"][key].as_str().unwrap_or("none").to_owned();
    format!("{}, {}", part("name"), part("driver"))
}

fn commit() -> String {
    said(Command::new("git").args(["describe", "--always", "--dirty"]))
}

/// What a program prints, `unknown` where it cannot be run: a source archive has no history.
fn said(command: &mut Command) -> String {
    let output = command.output().ok().filter(|output| output.status.success());
    let text = output.map(|output| String::from_utf8_lossy(&output.stdout).trim().to_owned());
    text.filter(|text| !text.is_empty()).unwrap_or_else(|| "unknown".to_owned())
}
