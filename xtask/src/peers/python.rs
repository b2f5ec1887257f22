//! Is there a Python with VTK that can draw without a display?

use std::{
    path::Path,
    process::{Command, Stdio},
};

/// A Python that has VTK.
pub struct Vtk {
    /// Its interpreter.
    pub python: &'static str,
    /// VTK's version.
    pub version: String,
}

/// Draws an empty picture: a wheel whose OpenGL is missing imports well and then dies.
const PROBE: &str = "import vtk
w = vtk.vtkRenderWindow(); w.SetOffScreenRendering(1); w.SetSize(8, 8); w.AddRenderer(vtk.vtkRenderer()); w.Render()
vtk.vtkOpenGLFluidMapper
print('VTK', vtk.vtkVersion.GetVTKVersion())";

/// Finds VTK, or says why there is none.
pub fn find_vtk(workspace: &Path, variables: &[(&'static str, String)]) -> Result<Vtk, String> {
    let mut reason = "neither python3 nor python was found".to_owned();
    for python in ["python3", "python"] {
        let mut command = Command::new(python);
        command.args(["-c", PROBE]).current_dir(workspace).envs(variables.iter().cloned());
        let Ok(output) = command.stdin(Stdio::null()).output() else { continue };
        match version(&String::from_utf8_lossy(&output.stdout)) {
            Some(version) if output.status.success() => return Ok(Vtk { python, version }),
            _ => {
                reason = refusal(python, &String::from_utf8_lossy(&output.stderr), &output.status.to_string())
            }
        }
    }
    Err(reason)
}

fn version(output: &str) -> Option<String> {
    output.lines().find_map(|line| line.strip_prefix("VTK ")).map(str::to_owned)
}

/// The last line says what a traceback is about; a crash leaves none.
fn refusal(python: &str, stderr: &str, status: &str) -> String {
    let last = stderr.lines().rev().find(|line| !line.trim().is_empty());
    format!("{python} cannot draw with VTK: {}", last.unwrap_or(status).trim())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_version_is_found_among_warnings_and_the_reason_in_a_traceback() {
        assert_eq!(version("some warning\nVTK 9.7.2\n"), Some("9.7.2".to_owned()));
        assert_eq!(version("vtk\n"), None);
        let traceback = "Traceback (most recent call last):\nModuleNotFoundError: No module named 'vtk'\n\n";
        assert!(refusal("python3", traceback, "exit status: 1").ends_with("No module named 'vtk'"));
        assert!(refusal("python3", "", "signal: 11").ends_with("signal: 11"));
    }
}
