use std::path::Path;

use tempfile::NamedTempFile;

/// A file in the folder of `path` that vanishes unless it is renamed, with the rights that any new file has there. Missing
/// folders are made. Refuses a `path` that is there and no file: renamed over, a pipe would lose its reader and `/dev/null` would
/// be gone.
pub(crate) fn beside(path: &Path) -> std::io::Result<NamedTempFile> {
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
