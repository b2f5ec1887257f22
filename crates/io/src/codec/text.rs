//! Numbers in text: counted and parsed in parallel pieces cut at blanks.

use std::ops::Range;

use rayon::prelude::*;

/// Bytes of text handled at a time.
const PIECE: usize = 1 << 18;

fn is_blank(byte: u8) -> bool {
    byte.is_ascii_whitespace() || byte == 0x0b
}

/// Splits at blanks.
pub(crate) fn tokens(text: &[u8]) -> impl Iterator<Item = &[u8]> {
    text.split(|&b| is_blank(b)).filter(|token| !token.is_empty())
}

/// Offset just behind the first `count` tokens of `text`; `None` when there are fewer.
pub(crate) fn skip_tokens(text: &[u8], count: usize) -> Option<usize> {
    let mut position = 0;
    for _ in 0..count {
        position += text[position..].iter().position(|&b| !is_blank(b))?;
        position += text[position..].iter().position(|&b| is_blank(b)).unwrap_or(text.len() - position);
    }
    Some(position)
}

/// A stretch of whole tokens and the index of its first one.
pub(crate) struct Piece {
    pub range: Range<usize>,
    pub first: usize,
    pub count: usize,
}

/// Cuts `text` at blanks and counts the tokens of each piece.
pub(crate) fn pieces(text: &[u8]) -> Vec<Piece> {
    let mut cuts = vec![0];
    while text.len() - cuts[cuts.len() - 1] > PIECE {
        let probe = cuts[cuts.len() - 1] + PIECE;
        let Some(blank) = text[probe..].iter().position(|&b| is_blank(b)) else { break };
        cuts.push(probe + blank);
    }
    cuts.push(text.len());
    let counts: Vec<usize> = cuts
        .par_windows(2)
        .map(|cut| {
            let piece = &text[cut[0]..cut[1]];
            let starts = piece.windows(2).filter(|pair| is_blank(pair[0]) && !is_blank(pair[1])).count();
            starts + usize::from(piece.first().is_some_and(|&b| !is_blank(b)))
        })
        .collect();
    let mut first = 0;
    std::iter::zip(cuts.windows(2), counts)
        .map(|(cut, count)| {
            let piece = Piece { range: cut[0]..cut[1], first, count };
            first += count;
            piece
        })
        .collect()
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

    #[test]
    fn pieces_hold_every_token_once() {
        let text: String = (0..200_000).map(|i| format!("{i} ")).collect();
        let pieces = pieces(text.as_bytes());
        assert!(pieces.len() > 2, "the text must be cut for this test to mean anything");
        assert_eq!(pieces.iter().map(|p| p.count).sum::<usize>(), 200_000);
        for piece in pieces {
            let first = tokens(&text.as_bytes()[piece.range]).next().map(<[u8]>::to_vec);
            assert_eq!(first, Some(piece.first.to_string().into_bytes()));
        }
    }

    #[test]
    fn tokens_are_skipped_exactly() {
        assert_eq!(skip_tokens(b" a  bb\nccc", 2), Some(6));
        assert_eq!(skip_tokens(b" a  bb\nccc", 3), Some(10));
        assert_eq!(skip_tokens(b" a  bb\nccc", 4), None);
    }
}
