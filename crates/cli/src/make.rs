//! `meniscus make`.

use meniscus_cases::{CaseOptions, CaseSource};
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
    terminal.say(format_args!(
        "wrote {} frames of {} particles; draw them with: meniscus render {} -o '{stem}_%04d.png'",
        options.frames,
        options.particles,
        series.display()
    ));
    Ok(())
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
