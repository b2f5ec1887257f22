use std::fmt::Display;
use std::str::FromStr;

use crate::Error;
use crate::array::{Content, DataArray};
use crate::codec::text::{self, Separators};
use crate::forward::Forward;
use crate::input_file::{Bytes, InputFile};
use crate::scalar::ScalarType;

/// A place in a legacy file.
pub(super) struct Cursor<'a> {
    pub place: Forward<'a>,
    pub binary: bool,
}

/// No keyword, number or name is longer; a longer run of bytes is data.
const MAX_WORD: usize = 4096;

impl<'a> Cursor<'a> {
    pub fn new(file: &'a InputFile) -> Self {
        Self { place: Forward::new(file, 0), binary: false }
    }

    pub fn file(&self) -> &'a InputFile {
        self.place.file()
    }

    pub fn malformed(&self, message: impl Display) -> Error {
        self.malformed_at(self.place.position(), message)
    }

    fn malformed_at(&self, position: usize, message: impl Display) -> Error {
        Error::malformed(self.file().path(), format_args!("byte {position}"), message)
    }

    /// Steps behind the end of the line: LF, CR LF, or CR alone. Says whether there was more than blanks in it.
    pub fn line(&mut self) -> Result<bool, Error> {
        let is_blank = |byte: &u8| byte.is_ascii_whitespace() && !matches!(byte, b'\r' | b'\n');
        self.place.skip_to(|text| text.iter().position(|byte| !is_blank(byte)))?;
        let has_text = !matches!(self.place.peek(1)?.first(), None | Some(b'\r' | b'\n'));
        self.place.skip_to(|text| memchr::memchr2(b'\n', b'\r', text))?;
        match self.place.peek(2)? {
            [b'\r', b'\n', ..] => self.place.advance(2),
            [b'\r' | b'\n', ..] => self.place.advance(1),
            _ => {}
        }
        Ok(has_text)
    }

    /// The next word as written, empty at the end of the file. The place moves behind it.
    pub fn raw_word(&mut self) -> Result<Vec<u8>, Error> {
        self.place.skip_blanks()?;
        let there = self.place.peek(MAX_WORD)?;
        let there = &there[..there.len().min(MAX_WORD)];
        let length = there.iter().position(u8::is_ascii_whitespace).unwrap_or(there.len());
        let word = there[..length].to_vec();
        self.place.advance(length);
        Ok(word)
    }

    /// The next word in lower case.
    pub fn word(&mut self, expected: &str) -> Result<String, Error> {
        let word = self.raw_word()?;
        if word.is_empty() {
            return Err(self.malformed(format_args!("the file ends, expected {expected}")));
        }
        Ok(String::from_utf8_lossy(&word).to_ascii_lowercase())
    }

    /// Whether the next word is `keyword` (any case); consumes it if so. Else nothing is consumed: the blanks before the word
    /// may be data that looks like blanks.
    pub fn accept(&mut self, keyword: &str) -> Result<bool, Error> {
        let start = self.place.position();
        let found = self.raw_word()?.eq_ignore_ascii_case(keyword.as_bytes());
        if !found {
            self.place.go_to(start);
        }
        Ok(found)
    }

    /// Whether another word stands on this line; the blanks before it are consumed.
    pub fn line_goes_on(&mut self) -> Result<bool, Error> {
        self.place.skip_to(|text| text.iter().position(|byte| !matches!(byte, b' ' | b'\t')))?;
        Ok(self.place.peek(1)?.first().is_some_and(|byte| !byte.is_ascii_whitespace()))
    }

    pub fn number<T: FromStr>(&mut self, what: &str) -> Result<T, Error> {
        let start = self.place.position();
        let word = self.word(what)?;
        word.parse().map_err(|_| self.malformed_at(start, format_args!("expected {what}, found {word:?}")))
    }

    /// A name, in which VTK writes unusual characters as `%xx`.
    pub fn name(&mut self) -> Result<String, Error> {
        let word = self.raw_word()?;
        if word.is_empty() {
            return Err(self.malformed("the file ends, expected an array name"));
        }
        Ok(percent_decoded(&word))
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

    /// The values that follow the line the cursor is on, and what is said about them.
    pub fn array(
        &mut self,
        name: String,
        components: usize,
        tuples: usize,
        ty: ScalarType,
    ) -> Result<DataArray, Error> {
        let content = self.payload(components, tuples, ty)?.ok_or_else(|| {
            self.malformed(format_args!(
                "{name:?} declares {tuples} x {components} values, more than the {} bytes left in the file; \
                 it is cut off or the count is wrong",
                self.place.left()
            ))
        })?;
        self.skip_metadata(components)?;
        Ok(DataArray { name, components, tuples, ty, content })
    }

    /// Steps over the values; `None` when they are not all there.
    fn payload(
        &mut self,
        components: usize,
        tuples: usize,
        ty: ScalarType,
    ) -> Result<Option<Content>, Error> {
        let Some(values) = components.checked_mul(tuples) else { return Ok(None) };
        if self.binary {
            self.line()?;
            let Some(length) = ty.bytes(values).filter(|&length| length <= self.place.left()) else {
                return Ok(None);
            };
            let start = self.place.position();
            self.place.advance(length);
            let bytes = Bytes::of(self.file(), start..start + length);
            return Ok(Some(Content::Binary { bytes, big: true }));
        }
        let start = self.place.position();
        let rest = Bytes::of(self.file(), start..self.file().len());
        // Every number takes a byte and a blank.
        if values > rest.len() {
            return Ok(None);
        }
        let pieces = text::find(&rest, values, Separators::Blanks)?;
        if pieces.iter().map(|piece| piece.count).sum::<usize>() < values {
            return Ok(None);
        }
        let length = text::end_of(&rest, &pieces)?;
        self.place.advance(length);
        let bytes = Bytes::of(self.file(), start..start + length);
        Ok(Some(Content::Text { bytes, unit_colours: false, pieces: Some(pieces.into()), columns: None }))
    }

    /// Steps over `count` strings, in text one to a line, in binary each behind its length.
    pub fn skip_strings(&mut self, count: usize) -> Result<(), Error> {
        if count > self.place.left() {
            return Err(self.malformed(format_args!("{count} strings cannot be in the rest of the file")));
        }
        self.line()?;
        for _ in 0..count {
            if !self.binary {
                self.line()?;
                continue;
            }
            // The two high bits of the first byte say how many bytes the length has: 8, 4, 2 or 1.
            let rest = self.place.peek(8)?;
            let width = 8 >> (rest.first().copied().unwrap_or(0) >> 6);
            let length = rest.get(..width).map(|bytes| {
                let raw = bytes.iter().fold(0_u64, |acc, &b| acc << 8 | u64::from(b));
                raw & (u64::MAX >> (66 - 8 * width))
            });
            let end = length
                .and_then(|length| usize::try_from(length).ok()?.checked_add(width))
                .filter(|&end| end <= self.place.left())
                .ok_or_else(|| self.malformed("a string runs past the end of the file"))?;
            self.place.advance(end);
        }
        Ok(())
    }

    /// Steps over METADATA blocks, if any follow, of an array with `components`.
    pub fn skip_metadata(&mut self, components: usize) -> Result<(), Error> {
        while self.accept("METADATA")? {
            self.line()?;
            // An empty line ends the block, but for those that stand for components without a name.
            if self.accept("COMPONENT_NAMES")? {
                self.line()?;
                for _ in 0..components.min(self.place.left()) {
                    self.line()?;
                }
            }
            while self.line()? {}
        }
        Ok(())
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
