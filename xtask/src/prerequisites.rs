//! What the machine must have before anything is rendered, and how to get it.

use std::{
    path::{Path, PathBuf},
    process::Command,
};

use crate::{
    drivers::{self, Machine, Vulkan},
    error::{Error, Result},
    process,
};

/// Makes sure that there are a Vulkan driver and, if a dependency compiles C or C++, a compiler for it.
///
/// What is missing is installed with apt-get, if `install` says so or we are root anyway (a container, CI);
/// otherwise the error holds the one line to type. Returns the variables that rendering commands must be given.
pub fn ensure(workspace: &Path, install: bool) -> Result<Vec<(&'static str, String)>> {
    let path = workspace.join("Cargo.lock");
    let lock_file = std::fs::read_to_string(&path).map_err(|source| Error::File { path, source })?;
    let look = |vulkan: &Vulkan| Missing {
        vulkan: !vulkan.is_usable(),
        c_compiler: compiles_c(&lock_file) && !has_compiler("CC", &["cc", "gcc", "clang"]),
        cpp_compiler: compiles_cpp(&lock_file) && !has_compiler("CXX", &["c++", "g++", "clang++"]),
    };
    let mut vulkan = find_vulkan();
    let missing = look(&vulkan);
    if missing.any() {
        eprintln!("{}", missing.explanation(&vulkan));
        if let Some(variable) = steering_variable(|name| std::env::var(name).ok()).filter(|_| missing.vulkan)
        {
            return Err(Error::NoSuchDriver { variable });
        }
        if !(install || is_root()) {
            return Err(Error::Missing { missing: missing.names(), install: missing.apt_line() });
        }
        install_packages(&missing)?;
        vulkan = find_vulkan();
        let still = look(&vulkan);
        if still.any() {
            return Err(Error::StillMissing(still.names()));
        }
    }
    let drivers = vulkan.drivers.iter().chain(&vulkan.unlisted).map(|path| path.display().to_string());
    println!("Vulkan drivers: {}", drivers.collect::<Vec<_>>().join(", "));
    Ok(variables(&vulkan))
}

/// What is not there.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Missing {
    vulkan: bool,
    c_compiler: bool,
    cpp_compiler: bool,
}

impl Missing {
    fn any(self) -> bool {
        self.vulkan || self.c_compiler || self.cpp_compiler
    }

    fn names(self) -> String {
        let names = [
            (self.vulkan, "a Vulkan driver"),
            (self.c_compiler, "a C compiler"),
            (self.cpp_compiler, "a C++ compiler"),
        ];
        names
            .into_iter()
            .filter(|(is_missing, _)| *is_missing)
            .map(|(_, n)| n)
            .collect::<Vec<_>>()
            .join(" and ")
    }

    fn packages(self) -> Vec<&'static str> {
        let mut packages = Vec::new();
        if self.vulkan {
            packages.extend(["mesa-vulkan-drivers", "libvulkan1"]);
        }
        if self.c_compiler {
            packages.extend(["gcc", "libc6-dev"]);
        }
        if self.cpp_compiler {
            packages.push("g++");
        }
        packages
    }

    /// The arguments of apt-get that install it all.
    fn apt_arguments(self) -> Vec<&'static str> {
        let mut arguments = vec!["install", "-y", "--no-install-recommends"];
        arguments.extend(self.packages());
        arguments
    }

    fn apt_line(self) -> String {
        format!("apt-get {}", self.apt_arguments().join(" "))
    }

    /// What was looked for and what was found instead.
    fn explanation(self, vulkan: &Vulkan) -> String {
        let mut lines = vec![format!("missing: {}", self.names())];
        if self.vulkan && vulkan.loader.is_none() {
            lines.push("  the Vulkan loader libvulkan.so.1 was not found".to_owned());
        }
        if self.vulkan && vulkan.drivers.is_empty() {
            lines.push(
                "  no driver manifest was found in .../vulkan/icd.d, nor by VK_DRIVER_FILES".to_owned(),
            );
        }
        let broken = |path: &PathBuf| format!("  {}: the library it names is not there", path.display());
        lines.extend(vulkan.broken.iter().map(broken));
        lines.join("\n")
    }
}

/// Manifests where no loader looks have to be passed on by name.
fn variables(vulkan: &Vulkan) -> Vec<(&'static str, String)> {
    if vulkan.unlisted.is_empty() {
        return Vec::new();
    }
    let given = std::env::var("VK_ADD_DRIVER_FILES").ok().filter(|given| !given.is_empty());
    let unlisted = vulkan.unlisted.iter().map(|path| path.display().to_string());
    vec![("VK_ADD_DRIVER_FILES", given.into_iter().chain(unlisted).collect::<Vec<_>>().join(":"))]
}

/// The variable, if any, that keeps the loader from the folders into which packages install their drivers.
fn steering_variable(value: impl Fn(&str) -> Option<String>) -> Option<&'static str> {
    let is_set = |name: &&str| value(name).is_some_and(|value| !value.is_empty());
    ["VK_DRIVER_FILES", "VK_ICD_FILENAMES"].into_iter().find(is_set)
}

fn find_vulkan() -> Vulkan {
    drivers::find(&Machine { root: PathBuf::from("/"), variable: &|name| std::env::var(name).ok() })
}

/// Whether some dependency's build script calls a C compiler, by way of the `cc` crate. The lock file tells without a
/// download.
fn compiles_c(lock_file: &str) -> bool {
    lock_file.lines().any(|line| line == r#"name = "cc""#)
}

/// Whether one of them compiles C++: the encoder of films, and FLIP, by which pictures are compared, are their authors' own code.
fn compiles_cpp(lock_file: &str) -> bool {
    let names = [r#"name = "openh264-sys2""#, r#"name = "nv-flip-sys""#];
    lock_file.lines().any(|line| names.contains(&line))
}

/// Whether there is one of the compilers that the `cc` crate tries, or the one that it is told by `variable`.
fn has_compiler(variable: &str, names: &[&str]) -> bool {
    let told = std::env::var(variable).ok();
    names.iter().copied().chain(told.as_deref()).any(is_program)
}

fn is_program(name: &str) -> bool {
    let folders = std::env::var_os("PATH").unwrap_or_default();
    Path::new(name).is_file() || std::env::split_paths(&folders).any(|folder| folder.join(name).is_file())
}

fn is_root() -> bool {
    let output = Command::new("id").arg("-u").output();
    output.is_ok_and(|output| output.stdout.trim_ascii() == b"0")
}

fn install_packages(missing: &Missing) -> Result<()> {
    let apt_get = |arguments: &[&str]| {
        let mut command = match is_root() {
            true => Command::new("apt-get"),
            false => Command::new("sudo"),
        };
        if !is_root() {
            command.arg("apt-get");
        }
        process::run(command.args(arguments).env("DEBIAN_FRONTEND", "noninteractive"))
    };
    apt_get(&["update"])?;
    apt_get(&missing.apt_arguments())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_line_installs_what_is_missing_and_nothing_else() {
        let only_vulkan = Missing { vulkan: true, c_compiler: false, cpp_compiler: false };
        assert_eq!(
            only_vulkan.apt_line(),
            "apt-get install -y --no-install-recommends mesa-vulkan-drivers libvulkan1"
        );
        let all = Missing { vulkan: true, c_compiler: true, cpp_compiler: true };
        assert!(all.apt_line().ends_with("mesa-vulkan-drivers libvulkan1 gcc libc6-dev g++"));
        assert_eq!(all.names(), "a Vulkan driver and a C compiler and a C++ compiler");
        assert!(!Missing { vulkan: false, c_compiler: false, cpp_compiler: false }.any());
    }

    #[test]
    fn the_explanation_names_what_was_found_instead() {
        let vulkan = Vulkan { broken: vec!["/etc/vulkan/icd.d/x.json".into()], ..Vulkan::default() };
        let text = Missing { vulkan: true, c_compiler: false, cpp_compiler: false }.explanation(&vulkan);
        assert!(text.contains("libvulkan.so.1") && text.contains("x.json: the library"), "{text}");
    }

    #[test]
    fn only_unlisted_manifests_are_passed_on() {
        let mut vulkan = Vulkan { drivers: vec!["/a.json".into()], ..Vulkan::default() };
        assert!(variables(&vulkan).is_empty());
        vulkan.unlisted.push("/b.json".into());
        assert_eq!(variables(&vulkan).len(), 1);
        assert!(variables(&vulkan)[0].1.ends_with("/b.json"));
    }

    #[test]
    fn a_variable_that_hides_installed_drivers_is_named() {
        let only = |set: &'static str| move |name: &str| (name == set).then(|| "/x.json".to_owned());
        assert_eq!(steering_variable(only("VK_ICD_FILENAMES")), Some("VK_ICD_FILENAMES"));
        assert_eq!(steering_variable(only("VK_ADD_DRIVER_FILES")), None);
        assert_eq!(steering_variable(|_| Some(String::new())), None);
    }

    #[test]
    fn the_lock_file_tells_who_compiles_c() {
        assert!(compiles_c("[[package]]\nname = \"cc\"\nversion = \"1.11.1\"\n"));
        assert!(compiles_cpp("name = \"openh264-sys2\"\n") && !compiles_cpp("name = \"nv-flip\"\n"));
        assert!(!compiles_c("[[package]]\nname = \"ccc\"\ndependencies = [\n \"cc-lib\",\n]\n"));
    }

    #[test]
    fn programs_are_looked_up_on_the_path() {
        assert!(is_program("sh") && !is_program("no-such-program-here"));
    }
}
