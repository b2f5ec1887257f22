//! Base64 with random access: any byte range is decoded from the characters that hold it.

use base64::Engine;
use base64::alphabet::STANDARD;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};
use std::ops::Range;

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

/// Decodes bytes `range` of the stream that starts at `text[0]` into `scratch` and returns them; `None` when characters are
/// missing or illegal.
pub(crate) fn decode_range<'s>(
    text: &[u8],
    range: Range<usize>,
    scratch: &'s mut Vec<u8>,
) -> Option<&'s [u8]> {
    let first_quad = range.start / 3;
    let end = encoded_len(range.end)?.min(text.len());
    let chars = text.get(first_quad * 4..end)?;
    scratch.clear();
    ENGINE.decode_vec(chars, scratch).ok()?;
    let skip = first_quad * 3;
    scratch.get(range.start - skip..range.end - skip)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn any_range_equals_the_slice() {
        let bytes: Vec<u8> = (0..=255).collect();
        let text = ENGINE.encode(&bytes);
        let mut scratch = Vec::new();
        for start in (0..256).step_by(7) {
            for end in start..=256 {
                let decoded = decode_range(text.as_bytes(), start..end, &mut scratch);
                assert_eq!(decoded, Some(&bytes[start..end]), "{start}..{end}");
            }
        }
        assert_eq!(decode_range(text.as_bytes(), 0..257, &mut scratch), None);
        assert_eq!(decode_range(b"AA*A", 0..3, &mut scratch), None);
    }
}
