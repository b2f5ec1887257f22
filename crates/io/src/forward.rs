//! A file from front to back, with a look ahead: what parsers see of it.

use std::io::{self, BufRead, Read};
use std::ops::Range;

use crate::Error;
use crate::input_file::InputFile;

/// A place in a file. Of a file that is not mapped, one window is in memory.
pub(crate) struct Forward<'a> {
    file: &'a InputFile,
    position: usize,
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
        let wanted = count.min(self.left());
        let window = self.window_start..self.window_start + self.window.len();
        if self.position < window.start || self.position + wanted > window.end {
            self.window_start = self.position;
            let end = self.position + wanted.max(WINDOW).min(self.left());
            // Half a window must not be taken for a whole one.
            if let Err(error) = self.file.get(self.position..end, &mut self.window) {
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
        // Asked twice, because what is given out would keep the failure from being noted.
        if let Err(error) = self.peek(1) {
            let copy = io::Error::other(error.to_string());
            self.failure = Some(error);
            return Err(copy);
        }
        let there = self.peek(1).map_err(io::Error::other)?;
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
