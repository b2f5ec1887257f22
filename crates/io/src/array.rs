//! An array in a file: where it is, and its values on demand.

use std::ops::Range;
use std::sync::Arc;

use meniscus_core::Cancel;
use rayon::prelude::*;

use crate::Error;
use crate::codec::blocks::{BlockTable, Compressor};
use crate::codec::{base64, text};
use crate::mapped::MappedFile;
use crate::scalar::{Convert, ScalarType};

/// Values converted between two looks at the cancel flag; a multiple of 3, so that points stay whole.
const PIECE_VALUES: usize = 3 << 14;

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

impl CheckedArray<'_> {
    /// Number of values.
    pub fn len(&self) -> usize {
        self.array.components * self.array.tuples
    }

    /// All values.
    pub fn collect<C: Convert>(&self, convert: &C, cancel: &Cancel) -> Result<Vec<C::Out>, Error> {
        let mut out = vec![C::Out::default(); self.len()];
        self.decode(convert, &mut out, cancel)?;
        Ok(out)
    }

    /// Converts the first `out.len()` values, at most [`Self::len`], in parallel.
    pub fn decode<C: Convert>(&self, convert: &C, out: &mut [C::Out], cancel: &Cancel) -> Result<(), Error> {
        match &self.data {
            Data::Plain { stream, start } if self.array.ty == ScalarType::Bit => {
                self.decode_bits(stream, *start, convert, out)
            }
            Data::Plain { stream, start } => self.decode_plain(stream, *start, convert, out, cancel),
            Data::Blocks { stream, start, table, compressor } => {
                self.decode_blocks(stream, *start, table, *compressor, convert, out, cancel)
            }
            Data::Text { text, pieces } => self.decode_text(text, pieces, convert, out, cancel),
        }
    }

    fn big(&self) -> bool {
        matches!(self.array.content, Content::Binary { big: true, .. } | Content::Framed { big: true, .. })
    }

    fn fault(&self, message: impl std::fmt::Display) -> Error {
        self.array.malformed(self.file, message)
    }

    fn decode_plain<C: Convert>(
        &self,
        stream: &Stream<'_>,
        start: usize,
        convert: &C,
        out: &mut [C::Out],
        cancel: &Cancel,
    ) -> Result<(), Error> {
        let (ty, big) = (self.array.ty, self.big());
        let size = ty.size().unwrap_or(1);
        out.par_chunks_mut(PIECE_VALUES).enumerate().try_for_each_init(Vec::new, |scratch, (i, out)| {
            check(cancel)?;
            let first = i * PIECE_VALUES;
            let from = start + first * size;
            let bytes = stream
                .get(from..from + out.len() * size, scratch)
                .ok_or_else(|| self.fault(format_args!("cut off or not base64 near value {first}")))?;
            convert.bytes(ty, big, first, bytes, out);
            Ok(())
        })
    }

    fn decode_bits<C: Convert>(
        &self,
        stream: &Stream<'_>,
        start: usize,
        convert: &C,
        out: &mut [C::Out],
    ) -> Result<(), Error> {
        let mut scratch = Vec::new();
        let packed = stream
            .get(start..start + out.len().div_ceil(8), &mut scratch)
            .ok_or_else(|| self.fault("the bits are cut off"))?;
        let bits: Vec<u8> = (0..out.len()).map(|i| packed[i / 8] >> (7 - i % 8) & 1).collect();
        convert.bytes(ScalarType::U8, false, 0, &bits, out);
        Ok(())
    }

    #[expect(clippy::too_many_arguments, reason = "the parts of one enum variant and the caller's three")]
    fn decode_blocks<C: Convert>(
        &self,
        stream: &Stream<'_>,
        start: usize,
        table: &BlockTable,
        compressor: Compressor,
        convert: &C,
        out: &mut [C::Out],
        cancel: &Cancel,
    ) -> Result<(), Error> {
        let (ty, big) = (self.array.ty, self.big());
        let unpack = |i: usize, scratch: &mut Vec<u8>, raw: &mut [u8]| {
            let range = table.blocks[i].start + start..table.blocks[i].end + start;
            let block = stream
                .get(range, scratch)
                .ok_or_else(|| self.fault(format_args!("block {i} is cut off or not base64")))?;
            compressor.decompress(block, raw).map_err(|e| self.fault(format_args!("block {i}: {e}")))
        };
        let size = ty.size().filter(|size| table.block_size.is_multiple_of(*size));
        let Some(size) = size else {
            // Values cross block borders (never from VTK): unpack everything, then convert.
            // Also when only the first values are asked for.
            let mut raw = vec![0; table.total];
            raw.par_chunks_mut(table.block_size).enumerate().try_for_each_init(
                Vec::new,
                |scratch, (i, raw)| {
                    check(cancel)?;
                    unpack(i, scratch, raw)
                },
            )?;
            if ty == ScalarType::Bit {
                return self.decode_bits(&Stream::Raw(&raw), 0, convert, out);
            }
            return self.decode_plain(&Stream::Raw(&raw), 0, convert, out, cancel);
        };
        let values = table.block_size / size;
        out.par_chunks_mut(values).enumerate().try_for_each_init(
            || (Vec::new(), Vec::new()),
            |(scratch, raw), (i, out)| {
                check(cancel)?;
                raw.resize(table.raw_size(i), 0);
                unpack(i, scratch, raw)?;
                convert.bytes(ty, big, i * values, &raw[..out.len() * size], out);
                Ok(())
            },
        )
    }

    fn decode_text<C: Convert>(
        &self,
        text: &[u8],
        pieces: &[text::Piece],
        convert: &C,
        out: &mut [C::Out],
        cancel: &Cancel,
    ) -> Result<(), Error> {
        let mut rest = out;
        let mut jobs = Vec::with_capacity(pieces.len());
        for piece in pieces {
            let (head, tail) = rest.split_at_mut(piece.count.min(rest.len()));
            jobs.push((piece, head));
            rest = tail;
        }
        jobs.into_par_iter().try_for_each_init(Vec::new, |binary, (piece, out)| {
            check(cancel)?;
            binary.clear();
            let mut ty = self.array.ty;
            for (i, token) in text::tokens(&text[piece.range.clone()]).take(out.len()).enumerate() {
                ty = self.push_number(token, binary).ok_or_else(|| {
                    let found = String::from_utf8_lossy(&token[..token.len().min(40)]).into_owned();
                    self.fault(format_args!("value {} is {found:?}, expected a number", piece.first + i))
                })?;
            }
            convert.bytes(ty, false, piece.first, binary, out);
            Ok(())
        })
    }

    /// Appends a parsed number, little endian, and says as which type.
    fn push_number(&self, token: &[u8], binary: &mut Vec<u8>) -> Option<ScalarType> {
        if matches!(self.array.content, Content::Text { unit_colours: true, .. }) {
            // As VTK: 255 times the fraction, rounded to the nearest.
            binary.push((text::parse_f64(token)? * 255.0 + 0.5) as u8);
            return Some(ScalarType::U8);
        }
        match self.array.ty {
            ScalarType::F32 => {
                binary.extend((text::parse_f64(token)? as f32).to_le_bytes());
                Some(ScalarType::F32)
            }
            ScalarType::F64 => {
                binary.extend(text::parse_f64(token)?.to_le_bytes());
                Some(ScalarType::F64)
            }
            ScalarType::U64 => {
                binary.extend(u64::try_from(whole(token)?).ok()?.to_le_bytes());
                Some(ScalarType::U64)
            }
            _ => {
                binary.extend(i64::try_from(whole(token)?).ok()?.to_le_bytes());
                Some(ScalarType::I64)
            }
        }
    }
}

fn whole(token: &[u8]) -> Option<i128> {
    text::parse_integer(token).or_else(|| {
        let value = text::parse_f64(token)?;
        (value.fract() == 0.0 && value.abs() < 1e18).then_some(value as i128)
    })
}

pub(crate) fn check(cancel: &Cancel) -> Result<(), Error> {
    if cancel.is_cancelled() { Err(Error::Cancelled) } else { Ok(()) }
}
