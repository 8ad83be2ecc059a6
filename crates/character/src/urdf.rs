//! URDF in.

use std::path::Path;

use crate::error::CharacterError;
use crate::mjcf::document::Element;
use crate::model::Character;

/// Compiles the `<robot>` element.
pub(crate) fn compile(root: &Element, _folder: Option<&Path>) -> Result<Character, CharacterError> {
    Err(root.unsupported("root element"))
}
