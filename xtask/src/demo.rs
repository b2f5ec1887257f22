//! `cargo xtask demo`: from a fresh clone to a picture and a film of water.

use std::{path::Path, process::Command, time::Instant};

use cargo_metadata::MetadataCommand;
use clap::Args;

use crate::{
    error::{Error, Result},
    prerequisites,
    process::{cargo, run as run_process},
};

/// Build meniscus, make a small dam break and render a picture and a short film of it.
///
/// Builds without the viewer, so no window system is needed; renders on the GPU, or without one on the CPU through
/// Mesa's lavapipe. Everything it writes is under target/demo. Takes up to 15 minutes on two cores the first time,
/// most of it compiling.
///
/// Where the driver is missing, the apt-get line is printed; with --install, or as root, it is run.
#[derive(Args)]
#[command(after_help = "Examples:\n  cargo xtask demo\n  cargo xtask demo --install --size 1920x1080")]
pub struct Options {
    /// Install missing Debian packages (with sudo, unless root)
    #[arg(long)]
    install: bool,

    /// Size of the pictures in pixels
    #[arg(long, value_name = "WxH", default_value = "1280x720", value_parser = size)]
    size: String,
}

/// Enough for splashes that look like water, few enough for a CPU to draw in seconds.
const PARTICLES: &str = "400000";

/// A second of film at 24 frames per second.
const FRAMES: usize = 24;

/// The frame of the still picture, from the middle of the film, where the water is on its way.
const STILL: usize = FRAMES / 2;

/// Builds, makes, renders, and says where everything is.
pub fn run(options: &Options) -> Result<()> {
    let start = Instant::now();
    let metadata = MetadataCommand::new().no_deps().exec()?;
    let variables = prerequisites::ensure(metadata.workspace_root.as_std_path(), options.install)?;

    run_process(
        cargo(["build", "--release", "--package", "meniscus", "--no-default-features"])
            .current_dir(&metadata.workspace_root),
    )?;
    let program = metadata.target_directory.join("release/meniscus");
    let meniscus = |arguments: &[&str]| {
        run_process(Command::new(&program).args(arguments).envs(variables.iter().cloned()))
    };

    let folder = metadata.target_directory.join("demo");
    create_empty(folder.as_std_path())?;
    let data = folder.join("data");
    let still = folder.join("water.png");
    let film = folder.join("water.mp4");
    meniscus(&[
        "make",
        "dam-break",
        "-o",
        data.as_str(),
        "--particles",
        PARTICLES,
        "--frames",
        &FRAMES.to_string(),
        "--format",
        "vtu-zlib",
    ])?;
    meniscus(&[
        "render",
        data.as_str(),
        "-o",
        still.as_str(),
        "--frame",
        &STILL.to_string(),
        "--size",
        &options.size,
    ])?;
    meniscus(&["render", data.as_str(), "-o", film.as_str(), "--size", &options.size])?;
    for written in [&still, &film] {
        if std::fs::metadata(written).map_or(0, |file| file.len()) == 0 {
            return Err(Error::NotWritten { path: written.into() });
        }
    }
    println!("\ndone in {:.0} s\n", start.elapsed().as_secs_f64());
    println!("particles  {data}");
    println!("picture    {still}");
    println!("film       {film}");
    Ok(())
}

/// Checked here, not by meniscus, which is built first: nobody should wait minutes for a typing error.
fn size(text: &str) -> std::result::Result<String, String> {
    let is_side = |side: &str| side.parse::<u32>().is_ok_and(|pixels| pixels > 0);
    match text.split_once('x') {
        Some((width, height)) if is_side(width) && is_side(height) => Ok(text.to_owned()),
        _ => Err("expected width and height in pixels, as in 1280x720".to_owned()),
    }
}

/// An earlier run must not leave frames among ours.
fn create_empty(folder: &Path) -> Result<()> {
    let file_error = |source| Error::File { path: folder.to_owned(), source };
    if folder.exists() {
        std::fs::remove_dir_all(folder).map_err(file_error)?;
    }
    std::fs::create_dir_all(folder).map_err(file_error)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_two_positive_numbers() {
        assert_eq!(size("1280x720"), Ok("1280x720".to_owned()));
        for wrong in ["", "1280", "1280x", "0x720", "1280*720", "-1x5", "axb"] {
            assert!(size(wrong).is_err(), "{wrong:?}");
        }
    }

    #[test]
    fn nothing_of_an_earlier_run_is_kept() {
        let parent = tempfile::tempdir().unwrap();
        let folder = parent.path().join("demo");
        create_empty(&folder).unwrap();
        std::fs::write(folder.join("water.mp4"), "").unwrap();
        std::fs::create_dir(folder.join("data")).unwrap();
        create_empty(&folder).unwrap();
        assert_eq!(std::fs::read_dir(&folder).unwrap().count(), 0);
    }
}
