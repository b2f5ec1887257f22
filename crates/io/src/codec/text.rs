//! Numbers in text: counted and parsed in parallel pieces.

use std::ops::Range;

use rayon::prelude::*;

use crate::Error;
use crate::input_file::Bytes;

/// Bytes of text handled at a time.
const PIECE: usize = 1 << 18;

/// Pieces counted together, before it is asked whether there are enough.
const BATCH: usize = 64;

/// No number is longer; longer runs of other bytes than blanks are cut.
const MAX_TOKEN: usize = 4096;

fn is_blank(byte: u8) -> bool {
    // One comparison and one subtraction instead of six comparisons: counting is bound by them. 0x0b is one for VTK.
    byte == b' ' || byte.wrapping_sub(b'\t') < 5
}

/// What stands between numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Separators {
    Blanks,
    /// Commas as well, or semicolons.
    Marks(u8),
}

impl Separators {
    fn test(self) -> impl Fn(u8) -> bool + Copy {
        move |byte| is_blank(byte) || matches!(self, Self::Marks(mark) if byte == mark)
    }
}

/// Splits at separators.
pub(crate) fn tokens(text: &[u8], separators: Separators) -> impl Iterator<Item = &[u8]> {
    let is_between = separators.test();
    text.split(move |&b| is_between(b)).filter(|token| !token.is_empty())
}

/// A stretch of text, the number of tokens that start in it, and the index of the first of them.
#[derive(Clone, Debug)]
pub(crate) struct Piece {
    range: Range<usize>,
    pub first: usize,
    pub count: usize,
}

impl Piece {
    /// Its text from the first token's start to the last one's end.
    pub fn text<'a>(&self, text: &'a Bytes, scratch: &'a mut Vec<u8>) -> Result<&'a [u8], Error> {
        text.get_up_to(self.range.start..self.range.end + MAX_TOKEN, scratch)
    }
}

/// Finds the first `wanted` tokens of `text`: pieces that hold as many, or all where there are fewer.
pub(crate) fn find(text: &Bytes, wanted: usize, separators: Separators) -> Result<Vec<Piece>, Error> {
    // Compiled once for each: counting is bound by the test.
    match separators {
        Separators::Blanks => find_between(text, wanted, is_blank),
        Separators::Marks(_) => find_between(text, wanted, separators.test()),
    }
}

fn find_between(
    text: &Bytes,
    wanted: usize,
    is_between: impl Fn(u8) -> bool + Copy + Sync,
) -> Result<Vec<Piece>, Error> {
    let mut pieces: Vec<Piece> = Vec::new();
    let (mut first, mut at) = (0, 0);
    while at < text.len() && first < wanted {
        // Numbers rarely take more than 16 characters, so that little is counted in vain behind a short array.
        let likely = (wanted - first).saturating_mul(16).clamp(MAX_TOKEN, PIECE * BATCH);
        let end = text.len().min(at + likely);
        let found: Vec<Piece> = (at..end)
            .into_par_iter()
            .step_by(PIECE)
            .map_init(Vec::new, |scratch, start| {
                count(text, start..end.min(start + PIECE), scratch, is_between)
            })
            .collect::<Result<_, _>>()?;
        for mut piece in found {
            if first < wanted && piece.count > 0 {
                piece.first = first;
                piece.count = piece.count.min(wanted - first);
                first += piece.count;
                pieces.push(piece);
            }
        }
        at = end;
    }
    Ok(pieces)
}

/// The piece of the tokens that start in `range`, its place among the others left open.
fn count(
    text: &Bytes,
    range: Range<usize>,
    scratch: &mut Vec<u8>,
    is_blank: impl Fn(u8) -> bool + Copy,
) -> Result<Piece, Error> {
    // A byte more tells whether the first one goes on with a token of the piece before.
    let ahead = usize::from(range.start > 0);
    let bytes = text.get_up_to(range.start - ahead..range.end, scratch)?;
    let leading = usize::from(ahead == 0 && bytes.first().is_some_and(|&byte| !is_blank(byte)));
    let count = leading + starts(bytes, is_blank);
    let start = if leading == 1 {
        0
    } else {
        let pairs = std::iter::zip(bytes, bytes.get(1..).unwrap_or_default());
        pairs.take_while(|(before, here)| !is_blank(**before) || is_blank(**here)).count() + 1 - ahead
    };
    Ok(Piece { range: range.start + start..range.end, first: 0, count })
}

/// How many bytes of `text` start a token behind a blank.
fn starts(text: &[u8], is_blank: impl Fn(u8) -> bool + Copy) -> usize {
    let next = text.get(1..).unwrap_or_default();
    // Sums of bytes, which cannot overflow in 255 steps, are what processors add up many at a time.
    let of_block = |(before, here): (&[u8], &[u8])| {
        let pairs = std::iter::zip(before, here);
        usize::from(pairs.map(|(before, here)| u8::from(is_blank(*before) & !is_blank(*here))).sum::<u8>())
    };
    std::iter::zip(text.chunks(255), next.chunks(255)).map(of_block).sum()
}

/// Offset just behind the last token of `pieces`, which [`find`] found in `text`.
pub(crate) fn end_of(text: &Bytes, pieces: &[Piece]) -> Result<usize, Error> {
    let Some(piece) = pieces.last() else { return Ok(0) };
    let mut scratch = Vec::new();
    let there = piece.text(text, &mut scratch)?;
    let end = tokens(there, Separators::Blanks)
        .nth(piece.count - 1)
        .map_or(there.len(), |token| token.as_ptr().addr() - there.as_ptr().addr() + token.len());
    Ok(piece.range.start + end)
}

/// A row of a table that has another number of tokens than the others, and where it starts.
pub(crate) struct OddRow {
    pub start: usize,
    pub found: usize,
}

/// Counts the rows of a table, lines that are not blank, the first `most` at most; each must have `per_row` tokens.
pub(crate) fn count_rows(
    text: &Bytes,
    per_row: usize,
    most: usize,
    separators: Separators,
) -> Result<Result<usize, OddRow>, Error> {
    let (mut rows, mut at, mut scratch) = (0, 0, Vec::new());
    while at < text.len() && rows < most {
        let there = text.get_up_to(at..at + PIECE, &mut scratch)?;
        // Whole lines; the last one may have no end, and one that is longer than a piece is none of a table.
        let is_last = at + there.len() == text.len();
        let end = if is_last { there.len() } else { memchr::memrchr(b'\n', there).map_or(0, |end| end + 1) };
        if end == 0 {
            return Ok(Err(OddRow { start: at, found: tokens(there, separators).count() }));
        }
        let mut start = 0;
        for line in there[..end].split(|byte| *byte == b'\n') {
            match tokens(line, separators).count() {
                _ if rows == most => break,
                0 => {}
                found if found == per_row => rows += 1,
                found => return Ok(Err(OddRow { start: at + start, found })),
            }
            start += line.len() + 1;
        }
        at += end;
    }
    Ok(Ok(rows))
}

/// A number as people and programs write it: also `+1`, `1.`, `.5`, `nan`, `-inf`, and Windows' `1.#QNAN`.
pub(crate) fn parse_f64(token: &[u8]) -> Option<f64> {
    let unsigned = match token {
        [b'+', b'+' | b'-', ..] => return None,
        [b'+', rest @ ..] => rest,
        _ => token,
    };
    match fast_float2::parse(unsigned) {
        Ok(value) => Some(value),
        Err(_) => {
            let lower = unsigned.to_ascii_lowercase();
            let body = lower.strip_prefix(b"-").unwrap_or(&lower);
            let is_nan = body.starts_with(b"nan(") || matches!(body, b"1.#qnan" | b"1.#ind" | b"1.#snan");
            match body {
                _ if is_nan => Some(f64::NAN),
                b"1.#inf" => Some(if lower[0] == b'-' { f64::NEG_INFINITY } else { f64::INFINITY }),
                _ => None,
            }
        }
    }
}

/// A whole number that an `f64` may be too coarse for, as its 64 bits.
pub(crate) fn parse_integer(token: &[u8]) -> Option<i128> {
    std::str::from_utf8(token).ok()?.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spellings_of_numbers() {
        for (text, value) in
            [("+1.5", 1.5), ("1.", 1.0), (".5", 0.5), ("-1e-3", -1e-3), ("1.#INF", f64::INFINITY)]
        {
            assert_eq!(parse_f64(text.as_bytes()), Some(value), "{text}");
        }
        for text in ["nan", "NaN", "-nan", "nan(ind)", "1.#QNAN"] {
            assert!(parse_f64(text.as_bytes()).is_some_and(f64::is_nan), "{text}");
        }
        for text in ["abc", "0x12", "1,5", "--1", "+-1", "1.5abc"] {
            assert_eq!(parse_f64(text.as_bytes()), None, "{text}");
        }
    }

    fn bytes(text: &str) -> Bytes {
        text.as_bytes().to_vec().into()
    }

    #[test]
    fn pieces_hold_every_token_once() {
        // Numbers of every length, so that the cuts fall into them.
        let text: String = (0..200_000).map(|i| format!("{i}{}", [" ", "\n\t", "  "][i % 3])).collect();
        let text = bytes(&text);
        let pieces = find(&text, usize::MAX, Separators::Blanks).expect("in memory");
        assert!(pieces.len() > 2, "the text must be cut for this test to mean anything");
        let mut expected = 0;
        for piece in &pieces {
            assert_eq!(piece.first, expected);
            let mut scratch = Vec::new();
            let there = piece.text(&text, &mut scratch).expect("in memory");
            for token in tokens(there, Separators::Blanks).take(piece.count) {
                assert_eq!(token, expected.to_string().as_bytes());
                expected += 1;
            }
        }
        assert_eq!(expected, 200_000);
    }

    #[test]
    fn tokens_are_found_exactly() {
        let text = bytes(" a  bb\nccc");
        let found = |wanted| {
            let pieces = find(&text, wanted, Separators::Blanks).expect("in memory");
            let count: usize = pieces.iter().map(|piece| piece.count).sum();
            (count, end_of(&text, &pieces).expect("in memory"))
        };
        assert_eq!([0, 1, 2, 3, 4].map(found), [(0, 0), (1, 2), (2, 6), (3, 10), (3, 10)]);
        assert!(find(&bytes(" \n "), 1, Separators::Blanks).expect("in memory").is_empty());
    }

    #[test]
    fn a_token_across_the_end_of_what_is_counted_at_once_is_whole() {
        let text = bytes(&format!("{}12345 6", " ".repeat(MAX_TOKEN - 2)));
        let pieces = find(&text, 1, Separators::Blanks).expect("in memory");
        assert_eq!(end_of(&text, &pieces).expect("in memory"), MAX_TOKEN + 3);
    }
}
