//! The values of an array whose size is known to be sound.

use meniscus_core::Cancel;
use rayon::prelude::*;

use super::{CheckedArray, Content, Data, Stream, check};
use crate::Error;
use crate::codec::blocks::{BlockTable, Compressor};
use crate::codec::{base64, text};
use crate::scalar::{Convert, ScalarType};
use crate::sink::{self, Sink};

/// Values converted between two looks at the cancel flag; a multiple of 3, so that points stay whole.
const PIECE_VALUES: usize = 3 << 14;

impl CheckedArray<'_> {
    /// Number of values.
    pub fn len(&self) -> usize {
        self.array.components * self.array.tuples
    }

    /// Bytes of the file that hold its values.
    pub fn stored_bytes(&self) -> u64 {
        let in_stream = |stream: &Stream<'_>, bytes: usize| match stream {
            Stream::Raw(_) => bytes,
            Stream::Base64(_) => base64::encoded_len(bytes).unwrap_or(bytes),
        };
        let bytes = match &self.data {
            Data::Plain { stream, .. } => in_stream(stream, self.array.ty.bytes(self.len()).unwrap_or(0)),
            Data::Blocks { stream, table, .. } => {
                in_stream(stream, table.blocks.iter().map(ExactSizeIterator::len).sum())
            }
            Data::Text { text, .. } => text.len(),
        };
        bytes as u64
    }

    /// All values.
    pub fn collect<C: Convert>(&self, convert: &C, cancel: &Cancel) -> Result<Vec<C::Out>, Error> {
        let mut out = vec![C::Out::default(); self.len()];
        self.decode(convert, out.as_mut_slice(), cancel)?;
        Ok(out)
    }

    /// The tuples `indices`. Only they are decoded where values can be addressed: not in compressed blocks and text.
    pub fn pick<C: Convert>(
        &self,
        indices: &[usize],
        convert: &C,
        cancel: &Cancel,
    ) -> Result<Vec<C::Out>, Error> {
        let (ty, components) = (self.array.ty, self.array.components);
        let mut out = vec![C::Out::default(); indices.len() * components];
        let tuples = std::iter::zip(indices, out.chunks_exact_mut(components.max(1)));
        if let (Data::Plain { stream, start }, Some(size)) = (&self.data, ty.size()) {
            let (big, mut scratch) = (self.big(), Vec::new());
            for (index, out) in tuples {
                let from = start + index * components * size;
                let bytes = stream
                    .get(from..from + components * size, &mut scratch)
                    .ok_or_else(|| self.fault(format_args!("cut off or not base64 near tuple {index}")))?;
                convert.bytes(ty, big, index * components, bytes, out);
            }
        } else {
            let all = self.collect(convert, cancel)?;
            for (index, out) in tuples {
                out.copy_from_slice(&all[index * components..(index + 1) * components]);
            }
        }
        Ok(out)
    }

    /// Converts the first `out.len()` values, at most [`Self::len`], in parallel.
    pub fn decode<C: Convert, S: Sink<Item = C::Out>>(
        &self,
        convert: &C,
        out: S,
        cancel: &Cancel,
    ) -> Result<(), Error> {
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

    fn decode_plain<C: Convert, S: Sink<Item = C::Out>>(
        &self,
        stream: &Stream<'_>,
        start: usize,
        convert: &C,
        out: S,
        cancel: &Cancel,
    ) -> Result<(), Error> {
        let (ty, big) = (self.array.ty, self.big());
        let size = ty.size().unwrap_or(1);
        let pieces = sink::pieces(out, PIECE_VALUES).into_par_iter().enumerate();
        pieces.try_for_each_init(Default::default, |(scratch, values): &mut (Vec<_>, Vec<_>), (i, out)| {
            check(cancel)?;
            let first = i * PIECE_VALUES;
            let from = start + first * size;
            let bytes = stream
                .get(from..from + out.len() * size, scratch)
                .ok_or_else(|| self.fault(format_args!("cut off or not base64 near value {first}")))?;
            out.fill(values, |out| {
                convert.bytes(ty, big, first, bytes, out);
                Ok(())
            })
        })
    }

    fn decode_bits<C: Convert, S: Sink<Item = C::Out>>(
        &self,
        stream: &Stream<'_>,
        start: usize,
        convert: &C,
        out: S,
    ) -> Result<(), Error> {
        let mut scratch = Vec::new();
        let packed = stream
            .get(start..start + out.len().div_ceil(8), &mut scratch)
            .ok_or_else(|| self.fault("the bits are cut off"))?;
        let bits: Vec<u8> = (0..out.len()).map(|i| packed[i / 8] >> (7 - i % 8) & 1).collect();
        out.fill(&mut Vec::new(), |out| {
            convert.bytes(ScalarType::U8, false, 0, &bits, out);
            Ok(())
        })
    }

    #[expect(clippy::too_many_arguments, reason = "the parts of one enum variant and the caller's three")]
    fn decode_blocks<C: Convert, S: Sink<Item = C::Out>>(
        &self,
        stream: &Stream<'_>,
        start: usize,
        table: &BlockTable,
        compressor: Compressor,
        convert: &C,
        out: S,
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
        sink::pieces(out, values).into_par_iter().enumerate().try_for_each_init(
            || (Vec::new(), Vec::new(), Vec::new()),
            |(scratch, raw, converted), (i, out)| {
                check(cancel)?;
                raw.resize(table.raw_size(i), 0);
                unpack(i, scratch, raw)?;
                let used = &raw[..out.len() * size];
                out.fill(converted, |out| {
                    convert.bytes(ty, big, i * values, used, out);
                    Ok(())
                })
            },
        )
    }

    fn decode_text<C: Convert, S: Sink<Item = C::Out>>(
        &self,
        text: &[u8],
        pieces: &[text::Piece],
        convert: &C,
        out: S,
        cancel: &Cancel,
    ) -> Result<(), Error> {
        let mut rest = out;
        let mut jobs = Vec::with_capacity(pieces.len());
        for piece in pieces {
            let count = piece.count.min(rest.len());
            let (head, tail) = rest.split_at(count);
            jobs.push((piece, head));
            rest = tail;
        }
        jobs.into_par_iter().try_for_each_init(
            Default::default,
            |(binary, values): &mut (Vec<_>, Vec<_>), (piece, out)| {
                check(cancel)?;
                binary.clear();
                let mut ty = self.array.ty;
                for (i, token) in text::tokens(&text[piece.range.clone()]).take(out.len()).enumerate() {
                    ty = self.push_number(token, binary).ok_or_else(|| {
                        let found = String::from_utf8_lossy(&token[..token.len().min(40)]).into_owned();
                        self.fault(format_args!("value {} is {found:?}, expected a number", piece.first + i))
                    })?;
                }
                out.fill(values, |out| {
                    convert.bytes(ty, false, piece.first, binary, out);
                    Ok(())
                })
            },
        )
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
