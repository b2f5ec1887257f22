//! Legacy `.vtk` files, ASCII and binary (big endian), versions 1.0 to 5.1.
//!
//! Sections follow one another without a directory, so the file is walked: binary payloads are stepped over, text is skipped
//! number by number. Nothing is converted here.

mod cursor;
mod grid;
mod sections;

use crate::Error;
use crate::dataset::Dataset;
use crate::format::legacy::cursor::Cursor;
use crate::format::legacy::sections::Sections;
pub(crate) use crate::format::legacy::sections::is_time;
use crate::format::{skip_mark, starts_with_ignore_case};
use crate::input_file::InputFile;

/// Finds the points and attributes of `file`.
pub(crate) fn parse(file: &InputFile) -> Result<Dataset, Error> {
    let mut cursor = Cursor::new(file);
    skip_mark(&mut cursor.place)?;
    if !starts_with_ignore_case(cursor.place.peek(64)?, b"# vtk datafile version") {
        return Err(cursor.malformed("expected `# vtk DataFile Version`"));
    }
    cursor.line()?;
    cursor.line()?; // The title: any text, any encoding.
    let mode = cursor.word("ASCII or BINARY")?;
    cursor.binary = match mode.as_str() {
        "ascii" => false,
        "binary" => true,
        other => return Err(cursor.malformed(format_args!("expected ASCII or BINARY, found {other:?}"))),
    };
    Sections::new(cursor).walk()
}
