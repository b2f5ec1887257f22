//! An array in a file: where it is, and its values on demand.

mod decode;

use std::borrow::Cow;
use std::ops::Range;
use std::sync::Arc;

use meniscus_core::Cancel;

use crate::Error;
use crate::codec::base64::{self, Scratch};
use crate::codec::blocks::{BlockTable, Compressor};
use crate::codec::text::{self, Separators};
use crate::error::Fault;
use crate::input_file::{Bytes, InputFile};
use crate::scalar::ScalarType;

/// How an array is stored.
#[derive(Clone, Debug)]
pub(crate) enum Content {
    /// The values and nothing else.
    Binary { bytes: Bytes, big: bool },
    /// One record of `stride` bytes a tuple, with the tuple's values `offset` bytes into it.
    Records { bytes: Bytes, stride: usize, offset: usize, big: bool },
    /// Numbers in text. `unit_colours`: fractions that stand for 0 to 255 (legacy `COLOR_SCALARS`). `pieces`: where they are,
    /// when who found the array had to count them anyway. `columns`: those of a table that are the array, when not all are.
    Text { bytes: Bytes, unit_colours: bool, pieces: Option<Arc<[text::Piece]>>, columns: Option<Columns> },
    /// VTK XML: a size word or a block table, then the data. `bytes` may run on behind the array.
    Framed { bytes: Bytes, base64: bool, compressor: Option<Compressor>, wide_header: bool, big: bool },
}

/// Columns of a table in text, as many as the array has components.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Columns {
    /// Numbers in a row of the table.
    pub per_row: usize,
    pub first: usize,
    pub separators: Separators,
}

/// An array of a file, not yet read.
#[derive(Clone, Debug)]
pub(crate) struct DataArray {
    pub name: String,
    pub components: usize,
    pub tuples: usize,
    pub ty: ScalarType,
    pub content: Content,
}

/// An array whose size is known to be backed by the file.
pub(crate) struct CheckedArray<'a> {
    array: &'a DataArray,
    file: &'a InputFile,
    data: Data<'a>,
}

enum Data<'a> {
    Plain { stream: Stream, start: usize },
    Records { bytes: &'a Bytes, stride: usize, offset: usize },
    Blocks { stream: Stream, table: BlockTable, compressor: Compressor },
    Text { text: &'a Bytes, pieces: Cow<'a, [text::Piece]> },
}

/// Bytes as they are, or behind base64.
enum Stream {
    Raw(Bytes),
    Base64(base64::Text),
}

impl Stream {
    /// The stream of `bytes`, of which the first `wanted` bytes will be asked for.
    fn new(bytes: &Bytes, is_base64: bool, wanted: usize) -> Result<Self, Error> {
        Ok(if is_base64 {
            Self::Base64(base64::Text::find(bytes, base64::encoded_len(wanted).unwrap_or(usize::MAX))?)
        } else {
            Self::Raw(bytes.clone())
        })
    }

    fn get<'s>(&'s self, range: Range<usize>, scratch: &'s mut Scratch) -> Result<Option<&'s [u8]>, Error> {
        match self {
            Self::Raw(bytes) => bytes.get(range, &mut scratch.stored),
            Self::Base64(text) => text.decode(range, scratch),
        }
    }

    /// Leaves out the first `bytes` bytes, which are encoded on their own.
    fn skip_own_encoding(&mut self, bytes: usize) {
        match self {
            Self::Raw(stretch) => *stretch = stretch.from(bytes),
            Self::Base64(text) => text.skip(base64::encoded_len(bytes).unwrap_or(usize::MAX)),
        }
    }

    /// Upper bound of the bytes in it.
    fn capacity(&self) -> usize {
        match self {
            Self::Raw(bytes) => bytes.len(),
            Self::Base64(text) => text.len().div_ceil(4).saturating_mul(3),
        }
    }
}

impl DataArray {
    /// Number of values.
    fn len(&self) -> Option<usize> {
        self.components.checked_mul(self.tuples)
    }

    fn malformed(&self, file: &InputFile, message: impl std::fmt::Display) -> Error {
        let (Content::Binary { bytes, .. }
        | Content::Records { bytes, .. }
        | Content::Text { bytes, .. }
        | Content::Framed { bytes, .. }) = &self.content;
        Error::malformed(
            file.path(),
            format_args!("array {:?} at byte {}", self.name, bytes.start()),
            message,
        )
    }

    /// Checks that the file holds what the array declares; allocates nothing that the file does not back.
    pub fn check<'a>(&'a self, file: &'a InputFile) -> Result<CheckedArray<'a>, Error> {
        let size = self.len().and_then(|len| Some((len, self.ty.bytes(len)?)));
        let (len, size) = size.ok_or_else(|| {
            let (tuples, components) = (self.tuples, self.components);
            self.malformed(
                file,
                format_args!("{tuples} tuples of {components} values overflow; the file lies"),
            )
        })?;
        let data = match &self.content {
            Content::Binary { bytes, .. } => {
                if bytes.len() != size {
                    let found = bytes.len();
                    return Err(self.malformed(file, format_args!("expected {size} bytes, found {found}")));
                }
                Data::Plain { stream: Stream::Raw(bytes.clone()), start: 0 }
            }
            Content::Records { bytes, stride, offset, .. } => {
                let (tuples, found) = (self.tuples, bytes.len());
                if tuples.checked_mul(*stride) != Some(found) {
                    return Err(self.malformed(
                        file,
                        format_args!("expected {tuples} records of {stride} bytes, found {found} bytes"),
                    ));
                }
                Data::Records { bytes, stride: *stride, offset: *offset }
            }
            Content::Text { bytes, pieces, columns, .. } => {
                let len = columns.map_or(Some(len), |table| table.per_row.checked_mul(self.tuples));
                let Some(len) = len.filter(|&len| len <= bytes.len()) else {
                    return Err(self.malformed(
                        file,
                        format_args!(
                            "the numbers of {} points cannot be in {} bytes of text",
                            self.tuples,
                            bytes.len()
                        ),
                    ));
                };
                let pieces: Cow<'_, [text::Piece]> = match pieces {
                    Some(pieces) => Cow::Borrowed(pieces),
                    None => text::find(bytes, usize::MAX, Separators::Blanks)?.into(),
                };
                let found: usize = pieces.iter().map(|piece| piece.count).sum();
                if found != len {
                    return Err(self.malformed(file, format_args!("expected {len} numbers, found {found}")));
                }
                Data::Text { text: bytes, pieces }
            }
            Content::Framed { .. } => self.check_frame(size).map_err(|fault| match fault {
                Fault::Bytes(message) => self.malformed(file, message),
                Fault::File(error) => error,
            })?,
        };
        Ok(CheckedArray { array: self, file, data })
    }

    /// The data behind the size word or block table of a framed array of `size` bytes.
    fn check_frame<'a>(&self, size: usize) -> Result<Data<'a>, Fault> {
        let Content::Framed { bytes, base64, compressor, wide_header, big } = &self.content else {
            return Err("no size word".into());
        };
        let word_size = if *wide_header { 8 } else { 4 };
        let words = |range: Range<usize>| {
            let (start, end) = (range.start.checked_mul(word_size), range.end.checked_mul(word_size));
            let Some((start, end)) = start.zip(end) else { return Ok(None) };
            let stream = Stream::new(bytes, *base64, end)?;
            let mut scratch = Scratch::default();
            let words = stream.get(start..end, &mut scratch)?;
            Ok(words.map(|words| words.chunks_exact(word_size).map(|word| header_word(word, *big)).collect()))
        };
        let Some(compressor) = *compressor else {
            let found: Vec<u64> = words(0..1)?.ok_or("no data at this offset")?;
            if found != [size as u64] {
                return Err(format!("expected {size} bytes of data, the size word says {}", found[0]).into());
            }
            let wanted = size.checked_add(word_size + 3).ok_or("the size overflows")?;
            let mut stream = Stream::new(bytes, *base64, wanted)?;
            let own_encoding = match &stream {
                Stream::Base64(text) => {
                    base64::encoded_len(word_size).map_or(Ok(false), |chars| text.is_padding(chars - 1))?
                }
                Stream::Raw(_) => false,
            };
            let start = if own_encoding { 0 } else { word_size };
            if own_encoding {
                stream.skip_own_encoding(word_size);
            }
            let found = stream.capacity();
            if start.checked_add(size).is_none_or(|end| end > found) {
                return Err(format!("the data is cut off: expected {size} bytes, found {found}").into());
            }
            return Ok(Data::Plain { stream, start });
        };
        let behind = |words: usize, wanted: usize| -> Result<Stream, Error> {
            let head = words.saturating_mul(word_size);
            let mut stream = Stream::new(bytes, *base64, head.saturating_add(3).saturating_add(wanted))?;
            stream.skip_own_encoding(head);
            Ok(stream)
        };
        let available = |words, wanted| Ok(behind(words, wanted)?.capacity());
        let table = BlockTable::read(compressor, size, words, available)?;
        let stream = behind(table.blocks.len() + 3, table.blocks.last().map_or(0, |last| last.end))?;
        Ok(Data::Blocks { stream, table, compressor })
    }
}

fn header_word(bytes: &[u8], big: bool) -> u64 {
    let fold = |acc: u64, &byte: &u8| acc << 8 | u64::from(byte);
    if big { bytes.iter().fold(0, fold) } else { bytes.iter().rev().fold(0, fold) }
}

/// An error when the read was asked to stop.
pub(crate) fn check(cancel: &Cancel) -> Result<(), Error> {
    if cancel.is_cancelled() { Err(Error::Cancelled) } else { Ok(()) }
}
