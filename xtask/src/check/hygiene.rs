//! What should not be in a repository: large files, and paths of somebody's machine.

use std::{path::Path, process::Command};

use crate::{
    error::{Error, Result},
    process::capture,
};

/// A clone stays small only if every file does. Larger test data are generated or fetched.
const LARGEST_BYTES: u64 = 1_000_000;

/// Looks at every tracked file of the repository.
pub fn offences_in_repository() -> Result<Vec<String>> {
    let root = git(&["rev-parse", "--show-toplevel"])?;
    let root = Path::new(root.trim_end());
    let mut machine_paths = home_prefixes();
    machine_paths.push(root.to_string_lossy().into_owned());
    let mut offences = Vec::new();
    for name in git(&["ls-files", "-z", "--full-name", ":/"])?.split_terminator('\0') {
        let path = root.join(name);
        let Ok(metadata) = path.symlink_metadata() else {
            continue; // Deleted, but the deletion is not staged yet.
        };
        if !metadata.is_file() {
            continue;
        }
        if metadata.len() > LARGEST_BYTES {
            offences.push(too_large(name, metadata.len()));
            continue;
        }
        let bytes = std::fs::read(&path).map_err(|source| Error::File { path, source })?;
        offences.extend(machine_paths_in(name, &String::from_utf8_lossy(&bytes), &machine_paths));
    }
    Ok(offences)
}

/// Where people's own files live. Written in pieces, so that this file does not find itself.
fn home_prefixes() -> Vec<String> {
    [["/", "home/"], ["/", "root/"], ["/", "Users/"], [":\\", "Users\\"]]
        .map(|pieces| pieces.concat())
        .to_vec()
}

fn git(arguments: &[&str]) -> Result<String> {
    let output = capture(Command::new("git").args(arguments))?;
    Ok(String::from_utf8_lossy(&output).into_owned())
}

fn too_large(name: &str, bytes: u64) -> String {
    format!("{name}: {bytes} bytes, the limit is {LARGEST_BYTES}; generate it, or shrink it")
}

/// Lines that hold one of the prefixes as the beginning of a path (not as the tail of a longer one, as in a URL).
fn machine_paths_in(name: &str, text: &str, prefixes: &[String]) -> Vec<String> {
    let starts_a_path = |line: &str, at: usize, prefix: &str| {
        let before = line[..at].chars().next_back();
        prefix.starts_with(':') || before.is_none_or(|c| !(c.is_alphanumeric() || "/._-~$})".contains(c)))
    };
    let mut found = Vec::new();
    for (number, line) in text.lines().enumerate() {
        let hit = prefixes.iter().find(|prefix| {
            line.match_indices(prefix.as_str()).any(|(at, _)| starts_a_path(line, at, prefix))
        });
        if let Some(prefix) = hit {
            let number = number + 1;
            found.push(format!(
                "{name}:{number}: path of somebody's machine (`{prefix}...`); use a relative one"
            ));
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found_in(text: &str) -> usize {
        let mut prefixes = home_prefixes();
        prefixes.push("/build/clone".to_owned());
        machine_paths_in("file", text, &prefixes).len()
    }

    #[test]
    fn homes_and_the_clone_itself_are_found() {
        for prefix in home_prefixes() {
            assert_eq!(found_in(&format!("open(\"{prefix}me/data\")")), 1, "{prefix}");
        }
        assert_eq!(found_in("see /build/clone/target"), 1);
        assert_eq!(found_in("a\n/build/clone\nb /build/clone c"), 2);
    }

    #[test]
    fn relative_paths_and_addresses_are_not() {
        let home = &home_prefixes()[0];
        assert_eq!(found_in(&format!("https://example.org{home}page")), 0);
        assert_eq!(found_in(&format!("data{home}x ..{home}y")), 0);
        assert_eq!(found_in("/usr/share/vulkan/icd.d /tmp/x"), 0);
    }

    #[test]
    fn the_message_names_file_line_and_limit() {
        let found = machine_paths_in("a.rs", "x\n/build/clone", &["/build/clone".to_owned()]);
        assert!(found[0].starts_with("a.rs:2:"), "{}", found[0]);
        assert!(too_large("b.bin", 1_000_001).starts_with("b.bin: 1000001 bytes"));
    }
}
