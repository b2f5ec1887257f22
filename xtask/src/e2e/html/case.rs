//! A picture beside what is expected.

use super::text::{escape, png_address, prose};
use crate::e2e::images::{Case, Metric, Status};

/// Reads a picture of the run by its name; `None` where it is not there.
pub type ReadPicture<'a> = dyn Fn(&str) -> Option<Vec<u8>> + 'a;

/// Where the limit is on a bar, as a part of its length: room is left to see by how much a value is beyond it.
const LIMIT_AT: f64 = 2.0 / 3.0;

/// Failed ones first, otherwise in the order of `cases.toml`.
pub fn cases(cases: &[Case], read: &ReadPicture<'_>) -> String {
    let mut sorted: Vec<&Case> = cases.iter().collect();
    sorted.sort_by_key(|case| case.status != Status::Failed);
    sorted.into_iter().map(|case| card(case, read)).collect()
}

fn card(case: &Case, read: &ReadPicture<'_>) -> String {
    let name = escape(&case.name);
    let status = match case.status {
        Status::Passed => "passed",
        Status::Failed => "failed",
        Status::Updated => "updated",
    };
    let why = escape(&case.why);
    let problem = case
        .problem
        .as_deref()
        .map_or(String::new(), |problem| format!("<p class=\"problem\">{}</p>\n", prose(problem)));
    let pictures = pictures(case, read);
    let metrics = metrics(&case.metrics);
    let more = more(case);
    format!(
        "<article class=\"case {status}\" id=\"case-{name}\">\n\
         <header><h3>{name}</h3><span class=\"pill\">{status}</span><span class=\"soft\">{why}</span></header>\n\
         {problem}{pictures}{metrics}\
         <p><span class=\"soft\">Repeat:</span> <code>cargo xtask e2e {name}</code></p>\n{more}</article>\n"
    )
}

fn pictures(case: &Case, read: &ReadPicture<'_>) -> String {
    let files = &case.pictures;
    let figure = |caption: &str, missing: &str, file: &Option<String>| {
        let inside = match file.as_deref().and_then(read) {
            Some(bytes) => format!(
                "<button><img src=\"{}\" alt=\"{}: {}\"></button>",
                png_address(&bytes),
                escape(&case.name),
                escape(caption)
            ),
            None => format!("<div class=\"none wanted\">{}</div>", escape(missing)),
        };
        format!("<figure>{inside}<figcaption>{}</figcaption></figure>\n", escape(caption))
    };
    let ours = figure("ours", "no picture was drawn", &files.ours);
    let expected = figure("expected", "no expected image", &files.expected);
    let flip = figure("difference (FLIP): black is none", "nothing to compare", &files.flip);
    format!("<div class=\"pictures\">\n{ours}{expected}{flip}</div>\n")
}

fn metrics(metrics: &[Metric]) -> String {
    if metrics.is_empty() {
        return String::new();
    }
    let rows: String = metrics.iter().map(metric).collect();
    format!(
        "<table><tr><th>inside the water<th class=\"number\">value<th><th class=\"number\">limit<th>why this limit</tr>\n\
         {rows}</table>\n"
    )
}

fn metric(metric: &Metric) -> String {
    let class = if metric.passed { "passed" } else { "failed" };
    let relation = if metric.more_is_better { "≥" } else { "≤" };
    let (name, value, reason) = (escape(&metric.name), metric.shown(), escape(&metric.reason));
    let filled = 100.0 * filled(metric);
    format!(
        "<tr class=\"{class}\"><td>{name}<td class=\"number\">{value}\
         <td class=\"bar\"><div><i style=\"width:{filled:.1}%\"></i><u></u></div>\
         <td class=\"number\">{relation} {limit}<td class=\"reason\">{reason}</tr>\n",
        limit = metric.limit
    )
}

/// How much of its bar a value fills, 0 to 1: the larger, the worse.
fn filled(metric: &Metric) -> f64 {
    let Some(value) = metric.value else {
        return 1.0;
    };
    let (error, limit) = match metric.more_is_better {
        true => (1.0 - value, 1.0 - metric.limit),
        false => (value, metric.limit),
    };
    match (error <= 0.0, limit <= 0.0) {
        (true, _) => 0.0,
        (false, true) => 1.0,
        (false, false) => (error / limit * LIMIT_AT).min(1.0),
    }
}

fn more(case: &Case) -> String {
    let commands = case.commands.iter().map(|command| escape(command)).collect::<Vec<_>>().join("\n");
    let origin = case.made_by.as_ref().map_or(String::new(), |origin| {
        let limits = match case.same_driver {
            true => "the same driver: strict limits",
            false => "another driver than here: lenient limits",
        };
        format!(
            "<p>Expected image made on {} by meniscus {} at {} on {} ({limits}).</p>\n",
            escape(&origin.date),
            escape(&origin.version),
            escape(&origin.commit),
            escape(&origin.driver)
        )
    });
    let stages = case.stages.iter().map(|stage| format!("{} {:.1} ms", escape(&stage.name), stage.ms));
    let stages = match case.stages.is_empty() {
        true => String::new(),
        false => format!("<p class=\"soft\">Passes: {}.</p>\n", stages.collect::<Vec<_>>().join(", ")),
    };
    format!(
        "<details><summary>How it was made</summary>\n{origin}\
         <p>By hand, in a folder with the scene files of <code>tests/scenes</code>:</p>\n<pre>{commands}</pre>\n\
         {stages}</details>\n"
    )
}
