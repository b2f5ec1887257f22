use std::fmt::Display;
use std::str::FromStr;

use crate::Error;
use crate::array::{Bytes, Content, DataArray};
use crate::codec::text;
use crate::mapped::MappedFile;
use crate::scalar::ScalarType;

/// A place in a legacy file.
pub(super) struct Cursor<'a> {
    pub file: &'a MappedFile,
    pub position: usize,
    pub binary: bool,
}

impl<'a> Cursor<'a> {
    pub fn new(file: &'a MappedFile) -> Self {
        Self { file, position: 0, binary: false }
    }

    fn rest(&self) -> &'a [u8] {
        &self.file[self.position..]
    }

    pub fn malformed(&self, message: impl Display) -> Error {
        Error::malformed(self.file.path(), format_args!("byte {}", self.position), message)
    }

    /// The text up to the end of the line, which is consumed: LF, CR LF, or CR alone.
    pub fn line(&mut self) -> &'a [u8] {
        let rest = self.rest();
        let end = rest.iter().position(|&b| b == b'\n' || b == b'\r').unwrap_or(rest.len());
        self.position += end;
        self.end_line();
        &rest[..end]
    }

    fn end_line(&mut self) {
        match self.rest() {
            [b'\r', b'\n', ..] => self.position += 2,
            [b'\r' | b'\n', ..] => self.position += 1,
            _ => {}
        }
    }

    /// Where the next word lies. It is not consumed: the blanks before it may be data that looks like blanks.
    fn next_word(&self) -> std::ops::Range<usize> {
        let rest = self.rest();
        let start = rest.iter().position(|b| !b.is_ascii_whitespace()).unwrap_or(rest.len());
        // No keyword or number is longer; a longer run of bytes is data.
        let window = &rest[start..rest.len().min(start + 4096)];
        let length = window.iter().position(u8::is_ascii_whitespace).unwrap_or(window.len());
        self.position + start..self.position + start + length
    }

    /// The next word as written; `None` at the end of the file.
    pub fn raw_word(&mut self) -> Option<&'a [u8]> {
        let word = self.next_word();
        self.position = word.end;
        (!word.is_empty()).then(|| &self.file[word])
    }

    /// The next word in lower case.
    pub fn word(&mut self, expected: &str) -> Result<String, Error> {
        let word = self
            .raw_word()
            .ok_or_else(|| self.malformed(format_args!("the file ends, expected {expected}")))?;
        Ok(String::from_utf8_lossy(word).to_ascii_lowercase())
    }

    /// Whether the next word is `keyword` (any case); consumes it if so.
    pub fn accept(&mut self, keyword: &str) -> bool {
        let word = self.next_word();
        let found = self.file[word.clone()].eq_ignore_ascii_case(keyword.as_bytes());
        if found {
            self.position = word.end;
        }
        found
    }

    /// Whether another word stands on this line.
    pub fn line_goes_on(&self) -> bool {
        self.rest().iter().find(|b| !matches!(b, b' ' | b'\t')).is_some_and(|b| !b.is_ascii_whitespace())
    }

    pub fn number<T: FromStr>(&mut self, what: &str) -> Result<T, Error> {
        let start = self.position;
        let word = self.word(what)?;
        word.parse().map_err(|_| {
            Error::malformed(
                self.file.path(),
                format_args!("byte {start}"),
                format_args!("expected {what}, found {word:?}"),
            )
        })
    }

    /// A name, in which VTK writes unusual characters as `%xx`.
    pub fn name(&mut self) -> Result<String, Error> {
        let word = self.raw_word().ok_or_else(|| self.malformed("the file ends, expected an array name"))?;
        Ok(percent_decoded(word))
    }

    pub fn scalar_type(&mut self) -> Result<ScalarType, Error> {
        let word = self.word("a numeric type")?;
        self.numeric(&word)
    }

    pub fn numeric(&self, word: &str) -> Result<ScalarType, Error> {
        ScalarType::from_legacy(word).ok_or_else(|| {
            self.malformed(format_args!("unknown type {word:?}, expected float, double, int, ..."))
        })
    }

    /// The values that follow the line the cursor is on.
    pub fn array(
        &mut self,
        name: String,
        components: usize,
        tuples: usize,
        ty: ScalarType,
    ) -> Result<DataArray, Error> {
        let (start, end) = self.payload(&name, components, tuples, ty)?;
        let bytes = Bytes::File(start..end);
        let content = if self.binary {
            Content::Binary { bytes, big: true }
        } else {
            Content::Text { bytes, unit_colours: false }
        };
        Ok(DataArray { name, components, tuples, ty, content })
    }

    fn payload(
        &mut self,
        name: &str,
        components: usize,
        tuples: usize,
        ty: ScalarType,
    ) -> Result<(usize, usize), Error> {
        let values = components.checked_mul(tuples);
        let length = values.and_then(|values| {
            if self.binary {
                self.line();
                ty.bytes(values).filter(|&length| length <= self.rest().len())
            } else {
                // Every number takes a byte and a blank.
                let possible = values <= self.rest().len();
                possible.then(|| text::skip_tokens(self.rest(), values)).flatten()
            }
        });
        let start = self.position;
        let length = length.ok_or_else(|| {
            self.malformed(format_args!(
                "{name:?} declares {tuples} x {components} values, more than the {} bytes left in the file; \
                 it is cut off or the count is wrong",
                self.rest().len()
            ))
        })?;
        self.position += length;
        Ok((start, self.position))
    }

    /// Steps over `count` strings, in text one to a line, in binary each behind its length.
    pub fn skip_strings(&mut self, count: usize) -> Result<(), Error> {
        if count > self.rest().len() {
            return Err(self.malformed(format_args!("{count} strings cannot be in the rest of the file")));
        }
        self.line();
        for _ in 0..count {
            if !self.binary {
                self.line();
                continue;
            }
            // The two high bits of the first byte say how many bytes the length has: 8, 4, 2 or 1.
            let rest = self.rest();
            let width = 8 >> (rest.first().copied().unwrap_or(0) >> 6);
            let length = rest.get(..width).map(|bytes| {
                let raw = bytes.iter().fold(0_u64, |acc, &b| acc << 8 | u64::from(b));
                raw & (u64::MAX >> (66 - 8 * width))
            });
            let end = length
                .and_then(|length| usize::try_from(length).ok()?.checked_add(width))
                .filter(|&end| end <= rest.len())
                .ok_or_else(|| self.malformed("a string runs past the end of the file"))?;
            self.position += end;
        }
        Ok(())
    }

    /// Steps over a METADATA block, which an empty line ends.
    pub fn skip_metadata(&mut self) {
        self.line();
        while !self.rest().is_empty() && !self.line().trim_ascii().is_empty() {}
    }
}

fn percent_decoded(word: &[u8]) -> String {
    let mut bytes = Vec::with_capacity(word.len());
    let mut i = 0;
    while i < word.len() {
        let hex = word.get(i + 1..i + 3).filter(|_| word[i] == b'%');
        match hex.and_then(|h| u8::from_str_radix(std::str::from_utf8(h).ok()?, 16).ok()) {
            Some(byte) => {
                bytes.push(byte);
                i += 3;
            }
            None => {
                bytes.push(word[i]);
                i += 1;
            }
        }
    }
    String::from_utf8_lossy(&bytes).into_owned()
}

#[cfg(test)]
mod tests {
    use super::percent_decoded;

    #[test]
    fn names_are_decoded() {
        assert_eq!(percent_decoded("%CF%81%20x".as_bytes()), "ρ x");
        assert_eq!(percent_decoded(b"100%"), "100%");
        assert_eq!(percent_decoded(b"a%zzb"), "a%zzb");
    }
}
