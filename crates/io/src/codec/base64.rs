//! Base64 with random access: any byte range is decoded from the characters that hold it.

use base64::Engine;
use base64::alphabet::STANDARD;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};
use rayon::prelude::*;
use std::ops::Range;

use crate::Error;
use crate::input_file::Bytes;

const ENGINE: GeneralPurpose = GeneralPurpose::new(
    &STANDARD,
    GeneralPurposeConfig::new()
        .with_decode_padding_mode(DecodePaddingMode::Indifferent)
        .with_decode_allow_trailing_bits(true),
);

/// Characters that encode `bytes` bytes, padding included.
pub(crate) fn encoded_len(bytes: usize) -> Option<usize> {
    bytes.div_ceil(3).checked_mul(4)
}

/// Base64 in a file or in memory, as if there were no blanks in it: lines may be broken anywhere.
pub(crate) struct Text {
    /// Starts with the first character.
    bytes: Bytes,
    /// Characters there are, as far as they were looked for.
    chars: usize,
    /// How many of the characters belong to what comes before.
    skip: usize,
    /// Characters before each [`BLOCK`] of `bytes`; empty when there are no blanks.
    before: Vec<usize>,
}

/// Bytes of text in which blanks are counted at a time.
const BLOCK: usize = 1 << 16;

/// Blocks counted together, before it is asked whether there are enough characters.
const BATCH: usize = 64;

/// Room for what is read and what is decoded from it.
#[derive(Default)]
pub(crate) struct Scratch {
    pub stored: Vec<u8>,
    pub decoded: Vec<u8>,
}

impl Text {
    /// The text at the start of `bytes`, in which the first `wanted` characters are looked for.
    pub fn find(bytes: &Bytes, wanted: usize) -> Result<Self, Error> {
        let mut scratch = Vec::new();
        let mut start = 0;
        loop {
            let there = bytes.get_up_to(start..start + BLOCK, &mut scratch)?;
            let blanks = there.iter().take_while(|byte| byte.is_ascii_whitespace()).count();
            start += blanks;
            if blanks == 0 || blanks < there.len() {
                break;
            }
        }
        let bytes = bytes.from(start);
        let (mut before, mut chars, mut blanks, mut at) = (Vec::new(), 0, 0, 0);
        while at < bytes.len() && chars < wanted {
            let blocks = (wanted - chars).div_ceil(BLOCK).min(BATCH);
            let end = bytes.len().min(at + blocks * BLOCK);
            let counts: Vec<usize> = (at..end)
                .into_par_iter()
                .step_by(BLOCK)
                .map_init(Vec::new, |scratch, start| {
                    Ok(blanks_in(bytes.get_up_to(start..end.min(start + BLOCK), scratch)?))
                })
                .collect::<Result<_, Error>>()?;
            for (i, found) in counts.into_iter().enumerate() {
                before.push(chars);
                chars += (end - at - i * BLOCK).min(BLOCK) - found;
                blanks += found;
            }
            at = end;
        }
        if blanks == 0 {
            before.clear();
        }
        Ok(Self { bytes, chars, skip: 0, before })
    }

    /// Characters that were found, at least as many as were wanted where they are there.
    pub fn len(&self) -> usize {
        self.chars - self.skip
    }

    /// Leaves out the first `chars` characters.
    pub fn skip(&mut self, chars: usize) {
        self.skip = self.skip.saturating_add(chars).min(self.chars);
    }

    /// Whether character `index` ends an encoding.
    pub fn is_padding(&self, index: usize) -> Result<bool, Error> {
        Ok(self.chars(index..index + 1, &mut Vec::new())? == Some(b"="))
    }

    /// Decodes bytes `range` of the stream; `None` when characters are missing or illegal.
    pub fn decode<'s>(
        &'s self,
        range: Range<usize>,
        scratch: &'s mut Scratch,
    ) -> Result<Option<&'s [u8]>, Error> {
        let first_quad = range.start / 3;
        let Some(end) = encoded_len(range.end).map(|end| end.min(self.len())) else { return Ok(None) };
        let Some(chars) = self.chars(first_quad * 4..end, &mut scratch.stored)? else { return Ok(None) };
        scratch.decoded.clear();
        if ENGINE.decode_vec(chars, &mut scratch.decoded).is_err() {
            return Ok(None);
        }
        let skip = first_quad * 3;
        Ok(scratch.decoded.get(range.start - skip..range.end - skip))
    }

    /// The characters `range`.
    fn chars<'s>(&'s self, range: Range<usize>, scratch: &'s mut Vec<u8>) -> Result<Option<&'s [u8]>, Error> {
        if range.start > range.end || range.end > self.len() {
            return Ok(None);
        }
        let (start, end) = (range.start + self.skip, range.end + self.skip);
        if self.before.is_empty() {
            return self.bytes.get(start..end, scratch);
        }
        // Blocks that hold the characters.
        let first = self.before.partition_point(|&before| before <= start).saturating_sub(1);
        let last = self.before.partition_point(|&before| before < end);
        let mut text = self.bytes.get_up_to(first * BLOCK..last * BLOCK, scratch)?.to_vec();
        text.retain(|byte| !byte.is_ascii_whitespace());
        let skip = start - self.before[first];
        text.truncate(skip + (end - start));
        text.drain(..skip);
        *scratch = text;
        Ok(Some(scratch))
    }
}

fn blanks_in(text: &[u8]) -> usize {
    // Sums of bytes, which cannot overflow in 255 steps, are what processors add up many at a time.
    let of_block = |block: &[u8]| block.iter().map(|byte| u8::from(byte.is_ascii_whitespace())).sum::<u8>();
    text.chunks(255).map(|block| usize::from(of_block(block))).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn decode(text: &[u8], range: Range<usize>) -> Option<Vec<u8>> {
        let text = Text::find(&text.to_vec().into(), usize::MAX).expect("in memory");
        text.decode(range, &mut Scratch::default()).expect("in memory").map(<[u8]>::to_vec)
    }

    #[test]
    fn any_range_equals_the_slice() {
        let bytes: Vec<u8> = (0..=255).collect();
        let text = ENGINE.encode(&bytes);
        let lines: Vec<String> =
            text.as_bytes().chunks(7).map(|line| String::from_utf8_lossy(line).into()).collect();
        for text in [text, format!(" \r\n{}\n ", lines.join("\r\n"))] {
            for start in (0..256).step_by(7) {
                for end in start..=256 {
                    let decoded = decode(text.as_bytes(), start..end);
                    assert_eq!(decoded.as_deref(), Some(&bytes[start..end]), "{start}..{end} of {text}");
                }
            }
            assert_eq!(decode(text.as_bytes(), 0..257), None);
        }
        assert_eq!(decode(b"AA*A", 0..3), None);
    }

    #[test]
    fn long_texts_with_blanks_are_found_by_blocks() {
        let bytes: Vec<u8> = (0..300_000_u32).map(|i| (i.wrapping_mul(2_654_435_761) >> 24) as u8).collect();
        let mut text = String::new();
        for (i, letter) in ENGINE.encode(&bytes).chars().enumerate() {
            // Most blocks have blanks, and not all as many.
            text.push(letter);
            if i % 61 == 0 && i % 200_000 > 70_000 {
                text.push('\n');
            }
        }
        for start in [0, 1, 49_150, 49_152, 150_001, 299_998] {
            for end in [start, start + 1, start + 70_000, 300_000] {
                let end = end.min(300_000);
                assert_eq!(
                    decode(text.as_bytes(), start..end).as_deref(),
                    Some(&bytes[start..end]),
                    "{start}..{end}"
                );
            }
        }
    }

    #[test]
    fn what_is_not_wanted_is_not_looked_at() {
        let text = Text::find(&vec![b'A'; 10 * BLOCK].into(), 5).expect("in memory");
        assert!((5..=BLOCK).contains(&text.len()), "{}", text.len());
    }
}
