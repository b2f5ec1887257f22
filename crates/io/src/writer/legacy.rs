//! Legacy files, version 5.1: an unstructured grid of vertex cells.

use std::io::{Result, Write};
use std::path::Path;

use super::{VERTEX, Values, WriteParticles, counting, text, write_beside, write_values};
use crate::Error;

pub(super) fn write(
    path: &Path,
    particles: &WriteParticles<'_>,
    binary: bool,
) -> std::result::Result<(), Error> {
    let count = particles.positions.len();
    write_beside(path, |w| {
        let mode = if binary { "BINARY" } else { "ASCII" };
        write!(w, "# vtk DataFile Version 5.1\nparticles\n{mode}\nDATASET UNSTRUCTURED_GRID\n")?;
        if let Some(time) = particles.time {
            write!(w, "FIELD FieldData 1\nTimeValue 1 1 double\n")?;
            numbers(w, Values::F64(&[time]), binary)?;
            end(w, binary)?;
        }
        writeln!(w, "POINTS {count} double")?;
        numbers(w, Values::F64(particles.positions.as_flattened()), binary)?;
        end(w, binary)?;
        let offsets = count + 1;
        write!(w, "CELLS {offsets} {count}\nOFFSETS vtktypeint64\n")?;
        for piece in counting(0, offsets) {
            numbers(w, Values::I64(&piece), binary)?;
        }
        end(w, binary)?;
        writeln!(w, "CONNECTIVITY vtktypeint64")?;
        for piece in counting(0, count) {
            numbers(w, Values::I64(&piece), binary)?;
        }
        end(w, binary)?;
        writeln!(w, "CELL_TYPES {count}")?;
        for piece in counting(0, count) {
            numbers(w, Values::I32(&vec![VERTEX.into(); piece.len()]), binary)?;
        }
        end(w, binary)?;
        write!(w, "POINT_DATA {count}\nFIELD FieldData {}\n", particles.attributes.len())?;
        for attribute in particles.attributes {
            let (name, ty) = (encoded(attribute.name), attribute.values.type_names().1);
            writeln!(w, "{name} {} {count} {ty}", attribute.components)?;
            numbers(w, attribute.values, binary)?;
            end(w, binary)?;
        }
        Ok(())
    })
}

fn numbers(writer: &mut impl Write, values: Values<'_>, binary: bool) -> Result<()> {
    if binary { write_values(writer, values, true) } else { text::write(writer, values) }
}

/// Text ends its own lines.
fn end(writer: &mut impl Write, binary: bool) -> Result<()> {
    if binary { writeln!(writer) } else { Ok(()) }
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
