//! Files of a session: clips below the folder, files that were dropped, exports.

use std::path::Path;

use lifelike_motion::container;
use lifelike_motion::{formats, keyframes};
use lifelike_robot::clips;

use crate::scene::Scene;
use crate::stage::Stage;
use crate::{FromInput, StudioError};

/// Folder of dropped files, below that of the scene.
const DROPPED: &str = "dropped";
/// Most clips that are listed.
const MAX_LISTED: usize = 500;
/// Suffixes of motion that is listed.
const SUFFIXES: [&str; 5] = ["bvh", "npz", "csv", "safetensors", "pkl"];

/// A file to be saved by the browser.
pub struct Export {
    /// Its name.
    pub name: String,
    /// Its media type.
    pub kind: &'static str,
    /// Its content.
    pub bytes: Vec<u8>,
}

/// Lists clips: our own, then those of the folder and of the folders in it.
pub fn clips(folder: &Path) -> Vec<String> {
    let mut all: Vec<String> = keyframes::builtin().map(|(name, _)| format!("builtin:{name}")).collect();
    let mut found = Vec::new();
    let mut inner = vec![folder.to_path_buf()];
    let deep = std::fs::read_dir(folder).into_iter().flatten().flatten().filter(|entry| {
        let hidden = entry.file_name().to_string_lossy().starts_with('.');
        !hidden && entry.file_type().is_ok_and(|kind| kind.is_dir())
    });
    inner.extend(deep.map(|entry| entry.path()).take(MAX_LISTED));
    for path in inner.iter().flat_map(std::fs::read_dir).flatten().flatten().map(|entry| entry.path()) {
        let is_motion = path.extension().and_then(|e| e.to_str()).is_some_and(|e| SUFFIXES.contains(&e));
        let other =
            path.to_str().is_none_or(|text| text.ends_with(".safetensors") && !text.ends_with(container::EXTENSION));
        if is_motion && !other {
            found.extend(path.strip_prefix(folder).ok().map(|path| path.display().to_string()));
        }
    }
    found.sort();
    all.extend(found.into_iter().take(MAX_LISTED));
    all
}

/// Takes a dropped file in and reads it once. Returns its path below the folder, and what it was read as.
///
/// # Errors
/// A name that leads elsewhere; a file that holds no motion for the robot, which is then not kept.
pub fn take(stage: &Stage, name: &str, bytes: &[u8]) -> Result<(String, String), StudioError> {
    let plain = |c: char| c.is_alphanumeric() || "-_.+ ()".contains(c);
    if name.is_empty() || name.starts_with('.') || name.len() > 120 || !name.chars().all(plain) {
        return Err(StudioError::Operation(format!("expected a plain file name, got {name:?}")));
    }
    let folder = stage.folder.join(DROPPED);
    std::fs::create_dir_all(&folder).map_err(StudioError::io(&folder))?;
    // The folder may be a link to somewhere else.
    let folder = crate::workshop::inside(&stage.folder, Path::new(DROPPED))?;
    // Read outside of the folder first: what is no motion never has a name below it.
    let reading = tempfile::tempdir().map_err(StudioError::io(&folder))?;
    let unread = reading.path().join(name);
    std::fs::write(&unread, bytes).map_err(StudioError::io(&unread))?;
    let read = clips::load_one(&unread, stage.robot());
    let clip = read.map_err(|error| StudioError::Operation(without_folder(&error.to_string(), reading.path())))?;
    let seconds = clip.seconds();
    let format = formats::of_file(&unread).map_or("motion", |format| format.name);
    let told =
        format!("{name}: read as {format} ({}), {seconds:.1} s for {}", clip.provenance.source, stage.robot().name);
    let path = folder.join(name);
    lifelike_checkpoint::write_file(&path, bytes).map_err(StudioError::io(&path))?;
    Ok((format!("{DROPPED}/{name}"), told))
}

/// A message without the path of the folder that a file was read in.
fn without_folder(message: &str, folder: &Path) -> String {
    message.replace(&format!("{}{}", folder.display(), std::path::MAIN_SEPARATOR), "")
}

/// Makes an export: `page`, `clip` or `scene`.
///
/// # Errors
/// Another word; a scene that cannot be performed.
pub fn export(stage: &Stage, scene: &Scene, name: &str, what: &str) -> Result<Export, StudioError> {
    match what {
        "scene" => {
            let bytes = scene.to_toml()?.into_bytes();
            Ok(Export { name: format!("{name}{}", crate::scene::EXTENSION), kind: "application/toml", bytes })
        }
        "page" => {
            let bytes = stage.for_scene(scene)?.perform(scene)?.page(name).to_html().into_bytes();
            Ok(Export { name: format!("{name}.html"), kind: "text/html; charset=utf-8", bytes })
        }
        "clip" => {
            let bytes = container::to_bytes(&stage.for_scene(scene)?.perform(scene)?.clip(name))?;
            Ok(Export { name: format!("{name}{}", container::EXTENSION), kind: "application/octet-stream", bytes })
        }
        _ => Err(StudioError::Operation(format!("export: expected page, clip or scene, got '{what}'"))),
    }
}
