//! `cargo xtask peers`: VTK's fluid mapper and readers beside ours.

mod fluid;
mod gallery;
mod page;
mod python;
mod readers;
mod samples;
mod surfaces;
mod tool;

use std::path::PathBuf;

use cargo_metadata::MetadataCommand;
use clap::Args;
use serde_json::json;

use crate::{
    error::{Error, Result},
    machine, prerequisites,
    process::{cargo, run as run_process},
    sabotage::data_folder,
};
use tool::Tools;

/// Compare with VTK: the same files, cores, camera, radius and picture size, taken in turn in one run.
///
/// Pictures: VTK's fluid mapper, with its own settings and with those that look most like water, against `meniscus bench`,
/// on the committed views (`benches/views`) at their radius and at the 0.9 spacings of the published comparison. Every
/// round has its median frame; printed are median, smallest and largest of the rounds. The camera orbits by half a degree a
/// frame; set-up is not counted.
///
/// Readers: MB of file per second, warm page cache, a new reader every time. `copy` is what no reader can be faster than: the
/// file's bytes from the page cache to memory.
///
/// --gallery: instead of measuring, draws sphere entry, PySPH's dam break and the fjord, ours without flags, VTK's with its best
/// settings among our surroundings, as one small JPEG each. The dam break needs the third-party data (MENISCUS_DATA, else
/// ../shared/data).
///
/// --surfaces: instead of measuring times, tells how far normals and distances of every filter of ours, and normals of VTK's fluid
/// mapper, are from a mesh that splashsurf reconstructs from the same particles, and draws the normals side by side.
///
/// Needs Python and VTK (`pip install vtk`). Without them the peers' part is skipped and said so; with --require that is an
/// error. Writes pictures, peers.json and index.html to target/peers. Whatever the times, the exit code is 0.
#[derive(Args)]
#[command(after_help = "Examples:\n  \
    cargo xtask peers\n  \
    cargo xtask peers --views dam-break\n  \
    cargo xtask peers --readers-only\n  \
    cargo xtask peers --quick --require\n  \
    cargo xtask peers --gallery\n  \
    cargo xtask peers --surfaces")]
pub struct Options {
    /// Views to draw
    #[arg(long, value_delimiter = ',', default_values_t = ["dam-break", "sphere-entry", "fjord-tsunami"].map(String::from))]
    views: Vec<String>,

    /// How often the tools take turns
    #[arg(long, default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..=100))]
    rounds: u32,

    /// A hundredth of the particles, one round: only to see that it works
    #[arg(long)]
    quick: bool,

    /// Only the readers
    #[arg(long, conflicts_with = "pictures_only")]
    readers_only: bool,

    /// Only the pictures
    #[arg(long)]
    pictures_only: bool,

    /// Only small pictures of both beside each other, into this folder [default: docs/beside-vtk]
    #[arg(
        long,
        value_name = "FOLDER",
        conflicts_with_all = ["views", "rounds", "quick", "readers_only", "pictures_only"]
    )]
    gallery: Option<Option<PathBuf>>,

    /// Only the surfaces, and their normals as this picture [default: docs/surface-quality.jpg]
    #[arg(
        long,
        value_name = "JPEG",
        conflicts_with_all = ["views", "rounds", "quick", "readers_only", "pictures_only", "gallery"]
    )]
    surfaces: Option<Option<PathBuf>>,

    /// Take our programs from this folder, already built, instead of building them
    #[arg(long, value_name = "FOLDER")]
    programs: Option<PathBuf>,

    /// Fail where a peer is missing
    #[arg(long)]
    require: bool,

    /// Install missing Debian packages (with sudo, unless root)
    #[arg(long)]
    install: bool,
}

/// Compares.
pub fn run(options: &Options) -> Result<()> {
    let metadata = MetadataCommand::new().no_deps().exec()?;
    let workspace = metadata.workspace_root.as_std_path();
    let variables = prerequisites::ensure(workspace, options.install)?;
    let vtk = python::find_vtk(workspace, &variables);
    if let Err(reason) = &vtk {
        let reason =
            format!("{reason}; VTK comes with `pip install vtk`, its OpenGL with libgl1 and libegl1");
        if options.require {
            return Err(Error::NoPeer(reason));
        }
        println!("SKIPPED: VTK's side: {reason}");
    }
    let programs = match &options.programs {
        // They are started in other folders, too.
        Some(built) => built.canonicalize().map_err(|source| Error::File { path: built.clone(), source })?,
        None => {
            let programs: &[&str] =
                if options.surfaces.is_some() { &[surfaces::PROGRAM] } else { &["meniscus", "bench-peers"] };
            let packages = programs.iter().flat_map(|program| ["--package", *program]);
            run_process(cargo(["build", "--release"]).args(packages).current_dir(workspace))?;
            metadata.target_directory.join("release").into()
        }
    };
    let folder: PathBuf = metadata.target_directory.join("peers").into();
    std::fs::create_dir_all(&folder).map_err(|source| Error::File { path: folder.clone(), source })?;
    let state = machine::state();
    println!("{state}");
    let tools = Tools { ours: programs, scripts: workspace.join("benches/peers"), variables, vtk: vtk.ok() };
    let data = data_folder(workspace).map(PathBuf::from);
    if let Some(picture) = &options.surfaces {
        let picture = picture.clone().unwrap_or_else(|| workspace.join("docs/surface-quality.jpg"));
        return surfaces::compare(&tools, &folder.join("surfaces"), &picture, data.as_deref());
    }
    if let Some(gallery) = &options.gallery {
        let gallery = gallery.clone().unwrap_or_else(|| workspace.join("docs/beside-vtk"));
        return gallery::draw(&tools, &folder.join("gallery"), &gallery, data.as_deref());
    }
    let divide = if options.quick { 100 } else { 1 };
    let rounds = if options.quick { 1 } else { options.rounds };

    let mut views = Vec::new();
    if !options.readers_only {
        for view in &options.views {
            views.push(fluid::compare(&tools, &folder, view, divide, rounds)?);
        }
    }
    let mut files = Vec::new();
    if !options.pictures_only {
        files = readers::compare(&tools, &folder, divide)?;
    }

    let text = fluid::markdown(&views) + &readers::markdown(&files);
    println!("\n{text}");
    let version = tools.vtk.as_ref().map_or("not there", |vtk| vtk.version.as_str());
    let record = json!({ "machine": state, "vtk": version, "views": views, "files": files });
    let write = |name: &str, content: &str| {
        let path = folder.join(name);
        std::fs::write(&path, content).map_err(|source| Error::File { path: path.clone(), source })?;
        println!("wrote {}", path.display());
        Ok(())
    };
    write("peers.json", &format!("{record:#}\n"))?;
    write("index.html", &page::html(&state, version, &views, &files))
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::*;

    #[derive(Parser)]
    struct Line {
        #[command(flatten)]
        options: Options,
    }

    fn gallery(line: &str) -> Option<Option<PathBuf>> {
        Line::try_parse_from(line.split(' ')).expect("a line that is right").options.gallery
    }

    #[test]
    fn a_gallery_is_drawn_where_it_is_asked_for_and_measures_nothing() {
        assert_eq!(gallery("peers"), None);
        assert_eq!(gallery("peers --gallery"), Some(None));
        assert_eq!(gallery("peers --gallery here --require"), Some(Some("here".into())));
        for measuring in ["--quick", "--views dam-break", "--rounds 2", "--readers-only", "--pictures-only"] {
            let line = format!("peers {measuring} --gallery");
            assert!(Line::try_parse_from(line.split(' ')).is_err(), "{line}");
        }
    }

    #[test]
    fn surfaces_are_compared_alone() {
        let surfaces = |line: &str| Line::try_parse_from(line.split(' ')).map(|line| line.options.surfaces);
        assert_eq!(surfaces("peers").unwrap(), None);
        assert_eq!(surfaces("peers --surfaces").unwrap(), Some(None));
        assert_eq!(surfaces("peers --surfaces here.jpg --require").unwrap(), Some(Some("here.jpg".into())));
        for other in ["--quick", "--readers-only", "--gallery"] {
            assert!(surfaces(&format!("peers {other} --surfaces")).is_err(), "{other}");
        }
    }
}
