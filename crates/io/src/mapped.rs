//! Files in memory without reading them.

use std::fs::File;
use std::ops::Deref;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use memmap2::Mmap;

use crate::Error;

/// A file mapped read-only; cheap to clone.
#[derive(Clone)]
pub(crate) struct MappedFile {
    path: Arc<PathBuf>,
    /// `None` for an empty file, which cannot be mapped.
    map: Option<Arc<Mmap>>,
}

impl MappedFile {
    /// Maps the regular file at `path`.
    pub fn open(path: &Path) -> Result<Self, Error> {
        let io = |e: std::io::Error| Error::io(path, &e);
        // Asked before opening: opening a pipe blocks until somebody writes to it.
        let kind = std::fs::metadata(path).map_err(io)?;
        if !kind.is_file() {
            let message = if kind.is_dir() { "this is a directory" } else { "this is not a regular file" };
            return Err(Error::Io {
                file: path.to_owned(),
                message: format!("{message}; give a particle file"),
            });
        }
        let file = File::open(path).map_err(io)?;
        let map = if file.metadata().map_err(io)?.len() == 0 {
            None
        } else {
            // SAFETY: the map is only ever read as bytes, for which every bit pattern is valid. A file that another process
            // shortens while it is mapped ends the process with SIGBUS; no library can prevent that without a signal handler.
            let map = unsafe { Mmap::map(&file) }.map_err(io)?;
            Some(Arc::new(map))
        };
        Ok(Self { path: Arc::new(path.to_owned()), map })
    }

    pub fn path(&self) -> &Path {
        &self.path
    }
}

impl Deref for MappedFile {
    type Target = [u8];

    fn deref(&self) -> &[u8] {
        self.map.as_deref().map_or(&[], |map| map)
    }
}
