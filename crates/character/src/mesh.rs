//! Mesh files: STL, OBJ and COLLADA.

use std::path::{Path, PathBuf};

use crate::rotation::Vec3;

/// The file of a mesh, and how large it is meant to be.
#[derive(Debug, Clone, PartialEq)]
pub struct MeshFile {
    /// The file.
    pub path: PathBuf,
    /// Factors on its three coordinates.
    pub scale: [f64; 3],
    /// Whether the text has it collide; else it is a picture.
    pub collides: bool,
}

impl MeshFile {
    /// Returns whether its name has one of these endings, in small or capital letters.
    pub(crate) fn is_one_of(&self, endings: &[&str]) -> bool {
        let ending = self.path.extension().and_then(|e| e.to_str()).unwrap_or_default();
        endings.iter().any(|other| ending.eq_ignore_ascii_case(other))
    }

    /// Returns the middle and the half lengths (m) of the box around it, along the axes of its own frame.
    ///
    /// # Errors
    /// A sentence: the file cannot be read, or has no points.
    pub(crate) fn bounds(&self) -> Result<(Vec3, Vec3), String> {
        let say = |problem: String| format!("mesh '{}': {problem}", self.path.display());
        if self.is_one_of(&["dae"]) {
            upright(&self.path).map_err(say)?;
        }
        let scene = mesh_loader::Loader::default().load(&self.path).map_err(|e| say(e.to_string()))?;
        let (mut low, mut high) = (Vec3::repeat(f64::INFINITY), Vec3::repeat(f64::NEG_INFINITY));
        for point in scene.meshes.iter().flat_map(|mesh| &mesh.vertices) {
            let point = Vec3::from(point.map(f64::from)).component_mul(&Vec3::from(self.scale));
            (low, high) = (low.inf(&point), high.sup(&point));
        }
        let (middle, half) = ((low + high) * 0.5, (high - low) * 0.5);
        if middle.iter().chain(&half).all(|x| x.is_finite()) {
            Ok((middle, half))
        } else {
            Err(say("no points".into()))
        }
    }
}

/// Refuses COLLADA whose up axis is not z, as it is without a word: some programs turn such a mesh and others do not, so nobody
/// knows how its robot was meant.
fn upright(path: &Path) -> Result<(), String> {
    let text = std::fs::read_to_string(path).map_err(|e| e.to_string())?;
    let document = roxmltree::Document::parse(&text).map_err(|e| e.to_string())?;
    let axis = document.descendants().find(|node| node.tag_name().name() == "up_axis").and_then(|node| node.text());
    match axis.map(str::trim) {
        Some("Z_UP") => Ok(()),
        other => Err(format!("expected COLLADA with <up_axis> Z_UP, got {}", other.unwrap_or("none (which is Y_UP)"))),
    }
}
