use std::io::Write;
use std::path::Path;

use super::{Values, WriteParticles, counting, write_beside, write_values};
use crate::Error;

/// VTK's number of the vertex cell.
const VERTEX: i32 = 1;

/// Writes `particles` to `path` as a legacy binary file, version 5.1 (big endian), an unstructured grid of vertex cells.
///
/// # Errors
/// [`Error::Io`] when the system refuses, [`Error::Usage`] when an attribute does not fit the number of particles.
pub fn write_legacy_binary(path: &Path, particles: &WriteParticles<'_>) -> Result<(), Error> {
    particles.validate()?;
    let count = particles.positions.len();
    write_beside(path, |w| {
        write!(w, "# vtk DataFile Version 5.1\nparticles\nBINARY\nDATASET UNSTRUCTURED_GRID\n")?;
        if let Some(time) = particles.time {
            write!(w, "FIELD FieldData 1\nTimeValue 1 1 double\n")?;
            w.write_all(&time.to_be_bytes())?;
            writeln!(w)?;
        }
        writeln!(w, "POINTS {count} double")?;
        write_values(w, Values::F64(particles.positions.as_flattened()), true)?;
        write!(w, "\nCELLS {} {count}\nOFFSETS vtktypeint64\n", count + 1)?;
        for piece in counting(0, count + 1) {
            write_values(w, Values::I64(&piece), true)?;
        }
        write!(w, "\nCONNECTIVITY vtktypeint64\n")?;
        for piece in counting(0, count) {
            write_values(w, Values::I64(&piece), true)?;
        }
        write!(w, "\nCELL_TYPES {count}\n")?;
        for piece in counting(0, count) {
            let types = vec![VERTEX; piece.len()];
            write_values(w, Values::I32(&types), true)?;
        }
        write!(w, "\nPOINT_DATA {count}\nFIELD FieldData {}\n", particles.attributes.len())?;
        for attribute in particles.attributes {
            let (name, ty) = (encoded(attribute.name), attribute.values.type_names().1);
            writeln!(w, "{name} {} {count} {ty}", attribute.components)?;
            write_values(w, attribute.values, true)?;
            writeln!(w)?;
        }
        Ok(())
    })
}

/// A name as one word: VTK writes blanks, quotes, `%` and what is not ASCII as `%xx`.
fn encoded(name: &str) -> String {
    if name.is_empty() {
        return "unknown".into();
    }
    let encode = |byte: u8| match byte {
        b'!'..=b'~' if byte != b'%' && byte != b'"' => char::from(byte).to_string(),
        _ => format!("%{byte:02X}"),
    };
    name.bytes().map(encode).collect()
}
