//! XML files whose numbers stand behind the markup.

use std::fmt::Write as _;
use std::fs::File;
use std::io::{BufWriter, Result, Seek, SeekFrom, Write};
use std::path::Path;

use rayon::prelude::*;

use super::{VERTEX, Values, WriteParticles, XmlKind, counting, write_beside, write_values};
use crate::Error;
use crate::codec::blocks::Compressor;

/// Bytes per compressed block, as VTK writes them.
const BLOCK: usize = 1 << 15;

/// Digits of the largest offset; the offsets are only known once the data is written, so their room is kept.
const OFFSET_WIDTH: usize = 20;

/// Writes `particles` to `path` as `kind` with appended data (little endian, 64-bit sizes), in blocks of `compressor` or as it is.
pub(super) fn write(
    path: &Path,
    particles: &WriteParticles<'_>,
    kind: XmlKind,
    compressor: Option<Compressor>,
) -> std::result::Result<(), Error> {
    write_beside(path, |writer| {
        let count = particles.positions.len();
        let mut offsets = vec![0; particles.attributes.len() + 5];
        let head = header(particles, kind, compressor, &offsets);
        writer.write_all(head.as_bytes())?;
        let mut data = Appended { writer, compressor, written: 0, offsets: Vec::new() };
        data.array(Values::F64(particles.time.as_slice()))?;
        for attribute in particles.attributes {
            data.array(attribute.values)?;
        }
        data.array(Values::F64(particles.positions.as_flattened()))?;
        data.integers(0, count)?;
        data.integers(1, count)?;
        if kind == XmlKind::Grid {
            data.array(Values::U8(&vec![VERTEX; count]))?;
        }
        offsets = data.offsets;
        write!(writer, "\n  </AppendedData>\n</VTKFile>\n")?;
        // Same length as before: only the digits of the offsets change, and their room is padded.
        writer.seek(SeekFrom::Start(0))?;
        writer.write_all(header(particles, kind, compressor, &offsets).as_bytes())
    })
}

/// Everything up to the underscore before the data. `offsets`: time, attributes, points, connectivity, offsets, types.
fn header(
    particles: &WriteParticles<'_>,
    kind: XmlKind,
    compressor: Option<Compressor>,
    offsets: &[u64],
) -> String {
    let count = particles.positions.len();
    let mut offsets = offsets.iter();
    let mut text = String::new();
    let compressor = compressor.map_or(String::new(), |c| format!(" compressor=\"{}\"", c.name()));
    let mut line = |indent: usize, line: &str| {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{:indent$}{line}", "");
    };
    let mut array = |ty: &str, name: &str, rest: &str| {
        let offset = offsets.next().copied().unwrap_or_default().to_string();
        let pad = OFFSET_WIDTH - offset.len();
        let name = quick_xml::escape::escape(name);
        format!(
            "<DataArray type=\"{ty}\" Name=\"{name}\"{rest} format=\"appended\" offset=\"{offset}\"{:pad$}/>",
            ""
        )
    };
    line(0, "<?xml version=\"1.0\"?>");
    line(
        0,
        &format!(
            "<VTKFile type=\"{}\" version=\"1.0\" byte_order=\"LittleEndian\" \
             header_type=\"UInt64\"{compressor}>",
            kind.name()
        ),
    );
    line(2, &format!("<{}>", kind.name()));
    let time = array("Float64", "TimeValue", " NumberOfTuples=\"1\"");
    if particles.time.is_some() {
        line(4, "<FieldData>");
        line(6, &time);
        line(4, "</FieldData>");
    }
    line(4, &kind.piece(count));
    line(6, "<PointData>");
    for attribute in particles.attributes {
        let components = format!(" NumberOfComponents=\"{}\"", attribute.components);
        line(8, &array(attribute.values.type_names().0, attribute.name, &components));
    }
    line(6, "</PointData>");
    line(6, "<Points>");
    line(8, &array("Float64", "Points", " NumberOfComponents=\"3\""));
    line(6, "</Points>");
    line(6, &format!("<{}>", kind.cells()));
    for (ty, name) in [("Int64", "connectivity"), ("Int64", "offsets")] {
        line(8, &array(ty, name, ""));
    }
    if kind == XmlKind::Grid {
        line(8, &array("UInt8", "types", ""));
    }
    line(6, &format!("</{}>", kind.cells()));
    line(4, "</Piece>");
    line(2, &format!("</{}>", kind.name()));
    line(2, "<AppendedData encoding=\"raw\">");
    text.push('_');
    text
}

/// The appended data as far as it is written.
struct Appended<'w, 'f> {
    writer: &'w mut BufWriter<&'f mut File>,
    compressor: Option<Compressor>,
    written: u64,
    offsets: Vec<u64>,
}

impl Appended<'_, '_> {
    fn array(&mut self, values: Values<'_>) -> Result<()> {
        self.offsets.push(self.written);
        if let Some(compressor) = self.compressor {
            return self.compressed(values, compressor);
        }
        let size = (values.len() * values.size()) as u64;
        self.writer.write_all(&size.to_le_bytes())?;
        self.written += 8 + size;
        write_values(self.writer, values, false)
    }

    /// The numbers `start..start + count`.
    fn integers(&mut self, start: usize, count: usize) -> Result<()> {
        if self.compressor.is_some() {
            let all: Vec<i64> = counting(start, count).flatten().collect();
            return self.array(Values::I64(&all));
        }
        self.offsets.push(self.written);
        let size = count as u64 * 8;
        self.writer.write_all(&size.to_le_bytes())?;
        self.written += 8 + size;
        counting(start, count).try_for_each(|piece| write_values(self.writer, Values::I64(&piece), false))
    }

    /// Block table and blocks: number of blocks, block size, size of a shorter last block or 0, compressed sizes.
    fn compressed(&mut self, values: Values<'_>, compressor: Compressor) -> Result<()> {
        let per_block = BLOCK / values.size();
        let count = values.len().div_ceil(per_block);
        let blocks: Vec<Vec<u8>> = (0..count)
            .into_par_iter()
            .map(|i| {
                let mut raw = Vec::with_capacity(BLOCK);
                values.append(i * per_block..((i + 1) * per_block).min(values.len()), false, &mut raw);
                compressor.compress(&raw)
            })
            .collect::<Result<_>>()?;
        let last = values.len() % per_block * values.size();
        let head = [count as u64, BLOCK as u64, last as u64];
        // VTK writes a single 0 for an array without data.
        let head = if count == 0 { &head[..1] } else { &head[..] };
        for word in head.iter().copied().chain(blocks.iter().map(|block| block.len() as u64)) {
            self.writer.write_all(&word.to_le_bytes())?;
            self.written += 8;
        }
        for block in blocks {
            self.writer.write_all(&block)?;
            self.written += block.len() as u64;
        }
        Ok(())
    }
}
