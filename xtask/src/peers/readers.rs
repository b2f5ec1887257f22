//! VTK's readers against ours.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::{
    fluid::Files,
    samples::{Samples, median, ratio},
    tool::{Tools, json},
};
use crate::{
    error::{Error, Result},
    process,
};

/// A tool's times over a file.
#[derive(Debug, Deserialize, Serialize)]
pub struct Reading {
    pub bytes: u64,
    pub points: u64,
    #[serde(flatten)]
    pub samples: Samples,
}

/// All tools over one file.
#[derive(Debug, Serialize)]
pub struct Readings {
    pub format: &'static str,
    pub file: PathBuf,
    /// By name, in the order of the table; `None` where the tool is not there.
    pub tools: Vec<(&'static str, Option<Reading>)>,
}

/// Arguments of `bench-peers read`, by name.
const OURS: [(&str, &[&str]); 6] = [
    ("copy", &["--tool", "copy"]),
    ("ours, none", &[]),
    ("ours, none, 2 threads", &["--threads", "2"]),
    ("ours, all", &["--all"]),
    ("ours, all, 2 threads", &["--all", "--threads", "2"]),
    ("ours, open", &["--tool", "open", "--threads", "2"]),
];

const THEIRS: [(&str, &[&str]); 2] = [("VTK, none", &["--none"]), ("VTK, all", &[])];

/// Reads the dam break in every format.
pub fn compare(tools: &Tools, folder: &Path, divide: u64) -> Result<Vec<Readings>> {
    let folder = folder.join(if divide > 1 { "dam-break-quick" } else { "dam-break" });
    let mut make = tools.ours("bench-peers");
    let files: Files =
        json(make.args(["make", "dam-break", "--encodings", "--divide", &divide.to_string()]).arg(&folder))?;
    let mut formats = vec![
        ("raw VTU", files.raw.clone()),
        ("zlib VTU", files.zlib.clone()),
        ("legacy binary", files.legacy.clone()),
    ];
    for (format, name, mode) in [
        ("base64 VTU", "base64.vtu", "base64"),
        ("ASCII VTU", "ascii.vtu", "ascii"),
        ("legacy ASCII", "ascii.vtk", "ascii"),
    ] {
        let path = folder.join(name);
        let Some(mut vtk) = tools.script("vtk_files.py") else { continue };
        let modified = |path: &Path| std::fs::metadata(path).and_then(|file| file.modified()).ok();
        if modified(&path) < modified(&files.raw) {
            process::run(vtk.arg(&files.raw).arg("--write").arg(&path).args(["--mode", mode]))?;
        }
        formats.push((format, path));
    }
    formats.into_iter().map(|(format, file)| read(tools, format, file)).collect()
}

fn read(tools: &Tools, format: &'static str, file: PathBuf) -> Result<Readings> {
    let mut results = Vec::new();
    for (name, arguments) in OURS {
        let mut ours = tools.ours("bench-peers");
        results.push((name, Some(json::<Reading>(ours.arg("read").arg(&file).args(arguments))?)));
    }
    for (name, arguments) in THEIRS {
        let vtk = tools.script("vtk_files.py");
        let reading = vtk.map(|mut vtk| json::<Reading>(vtk.arg(&file).args(arguments))).transpose()?;
        results.push((name, reading));
    }
    let readings = Readings { format, file, tools: results };
    readings.check()?;
    Ok(readings)
}

impl Readings {
    /// Whoever reads less than the others is fast for no reason.
    fn check(&self) -> Result<()> {
        // Copying and opening look at no points; no reader may find none.
        let readers = self.tools.iter().filter(|(name, _)| !["copy", "ours, open"].contains(name));
        let points: Vec<u64> = readers.filter_map(|(_, reading)| Some(reading.as_ref()?.points)).collect();
        match points.iter().all(|count| *count == points[0]) {
            true => Ok(()),
            false => Err(Error::UnlikePeers { file: self.file.clone(), points }),
        }
    }

    fn samples(&self, tool: &str) -> Option<&Samples> {
        let (_, reading) = self.tools.iter().find(|(name, _)| *name == tool)?;
        Some(&reading.as_ref()?.samples)
    }

    /// CPU time of theirs over that of ours.
    fn cpu_ratio(&self, theirs: &str, ours: &str) -> String {
        let both = self.samples(theirs).zip(self.samples(ours));
        let times = both.and_then(|(theirs, ours)| ratio(&theirs.cpu_ms, &ours.cpu_ms));
        times.map_or_else(|| "-".to_owned(), |times| format!("{times:.1}x"))
    }

    /// Bytes of the file per second of the median run, MB/s by wall and by CPU time.
    fn rate(&self, tool: &str) -> String {
        let reading =
            self.tools.iter().find(|(name, _)| *name == tool).and_then(|(_, reading)| reading.as_ref());
        let rate = |reading: &Reading, ms: &[f64]| {
            let ms = median(ms).filter(|ms| *ms > 0.0);
            ms.map_or_else(|| "-".to_owned(), |ms| format!("{:.0}", reading.bytes as f64 * 1e-3 / ms))
        };
        let both = |reading: &Reading| {
            format!(
                "{} / {}",
                rate(reading, &reading.samples.wall_ms),
                rate(reading, &reading.samples.cpu_ms)
            )
        };
        reading.map_or_else(|| "-".to_owned(), both)
    }
}

/// Ready for `benches/RESULTS.md`.
pub fn markdown(files: &[Readings]) -> String {
    let Some(first) = files.first() else { return String::new() };
    let mut text =
        "MB of file per second, by wall / by CPU time; none: positions without attributes\n\n|".to_owned();
    for format in std::iter::once("").chain(files.iter().map(|readings| readings.format)) {
        text += &format!(" {format} |");
    }
    text += &format!("\n|{}\n", "---|".repeat(files.len() + 1));
    let mut row = |name: &str, cell: &dyn Fn(&Readings) -> String| {
        text += &format!("| {name} |");
        files.iter().for_each(|readings| text += &format!(" {} |", cell(readings)));
        text.push('\n');
    };
    for (tool, _) in &first.tools {
        row(tool, &|readings| readings.rate(tool));
    }
    row("**VTK none / ours none, CPU**", &|readings| readings.cpu_ratio("VTK, none", "ours, none"));
    row("**VTK all / ours all, CPU**", &|readings| readings.cpu_ratio("VTK, all", "ours, all"));
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    fn reading(points: u64, ms: f64) -> Option<Reading> {
        let samples = Samples { wall_ms: vec![ms], cpu_ms: vec![2.0 * ms] };
        Some(Reading { bytes: 1_000_000, points, samples })
    }

    #[test]
    fn rates_and_ratios_come_from_the_same_file() {
        let tools =
            vec![("ours, none", reading(7, 10.0)), ("VTK, none", reading(7, 30.0)), ("VTK, all", None)];
        let readings = Readings { format: "raw VTU", file: "a.vtu".into(), tools };
        readings.check().unwrap();
        let text = markdown(&[readings]);
        assert!(text.contains("| ours, none | 100 / 50 |"), "{text}");
        assert!(text.contains("| **VTK none / ours none, CPU** | 3.0x |"), "{text}");
        assert!(text.contains("| **VTK all / ours all, CPU** | - |"), "{text}");
    }

    #[test]
    fn tools_that_read_different_numbers_of_points_are_not_compared() {
        let tools =
            vec![("copy", reading(0, 1.0)), ("ours, none", reading(7, 1.0)), ("VTK, none", reading(8, 1.0))];
        let readings = Readings { format: "raw VTU", file: "a.vtu".into(), tools };
        assert!(readings.check().unwrap_err().to_string().contains("7, 8"));
        let tools =
            vec![("copy", reading(0, 1.0)), ("ours, none", reading(7, 1.0)), ("VTK, none", reading(0, 0.1))];
        let readings = Readings { format: "raw VTU", file: "a.vtu".into(), tools };
        assert!(readings.check().is_err(), "a reader that finds nothing is not fast");
    }
}
