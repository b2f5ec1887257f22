//! What the lines of `cargo test` say.

use super::report::Totals;

/// How a test ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ending {
    Passed,
    Failed,
    /// Ignored by attribute, or passed after printing a skip notice.
    Skipped,
}

/// Name and ending in libtest's line `test name ... ok`.
pub fn test_ending(line: &str) -> Option<(String, Ending)> {
    let (name, ending) = line.strip_prefix("test ")?.rsplit_once(" ... ")?;
    let ending = match ending {
        "ok" => Ending::Passed,
        "FAILED" => Ending::Failed,
        _ if ending.starts_with("ignored") => Ending::Skipped,
        _ => return None,
    };
    Some((name.trim_end_matches(" - should panic").to_owned(), ending))
}

/// The test whose output follows `---- name stdout ----`.
pub fn section_of(line: &str) -> Option<&str> {
    line.strip_prefix("---- ")?.strip_suffix(" stdout ----")
}

/// The name in the line with which cargo announces a binary: `Running unittests src/lib.rs (.../name-<hash>)` or
/// `Doc-tests name`.
pub fn binary_name(line: &str) -> Option<String> {
    let line = line.strip_prefix("   ")?.trim_start();
    if let Some(name) = line.strip_prefix("Doc-tests ") {
        return Some(format!("{name}  documentation"));
    }
    let (target, path) = line.strip_prefix("Running ")?.strip_suffix(')')?.rsplit_once(" (")?;
    let file = path.rsplit(['/', '\\']).next()?;
    let (name, _hash) = file.rsplit_once('-')?;
    Some(format!("{name}  {}", target.trim_start_matches("unittests ")))
}

/// Counts and seconds of libtest's closing line:
/// `test result: ok. 1 passed; 0 failed; 0 ignored; 0 measured; 0 filtered out; finished in 0.00s`.
pub fn test_result(line: &str) -> Option<(Totals, f64)> {
    let (_verdict, counts) = line.strip_prefix("test result: ")?.split_once(". ")?;
    let mut parts = counts.split("; ");
    let mut count = |what: &str| parts.next()?.strip_suffix(what)?.trim_end().parse().ok();
    let (passed, failed, skipped) = (count("passed")?, count("failed")?, count("ignored")?);
    let seconds =
        counts.rsplit_once("finished in ").and_then(|(_, text)| text.strip_suffix('s')?.parse().ok());
    Some((Totals { passed, failed, skipped }, seconds.unwrap_or(0.0)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn endings_are_told_from_chatter() {
        let ending = |line| test_ending(line).map(|(name, ending)| format!("{name} {ending:?}"));
        assert_eq!(ending("test a::b ... ok").unwrap(), "a::b Passed");
        assert_eq!(ending("test a - should panic ... FAILED").unwrap(), "a Failed");
        assert_eq!(ending("test a ... ignored, takes an hour").unwrap(), "a Skipped");
        assert_eq!(ending("test a has been running for over 60 seconds"), None);
        assert_eq!(ending("test result: ok. 1 passed"), None);
    }

    #[test]
    fn look_alikes_are_not_results() {
        for line in
            ["test result: see above", "test result: ok. many passed; 0 failed; 0 ignored", "result: ok."]
        {
            assert_eq!(test_result(line), None, "{line}");
        }
    }
}
