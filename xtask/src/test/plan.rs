//! Which `cargo test` commands a set of arguments stands for.

/// Flags with which the user chooses packages; otherwise it is the whole workspace.
const PACKAGES: &[&str] = &["-p", "--package", "--workspace", "--all", "--manifest-path"];

/// Flags with which the user chooses targets; otherwise it is all of them, then the documentation tests.
const TARGETS: &[&str] =
    &["--lib", "--bin", "--bins", "--test", "--tests", "--example", "--examples", "--bench", "--benches"];

/// The arguments of each cargo command to run, in order.
///
/// `--all-targets` leaves documentation tests out, and cargo cannot do both at once: hence two commands.
/// `--show-output` prints what passing tests wrote, where [`super::report`] looks for skip notices.
/// `--no-fail-fast` because the totals are to be those of all tests.
pub fn invocations(given: &[String]) -> Vec<Vec<String>> {
    let split = given.iter().position(|argument| argument == "--").unwrap_or(given.len());
    let (for_cargo, for_tests) = given.split_at(split);
    let has = |flags: &[&str]| {
        for_cargo.iter().any(|argument| {
            let name = argument.split('=').next().unwrap_or_default();
            flags.contains(&name)
                || (flags.contains(&"-p") && name.starts_with("-p") && !name.starts_with("--"))
        })
    };
    let target_choices: &[&[&str]] = match (has(TARGETS), has(&["--doc"])) {
        (true, _) | (_, true) => &[&[]],
        _ => &[&["--all-targets"], &["--doc"]],
    };
    target_choices
        .iter()
        .map(|targets| {
            let mut arguments = vec!["test", "--no-fail-fast", "--color", "never"];
            if !has(PACKAGES) {
                arguments.push("--workspace");
            }
            arguments.extend(targets.iter());
            let mut arguments: Vec<String> = arguments.into_iter().map(String::from).collect();
            arguments.extend_from_slice(for_cargo);
            arguments.extend(["--", "--show-output"].map(String::from));
            arguments.extend(for_tests.iter().skip(1).cloned());
            arguments
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn planned(given: &str) -> Vec<String> {
        let given: Vec<String> = given.split_whitespace().map(String::from).collect();
        let common = "test --no-fail-fast --color never ";
        invocations(&given)
            .iter()
            .map(|arguments| arguments.join(" ").strip_prefix(common).unwrap().to_owned())
            .collect()
    }

    #[test]
    fn everything_is_the_default() {
        assert_eq!(
            planned(""),
            ["--workspace --all-targets -- --show-output", "--workspace --doc -- --show-output"]
        );
    }

    #[test]
    fn chosen_packages_replace_the_workspace() {
        for choice in ["-p meniscus-io", "-pmeniscus-io", "--package=meniscus-io"] {
            assert_eq!(planned(choice)[0], format!("--all-targets {choice} -- --show-output"));
        }
    }

    #[test]
    fn chosen_targets_replace_all_targets_and_documentation() {
        assert_eq!(planned("--lib"), ["--workspace --lib -- --show-output"]);
        assert_eq!(planned("--doc"), ["--workspace --doc -- --show-output"]);
        assert_eq!(planned("--test=golden"), ["--workspace --test=golden -- --show-output"]);
    }

    #[test]
    fn what_follows_the_dashes_reaches_the_tests() {
        assert_eq!(
            planned("name -- -p --test-threads 1")[0],
            "--workspace --all-targets name -- --show-output -p --test-threads 1"
        );
    }
}
