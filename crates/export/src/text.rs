use std::io::Write;
use std::path::Path;

use crate::ExportError;
use crate::beside::beside;

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
