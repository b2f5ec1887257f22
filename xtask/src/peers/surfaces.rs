//! Our surface and VTK's against a mesh of the same particles.

use std::path::Path;

use super::tool::Tools;
use crate::{error::Result, process};

/// The program that does it.
pub const PROGRAM: &str = "bench-surface-quality";

/// Prints tables and draws `picture`; `scratch` keeps what VTK reads and writes.
pub fn compare(tools: &Tools, scratch: &Path, picture: &Path, data: Option<&Path>) -> Result<()> {
    let mut program = tools.ours(PROGRAM);
    program.arg("--scratch").arg(scratch).arg("--picture").arg(picture);
    if let Some(data) = data {
        program.arg("--data").arg(data);
    }
    if let Some(vtk) = &tools.vtk {
        program.args(["--vtk", vtk.python]);
    }
    process::run(&mut program)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The committed picture is there, and small enough for a repository.
    #[test]
    fn the_committed_picture_is_small() {
        let picture = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/surface-quality.jpg");
        let size = std::fs::metadata(picture).unwrap().len();
        assert!((1..150_000).contains(&size), "{size} bytes");
    }
}
