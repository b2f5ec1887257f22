//! Runs the tests of a check in the copied tree and tells how they ended.

use std::{
    fs::File,
    io,
    os::unix::process::CommandExt,
    path::{Path, PathBuf},
    process::{Child, Command, ExitStatus, Stdio},
    sync::atomic::{AtomicI32, Ordering},
    time::{Duration, Instant},
};

use rustix::process::{Pid, Signal, kill_process_group};

use crate::{
    error::{Error, Result},
    process::{cargo, shown, start_error},
};

/// How the tests of a check ended.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Verdict {
    Green {
        passed: usize,
        skipped: usize,
    },
    /// These tests failed.
    Red(Vec<String>),
    /// Killed after its time.
    Hang,
    /// There was nothing to run: what the compiler said first.
    DoesNotBuild(String),
}

/// How much longer than without sabotage a check may take before it counts as hanging; the constant part is for machines
/// that have other things to do.
pub const PATIENCE: u32 = 10;
pub const LEAST_PATIENCE: Duration = Duration::from_secs(60);
/// No compilation takes longer, not even the first one on a slow machine.
const BUILD_LIMIT: Duration = Duration::from_secs(3600);

/// Where checks run.
pub struct Checks {
    /// Root of the copied workspace.
    pub tree: PathBuf,
    /// Where cargo builds, and where logs are kept.
    pub target: PathBuf,
    /// For the programs that draw.
    pub variables: Vec<(&'static str, String)>,
}

impl Checks {
    /// Compiles and runs the tests of `check`; the second number is how long running them took.
    pub fn run(&self, check: &str, limit: Duration) -> Result<(Verdict, Duration)> {
        let words = || check.split_whitespace();
        let mut build = cargo(["test", "--no-run", "--color", "never"].into_iter().chain(words()));
        let (status, text) = self.run_within(&mut build, BUILD_LIMIT)?;
        if !status.is_some_and(|status| status.success()) {
            return Ok((Verdict::DoesNotBuild(first_error(&text)), Duration::ZERO));
        }
        // The list's own tests look for the text that a sabotage has replaced, and would always notice.
        let runner = ["--", "--show-output", "--skip", "sabotage::"];
        let arguments =
            ["test", "--no-fail-fast", "--color", "never"].into_iter().chain(words()).chain(runner);
        let start = Instant::now();
        let (status, text) = self.run_within(&mut cargo(arguments), limit)?;
        let verdict = status.map_or(Verdict::Hang, |status| judge(&text, status.success()));
        Ok((verdict, start.elapsed()))
    }

    /// Runs `command` with its output in a file; no status means that it was killed after `limit`.
    fn run_within(&self, command: &mut Command, limit: Duration) -> Result<(Option<ExitStatus>, String)> {
        let path = self.target.join("sabotage.log");
        let file_error = |source: io::Error| Error::File { path: path.clone(), source };
        let log = File::create(&path).map_err(file_error)?;
        command
            .current_dir(&self.tree)
            .env("CARGO_TARGET_DIR", &self.target)
            .envs(self.variables.iter().cloned())
            .stdin(Stdio::null())
            .stdout(log.try_clone().map_err(file_error)?)
            .stderr(log)
            // A group of its own: what cargo starts has to end with it.
            .process_group(0);
        let child = command.spawn().map_err(|source| start_error(command, source))?;
        let status =
            wait(child, limit).map_err(|source| Error::Output { command: shown(command), source })?;
        let bytes = std::fs::read(&path).map_err(file_error)?;
        Ok((status, String::from_utf8_lossy(&bytes).into_owned()))
    }
}

/// Number of the process group that is running, 0 for none.
static RUNNING: AtomicI32 = AtomicI32::new(0);

/// On Ctrl-C ends what is running, then this program.
pub fn end_children_on_interrupt() {
    let installed = ctrlc::set_handler(|| {
        kill_group(RUNNING.load(Ordering::SeqCst));
        std::process::exit(130);
    });
    if let Err(error) = installed {
        eprintln!("note: an interrupt will leave cargo running: {error}");
    }
}

fn kill_group(group: i32) {
    if let Some(group) = Pid::from_raw(group) {
        // It may have ended by itself.
        let _ = kill_process_group(group, Signal::KILL);
    }
}

fn wait(mut child: Child, limit: Duration) -> io::Result<Option<ExitStatus>> {
    let group = child.id() as i32;
    RUNNING.store(group, Ordering::SeqCst);
    let start = Instant::now();
    let status = loop {
        if let Some(status) = child.try_wait()? {
            break Some(status);
        }
        if start.elapsed() > limit {
            kill_group(group);
            child.wait()?;
            break None;
        }
        std::thread::sleep(Duration::from_millis(20));
    };
    RUNNING.store(0, Ordering::SeqCst);
    Ok(status)
}

/// What the output of `cargo test -- --show-output` means.
fn judge(text: &str, success: bool) -> Verdict {
    // A shader is compiled when the program runs; one that does not compile is no mistake that a test had to find.
    let shader_error = SHADER_ERRORS.iter().find_map(|error| text.find(error));
    if let (false, Some(at)) = (success, shader_error) {
        return Verdict::DoesNotBuild(text[at..].chars().take(100).collect());
    }
    let ended = |how: &str| -> Vec<String> {
        let of_line = |line: &str| Some(line.strip_prefix("test ")?.strip_suffix(how)?.to_owned());
        text.lines().filter_map(of_line).collect()
    };
    let failed = ended(" ... FAILED");
    if !failed.is_empty() {
        return Verdict::Red(failed);
    }
    if !success {
        return Verdict::Red(vec!["the test program died".to_owned()]);
    }
    let skipped = text.lines().filter(|line| line.starts_with("SKIPPED:")).count();
    let passed = text.lines().filter(|line| line.starts_with("test ") && line.ends_with(" ... ok")).count();
    Verdict::Green { passed: passed.saturating_sub(skipped), skipped }
}

/// How `GpuError::Shader` shows, unwrapped in a test or printed by the program.
const SHADER_ERRORS: &[&str] = &["Shader { shader: ", "meniscus: shader "];

fn first_error(text: &str) -> String {
    let is_error = |line: &&str| line.starts_with("error");
    text.lines().find(is_error).unwrap_or("cargo took too long").to_owned()
}

/// Where third-party data are, for tests that would look beside the copy.
pub fn data_folder(workspace: &Path) -> Option<String> {
    let given = std::env::var_os("MENISCUS_DATA").map(PathBuf::from);
    let folder = given.unwrap_or_else(|| workspace.join("../shared/data")).canonicalize().ok()?;
    Some(folder.to_string_lossy().into_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn outputs_are_judged() {
        let green = "test a ... ok\ntest b ... ok\n\nsuccesses:\n---- b stdout ----\nSKIPPED: no data\n";
        assert_eq!(judge(green, true), Verdict::Green { passed: 1, skipped: 1 });
        let red = "test a ... ok\ntest b::c ... FAILED\ntest d ... FAILED\n";
        assert_eq!(judge(red, false), Verdict::Red(vec!["b::c".into(), "d".into()]));
        assert!(matches!(judge("test a ... ok\n", false), Verdict::Red(_)), "a test program that dies");
        let shader = "test a ... FAILED\nthread 'a': called `unwrap()`: Shader { shader: \"ssfr/depth\" }\n";
        assert!(matches!(judge(shader, false), Verdict::DoesNotBuild(_)));
        assert_eq!(judge("running 0 tests\n", true), Verdict::Green { passed: 0, skipped: 0 });
    }

    #[test]
    fn what_takes_too_long_is_killed_with_all_that_it_started() {
        let folder = tempfile::tempdir().unwrap();
        let checks = Checks {
            tree: folder.path().to_owned(),
            target: folder.path().to_owned(),
            variables: Vec::new(),
        };
        let mut shell = Command::new("sh");
        shell.args(["-c", "sleep 30 & echo $! > child; wait"]);
        let (status, _) = checks.run_within(&mut shell, Duration::from_millis(500)).unwrap();
        assert_eq!(status, None);
        let child = std::fs::read_to_string(folder.path().join("child")).unwrap();
        // A killed process vanishes when its parent has noticed; as a zombie it has no command line.
        let command_line = || std::fs::read(format!("/proc/{}/cmdline", child.trim())).unwrap_or_default();
        let start = Instant::now();
        while !command_line().is_empty() {
            assert!(start.elapsed() < Duration::from_secs(20), "still running");
            std::thread::sleep(Duration::from_millis(10));
        }
        let mut quick = Command::new("sh");
        quick.args(["-c", "echo out; echo err >&2; exit 3"]);
        let (status, text) = checks.run_within(&mut quick, Duration::from_secs(60)).unwrap();
        assert_eq!((status.and_then(|status| status.code()), text.as_str()), (Some(3), "out\nerr\n"));
    }
}
