//! How close the screen-space surface comes to a mesh that is reconstructed from the same particles: `cargo xtask peers --surfaces`.

#![expect(clippy::print_stdout, clippy::print_stderr, reason = "a program; printing is its job")]

mod cast;
mod compare;
mod mesh;
mod ours;
mod picture;
mod subject;
mod surface;
#[cfg(test)]
mod tests;
mod vtk;

use std::error::Error;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Parser;
use meniscus_pipeline::{Registry, Settings};

use compare::{Comparison, Spread, compare};
use mesh::Reconstruction;
use subject::{SIZE, SUBJECTS, Subject};
use surface::Surface;

/// As `meniscus` has it.
#[global_allocator]
static ALLOCATOR: meniscus_huge_pages::HugePages = meniscus_huge_pages::HugePages;

/// Compare the surfaces that filters make with a reconstructed mesh, as rows of a table for benches/RESULTS.md.
#[derive(Parser)]
struct Arguments {
    /// Only these filters [default: all]
    #[arg(long, value_delimiter = ',')]
    filters: Vec<String>,

    /// A parameter of the surface, as `meniscus render` takes it, e.g. filter.sigma=0.8
    #[arg(long = "param", value_name = "KEY=VALUE")]
    params: Vec<String>,

    /// Degrees above the horizon to look from, in place of where `meniscus render` would
    #[arg(long, value_name = "DEGREES", value_parser = clap::value_parser!(i16).range(1..=80))]
    elevation: Option<i16>,

    /// Folder of third-party data [default: MENISCUS_DATA, else ../shared/data beside the workspace]
    #[arg(long)]
    data: Option<PathBuf>,

    /// A Python that has VTK; without, VTK's surface is left out
    #[arg(long, value_name = "PYTHON")]
    vtk: Option<PathBuf>,

    /// Where normals of the mesh, of the default filter and of VTK are drawn side by side, a JPEG
    #[arg(long)]
    picture: Option<PathBuf>,

    /// Folder for files that VTK reads and writes; made if missing
    #[arg(long, default_value = "target/surface-quality")]
    scratch: PathBuf,
}

/// How else the reference might have been made: coarser, and smoothed less. What these differ by from it, no screen-space surface can
/// be blamed for.
const OTHER_MESH: Reconstruction = Reconstruction { cube_radii: 0.75, smoothing_steps: 15, normal_steps: 10 };

/// VTK's settings, as `vtk_fluid.py` knows them.
const LOOKS: [(&str, &str); 2] = [("VTK, best settings", "best"), ("VTK, as it comes", "default")];

/// Rows that the picture shows, after the reference.
const SHOWN: [&str; 2] = [meniscus_ssfr::filter::DEFAULT, LOOKS[0].0];

fn run(arguments: &Arguments) -> Result<(), Box<dyn Error>> {
    let registry = Registry::builtin();
    let names: Vec<String> = match &arguments.filters[..] {
        [] => registry.filter_names().into_iter().map(str::to_owned).collect(),
        some => some.to_vec(),
    };
    let named = |name: String| settings(&name, arguments, &registry).map(|settings| (name, settings));
    let filters = names.into_iter().map(named).collect::<Result<Vec<_>, _>>()?;
    let data = arguments.data.clone().unwrap_or_else(|| {
        let beside = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data");
        std::env::var_os("MENISCUS_DATA").map_or(beside, PathBuf::from)
    });
    std::fs::create_dir_all(&arguments.scratch)?;
    println!("adapter: {}", ours::adapter()?);
    let mut pictures = Vec::new();
    for subject in &SUBJECTS {
        pictures.extend(rows(subject, &data, &filters, arguments)?);
    }
    if let Some(path) = &arguments.picture {
        picture::write(path, &pictures, SIZE)?;
        println!("wrote {}", path.display());
    }
    Ok(())
}

/// What the surface is drawn with by a filter.
fn settings(filter: &str, arguments: &Arguments, registry: &Registry) -> Result<Settings, Box<dyn Error>> {
    let mut settings = ours::settings();
    settings.choose_filter(registry, filter)?;
    for parameter in &arguments.params {
        let (key, value) =
            parameter.split_once('=').ok_or_else(|| format!("--param {parameter}: expected KEY=VALUE"))?;
        settings.set(key, value)?;
    }
    settings.validate(registry)?;
    Ok(settings)
}

/// Prints the rows of a subject, and gives the surfaces that the picture shows; `None` without the data.
fn rows(
    subject: &Subject,
    data: &Path,
    filters: &[(String, Settings)],
    arguments: &Arguments,
) -> Result<Option<Vec<Surface>>, Box<dyn Error>> {
    let Some(mut view) = subject.open(data, &ours::settings())? else {
        println!("SKIPPED: {}: not in {}; set MENISCUS_DATA", subject.name, data.display());
        return Ok(None);
    };
    if let Some(degrees) = arguments.elevation {
        view.look_from(f32::from(degrees).to_radians());
    }
    let spacing = view.world.space().spacing as f32;
    let reference = Reconstruction::default().mesh(view.positions(), spacing)?;
    println!(
        "\n**{}**: {} particles, drawn with a radius of {:.3} spacings; mesh of {} triangles\n",
        subject.name,
        view.positions().len(),
        view.world.space().radius / view.world.space().spacing,
        reference.triangles.len()
    );
    println!("| | angle, median | 95 % | offset | distance, median | 95 % | only it | only the mesh |");
    println!("|---|---|---|---|---|---|---|---|");
    let reference = cast::cast(&reference, &view.camera, SIZE);
    let mut shown = vec![reference.clone()];
    let mut row = |name: &str, surface: Surface| {
        let compared = compare(&surface, &reference, view.particle_radius());
        println!("| {name} | {} |", compared.map_or_else(|| "nothing in common".to_owned(), |c| columns(&c)));
        if SHOWN.contains(&name) {
            shown.push(surface);
        }
    };
    let other = OTHER_MESH.mesh(view.positions(), spacing)?;
    row("mesh, coarser and less smooth", cast::cast(&other, &view.camera, SIZE));
    for (name, settings) in filters {
        row(name, ours::draw(&view, SIZE, settings)?);
    }
    if let Some(python) = &arguments.vtk {
        for (name, look) in LOOKS {
            row(name, vtk::draw(&view, SIZE, python, look, &arguments.scratch)?);
        }
    }
    Ok(Some(shown))
}

fn columns(compared: &Comparison) -> String {
    let of = |spread: Spread, unit: &str| format!("{:.2}{unit} | {:.2}{unit}", spread.median, spread.p95);
    let distance = compared.distance.map_or_else(
        || "- | - | -".to_owned(),
        |distance| format!("{:+.2} | {}", distance.offset_radii, of(distance.spread_radii, "")),
    );
    let percent = |share: f64| format!("{:.2} %", 100.0 * share);
    let [only_it, only_mesh] = [compared.only_surface, compared.only_reference].map(percent);
    format!("{} | {distance} | {only_it} | {only_mesh}", of(compared.angle_deg, "°"))
}

fn main() -> ExitCode {
    match run(&Arguments::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}
