//! What `bench` found, as a table.

use super::report::{BenchReport, StageSpread};
use super::spread::Spread;
use crate::terminal::print;

/// Prints `report` for people.
pub fn print_table(report: &BenchReport) {
    print(format_args!("{} ({})", report.adapter, report.driver));
    print(format_args!(
        "{}x{}, {} particles, {} kept, {:.0} % of the picture covered, {:.0} MiB of GPU memory at most",
        report.size[0],
        report.size[1],
        report.particles,
        report.kept,
        report.covered_fraction * 100.0,
        report.peak_bytes as f64 / f64::from(1 << 20),
    ));
    print(format_args!(
        "{:28} {:>9} {:>9} {:>9}   {:17} {:>6}",
        "ms, median", "gpu", "wall", "cpu", "wall min-max", "share"
    ));
    let row = |name: &str, [gpu, wall, cpu]: [Option<Spread>; 3], share: Option<f64>| {
        let range = wall.map_or_else(String::new, |s| format!("{:.2}-{:.2}", s.min, s.max));
        let share = share.map_or_else(String::new, |share| format!("{:.1} %", share * 100.0));
        let line =
            format!("{name:28} {:>9} {:>9} {:>9}   {range:17} {share:>6}", cell(gpu), cell(wall), cell(cpu));
        print(line.trim_end());
    };
    row("reading", [None, report.read_ms, None], None);
    row("preparing", [None, report.prepare_ms, None], None);
    let first = report.first_picture_ms.map(|ms| Spread { median: ms, min: ms, max: ms });
    if first.is_some() {
        row("first picture", [None, first, None], None);
    }
    let frame = &report.frame;
    row("whole picture", [frame.gpu_ms, frame.wall_ms, frame.cpu_ms], None);
    // Shares are of the stages' sum: the pictures' own time has the CPU's part in it.
    let sum: f64 = report.stages.iter().filter_map(StageSpread::time_ms).sum();
    for stage in &report.stages {
        let share = stage.time_ms().filter(|_| sum > 0.0).map(|ms| ms / sum);
        row(&format!("  {}", stage.name), [stage.gpu_ms, stage.wall_ms, stage.cpu_ms], share);
    }
    print(format_args!(
        "wall and cpu of a stage are of that stage run on its own; the whole picture is less than their sum"
    ));
    print(format_args!("{:28} {:>10}", "work of one picture", "count"));
    for (name, unit, value) in report.counters.iter() {
        if let Some(value) = value {
            print(format_args!("  {name:26} {value:>10} {unit}"));
        }
    }
}

fn cell(spread: Option<Spread>) -> String {
    spread.map_or_else(|| "-".to_owned(), |s| format!("{:.2}", s.median))
}
