//! `meniscus make`.

use std::path::{Path, PathBuf};

use meniscus_cases::{CaseOptions, CaseSource, Ground};
use meniscus_export::{ExportError, write_text};
use meniscus_io::writer::{self, Values, WriteAttribute, WriteParticles};

use crate::args::{MakeArgs, MakeFormat};
use crate::failure::Failure;
use crate::terminal::{Terminal, interrupt};

pub fn run(args: &MakeArgs, terminal: &Terminal) -> Result<(), Failure> {
    let case = args.case.0;
    let published = CaseOptions::published(case);
    let options = CaseOptions {
        particles: args.particles.unwrap_or(published.particles),
        frames: args.frames as usize,
        seed: args.seed,
    };
    let source = CaseSource::new(case, options).map_err(|e| Failure::Usage(e.to_string()))?;
    let cancel = interrupt();
    let unwritable = |source| Failure::Output(ExportError::Io { path: args.output.clone(), source });
    std::fs::create_dir_all(&args.output).map_err(unwritable)?;
    let stem = case.name().replace('-', "_");
    let ending = match args.format {
        MakeFormat::VtuRaw | MakeFormat::VtuZlib => "vtu",
        MakeFormat::VtkBinary => "vtk",
    };
    let bar = terminal.progress(options.frames as u64, "frames");
    let mut entries = Vec::with_capacity(options.frames);
    for index in 0..options.frames {
        let frame = source.case_frame(index, &cancel)?;
        let name = format!("{stem}_{index:04}.{ending}");
        let path = args.output.join(&name);
        let attributes = [
            attribute("velocity", 3, Values::F32(frame.velocities.as_flattened())),
            attribute("density", 1, Values::F32(&frame.density)),
            attribute("pressure", 1, Values::F32(&frame.pressure)),
            attribute("id", 1, Values::I64(&frame.ids)),
        ];
        let particles =
            WriteParticles { positions: &frame.positions, attributes: &attributes, time: Some(frame.time) };
        match args.format {
            MakeFormat::VtuRaw => writer::write_vtu_raw(&path, &particles),
            MakeFormat::VtuZlib => writer::write_vtu_zlib(&path, &particles),
            MakeFormat::VtkBinary => writer::write_legacy_binary(&path, &particles),
        }
        .map_err(output)?;
        entries.push((frame.time, name));
        bar.inc(1);
    }
    bar.finish_and_clear();
    let series = args.output.join(format!("{stem}.pvd"));
    write_text(&series, &collection(&entries))?;
    let scene = case.ground().map(|ground| write_scene(&args.output, &stem, &ground)).transpose()?;
    let flag = scene.map(|scene| format!("--scene {} ", scene.display())).unwrap_or_default();
    terminal.say(format_args!(
        "wrote {} frames of {} particles; draw them with: meniscus render {} {flag}-o '{stem}_%04d.png'",
        options.frames,
        options.particles,
        series.display()
    ));
    Ok(())
}

/// What the land around the water looks like, and where the sun stands for its slopes to be seen.
const LAND: &str = r#"material = "slopes"

[materials.slopes]
pattern = "soil"
color = [0.20, 0.185, 0.13]
roughness = 0.95
scale = 25

[sun]
azimuth_deg = 235
elevation_deg = 40
"#;

/// The land around the water, and the scene file that puts it there.
fn write_scene(folder: &Path, stem: &str, ground: &Ground) -> Result<PathBuf, Failure> {
    let terrain = format!("{stem}_ground.asc");
    write_text(&folder.join(&terrain), &esri_grid(ground))?;
    let scene = folder.join(format!("{stem}_scene.toml"));
    write_text(&scene, &format!("[[terrain]]\nfile = \"{terrain}\"\n{LAND}"))?;
    Ok(scene)
}

/// `ground` as an ESRI ASCII grid, whose rows go from north to south.
fn esri_grid(ground: &Ground) -> String {
    let Ground { south_west: [west, south], spacing, columns, heights } = ground;
    let rows = heights.len() / columns;
    let mut text =
        format!("ncols {columns}\nnrows {rows}\nxllcenter {west}\nyllcenter {south}\ncellsize {spacing}\n");
    for row in heights.chunks(*columns).rev() {
        let numbers: Vec<String> = row.iter().map(|height| format!("{height:.2}")).collect();
        text.push_str(&numbers.join(" "));
        text.push('\n');
    }
    text
}

/// A ParaView collection: time and file of every frame.
fn collection(entries: &[(f64, String)]) -> String {
    let files: String = entries
        .iter()
        .map(|(time, name)| format!("    <DataSet timestep=\"{time:?}\" part=\"0\" file=\"{name}\"/>\n"))
        .collect();
    format!(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\">\n  <Collection>\n{files}  </Collection>\n</VTKFile>\n"
    )
}

fn attribute<'a>(name: &'a str, components: usize, values: Values<'a>) -> WriteAttribute<'a> {
    WriteAttribute { name, components, values }
}

/// An error of the writer is about an output.
fn output(error: meniscus_io::Error) -> Failure {
    let path = error.file().map(ToOwned::to_owned).unwrap_or_default();
    Failure::Output(ExportError::Encode { path, message: error.to_string() })
}
