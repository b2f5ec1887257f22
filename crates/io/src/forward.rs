//! A file from front to back, with a look ahead: what parsers see of it.

use std::io::{self, BufRead, Read};
use std::ops::Range;

use crate::Error;
use crate::input_file::InputFile;

/// A place in a file.
pub(crate) struct Forward<'a> {
    file: &'a InputFile,
    position: usize,
    /// Bytes that stay what they are: of a file that is not mapped, and of all that is given out through [`BufRead`]. A map
    /// changes while it is read when somebody writes to the file or shortens it, and a parser that looks twice would find
    /// something else than it has checked.
    window: Vec<u8>,
    /// Where the window lies in the file.
    window_start: usize,
    /// Bytes that may still be read through [`BufRead`].
    budget: usize,
    /// Why reading through [`BufRead`] failed.
    failure: Option<Error>,
}

/// Bytes read at a time.
const WINDOW: usize = 64 << 10;

/// Bytes of a map copied at a time: an element with its attributes is short, and what follows it is passed over.
const MAP_WINDOW: usize = 4 << 10;

impl<'a> Forward<'a> {
    pub fn new(file: &'a InputFile, position: usize) -> Self {
        let position = position.min(file.len());
        Self { file, position, window: Vec::new(), window_start: 0, budget: usize::MAX, failure: None }
    }

    pub fn file(&self) -> &'a InputFile {
        self.file
    }

    pub fn position(&self) -> usize {
        self.position
    }

    /// Bytes from here to the end of the file.
    pub fn left(&self) -> usize {
        self.file.len() - self.position
    }

    /// Goes to `position`, at most the end of the file.
    pub fn go_to(&mut self, position: usize) {
        self.position = position.min(self.file.len());
    }

    pub fn advance(&mut self, count: usize) {
        self.go_to(self.position.saturating_add(count));
    }

    /// What follows: at least `count` bytes, fewer only at the end of the file.
    pub fn peek(&mut self, count: usize) -> Result<&[u8], Error> {
        if let Some(map) = self.file.mapped() {
            return Ok(&map[self.position..]);
        }
        self.peek_window(count, WINDOW)
    }

    /// As [`Self::peek`], of the window, which is filled with `ahead` bytes when it has to be.
    fn peek_window(&mut self, count: usize, ahead: usize) -> Result<&[u8], Error> {
        let wanted = count.min(self.left());
        let window = self.window_start..self.window_start + self.window.len();
        if self.position < window.start || self.position + wanted > window.end {
            self.window_start = self.position;
            let end = self.position + wanted.max(ahead).min(self.left());
            // Half a window must not be taken for a whole one.
            if let Err(error) = self.file.copy(self.position..end, &mut self.window) {
                self.window.clear();
                return Err(error);
            }
        }
        Ok(&self.window[self.position - self.window_start..])
    }

    /// Steps over the bytes before the first one that `find` finds in a stretch, or to the end of the file.
    pub fn skip_to(&mut self, find: impl Fn(&[u8]) -> Option<usize>) -> Result<(), Error> {
        while self.left() > 0 {
            let there = self.peek(1)?;
            let (found, length) = (find(there), there.len());
            self.advance(found.unwrap_or(length));
            if found.is_some() {
                break;
            }
        }
        Ok(())
    }

    /// Steps over blanks.
    pub fn skip_blanks(&mut self) -> Result<(), Error> {
        self.skip_to(|text| text.iter().position(|byte| !byte.is_ascii_whitespace()))
    }

    /// Steps over text up to the next `<` or `&`. Returns where it lies, and whether it is blank.
    pub fn skip_text(&mut self) -> Result<(Range<usize>, bool), Error> {
        let start = self.position;
        self.skip_blanks()?;
        let text = self.position;
        self.skip_to(|text| memchr::memchr2(b'<', b'&', text))?;
        Ok((start..self.position, text == self.position))
    }

    /// From here on at most `bytes` more are given out through [`BufRead`].
    pub fn limit(&mut self, bytes: usize) {
        self.budget = bytes;
    }

    /// Whether the limit is used up.
    pub fn is_exhausted(&self) -> bool {
        self.budget == 0
    }

    /// Why reading through [`BufRead`] failed, if it did.
    pub fn take_failure(&mut self) -> Option<Error> {
        self.failure.take()
    }
}

impl BufRead for Forward<'_> {
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        // Nothing more looks like the end of the file; who sets a limit asks whether it was that.
        if self.budget == 0 {
            return Ok(&[]);
        }
        let budget = self.budget;
        let ahead = if self.file.mapped().is_some() { MAP_WINDOW } else { WINDOW };
        // Asked twice, because what is given out would keep the failure from being noted.
        if let Err(error) = self.peek_window(1, ahead) {
            let copy = io::Error::other(error.to_string());
            self.failure = Some(error);
            return Err(copy);
        }
        let there = self.peek_window(1, ahead).map_err(io::Error::other)?;
        Ok(&there[..there.len().min(budget)])
    }

    fn consume(&mut self, amount: usize) {
        self.advance(amount);
        self.budget = self.budget.saturating_sub(amount);
    }
}

impl Read for Forward<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let count = self.fill_buf()?.read(buffer)?;
        self.consume(count);
        Ok(count)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::IoMode;

    #[test]
    fn what_is_given_out_stays_when_the_file_shrinks() {
        crate::map_guard::install().expect("installed");
        let mut file = tempfile::NamedTempFile::new().expect("a file");
        io::Write::write_all(&mut file, &[b'x'; 100_000]).expect("written");
        for mode in [IoMode::Map, IoMode::Read] {
            let input = InputFile::open(file.path(), mode).expect("opens");
            let mut place = Forward::new(&input, 10);
            let count = place.fill_buf().expect("there").len();
            file.as_file().set_len(0).expect("emptied");
            assert_eq!(place.fill_buf().expect("still there"), vec![b'x'; count], "{mode:?}");
            file.as_file().set_len(0).and_then(|()| file.as_file().set_len(100_000)).expect("long again");
            io::Seek::rewind(&mut file)
                .and_then(|()| io::Write::write_all(&mut file, &[b'x'; 100_000]))
                .expect("written");
        }
    }
}
