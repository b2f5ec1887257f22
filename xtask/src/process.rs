//! Running other programs: one way to echo, start and judge them.

use std::{
    ffi::OsStr,
    io::{BufRead, BufReader},
    process::{Command, ExitStatus, Stdio},
};

use crate::error::{Error, Result};

/// A command for the cargo that runs us, so that a toolchain chosen with `cargo +name` holds below too.
pub fn cargo<I: IntoIterator<Item = A>, A: AsRef<OsStr>>(arguments: I) -> Command {
    let mut command = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    command.args(arguments);
    command
}

/// The command as one would type it.
pub fn shown(command: &Command) -> String {
    let program = std::path::Path::new(command.get_program());
    let program = program.file_name().unwrap_or(program.as_os_str());
    let words = std::iter::once(program).chain(command.get_args());
    words.map(|word| word.to_string_lossy()).collect::<Vec<_>>().join(" ")
}

/// Echoes and runs the command with our own input and output.
pub fn run(command: &mut Command) -> Result<()> {
    println!("$ {}", shown(command));
    let status = command.status().map_err(|source| start_error(command, source))?;
    judge(command, status)
}

/// Runs the command and returns its standard output; its standard error is ours.
pub fn capture(command: &mut Command) -> Result<Vec<u8>> {
    let output = command.stderr(Stdio::inherit()).output().map_err(|source| start_error(command, source))?;
    judge(command, output.status)?;
    Ok(output.stdout)
}

/// Echoes and runs the command, handing over each line of standard output *and* standard error as it
/// comes. Both share one pipe, so that their order is the order of writing.
pub fn stream(command: &mut Command, mut each_line: impl FnMut(&str)) -> Result<ExitStatus> {
    println!("$ {}", shown(command));
    let output_error = |command: &Command, source| Error::Output { command: shown(command), source };
    let (reader, writer) = std::io::pipe().map_err(|source| output_error(command, source))?;
    let second_writer = writer.try_clone().map_err(|source| output_error(command, source))?;
    command.stdout(writer).stderr(second_writer);
    let mut child = command.spawn().map_err(|source| start_error(command, source))?;
    // The command holds two writing ends; as long as it does, the reader would wait for more.
    command.stdout(Stdio::null()).stderr(Stdio::null());

    let mut reader = BufReader::new(reader);
    let mut line = Vec::new();
    while reader.read_until(b'\n', &mut line).map_err(|source| output_error(command, source))? > 0 {
        each_line(String::from_utf8_lossy(&line).trim_end_matches(['\n', '\r']));
        line.clear();
    }
    child.wait().map_err(|source| output_error(command, source))
}

fn judge(command: &Command, status: ExitStatus) -> Result<()> {
    if status.success() {
        return Ok(());
    }
    Err(Error::Failed { command: shown(command), status: status.to_string() })
}

/// The command could not even be started.
pub fn start_error(command: &Command, source: std::io::Error) -> Error {
    let program = command.get_program().to_string_lossy().into_owned();
    Error::Start { command: shown(command), program, source }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shell(script: &str) -> Command {
        let mut command = Command::new("sh");
        command.args(["-c", script]);
        command
    }

    #[test]
    fn stream_keeps_the_order_of_both_outputs_and_ends() {
        let mut lines = Vec::new();
        let status = stream(&mut shell("echo a; echo b >&2; printf c; exit 3"), |line| {
            lines.push(line.to_owned());
        })
        .unwrap();
        assert_eq!(lines, ["a", "b", "c"]);
        assert_eq!(status.code(), Some(3));
    }

    #[test]
    fn a_failing_or_absent_program_is_an_error() {
        assert!(matches!(run(&mut shell("exit 1")), Err(Error::Failed { .. })));
        assert!(matches!(capture(&mut shell("exit 1")), Err(Error::Failed { .. })));
        assert!(matches!(run(&mut Command::new("no-such-program-here")), Err(Error::Start { .. })));
    }
}
