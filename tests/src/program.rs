use std::fs::File;
use std::io::{Read, Seek};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::{Duration, Instant};

use serde_json::Value;
use tempfile::TempDir;

/// What no command of these tests comes near: whoever reaches it hangs.
const HANGS_AFTER: Duration = Duration::from_secs(120);

/// The program with a folder of its own, which it runs in and which vanishes with this value.
pub struct Program {
    binary: PathBuf,
    folder: TempDir,
}

impl Program {
    /// `binary`: the path that Cargo gives to integration tests as `CARGO_BIN_EXE_meniscus-under-test`.
    pub fn new(binary: impl Into<PathBuf>) -> Self {
        Self { binary: binary.into(), folder: tempfile::tempdir().expect("a temporary folder") }
    }

    /// `name` in the program's folder.
    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Writes a file into the program's folder.
    pub fn write(&self, name: &str, content: impl AsRef<[u8]>) {
        let path = self.path(name);
        let made = path.parent().map_or(Ok(()), std::fs::create_dir_all);
        made.and_then(|()| std::fs::write(&path, content))
            .unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    }

    /// Names of what lies in a folder inside the program's, sorted.
    pub fn list(&self, folder: &str) -> Vec<String> {
        let entries = std::fs::read_dir(self.path(folder)).unwrap_or_else(|e| panic!("{folder}: {e}"));
        let mut names: Vec<String> =
            entries.flatten().map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
        names.sort();
        names
    }

    /// Runs the program with `arguments` as a shell reads them, so that tests look like what users type and printed flags
    /// can be pasted.
    ///
    /// # Panics
    /// When the program hangs or panics.
    pub fn run(&self, arguments: &str) -> Outcome {
        self.start(arguments, &[]).finish()
    }

    /// [`Self::run`] with environment variables.
    pub fn run_with(&self, arguments: &str, variables: &[(&str, &str)]) -> Outcome {
        self.start(arguments, variables).finish()
    }

    /// Starts the program and leaves it running.
    pub fn start(&self, arguments: &str, variables: &[(&str, &str)]) -> Running {
        self.start_after(":", arguments, variables)
    }

    /// [`Self::run`] in a process that may hold this much data of its own (`ulimit -d`): what it asks for beyond fails.
    pub fn run_within(&self, data_bytes: u64, arguments: &str) -> Outcome {
        self.start_after(&format!("ulimit -d {}", data_bytes / 1024), arguments, &[]).finish()
    }

    /// [`Self::run`] in a control group of its own, as a container has, which may hold `bytes` of memory: who takes more is killed.
    /// `None` where this process may not make groups.
    pub fn run_in_group(&self, bytes: u64, arguments: &str) -> Option<Outcome> {
        let group = MemoryGroup::new(bytes)?;
        let join = format!("echo $$ > {}/cgroup.procs", group.0.display());
        Some(self.start_after(&join, arguments, &[]).finish())
    }

    /// Starts the program from a shell that has done `before`.
    fn start_after(&self, before: &str, arguments: &str, variables: &[(&str, &str)]) -> Running {
        let capture = || tempfile::tempfile().expect("a temporary file");
        let (stdout, stderr) = (capture(), capture());
        let hand = |file: &File| Stdio::from(file.try_clone().expect("a second handle"));
        // `exec`: signals go to the program, not to a shell around it.
        let child = Command::new("sh")
            .args(["-c", &format!("{before} && exec \"$0\" {arguments}")])
            .arg(&self.binary)
            .current_dir(self.folder.path())
            .envs(variables.iter().copied())
            .env_remove("RUST_LOG")
            .stdin(Stdio::null())
            .stdout(hand(&stdout))
            .stderr(hand(&stderr))
            .spawn()
            .expect("the program under test");
        Running {
            child,
            stdout,
            stderr,
            arguments: arguments.to_owned(),
            started: Instant::now(),
            peak_bytes: 0,
            peak_data_bytes: 0,
        }
    }
}

/// A control group with a limit on memory; removed when dropped.
struct MemoryGroup(PathBuf);

impl MemoryGroup {
    fn new(bytes: u64) -> Option<Self> {
        static COUNT: AtomicU32 = AtomicU32::new(0);
        let name = format!("meniscus-{}-{}", std::process::id(), COUNT.fetch_add(1, Ordering::Relaxed));
        // Of the first version of control groups, and of the second.
        [("/sys/fs/cgroup/memory", "memory.limit_in_bytes"), ("/sys/fs/cgroup", "memory.max")]
            .into_iter()
            .find_map(|(parent, limit)| {
                let folder = Path::new(parent).join(&name);
                std::fs::create_dir(&folder).ok()?;
                let group = Self(folder);
                // Where memory is not controlled, there is no such file, and none can be made.
                std::fs::write(group.0.join(limit), bytes.to_string()).is_ok().then_some(group)
            })
    }
}

impl Drop for MemoryGroup {
    fn drop(&mut self) {
        // The group is empty: its only process has ended.
        let _ = std::fs::remove_dir(&self.0);
    }
}

/// A started program. Killed when dropped, so that a failing test leaves nothing behind.
pub struct Running {
    child: Child,
    stdout: File,
    stderr: File,
    arguments: String,
    started: Instant,
    peak_bytes: u64,
    peak_data_bytes: u64,
}

impl Running {
    /// The process's number.
    pub fn id(&self) -> u32 {
        self.child.id()
    }

    /// Whether it has ended, after a short wait.
    pub fn has_ended(&mut self) -> bool {
        self.poll()
    }

    /// Waits until `path` exists.
    ///
    /// # Panics
    /// When the program ends first.
    pub fn wait_for(&mut self, path: &Path) {
        while !path.exists() {
            assert!(!self.poll(), "`{}` ended without {}", self.arguments, path.display());
        }
    }

    /// Waits until the program has said `words`.
    ///
    /// # Panics
    /// When the program ends first.
    pub fn wait_for_words(&mut self, words: &str) {
        while !self.said().contains(words) {
            assert!(
                !self.poll() || self.said().contains(words),
                "`{}` ended without {words:?}",
                self.arguments
            );
        }
    }

    /// Standard error so far. The program writes where the shared handle stands, so that one may not be moved.
    fn said(&self) -> String {
        let mut bytes = vec![0; self.stderr.metadata().map_or(0, |data| data.len() as usize)];
        let count = std::os::unix::fs::FileExt::read_at(&self.stderr, &mut bytes, 0).unwrap_or(0);
        String::from_utf8_lossy(&bytes[..count]).into_owned()
    }

    /// Waits for the end.
    ///
    /// # Panics
    /// When the program hangs, or has panicked: nothing that a user does may make it panic.
    pub fn finish(mut self) -> Outcome {
        while !self.poll() {}
        let status = self.child.wait().expect("an ended child");
        let text = |file: &mut File| {
            let mut bytes = Vec::new();
            file.rewind().and_then(|()| file.read_to_end(&mut bytes)).expect("captured output");
            String::from_utf8_lossy(&bytes).into_owned()
        };
        let outcome = Outcome {
            code: status.code(),
            stdout: text(&mut self.stdout),
            stderr: text(&mut self.stderr),
            arguments: self.arguments.clone(),
            peak_bytes: self.peak_bytes,
            peak_data_bytes: self.peak_data_bytes,
        };
        assert!(!outcome.stderr.contains("panicked"), "{outcome:#?}");
        outcome
    }

    /// Whether the program has ended.
    fn poll(&mut self) -> bool {
        let status = std::fs::read_to_string(format!("/proc/{}/status", self.child.id())).unwrap_or_default();
        // The first is the kernel's own high-water mark, so that nothing is missed between two looks but what came after the last.
        self.peak_bytes = self.peak_bytes.max(bytes_in(&status, "VmHWM:").unwrap_or(0));
        self.peak_data_bytes = self.peak_data_bytes.max(bytes_in(&status, "VmData:").unwrap_or(0));
        if self.child.try_wait().expect("a child").is_some() {
            return true;
        }
        assert!(self.started.elapsed() < HANGS_AFTER, "`{}` hangs", self.arguments);
        std::thread::sleep(Duration::from_millis(2));
        false
    }
}

/// The bytes that a line of `/proc/.../status` states.
fn bytes_in(status: &str, name: &str) -> Option<u64> {
    let line = status.lines().find_map(|line| line.strip_prefix(name))?;
    line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok().map(|kib| kib * 1024)
}

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// How a run ended and what it said.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// What was run.
    pub arguments: String,
    /// Exit code; `None` after a signal.
    pub code: Option<i32>,
    /// Standard output.
    pub stdout: String,
    /// Standard error.
    pub stderr: String,
    /// The most memory it held at once, bytes; 0 where it ended before anyone looked.
    pub peak_bytes: u64,
    /// The most data of its own that it was seen with, in RAM or not: what `ulimit -d` limits.
    pub peak_data_bytes: u64,
}

impl Outcome {
    /// Checks the exit code.
    ///
    /// # Panics
    /// When it is another one.
    #[must_use]
    pub fn expect(self, code: i32) -> Self {
        assert_eq!(self.code, Some(code), "{self:#?}");
        self
    }

    /// Checks that the program did what was asked.
    ///
    /// # Panics
    /// When it did not.
    pub fn ok(self) -> Self {
        self.expect(0)
    }

    /// Standard output as JSON.
    ///
    /// # Panics
    /// When it is none.
    pub fn json(&self) -> Value {
        serde_json::from_str(&self.stdout).unwrap_or_else(|e| panic!("{e}\n{self:#?}"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exit_codes_and_both_outputs_are_kept_apart() {
        let outcome = Program::new("sh").run("-c 'echo to people >&2; echo [1]; exit 7'").expect(7);
        assert_eq!(outcome.stderr, "to people\n");
        assert_eq!(outcome.json(), serde_json::json!([1]));
    }

    #[test]
    #[should_panic(expected = "panicked")]
    fn a_panic_is_noticed() {
        let _ = Program::new("sh").run("-c 'echo thread main panicked >&2'");
    }
}
