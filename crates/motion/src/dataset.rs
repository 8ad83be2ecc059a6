//! Files of clips, found by file, folder or pattern in an order that does not depend on the file system.

use std::path::{Path, PathBuf};

use lifelike_checkpoint::InputError;

use crate::formats::{self, Format};
use crate::{FromInput, MotionError};

/// Finds files by name, folder, glob pattern (`motions/**/*.bvh`) or `@list.txt`, sorted and without repetition. A
/// list is a file with one of those per line; empty lines and comments after `#` do not count.
///
/// A file that is named is taken as it is; of folders (searched to the bottom) and patterns only what `accepts` is.
///
/// # Errors
/// [`MotionError::Input`] for a missing input, a folder that cannot be read, a bad pattern, or a folder or pattern in
/// which nothing is accepted.
pub fn find_files(inputs: &[PathBuf], accepts: impl Fn(&Path) -> bool) -> Result<Vec<PathBuf>, MotionError> {
    find(inputs, "a file of use", &accepts)
}

/// Finds files of motion as [`find_files`] does: of folders and patterns those whose format is known and accepted.
///
/// # Errors
/// As [`find_files`].
pub fn find_motion(inputs: &[PathBuf], accepts: impl Fn(&Format) -> bool) -> Result<Vec<PathBuf>, MotionError> {
    let sought = format!("motion as {}", formats::supported(&accepts));
    find(inputs, &sought, &|path| formats::of_found(path).is_some_and(&accepts))
}

fn find(inputs: &[PathBuf], sought: &str, accepts: &impl Fn(&Path) -> bool) -> Result<Vec<PathBuf>, MotionError> {
    let mut found = Vec::new();
    for input in &with_lists(inputs)? {
        let before = found.len();
        if input.is_file() {
            found.push(input.clone());
        } else if input.is_dir() {
            walk(input, accepts, &mut found)?;
        } else if is_pattern(input) {
            let text = input.to_string_lossy();
            let matches = glob::glob(&text).map_err(|e| fail(input, format!("bad pattern: {e}")))?;
            for path in matches {
                let path = path.map_err(|e| InputError::Io { path: e.path().into(), source: e.into() })?;
                if path.is_file() && accepts(&path) {
                    found.push(path);
                }
            }
        } else {
            return Err(fail(input, "no such file, folder or pattern".into()));
        }
        if found.len() == before {
            return Err(fail(input, format!("expected {sought}, got nothing of the kind")));
        }
    }
    found.sort();
    found.dedup();
    Ok(found)
}

/// Replaces `@file` by the lines of the file that are neither empty nor comments.
///
/// # Errors
/// [`MotionError::Input`] for a list that cannot be read.
pub fn with_lists(inputs: &[PathBuf]) -> Result<Vec<PathBuf>, MotionError> {
    let mut all = Vec::with_capacity(inputs.len());
    for input in inputs {
        let Some(file) = input.to_str().and_then(|text| text.strip_prefix('@')).filter(|_| !input.exists()) else {
            all.push(input.clone());
            continue;
        };
        let text = std::fs::read_to_string(file).map_err(MotionError::io(Path::new(file)))?;
        all.extend(text.lines().map(str::trim).filter(|l| !l.is_empty() && !l.starts_with('#')).map(PathBuf::from));
    }
    Ok(all)
}

fn walk(folder: &Path, accepts: &impl Fn(&Path) -> bool, found: &mut Vec<PathBuf>) -> Result<(), MotionError> {
    let io = MotionError::io(folder);
    for entry in std::fs::read_dir(folder).map_err(io)? {
        let entry = entry.map_err(io)?;
        let path = entry.path();
        // Links to folders are not followed, so there are no circles.
        if entry.file_type().map_err(io)?.is_dir() {
            walk(&path, accepts, found)?;
        } else if path.is_file() && accepts(&path) {
            found.push(path);
        }
    }
    Ok(())
}

fn is_pattern(path: &Path) -> bool {
    path.to_string_lossy().contains(['*', '?', '['])
}

fn fail(path: &Path, message: String) -> MotionError {
    MotionError::io(path)(std::io::Error::new(std::io::ErrorKind::NotFound, message))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::container;

    #[test]
    fn files_come_sorted_by_path_however_they_are_named() {
        let root = tempfile::tempdir().unwrap();
        let at = |file: &str| root.path().join(file);
        std::fs::create_dir(at("z")).unwrap();
        let [a, b, c] = ["z/a.motion.safetensors", "b.motion.safetensors", "c.motion.safetensors"].map(at);
        for file in [&a, &b, &c, &at("readme.txt")] {
            std::fs::write(file, "").unwrap();
        }
        let found = |inputs: &[PathBuf]| find_files(inputs, |path| container::FORMAT.is_named(path)).unwrap();
        assert_eq!(found(&[root.path().into()]), [b.clone(), c.clone(), a.clone()]);
        assert_eq!(found(&[at("*")]), [b.clone(), c.clone()], "a star stays in its folder, and takes only motion");
        assert_eq!(found(&[at("**/*.safetensors")]), [b.clone(), c, a]);
        assert_eq!(found(&[b, root.path().into()]).len(), 3, "named twice is found once");
    }

    #[test]
    fn a_list_stands_for_its_lines() {
        let folder = tempfile::tempdir().unwrap();
        let list = folder.path().join("list.txt");
        std::fs::write(&list, "# two\na.bvh\n\n  b/*.bvh\n").unwrap();
        let inputs = ["x".into(), PathBuf::from(format!("@{}", list.display()))];
        assert_eq!(with_lists(&inputs).unwrap(), ["x", "a.bvh", "b/*.bvh"].map(PathBuf::from));
        assert!(with_lists(&["@none".into()]).unwrap_err().to_string().contains("none"));
    }

    #[test]
    fn nothing_found_is_an_error_that_names_the_input() {
        let root = tempfile::tempdir().unwrap();
        for bad in [root.path().to_path_buf(), root.path().join("none"), root.path().join("*.bvh"), "a[".into()] {
            let message = find_files(std::slice::from_ref(&bad), |_| true).unwrap_err().to_string();
            assert!(message.contains(&*bad.to_string_lossy()), "{message}");
        }
    }
}
