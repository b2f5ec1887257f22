//! The values of an array whose size is known to be sound.

use std::ops::Range;

use meniscus_core::Cancel;
use rayon::prelude::*;

use super::{CheckedArray, Columns, Content, Data, Stream, check};
use crate::Error;
use crate::codec::base64::{self, Scratch};
use crate::codec::blocks::{BlockTable, Compressor, Inflater};
use crate::codec::text::{self, Separators};
use crate::input_file::Bytes;
use crate::scalar::{Convert, ScalarType};
use crate::sink::{self, Sink};

/// Values converted between two looks at the cancel flag; a multiple of 3, so that points stay whole.
const PIECE_VALUES: usize = 3 << 13;

/// Tuples decoded at a time to pick some of them.
const PICK_TUPLES: usize = 1 << 17;

impl CheckedArray<'_> {
    /// Number of values.
    pub fn len(&self) -> usize {
        self.array.components * self.array.tuples
    }

    /// Number of tuples.
    pub fn tuples(&self) -> usize {
        self.array.tuples
    }

    /// Bytes of the file that hold its values.
    pub fn stored_bytes(&self) -> u64 {
        let in_stream = |stream: &Stream, bytes: usize| match stream {
            Stream::Raw(_) => bytes,
            Stream::Base64(_) => base64::encoded_len(bytes).unwrap_or(bytes),
        };
        let bytes = match &self.data {
            Data::Plain { stream, .. } => in_stream(stream, self.array.ty.bytes(self.len()).unwrap_or(0)),
            Data::Records { .. } => self.array.ty.bytes(self.len()).unwrap_or(0),
            Data::Blocks { stream, table, .. } => {
                in_stream(stream, table.blocks.iter().map(ExactSizeIterator::len).sum())
            }
            Data::Text { text, .. } => text.len(),
        };
        bytes as u64
    }

    /// All values.
    pub fn collect<C: Convert>(&self, convert: &C, cancel: &Cancel) -> Result<Vec<C::Out>, Error> {
        self.tuples_in(0..self.array.tuples, convert, cancel)
    }

    /// The values of the tuples `range`, which must be there.
    pub fn tuples_in<C: Convert>(
        &self,
        range: Range<usize>,
        convert: &C,
        cancel: &Cancel,
    ) -> Result<Vec<C::Out>, Error> {
        let mut out = vec![C::Out::default(); range.len() * self.array.components];
        self.decode(convert, range.start * self.array.components, out.as_mut_slice(), cancel)?;
        Ok(out)
    }

    /// The tuples `indices`, which rise. Only they are decoded where values can be addressed; of compressed blocks and text,
    /// what lies between them as well.
    pub fn pick<C: Convert>(
        &self,
        indices: &[usize],
        convert: &C,
        cancel: &Cancel,
    ) -> Result<Vec<C::Out>, Error> {
        let (ty, components) = (self.array.ty, self.array.components);
        let mut picked = Vec::with_capacity(indices.len() * components);
        // Text is counted through to where an index is, so that there, neighbours are decoded together.
        if let (Some((bytes, start, stride)), Some(size)) = (self.addressed(), ty.size()) {
            let (big, mut scratch) = (self.big(), Vec::new());
            let mut tuple = vec![C::Out::default(); components];
            for index in indices {
                let from = start + index * stride;
                let bytes = bytes
                    .get(from..from + components * size, &mut scratch)?
                    .ok_or_else(|| self.fault(format_args!("cut off near tuple {index}")))?;
                convert.bytes(ty, big, index * components, bytes, &mut tuple);
                picked.extend_from_slice(&tuple);
            }
            return Ok(picked);
        }
        let mut rest = indices;
        while let Some(&first) = rest.first() {
            let end = self.array.tuples.min(first + PICK_TUPLES);
            let (here, later) = rest.split_at(rest.partition_point(|&index| index < end));
            let last = here.last().map_or(first, |last| last + 1);
            let block = self.tuples_in(first..last, convert, cancel)?;
            for index in here {
                picked.extend_from_slice(&block[(index - first) * components..][..components]);
            }
            rest = later;
        }
        Ok(picked)
    }

    /// Where tuples can be found by their number: the bytes, the first tuple's place and the distance to the next.
    fn addressed(&self) -> Option<(&Bytes, usize, usize)> {
        match &self.data {
            Data::Plain { stream: Stream::Raw(bytes), start } => {
                Some((bytes, *start, self.array.components * self.array.ty.size()?))
            }
            Data::Records { bytes, stride, offset } => Some((bytes, *offset, *stride)),
            _ => None,
        }
    }

    /// Converts the `out.len()` values from value `first` on, which must be there, in parallel.
    pub fn decode<C: Convert, S: Sink<Item = C::Out>>(
        &self,
        convert: &C,
        first: usize,
        out: S,
        cancel: &Cancel,
    ) -> Result<(), Error> {
        match &self.data {
            Data::Plain { stream, start } if self.array.ty == ScalarType::Bit => {
                self.decode_bits(stream, *start, convert, first, out)
            }
            Data::Plain { stream, start } => self.decode_plain(stream, *start, convert, first, out, cancel),
            Data::Records { bytes, stride, offset } => {
                self.decode_records(bytes, (*stride, *offset), convert, first, out, cancel)
            }
            Data::Blocks { stream, table, compressor } => {
                self.decode_blocks(stream, table, *compressor, convert, first, out, cancel)
            }
            Data::Text { text, pieces } => self.decode_text(text, pieces, convert, first, out, cancel),
        }
    }

    fn big(&self) -> bool {
        matches!(
            self.array.content,
            Content::Binary { big: true, .. }
                | Content::Records { big: true, .. }
                | Content::Framed { big: true, .. }
        )
    }

    fn fault(&self, message: impl std::fmt::Display) -> Error {
        self.array.malformed(self.file, message)
    }

    fn decode_plain<C: Convert, S: Sink<Item = C::Out>>(
        &self,
        stream: &Stream,
        start: usize,
        convert: &C,
        first: usize,
        out: S,
        cancel: &Cancel,
    ) -> Result<(), Error> {
        let (ty, big) = (self.array.ty, self.big());
        let size = ty.size().unwrap_or(1);
        let pieces = sink::pieces(out, PIECE_VALUES).into_par_iter().enumerate();
        pieces.try_for_each_init(Default::default, |(scratch, values): &mut (_, Vec<_>), (i, out)| {
            check(cancel)?;
            let first = first + i * PIECE_VALUES;
            let from = start + first * size;
            let bytes = stream
                .get(from..from + out.len() * size, scratch)?
                .ok_or_else(|| self.fault(format_args!("cut off or not base64 near value {first}")))?;
            out.fill(values, |out| {
                convert.bytes(ty, big, first, bytes, out);
                Ok(())
            })
        })
    }

    fn decode_records<C: Convert, S: Sink<Item = C::Out>>(
        &self,
        bytes: &Bytes,
        (stride, offset): (usize, usize),
        convert: &C,
        first: usize,
        out: S,
        cancel: &Cancel,
    ) -> Result<(), Error> {
        let (ty, big, components) = (self.array.ty, self.big(), self.array.components);
        let size = ty.size().unwrap_or(1);
        let pieces = sink::pieces(out, PIECE_VALUES).into_par_iter().enumerate();
        pieces.try_for_each_init(
            Default::default,
            |(scratch, gathered, values): &mut (_, Vec<u8>, _), (i, out)| {
                check(cancel)?;
                let first = first + i * PIECE_VALUES;
                // A piece may start and end within a tuple.
                let (from, to) = (first / components, (first + out.len()).div_ceil(components));
                let records = bytes
                    .get(from * stride..to * stride, scratch)?
                    .ok_or_else(|| self.fault(format_args!("cut off near tuple {from}")))?;
                gathered.clear();
                for record in records.chunks_exact(stride) {
                    gathered.extend_from_slice(&record[offset..][..components * size]);
                }
                let there = &gathered[(first - from * components) * size..][..out.len() * size];
                out.fill(values, |out| {
                    convert.bytes(ty, big, first, there, out);
                    Ok(())
                })
            },
        )
    }

    fn decode_bits<C: Convert, S: Sink<Item = C::Out>>(
        &self,
        stream: &Stream,
        start: usize,
        convert: &C,
        first: usize,
        out: S,
    ) -> Result<(), Error> {
        let mut scratch = Scratch::default();
        let end = first + out.len();
        let packed = stream
            .get(start + first / 8..start + end.div_ceil(8), &mut scratch)?
            .ok_or_else(|| self.fault("the bits are cut off"))?;
        let bit = |i: usize| packed[i / 8 - first / 8] >> (7 - i % 8) & 1;
        let bits: Vec<u8> = (first..end).map(bit).collect();
        out.fill(&mut Vec::new(), |out| {
            convert.bytes(ScalarType::U8, false, first, &bits, out);
            Ok(())
        })
    }

    #[expect(clippy::too_many_arguments, reason = "the parts of one enum variant and the caller's four")]
    fn decode_blocks<C: Convert, S: Sink<Item = C::Out>>(
        &self,
        stream: &Stream,
        table: &BlockTable,
        compressor: Compressor,
        convert: &C,
        first: usize,
        out: S,
        cancel: &Cancel,
    ) -> Result<(), Error> {
        let (ty, big) = (self.array.ty, self.big());
        let unpack = |i: usize, inflater: &mut Inflater, scratch: &mut Scratch, raw: &mut [u8]| {
            let block = stream
                .get(table.blocks[i].clone(), scratch)?
                .ok_or_else(|| self.fault(format_args!("block {i} is cut off or not base64")))?;
            inflater
                .decompress(compressor, block, raw)
                .map_err(|e| self.fault(format_args!("block {i}: {e}")))
        };
        let Some(size) = ty.size() else {
            // Packed bits are rare and small: all of them at once.
            let (mut raw, mut inflater) = (vec![0; table.total], Inflater::default());
            for (i, raw) in raw.chunks_mut(table.block_size).enumerate() {
                unpack(i, &mut inflater, &mut Scratch::default(), raw)?;
            }
            return self.decode_bits(&Stream::Raw(raw.into()), 0, convert, first, out);
        };
        // As few blocks as hold whole values; one, in what VTK writes.
        let group = (1..=size).find(|count| (count * table.block_size).is_multiple_of(size)).unwrap_or(size);
        let values = group * table.block_size / size;
        let mut jobs = Vec::new();
        let (mut rest, mut at) = (out, first);
        while !rest.is_empty() {
            let (head, tail) = {
                let room = rest.len();
                rest.split_at((values - at % values).min(room))
            };
            let next = at + head.len();
            jobs.push((at, head));
            (rest, at) = (tail, next);
        }
        jobs.into_par_iter().try_for_each_init(
            Default::default,
            |(inflater, scratch, raw, converted): &mut (_, _, Vec<u8>, Vec<_>), (first, out)| {
                check(cancel)?;
                let blocks = first / values * group..table.blocks.len().min((first / values + 1) * group);
                raw.resize(blocks.clone().map(|i| table.raw_size(i)).sum(), 0);
                for (i, raw) in std::iter::zip(blocks, raw.chunks_mut(table.block_size)) {
                    unpack(i, inflater, scratch, raw)?;
                }
                let start = first % values * size;
                let used = &raw[start..start + out.len() * size];
                out.fill(converted, |out| {
                    convert.bytes(ty, big, first, used, out);
                    Ok(())
                })
            },
        )
    }

    fn decode_text<C: Convert, S: Sink<Item = C::Out>>(
        &self,
        text: &Bytes,
        pieces: &[text::Piece],
        convert: &C,
        first: usize,
        out: S,
        cancel: &Cancel,
    ) -> Result<(), Error> {
        let table = self.columns();
        let mut rest = out;
        let mut jobs = Vec::new();
        let mut next = first;
        let start = pieces.partition_point(|piece| table.values_before(piece.first + piece.count) <= first);
        for piece in &pieces[start..] {
            if rest.is_empty() {
                break;
            }
            let end = table.values_before(piece.first + piece.count);
            let (head, tail) = {
                let room = rest.len();
                rest.split_at((end - next).min(room))
            };
            jobs.push((piece, next, head));
            (rest, next) = (tail, end);
        }
        jobs.into_par_iter().try_for_each_init(
            Default::default,
            |(scratch, binary, values): &mut (_, Vec<_>, Vec<_>), (piece, first, out)| {
                check(cancel)?;
                binary.clear();
                let mut ty = self.array.ty;
                let there = piece.text(text, scratch)?;
                let (mut tokens, mut at) = (text::tokens(there, table.columns.separators), piece.first);
                for i in first..first + out.len() {
                    let wanted = table.token_of(i);
                    // They were there when they were counted; somebody may have written to the file since.
                    let token = tokens.nth(wanted - at).ok_or_else(|| {
                        self.fault(format_args!(
                            "value {i} is missing; was the file written to while it was read?"
                        ))
                    })?;
                    at = wanted + 1;
                    ty = self.push_number(token, binary).ok_or_else(|| {
                        let found = String::from_utf8_lossy(&token[..token.len().min(40)]).into_owned();
                        self.fault(format_args!("value {i} is {found:?}, expected a number"))
                    })?;
                }
                out.fill(values, |out| {
                    convert.bytes(ty, false, first, binary, out);
                    Ok(())
                })
            },
        )
    }

    fn columns(&self) -> Table {
        let components = self.array.components;
        let all = Columns { per_row: components, first: 0, separators: Separators::Blanks };
        let Content::Text { columns, .. } = &self.array.content else {
            return Table { components, columns: all };
        };
        Table { components, columns: columns.unwrap_or(all) }
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

/// Which of the numbers in a text are an array's values.
#[derive(Clone, Copy)]
struct Table {
    components: usize,
    columns: Columns,
}

impl Table {
    /// How many values stand before number `token` of the text.
    fn values_before(self, token: usize) -> usize {
        let Columns { per_row, first, .. } = self.columns;
        token / per_row * self.components + (token % per_row).saturating_sub(first).min(self.components)
    }

    /// The number in the text that is value `value`.
    fn token_of(self, value: usize) -> usize {
        let Columns { per_row, first, .. } = self.columns;
        value / self.components * per_row + first + value % self.components
    }
}

fn whole(token: &[u8]) -> Option<i128> {
    text::parse_integer(token).or_else(|| {
        let value = text::parse_f64(token)?;
        (value.fract() == 0.0 && value.abs() < 1e18).then_some(value as i128)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::IoMode;
    use crate::array::DataArray;
    use crate::input_file::InputFile;
    use crate::scalar::{Recentre, ToU64};

    #[test]
    fn numbers_that_vanish_once_they_are_counted_are_an_error() {
        let file = tempfile::NamedTempFile::new().expect("a file");
        let write = |text: &str| std::fs::write(file.path(), text).expect("written");
        for mode in [IoMode::Map, IoMode::Read] {
            write("1 2 3 4 5 6");
            let input = InputFile::open(file.path(), mode).expect("opens");
            let array = DataArray {
                name: "Points".into(),
                components: 3,
                tuples: 2,
                ty: ScalarType::F32,
                content: Content::Text {
                    bytes: Bytes::of(&input, 0..11),
                    unit_colours: false,
                    pieces: None,
                    columns: None,
                },
            };
            let checked = array.check(&input).expect("six numbers");
            write("1 2     4 5");
            let convert = Recentre { origin: [0.0; 3] };
            let error = checked.collect(&convert, &Cancel::default()).expect_err("four numbers");
            assert!(error.to_string().contains("value 4 is missing"), "{mode:?}: {error}");
        }
    }

    #[test]
    fn records_give_their_values_whole_in_part_and_picked() {
        let file = tempfile::NamedTempFile::new().expect("a file");
        let input = InputFile::open(file.path(), IoMode::Read).expect("opens");
        // Five numbers do not fit a piece of values evenly.
        let (components, tuples, stride, offset) = (5, 20_000, 24, 3);
        let mut bytes = vec![0xaa; tuples * stride];
        for (i, record) in bytes.chunks_mut(stride).enumerate() {
            for (c, value) in record[offset..].chunks_mut(4).take(components).enumerate() {
                value.copy_from_slice(&((i * components + c) as u32).to_be_bytes());
            }
        }
        let array = DataArray {
            name: "a".into(),
            components,
            tuples,
            ty: ScalarType::U32,
            content: Content::Records { bytes: bytes.into(), stride, offset, big: true },
        };
        let checked = array.check(&input).expect("all there");
        let cancel = Cancel::default();
        let expected = |tuples: &[usize]| -> Vec<u64> {
            tuples.iter().flat_map(|i| (i * components..(i + 1) * components).map(|v| v as u64)).collect()
        };
        let all: Vec<usize> = (0..tuples).collect();
        assert_eq!(checked.collect(&ToU64, &cancel).expect("read"), expected(&all));
        assert_eq!(
            checked.tuples_in(777..12_345, &ToU64, &cancel).expect("read"),
            expected(&all[777..12_345])
        );
        let some: Vec<usize> = (3..tuples).step_by(1237).collect();
        assert_eq!(checked.pick(&some, &ToU64, &cancel).expect("read"), expected(&some));
    }
}
