//! The program without its viewer runs, and builds, where there is no window system.

use crate::{
    error::Result,
    process::{capture, cargo},
};

/// Packages that stand for a window system, or for a library that opens windows. `raw-window-handle`, a few types
/// without code, is not one of them.
pub fn is_window_system(name: &str) -> bool {
    const EXACT: &[&str] = &["winit", "eframe", "glutin", "glfw", "sdl2", "sdl3", "softbuffer", "xcb"];
    const PREFIXES: &[&str] = &["egui", "x11", "xkbcommon", "wayland-", "smithay-client-toolkit"];
    EXACT.contains(&name) || PREFIXES.iter().any(|prefix| name.starts_with(prefix))
}

/// Asks cargo what `meniscus` is made of without its default features; each offender comes with its path.
pub fn offences_of_program() -> Result<Vec<String>> {
    let tree = |more: &[&str]| -> Result<String> {
        let arguments = ["tree", "-p", "meniscus", "--no-default-features", "-e", "normal,build"];
        let output = capture(&mut cargo(arguments.iter().chain(more)))?;
        Ok(String::from_utf8_lossy(&output).into_owned())
    };
    let packages = tree(&["--prefix", "none", "--format", "{p}"])?;
    offenders(&packages)
        .into_iter()
        .map(|specification| {
            let path = tree(&["--invert", &specification])?;
            Ok(format!("meniscus --no-default-features depends on {specification}:\n{path}"))
        })
        .collect()
}

/// The window systems in a listing of `name vVERSION ...` lines, as package specifications (`name@version`).
fn offenders(listing: &str) -> Vec<String> {
    let mut found: Vec<String> = listing
        .lines()
        .filter_map(|line| {
            let mut words = line.split_whitespace();
            let (name, version) = (words.next()?, words.next()?);
            is_window_system(name).then(|| format!("{name}@{}", version.trim_start_matches('v')))
        })
        .collect();
    found.sort();
    found.dedup();
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn window_systems_are_found_once_each() {
        let listing = "meniscus v0.1.0 (/somewhere)\nwgpu v30.0.1\nraw-window-handle v0.6.2\n\
                       winit v0.30.12\negui-winit v0.37.0\nwinit v0.30.12 (*)\nx11-dl v2.21.0\n";
        assert_eq!(offenders(listing), ["egui-winit@0.37.0", "winit@0.30.12", "x11-dl@2.21.0"]);
    }

    #[test]
    fn a_gpu_alone_is_no_window_system() {
        assert_eq!(offenders("wgpu v30.0.1\nash v0.38.0+1.3.281\nwinapi v0.3.9\n"), [""; 0]);
    }
}
