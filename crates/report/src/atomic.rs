//! Files that are there whole or not at all.

use std::fs::{self, File};
use std::io::Write;
use std::path::{Path, PathBuf};

use crate::ReportError;

/// Ending of files that are being written; whatever carries it after a crash is rubbish.
pub(crate) const PARTIAL: &str = "partial";

/// Writes a file so that a reader, or a crash at any moment, sees the old content or the new, never a part: written
/// beside it, synced, renamed over it, and the folder synced.
///
/// # Errors
/// [`ReportError::Io`] with the file that failed.
pub fn write_atomically(path: &Path, bytes: &[u8]) -> Result<(), ReportError> {
    let mut name = path.file_name().unwrap_or_default().to_os_string();
    name.push(".");
    name.push(PARTIAL);
    let partial: PathBuf = path.with_file_name(name);
    let mut file = File::create(&partial).map_err(ReportError::io(&partial))?;
    file.write_all(bytes).and_then(|()| file.sync_all()).map_err(ReportError::io(&partial))?;
    drop(file);
    fs::rename(&partial, path).map_err(ReportError::io(path))?;
    if let Some(folder) = path.parent().filter(|f| !f.as_os_str().is_empty()) {
        // Not every file system lets a folder be opened and synced; the rename itself has happened either way.
        if let Ok(handle) = File::open(folder) {
            let _ = handle.sync_all();
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn the_new_content_replaces_the_old_and_leaves_nothing_behind() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.txt");
        write_atomically(&path, b"one").unwrap();
        write_atomically(&path, b"two").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"two");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn an_error_names_the_file() {
        let folder = tempfile::tempdir().unwrap();
        let error = write_atomically(&folder.path().join("no/such/a.txt"), b"x").unwrap_err();
        assert!(error.to_string().contains("a.txt"), "{error}");
    }
}
