use std::io::Write;
use std::path::Path;

use crate::ExportError;

/// Writes a text file, whole or not at all. Missing folders are made.
///
/// # Errors
/// [`ExportError::Io`]; an older file stays as it was.
pub fn write_text(path: &Path, text: &str) -> Result<(), ExportError> {
    let io = |source| ExportError::Io { path: path.to_owned(), source };
    let mut beside = beside(path).map_err(io)?;
    beside.write_all(text.as_bytes()).map_err(io)?;
    beside.persist(path).map_err(|e| io(e.error))?;
    Ok(())
}

/// A file in the folder of `path` that vanishes unless it is renamed, with the rights that any new file has there. Refuses a
/// `path` that is there and no file: renamed over, a pipe would lose its reader and `/dev/null` would be gone.
pub(crate) fn beside(path: &Path) -> std::io::Result<tempfile::NamedTempFile> {
    if path.metadata().is_ok_and(|there| !there.is_file()) {
        return Err(std::io::Error::other("it is there already and no regular file; choose another name"));
    }
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    std::fs::create_dir_all(folder)?;
    let mut builder = tempfile::Builder::new();
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        // The user's mask takes away what it takes away.
        builder.permissions(std::fs::Permissions::from_mode(0o666));
    }
    builder.prefix(".meniscus-").suffix(".part").tempfile_in(folder)
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    /// A socket stands for all that is no file: pipes, devices, folders.
    #[test]
    fn only_files_are_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("report.json");
        let _socket = std::os::unix::net::UnixListener::bind(&path).unwrap();
        let error = write_text(&path, "{}").unwrap_err().to_string();
        assert!(error.contains("report.json") && error.contains("no regular file"), "{error}");
        assert!(!path.metadata().unwrap().is_file());
        std::fs::remove_file(&path).unwrap();
        write_text(&path, "{}").unwrap();
        write_text(&path, "[]").unwrap();
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "[]");
    }
}
