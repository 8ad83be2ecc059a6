//! Path of a mesh's file: `package://` URIs without the build system that they are of.

use std::path::{Path, PathBuf};

/// Returns the path of a mesh as MJCF names it. A `package://NAME/...` is looked for in the robot's folder and those
/// above it: in one called NAME, or in a NAME beside the others. A file that is not found keeps its path without the
/// scheme.
pub(super) fn path(uri: &str, folder: Option<&Path>) -> String {
    if let Some(rest) = uri.strip_prefix("package://") {
        let rest = rest.trim_start_matches('/');
        return folder.and_then(|folder| find(rest, folder)).unwrap_or_else(|| rest.to_string());
    }
    let path = uri.strip_prefix("file://").unwrap_or(uri);
    if Path::new(path).is_file() { path.to_string() } else { path.trim_start_matches('/').to_string() }
}

fn find(rest: &str, folder: &Path) -> Option<String> {
    let (package, inside) = rest.split_once('/')?;
    let folder = folder.canonicalize().ok()?;
    let places = folder.ancestors().flat_map(|at| {
        let is_it = at.file_name().is_some_and(|name| name == package);
        [is_it.then(|| at.join(inside)), Some(at.join(rest))].into_iter().flatten()
    });
    let found: PathBuf = places.into_iter().find(|path| path.is_file())?;
    found.to_str().map(str::to_string)
}
