//! An array in a file: where it is, and its values on demand.

mod decode;

use std::ops::Range;
use std::sync::Arc;

use meniscus_core::Cancel;

use crate::Error;
use crate::codec::blocks::{BlockTable, Compressor};
use crate::codec::{base64, text};
use crate::mapped::MappedFile;
use crate::scalar::ScalarType;

/// Bytes of an array: in the file, or made while reading it.
#[derive(Clone, Debug)]
pub(crate) enum Bytes {
    File(Range<usize>),
    Owned(Arc<[u8]>),
}

impl Bytes {
    fn get<'a>(&'a self, file: &'a MappedFile) -> &'a [u8] {
        match self {
            Self::File(range) => file.get(range.clone()).unwrap_or_default(),
            Self::Owned(bytes) => bytes,
        }
    }

    fn start(&self) -> usize {
        match self {
            Self::File(range) => range.start,
            Self::Owned(_) => 0,
        }
    }
}

/// How an array is stored.
#[derive(Clone, Debug)]
pub(crate) enum Content {
    /// The values and nothing else.
    Binary { bytes: Bytes, big: bool },
    /// Numbers in text. `unit_colours`: fractions that stand for 0 to 255 (legacy `COLOR_SCALARS`).
    Text { bytes: Bytes, unit_colours: bool },
    /// VTK XML: a size word or a block table, then the data. `bytes` may run on behind the array.
    Framed { bytes: Bytes, base64: bool, compressor: Option<Compressor>, wide_header: bool, big: bool },
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
    file: &'a MappedFile,
    data: Data<'a>,
}

enum Data<'a> {
    Plain { stream: Stream<'a>, start: usize },
    Blocks { stream: Stream<'a>, start: usize, table: BlockTable, compressor: Compressor },
    Text { text: &'a [u8], pieces: Vec<text::Piece> },
}

/// Bytes as they are, or behind base64.
enum Stream<'a> {
    Raw(&'a [u8]),
    Base64(std::borrow::Cow<'a, [u8]>),
}

impl Stream<'_> {
    fn get<'s>(&'s self, range: Range<usize>, scratch: &'s mut Vec<u8>) -> Option<&'s [u8]> {
        match self {
            Self::Raw(bytes) => bytes.get(range),
            Self::Base64(text) => base64::decode_range(text, range, scratch),
        }
    }

    /// The stream that starts behind the first `bytes` bytes, which are encoded on their own.
    fn after_own_encoding(self, bytes: usize) -> Option<Self> {
        let Self::Base64(text) = self else { return Some(self) };
        let chars = base64::encoded_len(bytes)?;
        match text {
            std::borrow::Cow::Borrowed(text) => Some(Self::Base64(text.get(chars..)?.into())),
            std::borrow::Cow::Owned(mut text) => {
                text.drain(..chars.min(text.len()));
                Some(Self::Base64(text.into()))
            }
        }
    }

    /// Upper bound of the bytes in it.
    fn capacity(&self) -> usize {
        match self {
            Self::Raw(bytes) => bytes.len(),
            Self::Base64(text) => text.len().div_ceil(4) * 3,
        }
    }
}

impl DataArray {
    /// Number of values.
    fn len(&self) -> Option<usize> {
        self.components.checked_mul(self.tuples)
    }

    fn malformed(&self, file: &MappedFile, message: impl std::fmt::Display) -> Error {
        let (Content::Binary { bytes, .. } | Content::Text { bytes, .. } | Content::Framed { bytes, .. }) =
            &self.content;
        Error::malformed(
            file.path(),
            format_args!("array {:?} at byte {}", self.name, bytes.start()),
            message,
        )
    }

    /// Checks that the file holds what the array declares; allocates nothing that the file does not back.
    pub fn check<'a>(&'a self, file: &'a MappedFile) -> Result<CheckedArray<'a>, Error> {
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
                let bytes = bytes.get(file);
                if bytes.len() != size {
                    let found = bytes.len();
                    return Err(self.malformed(file, format_args!("expected {size} bytes, found {found}")));
                }
                Data::Plain { stream: Stream::Raw(bytes), start: 0 }
            }
            Content::Text { bytes, .. } => {
                let text = bytes.get(file);
                if len > text.len() {
                    return Err(self.malformed(
                        file,
                        format_args!("{len} numbers cannot be in {} bytes of text", text.len()),
                    ));
                }
                let pieces = text::pieces(text);
                let found: usize = pieces.iter().map(|piece| piece.count).sum();
                if found != len {
                    return Err(self.malformed(file, format_args!("expected {len} numbers, found {found}")));
                }
                Data::Text { text, pieces }
            }
            Content::Framed { bytes, base64, compressor, wide_header, big } => {
                let bytes = bytes.get(file);
                let stream = if *base64 { Stream::Base64(without_blanks(bytes)) } else { Stream::Raw(bytes) };
                self.check_frame(stream, *compressor, if *wide_header { 8 } else { 4 }, *big, size)
                    .map_err(|message| self.malformed(file, message))?
            }
        };
        Ok(CheckedArray { array: self, file, data })
    }

    fn check_frame<'a>(
        &self,
        stream: Stream<'a>,
        compressor: Option<Compressor>,
        word_size: usize,
        big: bool,
        size: usize,
    ) -> Result<Data<'a>, String> {
        let word = |i: usize| {
            let mut scratch = Vec::new();
            let start = i.checked_mul(word_size)?;
            stream.get(start..start.checked_add(word_size)?, &mut scratch).map(|b| header_word(b, big))
        };
        let Some(compressor) = compressor else {
            let found = word(0).ok_or("no data at this offset")?;
            if found != size as u64 {
                return Err(format!("expected {size} bytes of data, the size word says {found}"));
            }
            let own_encoding = matches!(&stream, Stream::Base64(text)
                if base64::encoded_len(word_size).and_then(|n| text.get(n - 1)) == Some(&b'='));
            let (stream, start) = if own_encoding {
                (stream.after_own_encoding(word_size).ok_or("the data is cut off")?, 0)
            } else {
                (stream, word_size)
            };
            if start.checked_add(size).is_none_or(|end| end > stream.capacity()) {
                return Err(format!(
                    "the data is cut off: expected {size} bytes, found {}",
                    stream.capacity()
                ));
            }
            return Ok(Data::Plain { stream, start });
        };
        let table = BlockTable::read(compressor, size, word, |words| match &stream {
            Stream::Raw(bytes) => bytes.len().saturating_sub(words.saturating_mul(word_size)),
            Stream::Base64(text) => {
                let head = base64::encoded_len(words.saturating_mul(word_size)).unwrap_or(usize::MAX);
                text.len().saturating_sub(head).div_ceil(4) * 3
            }
        })?;
        let head = (table.blocks.len() + 3) * word_size;
        let (stream, start) = match stream {
            _ if table.blocks.is_empty() => (Stream::Raw(&[]), 0),
            Stream::Raw(_) => (stream, head),
            Stream::Base64(_) => (stream.after_own_encoding(head).ok_or("the data is cut off")?, 0),
        };
        Ok(Data::Blocks { stream, start, table, compressor })
    }
}

fn header_word(bytes: &[u8], big: bool) -> u64 {
    let fold = |acc: u64, &byte: &u8| acc << 8 | u64::from(byte);
    if big { bytes.iter().fold(0, fold) } else { bytes.iter().rev().fold(0, fold) }
}

fn without_blanks(text: &[u8]) -> std::borrow::Cow<'_, [u8]> {
    let text = text.trim_ascii();
    if text.iter().any(u8::is_ascii_whitespace) {
        text.iter().copied().filter(|b| !b.is_ascii_whitespace()).collect::<Vec<_>>().into()
    } else {
        text.into()
    }
}

/// An error when the read was asked to stop.
pub(crate) fn check(cancel: &Cancel) -> Result<(), Error> {
    if cancel.is_cancelled() { Err(Error::Cancelled) } else { Ok(()) }
}
