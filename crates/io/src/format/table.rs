//! Tables in text, a point a line: `.xyz`, `.csv` and the like, with or without a line of names. ParaView, DualSPHysics and many
//! scripts write them.

use std::sync::Arc;

use crate::Error;
use crate::array::{Columns, Content, DataArray};
use crate::codec::text::{self, Separators};
use crate::dataset::{Cells, Dataset, Piece};
use crate::format::vectors::{Property, groups};
use crate::format::{MOST_COLUMNS, odd_row, skip_mark};
use crate::forward::Forward;
use crate::frame_data::is_id;
use crate::input_file::{Bytes, InputFile};
use crate::scalar::ScalarType;

/// Bytes in which a table's first row is, if it is one.
const HEAD: usize = 64 << 10;

/// Lines before the first row that are neither empty nor comments: names, or the count and the title of an `.xyz` file.
const MOST_LINES: usize = 2;

/// What vectors are called that are positions, in lower case; nothing if the columns are just x, y, z.
const POSITIONS: [&str; 10] =
    ["", "points", "point", "pos", "position", "positions", "coords", "coord", "coordinates", "p"];

/// How the rows of a table are written.
struct Layout {
    /// Where the first row starts.
    start: usize,
    separators: Separators,
    /// Names of all columns and whether they are numbers.
    columns: Vec<(String, bool)>,
}

/// Whether `place` is the beginning of a table.
pub(crate) fn is_table(place: &mut Forward<'_>) -> Result<bool, Error> {
    Ok(Layout::find(place)?.is_some())
}

/// Finds the points and attributes of `file`, which is a table.
pub(crate) fn parse(file: &InputFile) -> Result<Dataset, Error> {
    let mut place = Forward::new(file, 0);
    skip_mark(&mut place)?;
    let at_start = |message: &str| Error::malformed(file.path(), "byte 0", message);
    let layout =
        Layout::find(&mut place)?.ok_or_else(|| at_start("expected rows of three numbers or more"))?;
    let bytes = Bytes::of(file, layout.start..file.len());
    let per_row = layout.columns.len();
    let points = text::count_rows(&bytes, per_row, usize::MAX, layout.separators)?
        .map_err(|odd| odd_row(file, layout.start, per_row, &odd))?;
    let pieces: Arc<[text::Piece]> =
        text::find(&bytes, points.saturating_mul(per_row), layout.separators)?.into();
    let names = || layout.columns.iter().map(|column| column.0.as_str()).collect::<Vec<_>>();
    let mut arrays = layout.arrays(points, &bytes, &pieces);
    let is_position = |array: &DataArray| {
        array.components == 3 && POSITIONS.contains(&array.name.to_ascii_lowercase().as_str())
    };
    let positions = arrays.iter().position(is_position).ok_or_else(|| {
        let message = format_args!("expected columns called x, y, z, one after another; found {:?}", names());
        Error::malformed(file.path(), "the names of the columns", message)
    })?;
    let piece = Piece {
        file: file.clone(),
        points,
        positions: Some(arrays.remove(positions)),
        attributes: arrays,
        cells: Cells::Particles,
        cell_ghosts: None,
    };
    Ok(Dataset { pieces: vec![piece], time: None })
}

impl Layout {
    /// `None` where `place` is the beginning of something else.
    fn find(place: &mut Forward<'_>) -> Result<Option<Self>, Error> {
        let (offset, path) = (place.position(), place.file().path().to_owned());
        let there = place.peek(HEAD)?;
        let head = &there[..there.len().min(HEAD)];
        if head.contains(&0) {
            return Ok(None);
        }
        // And whether they stand in a comment, which may be anything.
        let mut names: Option<(Vec<String>, bool)> = None;
        // A line after a count is a title.
        let (mut start, mut others, mut is_counted) = (0, 0, false);
        while start < head.len() {
            let length = memchr::memchr(b'\n', &head[start..]).unwrap_or(head.len() - start);
            let line = String::from_utf8_lossy(&head[start..start + length]).into_owned();
            let separators = separators_of(&line);
            let row: Vec<&[u8]> = text::tokens(&head[start..start + length], separators).collect();
            let is_number: Vec<bool> = row.iter().map(|token| text::parse_f64(token).is_some()).collect();
            if is_number.iter().filter(|is| **is).count() >= 3 {
                // With commas in numbers there are more values than fields.
                if fields(&line).count() != row.len() || row.len() > MOST_COLUMNS {
                    return Ok(None);
                }
                let next = head.get(start + length + 1..).unwrap_or_default();
                let next = next.split(|byte| *byte == b'\n').next().unwrap_or_default();
                let next: Vec<&[u8]> = text::tokens(next, separators).collect();
                let usual = || usual_names(&is_number, counts_up(&row, &next));
                let names = match names {
                    Some((names, _)) if names.len() == row.len() => names,
                    Some((names, false)) => {
                        let message = format_args!(
                            "{} names {names:?} for rows of {} values; expected one for each, without commas and blanks",
                            names.len(),
                            row.len()
                        );
                        return Err(Error::malformed(&path, "the names of the columns", message));
                    }
                    _ => usual(),
                };
                let columns = std::iter::zip(names, is_number).collect();
                return Ok(Some(Self { start: offset + start, separators, columns }));
            }
            let text = line.trim();
            let comment = text.strip_prefix(['#', '%']);
            others += usize::from(comment.is_none() && !text.is_empty());
            if others > MOST_LINES {
                return Ok(None);
            }
            is_counted |= others == 1 && text.parse::<u64>().is_ok();
            if !text.is_empty() {
                let found = column_names(comment.unwrap_or(text));
                names = Some((found, comment.is_some())).filter(|_| !is_counted);
            }
            start += length + 1;
        }
        Ok(None)
    }

    /// One array for each number, and for three that make a vector.
    fn arrays(&self, points: usize, bytes: &Bytes, pieces: &Arc<[text::Piece]>) -> Vec<DataArray> {
        let properties: Vec<Property> = self
            .columns
            .iter()
            .map(|(name, _)| {
                let ty = if is_id(name) { ScalarType::I64 } else { ScalarType::F64 };
                Property { name: name.clone(), ty }
            })
            .collect();
        groups(&properties)
            .into_iter()
            .filter(|group| self.columns[group.members.clone()].iter().all(|(_, is_number)| *is_number))
            .map(|group| DataArray {
                components: group.members.len(),
                tuples: points,
                ty: properties[group.members.start].ty,
                content: Content::Text {
                    bytes: bytes.clone(),
                    unit_colours: false,
                    pieces: Some(pieces.clone()),
                    columns: Some(Columns {
                        per_row: self.columns.len(),
                        first: group.members.start,
                        separators: self.separators,
                    }),
                },
                name: group.name,
            })
            .collect()
    }
}

/// The names in a line, without quotes and units.
fn column_names(line: &str) -> Vec<String> {
    let bare = |name: &str| {
        let name = name.trim().trim_matches(['"', '\'']).trim();
        let unit = name.find(['[', '(']).filter(|at| *at > 0 && name.ends_with([']', ')']));
        unit.map_or(name, |at| &name[..at]).trim().to_owned()
    };
    fields(line).map(bare).collect()
}

/// Semicolons leave commas to numbers, where they are refused.
fn separators_of(line: &str) -> Separators {
    let mark = [b';', b','].into_iter().find(|mark| line.as_bytes().contains(mark));
    mark.map_or(Separators::Blanks, Separators::Marks)
}

/// What is between separators, of blanks without units.
fn fields(line: &str) -> Box<dyn Iterator<Item = &str> + '_> {
    match separators_of(line) {
        Separators::Marks(mark) => {
            let mark = char::from(mark);
            Box::new(line.trim().trim_end_matches(mark).split(mark))
        }
        Separators::Blanks => {
            let words = line.split_ascii_whitespace();
            Box::new(words.filter(|word| !word.starts_with(['[', '('])))
        }
    }
}

/// Names for columns that have none: x, y, z are the first three numbers, behind one that counts the rows.
fn usual_names(is_number: &[bool], counts_up: bool) -> Vec<String> {
    let mut first = if counts_up { vec!["id", "x", "y", "z"] } else { vec!["x", "y", "z"] }.into_iter();
    let name = |(index, is_number): (usize, &bool)| {
        let usual = if *is_number { first.next() } else { None };
        usual.map_or_else(|| format!("column {}", index + 1), str::to_owned)
    };
    is_number.iter().enumerate().map(name).collect()
}

/// Whether the first of at least four values is a whole number, one more in the next row.
fn counts_up(row: &[&[u8]], next: &[&[u8]]) -> bool {
    let number = |row: &[&[u8]]| row.first().and_then(|token| text::parse_integer(token));
    row.len() > 3
        && number(row).zip(number(next)).is_some_and(|(here, next)| here.checked_add(1) == Some(next))
}
