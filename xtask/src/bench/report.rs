//! Tables of a run and of its comparison with a baseline.

use super::record::{Record, Spread};
use crate::table;

/// One row per bench.
pub fn table(records: &[Record]) -> String {
    let header = ["bench", "view", "wall ms", "CPU ms", "GPU ms", "MB", "GB/s", "% of copy"];
    let mut rows = vec![header.map(String::from)];
    rows.extend(records.iter().map(|record| {
        [
            format!("{}/{}", record.stage, record.bench),
            record.view.clone(),
            milliseconds(record.wall()),
            milliseconds(record.cpu()),
            milliseconds(record.gpu()),
            or_dash(record.bytes.map(|bytes| significant(bytes as f64 * 1e-6))),
            or_dash(record.gb_per_s().map(significant)),
            or_dash(record.copy_percent().map(significant)),
        ]
    }));
    table::layout(&rows, [false, false, true, true, true, true, true, true])
}

/// What was measured on what, and how fast that copies: one line per device.
pub fn devices(records: &[Record]) -> String {
    let mut lines: Vec<String> = Vec::new();
    for record in records {
        if !lines.iter().any(|line| line.starts_with(&format!("{}: ", record.device))) {
            lines.push(format!(
                "{}: copies {:.1} GB/s, read and written",
                record.device, record.copy_gb_per_s
            ));
        }
    }
    lines.join("\n")
}

/// New over old, one row per bench; below 1 is faster.
pub fn comparison(records: &[Record], baseline: &[Record]) -> String {
    let header = ["bench", "view", "wall", "CPU", "GPU", ""];
    let mut rows = vec![header.map(String::from)];
    for record in records {
        let old = baseline.iter().find(|old| old.is_same_bench(record));
        let ([wall, cpu, gpu], verdict) = match old {
            None => (Default::default(), "not in the baseline".to_owned()),
            Some(old) if old.device != record.device => {
                (Default::default(), format!("measured on {}", old.device))
            }
            Some(old) => {
                let ratio = |of: fn(&Record) -> Option<Spread>| Some(of(record)?.over(of(old)?));
                let ratios = [ratio(Record::wall), ratio(Record::cpu), ratio(Record::gpu)];
                // The GPU's own clock is the better one where there is one.
                let judged = ratios[2].or(ratios[0]);
                let samples = record.samples.len().min(old.samples.len());
                (ratios.map(shown_ratio), verdict(judged, samples).to_owned())
            }
        };
        rows.push([
            format!("{}/{}", record.stage, record.bench),
            record.view.clone(),
            wall,
            cpu,
            gpu,
            verdict,
        ]);
    }
    table::layout(&rows, [false, false, true, true, true, false])
}

/// Samples below which the spread says nothing; `--quick` takes one or two.
const ENOUGH_SAMPLES: usize = 5;

/// A difference is one only where there are spreads and they do not overlap.
fn verdict(ratio: Option<Spread>, samples: usize) -> &'static str {
    match ratio {
        _ if samples < ENOUGH_SAMPLES => "too few samples",
        Some(ratio) if ratio.high < 1.0 => "faster",
        Some(ratio) if ratio.low > 1.0 => "slower",
        Some(_) => "the same",
        None => "",
    }
}

fn shown_ratio(ratio: Option<Spread>) -> String {
    or_dash(ratio.map(|Spread { low, median, high }| format!("{median:.2} ({low:.2} to {high:.2})")))
}

fn milliseconds(spread: Option<Spread>) -> String {
    or_dash(spread.map(|spread| significant(spread.median)))
}

fn or_dash(text: Option<String>) -> String {
    text.unwrap_or_else(|| "-".to_owned())
}

/// Three digits, never fewer before the point.
fn significant(value: f64) -> String {
    match value {
        _ if value >= 100.0 => format!("{value:.0}"),
        _ if value >= 10.0 => format!("{value:.1}"),
        _ if value >= 1.0 => format!("{value:.2}"),
        _ => format!("{value:.4}"),
    }
}

#[cfg(test)]
mod tests {
    use super::super::record::tests::record;
    use super::*;

    fn row(table: &str, line: usize) -> Vec<String> {
        table.lines().nth(line).unwrap().split_whitespace().map(String::from).collect()
    }

    #[test]
    fn a_row_has_every_figure_and_a_dash_for_what_is_not_known() {
        let text = table(&[record(&[2.0, 2.0])]);
        assert_eq!(row(&text, 1), ["lod/build", "dam-break", "2.00", "4.00", "-", "4.00", "2.00", "25.0"]);
    }

    #[test]
    fn only_ratios_clear_of_one_are_changes() {
        let old = [record(&[10.0, 10.0, 10.0, 10.0, 11.0])];
        for (new, expected) in [
            (record(&[5.0, 5.0, 5.0, 5.0, 5.5]), "faster"),
            (record(&[20.0, 20.5, 21.0, 21.5, 22.0]), "slower"),
            (record(&[9.0, 9.5, 10.0, 11.0, 12.0]), "the same"),
        ] {
            let text = comparison(&[new], &old);
            assert!(text.lines().nth(1).unwrap().ends_with(expected), "{text}");
        }
        let text = comparison(&[record(&[5.0])], &[record(&[10.0])]);
        assert!(text.contains("0.50 (0.50 to 0.50)") && text.contains("too few samples"), "{text}");
    }

    #[test]
    fn unlike_is_not_compared() {
        let mut other = record(&[1.0]);
        other.device = "another GPU".into();
        let text = comparison(&[record(&[1.0])], &[other.clone()]);
        assert!(text.contains("measured on another GPU") && !text.contains("1.00"), "{text}");
        other.view = "close-up".into();
        assert!(comparison(&[record(&[1.0])], &[other]).contains("not in the baseline"));
    }

    #[test]
    fn each_device_is_named_once() {
        let text = devices(&[record(&[1.0]), record(&[2.0])]);
        assert_eq!(text, "CPU: copies 8.0 GB/s, read and written");
    }
}
