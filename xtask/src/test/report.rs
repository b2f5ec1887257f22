//! Reads the output of `cargo test -- --show-output` as it passes by, and counts.

use super::lines::{Ending, binary_name, section_of, test_ending, test_result};
use crate::table;

/// How many tests ended how.
#[derive(Debug, Default, Clone, Copy, PartialEq, Eq)]
pub struct Totals {
    pub passed: usize,
    pub failed: usize,
    /// Ignored by attribute, or passed after printing a skip notice.
    pub skipped: usize,
}

/// A test that cannot do its work here prints this, and why, at the beginning of a line.
const SKIP_NOTICE: &str = "SKIPPED:";

/// What cargo says when asked for the documentation tests of programs only. That is no failure of theirs.
const NO_LIBRARY: &str = "error: no library targets found in package";

/// One test binary, or the documentation tests of one crate.
#[derive(Debug, Clone)]
pub struct Binary {
    /// Of crate or target, then two spaces and its source.
    pub name: String,
    pub totals: Totals,
    pub seconds: f64,
    /// In the order in which they ended.
    pub tests: Vec<Test>,
    /// Whether libtest came to its end and said so.
    has_result: bool,
}

/// One test.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Test {
    pub name: String,
    pub ending: Ending,
    /// Why it was skipped, or what it wrote before it failed.
    pub notes: String,
}

/// Where in the output of a test binary we are.
#[derive(Debug, Default, Clone, Copy, PartialEq, Eq)]
enum Section {
    #[default]
    Elsewhere,
    /// Between `successes:` and `failures:` or the result: what passing tests printed.
    Successes,
    /// The same, after the skip notice of the current test: a test is skipped once, however much it says.
    SuccessesAfterNotice,
    /// Between `failures:` and the list of names after it: what failing tests printed.
    Failures,
}

/// What has been seen so far.
#[derive(Debug, Default)]
pub struct Report {
    binaries: Vec<Binary>,
    section: Section,
    current_test: String,
    /// Skip notices of the binary being read, taken off its passed tests when its result comes.
    notices: usize,
    /// Index of the first binary of the current cargo command.
    invocation_start: usize,
    could_not_build: bool,
    nothing_to_document: bool,
}

impl Report {
    /// Takes one line in; returns what to show of it. The output of passing tests is only asked for because of the
    /// skip notices in it, so nothing else of it is shown.
    pub fn read(&mut self, line: &str) -> Option<String> {
        // Elsewhere only: a test of test reports prints such lines too.
        let ended = test_ending(line).filter(|_| self.section == Section::Elsewhere);
        if let (Some((name, ending)), Some(binary)) = (ended, self.binaries.last_mut()) {
            binary.tests.push(Test { name, ending, notes: String::new() });
        } else if let Some(name) = binary_name(line) {
            self.binaries.push(Binary::new(name));
            self.section = Section::Elsewhere;
            self.notices = 0;
        } else if let Some((totals, seconds)) = test_result(line) {
            self.section = Section::Elsewhere;
            self.add_result(totals, seconds);
        } else if line.starts_with("error: test failed") || line.starts_with("error: doctest failed") {
            self.section = Section::Elsewhere;
            self.note_failure();
        } else if line.starts_with(NO_LIBRARY) {
            self.nothing_to_document = true;
        } else if line == "failures:" {
            self.section = Section::Failures;
            self.current_test.clear();
        } else if line == "successes:" {
            self.section = Section::Successes;
        }
        match self.section {
            Section::Elsewhere => Some(line.to_owned()),
            Section::Failures => {
                self.read_failure(line);
                Some(line.to_owned())
            }
            Section::Successes | Section::SuccessesAfterNotice => self.read_success(line),
        }
    }

    fn read_success(&mut self, line: &str) -> Option<String> {
        if let Some(test) = section_of(line) {
            test.clone_into(&mut self.current_test);
            self.section = Section::Successes;
        }
        let reason = line.strip_prefix(SKIP_NOTICE)?;
        if self.section == Section::Successes {
            self.notices += 1;
            self.section = Section::SuccessesAfterNotice;
        }
        if let Some(test) = self.noted_test() {
            test.ending = Ending::Skipped;
            reason.trim().clone_into(&mut test.notes);
        }
        Some(format!("skipped {}:{reason}", self.current_test))
    }

    /// What a failing test wrote; the list of names that comes after it is indented.
    fn read_failure(&mut self, line: &str) {
        if let Some(test) = section_of(line) {
            test.clone_into(&mut self.current_test);
        } else if let Some(test) = self.noted_test() {
            test.notes += line;
            test.notes.push('\n');
        }
    }

    fn noted_test(&mut self) -> Option<&mut Test> {
        let name = &self.current_test;
        self.binaries.last_mut()?.tests.iter_mut().find(|test| test.name == *name)
    }

    /// Documentation tests give several results per crate (merged ones and those that must stand alone).
    fn add_result(&mut self, mut totals: Totals, seconds: f64) {
        let noticed = std::mem::take(&mut self.notices).min(totals.passed);
        totals.passed -= noticed;
        totals.skipped += noticed;
        let Some(binary) = self.binaries.last_mut() else {
            return;
        };
        binary.totals.add(totals);
        binary.seconds += seconds;
        binary.has_result = true;
    }

    /// A binary that cargo calls failed, but that came to no result, died: at least the test it was in failed.
    fn note_failure(&mut self) {
        if let Some(binary) = self.binaries[self.invocation_start..].last_mut()
            && !binary.has_result
        {
            binary.totals.failed = 1;
            binary.name.push_str(" (died)");
        }
    }

    /// To be called after each cargo command. A failure that shows in no count, such as code that does not compile,
    /// is made to count.
    pub fn end_invocation(&mut self, success: bool) {
        let binaries = &self.binaries[self.invocation_start..];
        let success = success || std::mem::take(&mut self.nothing_to_document);
        if !success && binaries.iter().all(|binary| binary.totals.failed == 0) {
            self.could_not_build = binaries.is_empty();
            let mut cargo_itself = Binary::new("cargo test (see above)".to_owned());
            cargo_itself.totals.failed = 1;
            self.binaries.push(cargo_itself);
        }
        self.invocation_start = self.binaries.len();
    }

    /// Whether a cargo command failed before it ran anything; another one would only say the same again.
    pub fn could_not_build(&self) -> bool {
        self.could_not_build
    }

    /// What ran, in order.
    pub fn binaries(&self) -> &[Binary] {
        &self.binaries
    }

    /// The sum over all binaries.
    pub fn totals(&self) -> Totals {
        let mut sum = Totals::default();
        self.binaries.iter().for_each(|binary| sum.add(binary.totals));
        sum
    }

    /// One row per binary that holds tests, and their sum.
    pub fn table(&self) -> String {
        let row = |name: &str, totals: Totals, seconds: f64| {
            let Totals { passed, failed, skipped } = totals;
            [
                name.to_owned(),
                passed.to_string(),
                failed.to_string(),
                skipped.to_string(),
                format!("{seconds:.1}"),
            ]
        };
        let mut rows = vec![["tests in", "passed", "failed", "skipped", "seconds"].map(String::from)];
        let with_tests = self.binaries.iter().filter(|binary| binary.totals != Totals::default());
        rows.extend(with_tests.map(|binary| row(&binary.name, binary.totals, binary.seconds)));
        let seconds = self.binaries.iter().map(|binary| binary.seconds).sum();
        rows.push(row("sum", self.totals(), seconds));
        table::layout(&rows, [false, true, true, true, true])
    }
}

impl Binary {
    fn new(name: String) -> Self {
        Self { name, totals: Totals::default(), seconds: 0.0, tests: Vec::new(), has_result: false }
    }
}

impl Totals {
    pub fn add(&mut self, other: Self) {
        self.passed += other.passed;
        self.failed += other.failed;
        self.skipped += other.skipped;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FIRST: &str = "
     Running unittests src/lib.rs (target/debug/deps/meniscus_io-0123456789abcdef)

running 4 tests
test a ... ok
test b ... ok
test c ... ignored
test d ... ok

successes:

---- a stdout ----
chatter of a passing test
SKIPPED: no data
SKIPPED: really none

---- d stdout ----
not SKIPPED: in the middle of a line


successes:
    a
    b
    d

test result: ok. 3 passed; 0 failed; 1 ignored; 0 measured; 0 filtered out; finished in 1.50s
";

    const SECOND: &str = "
     Running tests/golden.rs (/elsewhere/debug/deps/golden-00ff)

running 2 tests
test e ... FAILED
test f ... ok

successes:

---- f stdout ----
SKIPPED: no GPU


successes:
    f

failures:

---- e stdout ----
SKIPPED: printed by a test that then failed all the same
thread 'e' panicked


failures:
    e

test result: FAILED. 1 passed; 1 failed; 0 ignored; 0 measured; 0 filtered out; finished in 0.25s

error: test failed, to rerun pass `-p meniscus-tests --test golden`
";

    fn read(text: &str) -> (Report, Vec<String>) {
        let mut report = Report::default();
        let shown = text.lines().filter_map(|line| report.read(line)).collect();
        (report, shown)
    }

    #[test]
    fn totals_are_summed_and_noticed_skips_are_not_passes() {
        let (mut report, _) = read(&format!("{FIRST}{SECOND}"));
        report.end_invocation(false);
        assert_eq!(report.totals(), Totals { passed: 2, failed: 1, skipped: 3 });
        let table = report.table();
        let row = |name: &str| table.lines().find(|line| line.starts_with(name)).unwrap().to_owned();
        let cells = |name: &str| row(name).split_whitespace().skip(2).map(String::from).collect::<Vec<_>>();
        assert_eq!(cells("meniscus_io  src/lib.rs"), ["2", "0", "2", "1.5"]);
        assert_eq!(cells("golden  tests/golden.rs"), ["0", "1", "1", "0.2"]);
        assert_eq!(row("sum").split_whitespace().collect::<Vec<_>>(), ["sum", "2", "1", "3", "1.8"]);
    }

    #[test]
    fn of_passing_tests_only_the_notices_are_shown_but_failures_in_full() {
        let (_, shown) = read(&format!("{FIRST}{SECOND}"));
        let shown = shown.join("\n");
        assert!(shown.contains("skipped a: no data") && shown.contains("skipped f: no GPU"), "{shown}");
        assert!(!shown.contains("chatter") && !shown.contains("middle of a line"), "{shown}");
        assert!(shown.contains("thread 'e' panicked") && shown.contains("test result: FAILED"), "{shown}");
    }

    #[test]
    fn documentation_tests_may_have_several_results() {
        let line =
            "test result: ok. 2 passed; 0 failed; 0 ignored; 0 measured; 0 filtered out; finished in 0.10s";
        let (report, _) = read(&format!("   Doc-tests meniscus_core\n{line}\n{line}\n"));
        assert_eq!(report.totals(), Totals { passed: 4, failed: 0, skipped: 0 });
    }

    #[test]
    fn a_binary_that_dies_counts_as_a_failure_once() {
        let text = "     Running unittests src/lib.rs (target/debug/deps/meniscus_gpu-00)\nrunning 9 tests\n\
                    error: test failed, to rerun pass `-p meniscus-gpu --lib`\n";
        let (mut report, _) = read(&format!("{text}{FIRST}"));
        report.end_invocation(false);
        assert_eq!(report.totals().failed, 1);
        assert!(report.table().contains("meniscus_gpu  src/lib.rs (died)"), "{}", report.table());
    }

    #[test]
    fn code_that_does_not_compile_counts_as_a_failure() {
        let (mut report, _) =
            read("error[E0308]: mismatched types\nerror: could not compile `meniscus-io`\n");
        report.end_invocation(false);
        assert_eq!(report.totals(), Totals { passed: 0, failed: 1, skipped: 0 });
        assert!(report.could_not_build());
    }

    #[test]
    fn a_failure_of_the_second_command_counts_beside_a_sound_first() {
        let (mut report, _) = read(FIRST);
        report.end_invocation(true);
        assert_eq!(report.totals().failed, 0);
        report.end_invocation(false);
        assert_eq!(report.totals().failed, 1);
    }

    #[test]
    fn programs_without_a_library_have_no_documentation_tests_to_fail() {
        let (mut report, _) = read("error: no library targets found in package `xtask`\n");
        report.end_invocation(false);
        assert_eq!(report.totals(), Totals::default());
    }

    #[test]
    fn each_test_has_its_ending_and_what_it_said() {
        let (report, _) = read(&format!("{FIRST}{SECOND}"));
        let [first, second] = report.binaries() else { panic!("{report:?}") };
        let said = |binary: &Binary| {
            let test = |t: &Test| (t.name.clone(), t.ending, t.notes.trim_end().to_owned());
            binary.tests.iter().map(test).collect::<Vec<_>>()
        };
        let test = |name: &str, ending, notes: &str| (name.to_owned(), ending, notes.to_owned());
        let (passed, skipped) = (Ending::Passed, Ending::Skipped);
        assert_eq!(
            said(first),
            [
                test("a", skipped, "really none"),
                test("b", passed, ""),
                test("c", skipped, ""),
                test("d", passed, "")
            ]
        );
        let words = "SKIPPED: printed by a test that then failed all the same\nthread 'e' panicked";
        assert_eq!(said(second), [test("e", Ending::Failed, words), test("f", skipped, "no GPU")]);
    }
}
