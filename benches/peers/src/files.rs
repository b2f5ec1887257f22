//! The files that all tools read.

use std::error::Error;
use std::path::Path;

use bench_views::View;
use meniscus_cases::CaseFrame;
use meniscus_core::Cancel;
use meniscus_io::writer::{
    Values, WriteAttribute, WriteParticles, write_legacy_binary, write_vtu_raw, write_vtu_zlib,
};
use serde_json::{Value, json};

/// Writes the frame of `view` into `folder`, as a raw file and with `encodings` in the others that our writer knows, and says where everything is, in the files' own coordinates.
pub fn make(view: &str, folder: &Path, divide: u64, encodings: bool) -> Result<Value, Box<dyn Error>> {
    let names = View::all().map(|view| view.name);
    let view = View::all()
        .into_iter()
        .find(|known| known.name == view)
        .ok_or_else(|| format!("no view is called '{view}'; benches/views has {}", names.join(", ")))?;
    let view = View { particles: (view.particles / divide.max(1)).max(1), ..view };
    std::fs::create_dir_all(folder)?;
    let files = ["raw.vtu", "zlib.vtu", "legacy.vtk"].map(|name| folder.join(name));
    let writers = [write_vtu_raw, write_vtu_zlib, write_legacy_binary];
    let wanted = if encodings { 3 } else { 1 };
    // Millions of particles take their time; a file that is there was written beside and renamed.
    if !files[..wanted].iter().all(|file| file.exists()) {
        let frame = view.source().case_frame(view.frame, &Cancel::default())?;
        for (file, writer) in files.iter().zip(writers).take(wanted) {
            write(file, &frame, writer)?;
        }
    }
    let space = view.space();
    let in_file = |point: [f32; 3]| -> [f64; 3] {
        std::array::from_fn(|axis| f64::from(point[axis]) + space.origin[axis])
    };
    let text = |point: [f64; 3]| point.map(|c| format!("{c:.6}")).join(",");
    let camera =
        format!("{}/{}/0,0,1/{}", text(in_file(view.eye)), text(in_file(view.target)), view.fovy_deg);
    Ok(json!({
        "view": view.name,
        "why": view.why,
        "particles": view.particles,
        "size": view.size,
        "camera": camera,
        "spacing": space.spacing,
        "radius": space.radius,
        "covered_fraction": view.covered_fraction,
        "raw": files[0],
        "zlib": files[1],
        "legacy": files[2],
    }))
}

/// The three attributes that reading is judged with.
fn write(
    path: &Path,
    frame: &CaseFrame,
    write: fn(&Path, &WriteParticles<'_>) -> Result<(), meniscus_io::Error>,
) -> Result<(), Box<dyn Error>> {
    let attribute = |name, components, values| WriteAttribute { name, components, values };
    let attributes = [
        attribute("velocity", 3, Values::F32(frame.velocities.as_flattened())),
        attribute("density", 1, Values::F32(&frame.density)),
        attribute("pressure", 1, Values::F32(&frame.pressure)),
    ];
    let particles =
        WriteParticles { positions: &frame.positions, attributes: &attributes, time: Some(frame.time) };
    // The writers choose by argument, not by ending; so any name will do until the file is whole.
    let beside = path.with_extension("part");
    write(&beside, &particles)?;
    Ok(std::fs::rename(&beside, path)?)
}
