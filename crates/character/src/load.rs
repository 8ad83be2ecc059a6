//! A character from a file, whichever of the two languages it is written in.

use std::path::Path;

use crate::error::CharacterError;
use crate::mjcf::{document, xml_text};
use crate::model::Character;
use crate::{mjcf, urdf};

impl Character {
    /// Reads a character from a file: MJCF (root element `mujoco`) or URDF (`robot`).
    ///
    /// # Errors
    /// [`CharacterError`] with file, line and element.
    pub fn load(path: impl AsRef<Path>) -> Result<Self, CharacterError> {
        let path = path.as_ref();
        let text = xml_text::read(path)?;
        let folder = path.parent().map(|p| if p.as_os_str().is_empty() { Path::new(".") } else { p });
        let document = document::parse(&text, path, folder)?;
        let root = &document.root;
        match root.name.as_str() {
            "mujoco" => mjcf::compile_document(document, folder),
            "robot" => urdf::compile(root, folder),
            _ => Err(root.invalid("root element 'mujoco' (MJCF) or 'robot' (URDF)", format!("'{}'", root.name))),
        }
    }
}
