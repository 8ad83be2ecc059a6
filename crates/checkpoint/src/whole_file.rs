//! Files that are there whole or not at all.

use std::fs::{self, OpenOptions};
use std::io::{self, ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

/// Ending of files that are being written; one that is left after a crash can be removed.
pub const PARTIAL: &str = "partial";

/// Writes a file so that a reader, or a crash at any moment, sees the old content or the new, never a part.
///
/// The bytes are written beside the file, synced, and renamed over it; then the folder is synced.
///
/// # Errors
/// Something else than a regular file has the name (a symbolic link is not followed); the folder is missing; a full disk. No
/// partial file stays behind.
pub fn write_file(path: &Path, bytes: &[u8]) -> io::Result<()> {
    refuse_special(path)?;
    let partial = partial_of(path)?;
    let written = write_new(&partial, bytes).and_then(|()| fs::rename(&partial, path));
    if let Err(error) = written {
        // The first failure is the one worth reporting.
        let _ = fs::remove_file(&partial);
        return Err(error);
    }
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    // Not every system lets a folder be opened and synced; the rename itself has happened either way.
    let _ = fs::File::open(folder).and_then(|folder| folder.sync_all());
    Ok(())
}

/// Refuses a name that is taken by something else than a regular file.
fn refuse_special(path: &Path) -> io::Result<()> {
    let kind = match fs::symlink_metadata(path) {
        Ok(metadata) => metadata.file_type(),
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(()),
        Err(error) => return Err(error),
    };
    let got = match (kind.is_symlink(), kind.is_dir()) {
        _ if kind.is_file() => return Ok(()),
        (true, _) => "a symbolic link, which is not followed",
        (_, true) => "a folder",
        _ => "a pipe or device",
    };
    Err(io::Error::new(ErrorKind::InvalidInput, format!("expected a regular file or nothing, got {got}")))
}

/// Returns a hidden name beside a file, under which no other thread or process writes.
fn partial_of(path: &Path) -> io::Result<PathBuf> {
    static WRITTEN: AtomicU64 = AtomicU64::new(0);
    let name = path.file_name().ok_or(ErrorKind::InvalidInput)?.to_string_lossy();
    let (process, count) = (std::process::id(), WRITTEN.fetch_add(1, Ordering::Relaxed));
    Ok(path.with_file_name(format!(".{name}.{process}-{count}.{PARTIAL}")))
}

/// Writes a file that nobody else has opened: whatever has its name is removed, not followed.
fn write_new(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let _ = fs::remove_file(path);
    let mut file = OpenOptions::new().write(true).create_new(true).open(path)?;
    file.write_all(bytes)?;
    file.sync_all()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned()).collect()
    }

    #[test]
    fn the_new_content_replaces_the_old_and_leaves_nothing_behind() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.json");
        for text in ["one", "and another"] {
            write_file(&path, text.as_bytes()).unwrap();
            assert_eq!(fs::read_to_string(&path).unwrap(), text);
        }
        assert_eq!(names(folder.path()), ["a.json"]);
        assert!(write_file(&folder.path().join("none/a.json"), b"x").is_err(), "no folder");
        assert!(write_file(folder.path(), b"x").unwrap_err().to_string().contains("got a folder"));
    }

    #[test]
    fn threads_that_write_one_file_do_not_take_each_others_bytes() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.json");
        let texts: Vec<String> = (0..4).map(|i| i.to_string().repeat(10_000)).collect();
        std::thread::scope(|scope| {
            for text in &texts {
                scope.spawn(|| (0..20).for_each(|_| write_file(&path, text.as_bytes()).unwrap()));
            }
        });
        assert!(texts.contains(&fs::read_to_string(&path).unwrap()));
        assert_eq!(names(folder.path()), ["a.json"]);
    }

    #[cfg(unix)]
    #[test]
    fn links_are_not_followed() {
        let folder = tempfile::tempdir().unwrap();
        let (target, link) = (folder.path().join("precious"), folder.path().join("out.json"));
        fs::write(&target, "old").unwrap();
        std::os::unix::fs::symlink(&target, &link).unwrap();
        assert!(write_file(&link, b"new").unwrap_err().to_string().contains("symbolic link"));
        // Nor one that waits under the name of the partial file.
        let path = folder.path().join("b.json");
        std::os::unix::fs::symlink(&target, &path).unwrap();
        write_new(&path, b"new").unwrap();
        assert_eq!(fs::read_to_string(&target).unwrap(), "old");
        assert_eq!(fs::read_to_string(&path).unwrap(), "new");
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn devices_are_refused() {
        assert!(write_file(Path::new("/dev/null"), b"x").unwrap_err().to_string().contains("device"));
    }
}
