use std::path::{Path, PathBuf};

/// The folder of shared test data: `MENISCUS_DATA`, else `../shared/data` beside the workspace. Without it the caller says
/// nothing more and returns; this prints why.
#[expect(clippy::print_stderr, reason = "a skipped test must not look like a passed one")]
pub fn data_dir() -> Option<PathBuf> {
    let beside = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data");
    let folder = std::env::var_os("MENISCUS_DATA").map_or(beside, PathBuf::from);
    if folder.join("index.json").is_file() {
        // Tests run the program in other folders, where a relative path means something else.
        return folder.canonicalize().ok();
    }
    eprintln!("SKIPPED: no test data at {}; set MENISCUS_DATA", folder.display());
    None
}
