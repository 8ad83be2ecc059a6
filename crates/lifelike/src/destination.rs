//! Destinations of `-o`: checked while arguments are parsed, before any work is done.

use std::path::{Path, PathBuf};

use lifelike_motion::container::EXTENSION as MOTION;

use crate::error::CliError;

/// Suffixes of files that people ask for where a command writes a folder.
const FILE_SUFFIXES: [&str; 19] = [
    "avi",
    "bin",
    "bvh",
    "csv",
    "fbx",
    "gif",
    "glb",
    "gltf",
    "html",
    "json",
    "mov",
    "mp4",
    "npz",
    "pkl",
    "png",
    "safetensors",
    "toml",
    "txt",
    "webm",
];

/// Parses a folder that results are written into.
///
/// # Errors
/// A file is there, or the name is that of a file.
pub fn folder(text: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    if text == "-" {
        return Err("expected a folder, got '-': results are files, which are not printed".into());
    }
    if path.is_dir() {
        return Ok(path);
    }
    if path.exists() {
        return Err("expected a folder, got a file".into());
    }
    match suffix(&path) {
        Some(suffix) => Err(format!("expected a folder, got the name of a .{suffix} file: this writes several files")),
        None => Ok(path),
    }
}

/// Parses a motion's file (`NAME.motion.safetensors`), or a folder for it.
///
/// # Errors
/// The name is that of another kind of file.
pub fn motion(text: &str) -> Result<PathBuf, String> {
    if is_motion(Path::new(text)) {
        return Ok(text.into());
    }
    folder(text).map_err(|error| match suffix(Path::new(text)) {
        Some(suffix) => format!(
            "expected NAME{MOTION} or a folder, got a .{suffix} file: motion is written in our own format; `lifelike motion \
             convert` makes tables of it, and pages have buttons for pictures and films"
        ),
        None => error,
    })
}

/// Parses the file of a controller or another network.
///
/// # Errors
/// The name has another suffix.
pub fn network(text: &str) -> Result<PathBuf, String> {
    with_suffix(text, ".safetensors")
}

/// Parses a TOML file.
///
/// # Errors
/// The name has another suffix.
pub fn toml(text: &str) -> Result<PathBuf, String> {
    with_suffix(text, ".toml")
}

/// Parses a JSON file.
///
/// # Errors
/// The name has another suffix.
pub fn json(text: &str) -> Result<PathBuf, String> {
    with_suffix(text, ".json")
}

/// Returns whether a path is that of a motion's file rather than of a folder.
pub fn is_motion(path: &Path) -> bool {
    path.to_str().is_some_and(|text| text.ends_with(MOTION)) && !path.is_dir()
}

/// Returns the file of something that has a name of its own, such as a clip or a trace, in a folder.
///
/// Names may come from files of others, so they must be plain: nothing in them leads to another folder.
///
/// # Errors
/// [`CliError::Input`] for a name that is empty, hidden, or holds a separator or a control character.
pub fn named(folder: &Path, name: &str, extension: &str) -> Result<PathBuf, CliError> {
    let is_plain = |c: char| !"/\\:".contains(c) && !c.is_control();
    if name.is_empty() || name.starts_with('.') || !name.chars().all(is_plain) {
        return Err(CliError::Input(format!("expected a name that a file can have, got {name:?}")));
    }
    // What a shell would need quotes for.
    let safe: String = name.chars().map(|c| if c.is_alphanumeric() || "-_.+".contains(c) { c } else { '_' }).collect();
    Ok(folder.join(safe + extension))
}

/// Checks that a file's folder is there, which is found now rather than after the work.
///
/// # Errors
/// There is no such folder.
pub fn has_folder(file: &Path) -> Result<(), String> {
    match file.parent().filter(|folder| !folder.as_os_str().is_empty() && !folder.is_dir()) {
        Some(folder) => Err(format!("expected a folder '{}' for the file, got none", folder.display())),
        None => Ok(()),
    }
}

fn with_suffix(text: &str, expected: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    if path.is_dir() {
        return Err(format!("expected a file NAME{expected}, got a folder"));
    }
    has_folder(&path)?;
    if text.ends_with(expected) { Ok(path) } else { Err(format!("expected a file NAME{expected}, got '{text}'")) }
}

fn suffix(path: &Path) -> Option<String> {
    let suffix = path.extension()?.to_str()?.to_ascii_lowercase();
    FILE_SUFFIXES.contains(&suffix.as_str()).then_some(suffix)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_files_are_no_folders() {
        for name in ["out", "runs/walk-1.5", "a.b/c", "."] {
            assert_eq!(folder(name), Ok(name.into()));
        }
        assert_eq!(folder("Cargo.toml"), Err("expected a folder, got a file".into()));
        assert!(folder("-").is_err_and(|error| error.contains("not printed")) && motion("-").is_err());
        assert!(folder("wave.MP4").is_err_and(|error| error.contains(".mp4")));
    }

    #[test]
    fn motion_goes_into_its_own_kind_of_file() {
        for name in ["wave.motion.safetensors", "out", "runs/x"] {
            assert_eq!(motion(name), Ok(name.into()));
        }
        for name in ["wave.mp4", "wave.safetensors", "wave.csv"] {
            assert!(motion(name).is_err_and(|error| error.contains("NAME.motion.safetensors")), "{name}");
        }
        assert!(is_motion(Path::new("a.motion.safetensors")) && !is_motion(Path::new("a")));
    }

    #[test]
    fn a_name_cannot_choose_its_folder() {
        let at = |name| named(Path::new("out"), name, ".motion.safetensors").map_err(|e| e.to_string());
        assert_eq!(at("07_01"), Ok("out/07_01.motion.safetensors".into()));
        assert_eq!(at("it's a wave"), Ok("out/it_s_a_wave.motion.safetensors".into()));
        for bad in ["", "..", "../../etc/x", "a/b", "a\\b", "C:x", ".hidden", "a\0b", "a\nb"] {
            assert!(at(bad).is_err_and(|error| error.contains("got")), "{bad:?}");
        }
    }

    #[test]
    fn other_files_keep_their_suffix() {
        assert_eq!(toml("servo.toml"), Ok("servo.toml".into()));
        assert!(toml("servo.json").is_err() && toml("src").is_err());
        assert!(toml("no/such/servo.toml").is_err_and(|error| error.contains("'no/such'")));
        assert!(network("a.controller.safetensors").is_ok() && network("a.onnx").is_err());
    }
}
