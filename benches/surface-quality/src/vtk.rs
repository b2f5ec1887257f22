//! The surface of VTK's fluid mapper.

use std::error::Error;
use std::path::Path;
use std::process::Command;

use glam::Vec3;
use meniscus_core::Projection;
use meniscus_io::writer::{WriteParticles, write_vtu_raw};

use crate::subject::View;
use crate::surface::Surface;

/// Normals come as colours of 8 bits, which this leaves of their length.
const LENGTH_TOLERANCE: f32 = 0.02;

/// Normals as VTK draws them with its settings `look` (`benches/peers/vtk_fluid.py`), by the interpreter `python`. Distances it does not
/// tell: it writes them to a depth buffer that cuts them off at 0.
///
/// # Errors
/// What the script says, or normals that are none.
pub fn draw(
    view: &View,
    size: [u32; 2],
    python: &Path,
    look: &str,
    scratch: &Path,
) -> Result<Surface, Box<dyn Error>> {
    let [particles, picture, normals] = ["water.vtu", "vtk.png", "vtk.f32"].map(|name| scratch.join(name));
    let positions: Vec<[f64; 3]> = view.positions().iter().map(|p| p.map(f64::from)).collect();
    write_vtu_raw(&particles, &WriteParticles { positions: &positions, attributes: &[], time: None })?;
    let camera = &view.camera;
    let Projection::Perspective { fovy_rad } = camera.projection else {
        return Err("VTK is compared in perspective only".into());
    };
    let comma = |v: Vec3| format!("{},{},{}", v.x, v.y, v.z);
    let camera =
        [comma(camera.eye), comma(camera.target), comma(camera.up), fovy_rad.to_degrees().to_string()];
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("../peers/vtk_fluid.py");
    let mut command = Command::new(python);
    command.arg(script).arg(particles).arg(picture).args(["--frames", "0", "--look", look]);
    command
        .arg(format!("--camera={}", camera.join("/")))
        .args(["--size", &format!("{}x{}", size[0], size[1])]);
    command.args(["--radius", &view.world.space().radius.to_string()]).arg("--normals").arg(&normals);
    let output = command.output().map_err(|error| format!("{}: {error}", python.display()))?;
    if !output.status.success() {
        return Err(format!("{command:?}: {}", String::from_utf8_lossy(&output.stderr).trim()).into());
    }
    let read: Vec<f32> = bytemuck::pod_collect_to_vec(&std::fs::read(&normals)?);
    if read.len() != 3 * size[0] as usize * size[1] as usize {
        return Err(format!("{}: {} numbers, expected 3 a pixel", normals.display(), read.len()).into());
    }
    let found: Vec<Vec3> = read.as_chunks().0.iter().map(|&n: &[f32; 3]| n.into()).collect();
    let is_off = |n: &&Vec3| **n != Vec3::ZERO && (n.length() - 1.0).abs() > LENGTH_TOLERANCE;
    let (off, covered) =
        (found.iter().filter(is_off).count(), found.iter().filter(|n| **n != Vec3::ZERO).count());
    if off * 100 > covered {
        return Err(format!("{}: {off} of {covered} normals are no unit vectors", normals.display()).into());
    }
    Ok(Surface { normal: found.iter().map(|n| n.normalize_or_zero()).collect(), distance: None })
}
