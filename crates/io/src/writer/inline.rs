//! XML files whose numbers stand where their array is declared: text or base64.

use std::fs::File;
use std::io::{BufWriter, Result, Write};
use std::path::Path;

use base64::prelude::BASE64_STANDARD;
use base64::write::EncoderWriter;

use super::{VERTEX, Values, WriteParticles, XmlKind, counting, text, write_beside, write_values};
use crate::Error;

pub(super) fn write(
    path: &Path,
    particles: &WriteParticles<'_>,
    kind: XmlKind,
    ascii: bool,
) -> std::result::Result<(), Error> {
    let count = particles.positions.len();
    write_beside(path, |writer| {
        let name = kind.name();
        writeln!(
            writer,
            "<?xml version=\"1.0\"?>\n<VTKFile type=\"{name}\" version=\"1.0\" byte_order=\"LittleEndian\" \
             header_type=\"UInt64\">\n<{name}>"
        )?;
        let mut arrays = Arrays { writer, ascii };
        if particles.time.is_some() {
            arrays.line("<FieldData>")?;
            arrays.one("TimeValue", " NumberOfTuples=\"1\"", Values::F64(particles.time.as_slice()))?;
            arrays.line("</FieldData>")?;
        }
        arrays.line(&kind.piece(count))?;
        arrays.line("<PointData>")?;
        for attribute in particles.attributes {
            let components = format!(" NumberOfComponents=\"{}\"", attribute.components);
            arrays.one(attribute.name, &components, attribute.values)?;
        }
        arrays.line("</PointData>\n<Points>")?;
        let positions = Values::F64(particles.positions.as_flattened());
        arrays.one("Points", " NumberOfComponents=\"3\"", positions)?;
        arrays.line(&format!("</Points>\n<{}>", kind.cells()))?;
        for (name, start) in [("connectivity", 0), ("offsets", 1)] {
            let numbers: Vec<i64> = counting(start, count).flatten().collect();
            arrays.one(name, "", Values::I64(&numbers))?;
        }
        if kind == XmlKind::Grid {
            arrays.one("types", "", Values::U8(&vec![VERTEX; count]))?;
        }
        arrays.line(&format!("</{}>\n</Piece>\n</{name}>\n</VTKFile>", kind.cells()))
    })
}

struct Arrays<'w, 'f> {
    writer: &'w mut BufWriter<&'f mut File>,
    ascii: bool,
}

impl Arrays<'_, '_> {
    fn line(&mut self, line: &str) -> Result<()> {
        writeln!(self.writer, "{line}")
    }

    /// An array `name` with the further XML attributes `rest`.
    fn one(&mut self, name: &str, rest: &str, values: Values<'_>) -> Result<()> {
        let (ty, name) = (values.type_names().0, quick_xml::escape::escape(name));
        let format = if self.ascii { "ascii" } else { "binary" };
        self.line(&format!("<DataArray type=\"{ty}\" Name=\"{name}\"{rest} format=\"{format}\">"))?;
        if self.ascii {
            text::write(self.writer, values)?;
        } else {
            let mut encoder = EncoderWriter::new(&mut *self.writer, &BASE64_STANDARD);
            let size = (values.len() * values.size()) as u64;
            encoder.write_all(&size.to_le_bytes())?;
            write_values(&mut encoder, values, false)?;
            encoder.finish()?;
            drop(encoder);
            self.line("")?;
        }
        self.line("</DataArray>")
    }
}
