use std::io::Write;
use std::path::Path;

use super::write_beside;
use crate::Error;

/// Writes a `.pvd` collection to `path`: times, and files as they are named from its folder, with `/` between folders.
///
/// # Errors
/// [`Error::Io`] when the system refuses.
pub fn write_pvd(path: &Path, entries: &[(f64, String)]) -> Result<(), Error> {
    write_beside(path, |writer| {
        writeln!(
            writer,
            "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"1.0\">\n<Collection>"
        )?;
        for (time, file) in entries {
            let file = quick_xml::escape::escape(file);
            writeln!(writer, "<DataSet timestep=\"{time}\" part=\"0\" file=\"{file}\"/>")?;
        }
        writeln!(writer, "</Collection>\n</VTKFile>")
    })
}
