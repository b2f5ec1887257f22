//! Files in memory: mapped without reading them, or read block by block.

use std::fs::{File, Metadata};
use std::ops::Deref;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, SystemTime};

use meniscus_map_guard::Map;

use crate::{Error, IoMode};

/// A file's bytes; cheap to clone.
#[derive(Clone)]
pub(crate) struct MappedFile {
    path: Arc<PathBuf>,
    bytes: Arc<Bytes>,
    /// What the file was when it was opened.
    stamp: Stamp,
}

enum Bytes {
    Map(Map),
    /// Also of an empty file, which cannot be mapped.
    Read(Vec<u8>),
}

/// What changes when somebody writes to a file.
#[derive(Clone, Copy, PartialEq)]
struct Stamp {
    /// Which file it is, where the system tells.
    identity: u64,
    length: u64,
    modified: Option<SystemTime>,
}

impl Stamp {
    fn of(metadata: &Metadata) -> Self {
        #[cfg(unix)]
        let identity = std::os::unix::fs::MetadataExt::ino(metadata);
        #[cfg(not(unix))]
        let identity = 0;
        Self { identity, length: metadata.len(), modified: metadata.modified().ok() }
    }
}

/// Bytes read at a time.
const BLOCK: usize = 4 << 20;

/// A file modified less long ago may still be written to.
const AT_REST: Duration = Duration::from_secs(3);

impl MappedFile {
    /// Opens the regular file at `path`.
    pub fn open(path: &Path, mode: IoMode) -> Result<Self, Error> {
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
        let metadata = file.metadata().map_err(io)?;
        let bytes = if metadata.len() == 0 {
            Bytes::Read(Vec::new())
        } else if reason_to_read(path, &metadata, mode).is_none() {
            Bytes::Map(Map::new(&file).map_err(io)?)
        } else {
            Bytes::Read(read_blocks(&file, metadata.len()).map_err(|e| match e.kind() {
                std::io::ErrorKind::UnexpectedEof => changed(path, "was shortened"),
                _ => io(e),
            })?)
        };
        Ok(Self { path: Arc::new(path.to_owned()), bytes: Arc::new(bytes), stamp: Stamp::of(&metadata) })
    }

    pub fn path(&self) -> &Path {
        &self.path
    }

    /// An error when the bytes may not be those of one state of the file. A file that another one has taken the place of is
    /// still whole.
    pub fn check_unchanged(&self) -> Result<(), Error> {
        if matches!(&*self.bytes, Bytes::Map(map) if map.is_broken()) {
            return Err(changed(&self.path, "was shortened"));
        }
        let now = std::fs::metadata(&*self.path).ok().map(|metadata| Stamp::of(&metadata));
        match now.filter(|now| now.identity == self.stamp.identity) {
            Some(now) if now.length < self.stamp.length => Err(changed(&self.path, "was shortened")),
            Some(now) if now != self.stamp => Err(changed(&self.path, "was written to")),
            _ => Ok(()),
        }
    }
}

fn changed(path: &Path, what: &str) -> Error {
    Error::Changed { file: path.to_owned(), what: what.to_owned() }
}

/// Why the file at `path` is read in blocks; `None` when it is mapped.
pub(crate) fn reason_to_read(path: &Path, metadata: &Metadata, mode: IoMode) -> Option<&'static str> {
    match mode {
        IoMode::Map => None,
        IoMode::Read => Some("as asked"),
        IoMode::Auto => {
            let age = metadata.modified().ok().and_then(|at| SystemTime::now().duration_since(at).ok());
            if age.is_none_or(|age| age < AT_REST) {
                Some("modified in the last seconds: it may still be written to")
            } else {
                is_remote(path).then_some("on a network file system")
            }
        }
    }
}

/// Whether `path` lies on a file system whose pages come over a network, or through another process that may fail to give them
/// (numbers from Linux' `magic.h` and the file systems' own headers).
#[cfg(target_os = "linux")]
fn is_remote(path: &Path) -> bool {
    const REMOTE: [u32; 13] = [
        0x6969,      // NFS
        0x517b,      // SMB
        0xff53_4d42, // CIFS
        0xfe53_4d42, // SMB2
        0x0102_1997, // 9P
        0x6573_5546, // FUSE: sshfs and others
        0x00c3_6400, // Ceph
        0x0bd0_0bd0, // Lustre
        0x4750_4653, // GPFS
        0x1983_0326, // BeeGFS
        0x5346_414f, // AFS
        0x6b41_4653, // kAFS
        0x7375_7245, // Coda
    ];
    rustix::fs::statfs(path).is_ok_and(|system| REMOTE.contains(&(system.f_type as u32)))
}

#[cfg(not(target_os = "linux"))]
fn is_remote(_path: &Path) -> bool {
    false
}

#[cfg(unix)]
fn read_blocks(file: &File, length: u64) -> std::io::Result<Vec<u8>> {
    use std::os::unix::fs::FileExt;

    use rayon::prelude::*;

    let length = usize::try_from(length).map_err(std::io::Error::other)?;
    let mut bytes = vec![0; length];
    bytes
        .par_chunks_mut(BLOCK)
        .enumerate()
        .try_for_each(|(i, block)| file.read_exact_at(block, (i * BLOCK) as u64))?;
    Ok(bytes)
}

#[cfg(not(unix))]
fn read_blocks(mut file: &File, length: u64) -> std::io::Result<Vec<u8>> {
    use std::io::Read;

    let length = usize::try_from(length).map_err(std::io::Error::other)?;
    let mut bytes = vec![0; length];
    bytes.chunks_mut(BLOCK).try_for_each(|block| file.read_exact(block))?;
    Ok(bytes)
}

impl Deref for MappedFile {
    type Target = [u8];

    fn deref(&self) -> &[u8] {
        match &*self.bytes {
            Bytes::Map(map) => map,
            Bytes::Read(bytes) => bytes,
        }
    }
}
