//! What `bench` found, as a table.

use super::report::BenchReport;
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
    print(format_args!("{:28} {:>10} {:>10} {:>10}", "ms, median", "gpu", "wall", "cpu"));
    let cell = |v: Option<f64>| v.map_or_else(|| "-".to_owned(), |v| format!("{v:.2}"));
    let spread = |s: Option<Spread>| cell(s.map(|s| s.median));
    let frame = &report.frame;
    print(format_args!(
        "{:28} {:>10} {:>10} {:>10}",
        "whole frame",
        spread(frame.gpu_ms),
        spread(frame.wall_ms),
        spread(frame.cpu_ms)
    ));
    for stage in &report.stages {
        print(format_args!(
            "  {:26} {:>10} {:>10} {:>10}",
            stage.name,
            cell(stage.gpu_ms),
            cell(stage.wall_ms),
            cell(stage.cpu_ms)
        ));
    }
    print(format_args!(
        "wall and cpu of a stage are of that stage run on its own; the whole frame is less than their sum"
    ));
}
