//! Files as bytes: mapped without reading them, or read block by block as they are asked for.

use std::fs::{File, Metadata};
use std::io;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, SystemTime};

use meniscus_map_guard::Map;

use crate::{Error, IoMode};

/// A file; cheap to clone. Nobody holds all of it: bytes are asked for range by range.
#[derive(Clone)]
pub(crate) struct InputFile(Arc<Inner>);

struct Inner {
    path: PathBuf,
    access: Access,
    length: usize,
    /// What the file was when it was opened.
    stamp: Stamp,
}

enum Access {
    Map(Map),
    /// Also of an empty file, which cannot be mapped.
    Read(File),
    /// What was packed in it.
    Unpacked(Vec<u8>),
}

/// What changes when somebody writes to a file.
#[derive(Clone, Copy)]
struct Stamp {
    /// Which file it is, where the system tells.
    identity: u64,
    length: u64,
    modified: Option<SystemTime>,
    /// Whether a change could have the time stamp of the last one.
    is_hot: bool,
}

impl Stamp {
    fn of(metadata: &Metadata) -> Self {
        #[cfg(unix)]
        let identity = std::os::unix::fs::MetadataExt::ino(metadata);
        #[cfg(not(unix))]
        let identity = 0;
        Self {
            identity,
            length: metadata.len(),
            modified: metadata.modified().ok(),
            is_hot: rest_of_tick(metadata).is_some(),
        }
    }
}

/// Time stamps of files move in steps of the system's clock tick, at most this long.
const TICK: Duration = Duration::from_millis(20);

/// How long a change of the file would still get the time stamp it has, if it would.
fn rest_of_tick(metadata: &Metadata) -> Option<Duration> {
    let age = SystemTime::now().duration_since(metadata.modified().ok()?).ok()?;
    TICK.checked_sub(age)
}

/// A file modified less long ago may still be written to.
const AT_REST: Duration = Duration::from_secs(3);

impl InputFile {
    /// Opens the regular file at `path`.
    pub fn open(path: &Path, mode: IoMode) -> Result<Self, Error> {
        let io = |e: io::Error| Error::io(path, &e);
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
        let mut metadata = file.metadata().map_err(io)?;
        if let Some(rest) = rest_of_tick(&metadata) {
            std::thread::sleep(rest);
            metadata = file.metadata().map_err(io)?;
        }
        let stamp = Stamp::of(&metadata);
        let (access, length) = if metadata.len() > 0 && reason_to_read(path, &metadata, mode).is_none() {
            let map = Map::new(&file).map_err(io)?;
            let length = map.len();
            (Access::Map(map), length)
        } else {
            (Access::Read(file), usize::try_from(metadata.len()).map_err(|e| io(io::Error::other(e)))?)
        };
        Ok(Self(Arc::new(Inner { path: path.to_owned(), access, length, stamp })))
    }

    /// The file with other bytes: what was packed in it.
    pub fn with_content(&self, bytes: Vec<u8>) -> Self {
        let Inner { path, stamp, .. } = &*self.0;
        let length = bytes.len();
        Self(Arc::new(Inner { path: path.clone(), access: Access::Unpacked(bytes), length, stamp: *stamp }))
    }

    pub fn path(&self) -> &Path {
        &self.0.path
    }

    /// Bytes it had when it was opened.
    pub fn len(&self) -> usize {
        self.0.length
    }

    /// All bytes, of a file that is mapped or was unpacked.
    pub fn mapped(&self) -> Option<&[u8]> {
        match &self.0.access {
            Access::Map(map) => Some(map),
            Access::Unpacked(bytes) => Some(bytes),
            Access::Read(_) => None,
        }
    }

    /// The bytes `range`, from the map or read into `scratch`; `None` where it leaves the file.
    ///
    /// # Errors
    /// When reading fails or the file has become shorter.
    pub fn get<'a>(
        &'a self,
        range: Range<usize>,
        scratch: &'a mut Vec<u8>,
    ) -> Result<Option<&'a [u8]>, Error> {
        if range.start > range.end || range.end > self.len() {
            return Ok(None);
        }
        match &self.0.access {
            Access::Map(map) => Ok(map.get(range)),
            Access::Unpacked(bytes) => Ok(bytes.get(range)),
            Access::Read(_) => {
                self.copy(range, scratch)?;
                Ok(Some(scratch))
            }
        }
    }

    /// Makes `out` the bytes `range`, which must lie in the file, whatever becomes of the file afterwards.
    ///
    /// # Errors
    /// When reading fails or the file has become shorter.
    pub fn copy(&self, range: Range<usize>, out: &mut Vec<u8>) -> Result<(), Error> {
        match &self.0.access {
            Access::Map(map) => {
                out.clear();
                out.extend_from_slice(&map[range]);
                Ok(())
            }
            Access::Unpacked(bytes) => {
                out.clear();
                out.extend_from_slice(&bytes[range]);
                Ok(())
            }
            Access::Read(file) => {
                out.resize(range.len(), 0);
                read_exact_at(file, out, range.start as u64).map_err(|e| match e.kind() {
                    io::ErrorKind::UnexpectedEof => changed(self.path(), "was shortened"),
                    _ => Error::io(self.path(), &e),
                })
            }
        }
    }

    /// The first bytes, at most `count`.
    pub fn head(&self, count: usize) -> Result<Vec<u8>, Error> {
        let mut scratch = Vec::new();
        Ok(self.get(0..count.min(self.len()), &mut scratch)?.unwrap_or_default().to_vec())
    }

    /// An error when the bytes may not be those of one state of the file. A file that another one has taken the place of is
    /// still whole.
    pub fn check_unchanged(&self) -> Result<(), Error> {
        let Inner { path, access, stamp, .. } = &*self.0;
        if matches!(access, Access::Map(map) if map.is_broken()) {
            return Err(changed(path, "was shortened"));
        }
        let now = std::fs::metadata(path).ok().map(|metadata| Stamp::of(&metadata));
        match now.filter(|now| now.identity == stamp.identity) {
            Some(now) if now.length < stamp.length => Err(changed(path, "was shortened")),
            Some(now) if now.modified != stamp.modified || now.length != stamp.length || stamp.is_hot => {
                Err(changed(path, "was written to"))
            }
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

/// Fills `buffer` from byte `offset` of `file`, whose own position it leaves alone: several threads may read.
fn read_exact_at(file: &File, buffer: &mut [u8], offset: u64) -> io::Result<()> {
    #[cfg(unix)]
    use std::os::unix::fs::FileExt;
    #[cfg(windows)]
    use std::os::windows::fs::FileExt;

    #[cfg(unix)]
    return file.read_exact_at(buffer, offset);
    #[cfg(windows)]
    {
        let mut done = 0;
        while done < buffer.len() {
            match file.seek_read(&mut buffer[done..], offset + done as u64) {
                Ok(0) => return Err(io::ErrorKind::UnexpectedEof.into()),
                Ok(count) => done += count,
                Err(e) if e.kind() == io::ErrorKind::Interrupted => {}
                Err(e) => return Err(e),
            }
        }
        Ok(())
    }
}

/// A stretch of bytes: of a file, or made while reading it.
#[derive(Clone)]
pub(crate) struct Bytes {
    source: Source,
    range: Range<usize>,
}

#[derive(Clone)]
enum Source {
    File(InputFile),
    Memory(Arc<[u8]>),
}

impl std::fmt::Debug for Bytes {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "bytes {:?}", self.range)
    }
}

impl From<Vec<u8>> for Bytes {
    fn from(bytes: Vec<u8>) -> Self {
        Self { range: 0..bytes.len(), source: Source::Memory(bytes.into()) }
    }
}

impl Bytes {
    /// Bytes `range` of `file`, which must be there.
    pub fn of(file: &InputFile, range: Range<usize>) -> Self {
        Self { source: Source::File(file.clone()), range }
    }

    pub fn len(&self) -> usize {
        self.range.len()
    }

    /// Where it starts in its file.
    pub fn start(&self) -> usize {
        self.range.start
    }

    /// The bytes `range` of it, as [`InputFile::get`].
    pub fn get<'a>(
        &'a self,
        range: Range<usize>,
        scratch: &'a mut Vec<u8>,
    ) -> Result<Option<&'a [u8]>, Error> {
        if range.start > range.end || range.end > self.len() {
            return Ok(None);
        }
        let range = self.range.start + range.start..self.range.start + range.end;
        match &self.source {
            Source::File(file) => file.get(range, scratch),
            Source::Memory(bytes) => Ok(bytes.get(range)),
        }
    }

    /// The bytes from `range.start` on, at most up to `range.end`.
    pub fn get_up_to<'a>(&'a self, range: Range<usize>, scratch: &'a mut Vec<u8>) -> Result<&'a [u8], Error> {
        let end = range.end.min(self.len());
        Ok(self.get(range.start.min(end)..end, scratch)?.unwrap_or_default())
    }

    /// The part of it from `start` on, nothing where it is shorter.
    pub fn from(&self, start: usize) -> Self {
        let start = self.range.start.saturating_add(start).min(self.range.end);
        Self { source: self.source.clone(), range: start..self.range.end }
    }
}
