//! The report: one HTML file that needs nothing beside it.

mod case;
mod tests;
mod text;

use super::{images::Images, run::Findings, summary};
use crate::test::report::Totals;
use case::ReadPicture;
use text::{escape, prose};

/// The whole page. `read` gives the pictures that the findings name; `date` is when they were made.
pub fn page(findings: &Findings, date: &str, read: &ReadPicture<'_>) -> String {
    let images = findings.images.as_ref().filter(|images| !images.cases.is_empty());
    let pictures = images.map_or(String::new(), |images| {
        format!(
            "<h2 id=\"{}\">Images</h2>\n<p class=\"soft\">Click a picture to enlarge it; click again, or press space, \
             to flip between ours and what is expected; 1, 2, 3 choose a picture, Esc closes.</p>\n{}",
            summary::anchor(summary::IMAGES),
            case::cases(&images.cases, read)
        )
    });
    let groups = findings
        .tests
        .as_ref()
        .map_or(String::new(), |report| format!("<h2>Tests</h2>\n{}", tests::groups(report)));
    let (top, tiles, failures) = (top(findings, date), tiles(findings), failures(findings));
    let style = include_str!("style.css");
    let script = include_str!("viewer.js");
    format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <title>meniscus end-to-end report</title>\n<style>\n{style}</style>\n</head>\n<body>\n<main>\n\
         {top}{tiles}{failures}{pictures}{groups}</main>\n\
         <dialog><header><b></b><span class=\"soft\">space flips, Esc closes</span></header><img alt=\"\"></dialog>\n\
         <script>\n{script}</script>\n</body>\n</html>\n"
    )
}

fn top(findings: &Findings, date: &str) -> String {
    let Totals { passed, failed, skipped } = findings.totals();
    let skips = if skipped > 0 { format!(", {skipped} skipped") } else { String::new() };
    let updated = findings.images.as_ref().map_or(0, Images::updated);
    let verdict = match (findings.is_success(), failed) {
        (true, _) if updated > 0 => {
            format!("Expected images replaced: {updated}; look at them before you commit")
        }
        (true, _) => format!("All {passed} checks passed{skips}"),
        (false, 0) => format!("Nothing was checked{skips}"),
        (false, _) => format!("{failed} failed, {passed} passed{skips}"),
    };
    let class = if findings.is_success() { "passed" } else { "failed" };
    let images = findings.images.as_ref();
    let fact = |name: &str, value: &str| format!("<dt>{name}<dd>{}\n", escape(value));
    let source = images.map_or("unknown".to_owned(), |i| format!("meniscus {} at {}", i.version, i.commit));
    let facts = [
        findings.part.as_deref().map_or(String::new(), |part| fact("Part", part)),
        fact("Adapter, driver", images.map_or("unknown", |images| &images.driver)),
        fact("Source", &source),
        fact("Date", date),
        fact("Duration", &format!("{:.0} s with building", findings.elapsed_s)),
    ];
    format!(
        "<header class=\"top {class}\">\n<h1>meniscus end-to-end report</h1>\n<p class=\"verdict\">{verdict}</p>\n\
         <dl class=\"facts\">\n{}</dl>\n</header>\n",
        facts.concat()
    )
}

fn tiles(findings: &Findings) -> String {
    let tile = |line: summary::Line| {
        let Totals { passed, failed, skipped } = line.totals;
        let class = if failed > 0 { "failed" } else { "passed" };
        let counts = match failed {
            0 => format!("{passed} passed"),
            _ => format!("{failed} failed"),
        };
        let skips = if skipped > 0 { format!("{skipped} skipped, ") } else { String::new() };
        let others = if failed > 0 { format!("{passed} passed, ") } else { String::new() };
        format!(
            "<a class=\"tile {class}\" href=\"#{}\">{}<b>{counts}</b><span class=\"soft\">{others}{skips}{:.1} s\
             </span></a>\n",
            summary::anchor(line.title),
            escape(line.title),
            line.seconds
        )
    };
    let tiles: String = summary::lines(findings).into_iter().map(tile).collect();
    format!("<nav class=\"tiles\">\n{tiles}</nav>\n")
}

/// Empty where nothing failed.
fn failures(findings: &Findings) -> String {
    let failures = summary::failures(findings);
    if failures.is_empty() {
        return String::new();
    }
    let item = |failure: &summary::Failure| {
        let (name, why) = (escape(&failure.name), prose(&failure.why));
        match name.is_empty() {
            true => format!("<li>{why}</li>\n"),
            false => format!("<li><a href=\"#{}\">{name}</a> {why}</li>\n", escape(&failure.anchor)),
        }
    };
    let items: String = failures.iter().map(item).collect();
    let anchor = summary::anchor(summary::PROBLEMS);
    format!(
        "<section class=\"failures\" id=\"{anchor}\"><h2>What failed</h2>\n<ul>\n{items}</ul></section>\n"
    )
}

#[cfg(test)]
mod checks {
    use super::*;
    use crate::test::report::Report;

    fn case(name: &str, status: &str, problem: Option<&str>) -> serde_json::Value {
        let file = |ending: &str| format!("{name}{ending}.png");
        serde_json::json!({
            "name": name, "why": "crown & cavity", "commands": ["meniscus make x", "meniscus render 'a<b'"],
            "status": status, "problem": problem, "stages": [{"name": "ssfr.depth", "ms": 1.25}],
            "pictures": {"ours": file(""), "expected": file(".expected"), "flip": file(".flip")},
            "metrics": [
                {"name": "FLIP mean", "value": 0.004, "limit": 0.002, "reason": "a < b", "more_is_better": false,
                 "passed": false},
                {"name": "SSIM", "value": 0.999, "limit": 0.998, "reason": "c", "more_is_better": true, "passed": true},
                {"name": "mask area", "value": null, "limit": 0.0, "reason": "d", "more_is_better": false,
                 "passed": false},
            ],
            "made_by": {"driver": "llvmpipe", "version": "0.1.0", "commit": "abc", "date": "2026-11-24"},
            "same_driver": true, "elapsed_s": 1.5,
        })
    }

    fn findings(cases: &[serde_json::Value]) -> Findings {
        let json = serde_json::json!({
            "driver": "<llvmpipe>", "version": "0.1.0", "commit": "abc", "cases": cases, "stale": [],
        });
        Findings { images: Some(serde_json::from_value::<Images>(json).unwrap()), ..Findings::default() }
    }

    fn position(page: &str, text: &str) -> usize {
        page.find(text).unwrap_or_else(|| panic!("{text} is not in\n{page}"))
    }

    #[test]
    fn failed_cases_come_first() {
        let findings = findings(&[case("one", "passed", None), case("two", "failed", None)]);
        let page = page(&findings, "today", &|_| Some(vec![1]));
        assert!(position(&page, "id=\"case-two\"") < position(&page, "id=\"case-one\""));
        assert!(page.contains("1 failed, 1 passed") && page.contains("top failed"));
        assert!(position(&page, "What failed") < position(&page, "id=\"case-two\""));
    }

    #[test]
    fn a_missing_picture_is_said_and_nothing_is_loaded_from_elsewhere() {
        let findings = findings(&[case("one", "passed", None)]);
        let page = page(&findings, "today", &|name| (name == "one.png").then(|| vec![1, 2, 3]));
        assert!(page.contains("no expected image") && page.contains("nothing to compare"));
        assert!(!page.contains("no picture was drawn") && page.contains("data:image/png;base64,AQID"));
        for reference in ["src=\"", "href=\""] {
            for target in page.split(reference).skip(1) {
                assert!(target.starts_with("data:") || target.starts_with('#'), "{:.40}", target);
            }
        }
    }

    #[test]
    fn text_is_escaped_wherever_it_comes_from() {
        let hostile = "<script>alert('x')</script>";
        let mut findings = findings(&[case("one", "failed", Some(hostile))]);
        findings.problems.push(hostile.to_owned());
        let mut report = Report::default();
        for line in [
            "     Running tests/sphere.rs (target/debug/deps/sphere-00)",
            "test <b>bold</b> ... FAILED",
            "failures:",
            "---- <b>bold</b> stdout ----",
            hostile,
        ] {
            report.read(line);
        }
        findings.tests = Some(report);
        let page = page(&findings, hostile, &|_| None);
        assert!(!page.contains("<script>alert") && !page.contains("<b>bold") && !page.contains("a<b"));
        assert!(!page.contains("<llvmpipe>") && !page.contains("a < b"));
        assert_eq!(page.matches("&lt;script&gt;alert").count(), 5, "problem, list twice, date, notes");
    }

    #[test]
    fn bars_show_how_far_from_the_limit_a_value_is() {
        let page = page(&findings(&[case("one", "failed", None)]), "today", &|_| None);
        // Twice the limit and what is no number fill the bar; half of what the limit allows fills half of two thirds.
        assert_eq!(page.matches("width:100.0%").count(), 2);
        assert!(page.contains("width:33.3%") && page.contains("not a number"));
    }

    #[test]
    fn replaced_expectations_and_parts_are_not_called_a_sound_whole() {
        let part = Some("only one".to_owned());
        let updated = Findings { part, ..findings(&[case("one", "updated", None)]) };
        let page = page(&updated, "today", &|_| None);
        assert!(page.contains("Expected images replaced: 1;") && page.contains("<dt>Part<dd>only one"));
        assert!(!page.contains("checks passed"));
    }

    #[test]
    fn what_could_not_run_is_no_success() {
        let findings = Findings { problems: vec!["no driver".into()], ..Findings::default() };
        let failed = page(&findings, "today", &|_| None);
        assert!(failed.contains("1 failed, 0 passed") && failed.contains("<li>no driver</li>"));
        assert!(page(&Findings::default(), "today", &|_| None).contains("Nothing was checked"));
    }
}
