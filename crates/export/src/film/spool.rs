//! The file of a film on its way: it grows at its end, and counts are filled in once they are known.

use std::fs::File;
use std::io::{Error, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;

use crate::ExportError;
use crate::beside::beside;

/// A file beside the one that it will be.
pub(super) struct Spool {
    file: NamedTempFile,
    path: PathBuf,
    length: u64,
}

impl Spool {
    /// For the film that will lie at `path`.
    pub fn new(path: &Path) -> Result<Self, ExportError> {
        let file = beside(path).map_err(|source| ExportError::Io { path: path.to_owned(), source })?;
        Ok(Self { file, path: path.to_owned(), length: 0 })
    }

    /// Where the file lies until it is finished.
    pub fn place(&self) -> &Path {
        self.file.path()
    }

    /// Bytes so far.
    pub fn length(&self) -> u64 {
        self.length
    }

    /// Appends `bytes`, all or none of them: what a full disk has taken is cut off again.
    pub fn append(&mut self, bytes: &[u8]) -> Result<(), ExportError> {
        let file = self.file.as_file_mut();
        let result = file.seek(SeekFrom::Start(self.length)).and_then(|_| file.write_all(bytes));
        if let Err(error) = result {
            self.shorten(self.length)?;
            return Err(self.refused(error));
        }
        self.length += bytes.len() as u64;
        Ok(())
    }

    /// Cuts off what lies behind `length`.
    pub fn shorten(&mut self, length: u64) -> Result<(), ExportError> {
        self.file.as_file_mut().set_len(length).map_err(|error| self.refused(error))?;
        self.length = length;
        Ok(())
    }

    /// Writes `bytes` over those at `offset`; the file does not grow.
    pub fn replace(&mut self, offset: u64, bytes: &[u8]) -> Result<(), ExportError> {
        debug_assert!(offset + bytes.len() as u64 <= self.length, "replacing does not append");
        let file = self.file.as_file_mut();
        let result = file.seek(SeekFrom::Start(offset)).and_then(|_| file.write_all(bytes));
        result.map_err(|error| self.refused(error))
    }

    /// Gives the file the name `path`.
    pub fn persist(self, path: &Path) -> Result<(), ExportError> {
        let renamed: Result<File, _> = self.file.persist(path);
        renamed.map(drop).map_err(|e| ExportError::Io { path: path.to_owned(), source: e.error })
    }

    fn refused(&self, source: Error) -> ExportError {
        ExportError::Io { path: self.path.clone(), source }
    }
}
