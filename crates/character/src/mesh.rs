//! Mesh files: STL, OBJ, COLLADA and glTF.

mod gltf_file;

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
    /// As [`Self::triangles`].
    pub(crate) fn bounds(&self) -> Result<(Vec3, Vec3), String> {
        let (mut low, mut high) = (Vec3::repeat(f64::INFINITY), Vec3::repeat(f64::NEG_INFINITY));
        for point in self.triangles()?.points {
            let point = Vec3::from(point.map(f64::from));
            (low, high) = (low.inf(&point), high.sup(&point));
        }
        Ok(((low + high) * 0.5, (high - low) * 0.5))
    }

    /// Reads its surface.
    ///
    /// # Errors
    /// A sentence: the file cannot be read, or has no finite points.
    pub fn triangles(&self) -> Result<Triangles, String> {
        let say = |problem: String| format!("mesh '{}': {problem}", self.path.display());
        let mut all = if self.is_one_of(&["glb", "gltf"]) {
            gltf_file::read(&self.path).map_err(say)?
        } else {
            if self.is_one_of(&["dae"]) {
                upright(&self.path).map_err(say)?;
            }
            // The reader panics on some files that are cut.
            let read = std::panic::catch_unwind(|| mesh_loader::Loader::default().load(&self.path));
            let read = read.map_err(|_| say("not well-formed".into()))?;
            let scene = read.map_err(|e| say(e.to_string()))?;
            let mut all = Triangles::default();
            scene.meshes.into_iter().for_each(|mesh| all.append(mesh.vertices, mesh.faces));
            all
        };
        let scale = self.scale.map(|factor| factor as f32);
        all.points.iter_mut().for_each(|p| (0..3).for_each(|k| p[k] *= scale[k]));
        if all.points.is_empty() || all.points.iter().flatten().any(|x| !x.is_finite()) {
            return Err(say("no points, or points that are not finite".into()));
        }
        Ok(all)
    }
}

/// A surface of triangles, in the frame of its mesh.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Triangles {
    /// Points (m).
    pub points: Vec<[f32; 3]>,
    /// Indices of three points each, counter-clockwise from outside.
    pub faces: Vec<[u32; 3]>,
}

impl Triangles {
    /// Adds a part with indices of its own; faces that name points it does not have are left out.
    pub(crate) fn append(&mut self, points: Vec<[f32; 3]>, faces: Vec<[u32; 3]>) {
        let (first, count) = (self.points.len() as u32, points.len() as u32);
        self.points.extend(points);
        let whole = faces.into_iter().filter(|face| face.iter().all(|i| *i < count));
        self.faces.extend(whole.map(|face| face.map(|i| i + first)));
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
