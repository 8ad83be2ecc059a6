//! Folders of the user that the program keeps files in, by the conventions of the system.

use std::path::PathBuf;

/// Returns the folder of files that can be made again: `$XDG_CACHE_HOME/lifelike`, or what the system has in its place.
pub fn cache() -> PathBuf {
    folder("XDG_CACHE_HOME", &[".cache"], &["Library", "Caches"])
}

/// Returns the folder of fetched files: `$XDG_DATA_HOME/lifelike`, or what the system has in its place.
pub fn data() -> PathBuf {
    lifelike_robot::load::data_folder()
}

fn folder(variable: &str, unix: &[&str], mac: &[&str]) -> PathBuf {
    let set = |name: &str| std::env::var_os(name).filter(|value| !value.is_empty()).map(PathBuf::from);
    let below_home = |parts: &[&str]| set("HOME").map(|home| parts.iter().fold(home, |path, part| path.join(part)));
    let found = set(variable).or_else(|| match std::env::consts::OS {
        "windows" => set("LOCALAPPDATA"),
        "macos" => below_home(mac),
        _ => below_home(unix),
    });
    found.unwrap_or_else(std::env::temp_dir).join("lifelike")
}
