//! Mesh files: STL, OBJ, COLLADA and glTF.

mod gltf_file;

use std::io::Read;
use std::path::{Path, PathBuf};

use crate::mjcf::document::POINTER;
use crate::rotation::Vec3;

/// The file of a mesh, and how large it is meant to be.
#[derive(Debug, Clone, PartialEq)]
pub struct MeshFile {
    /// The file.
    pub path: PathBuf,
    /// Factors on its three coordinates.
    pub scale: [f64; 3],
    /// True if it collides in the text; else it is a picture.
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
        if is_pointer(&self.path) {
            return Err(say("a pointer of Git LFS in place of the file; fetch it with `git lfs pull`".into()));
        }
        let mut all = if self.is_one_of(&["glb", "gltf"]) {
            gltf_file::read(&self.path).map_err(say)?
        } else {
            if self.is_one_of(&["dae"]) {
                upright(&self.path).map_err(say)?;
            }
            if self.is_one_of(&["stl"]) {
                whole(&self.path).map_err(say)?;
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

/// Returns whether a file holds what Git LFS leaves in place of one.
fn is_pointer(path: &Path) -> bool {
    let mut start = [0; POINTER.len()];
    let read = std::fs::File::open(path).and_then(|mut file| file.read_exact(&mut start));
    read.is_ok() && start == *POINTER.as_bytes()
}

/// Most levels of elements in a COLLADA file.
const MOST_LEVELS: usize = 200;

/// Refuses a binary STL file that holds another number of triangles than it says: one that was cut, most often.
fn whole(path: &Path) -> Result<(), String> {
    let bytes = std::fs::read(path).map_err(|e| e.to_string())?;
    // 80 bytes of text and a count come before triangles of 50 bytes. A text that begins with "solid" may be either kind.
    let (Some(count), false) = (bytes.get(80..84), bytes.starts_with(b"solid")) else { return Ok(()) };
    let count = u64::from(u32::from_le_bytes(count.try_into().unwrap_or_default()));
    let (expected, got) = (84 + 50 * count, bytes.len() as u64);
    if expected == got {
        return Ok(());
    }
    Err(format!("expected the {count} triangles that it says, in {expected} bytes, got {got} bytes"))
}

/// Refuses COLLADA whose up axis is not z, as it is without a word: some programs turn such a mesh and others do not, so nobody
/// knows how its robot was meant.
fn upright(path: &Path) -> Result<(), String> {
    let text = std::fs::read_to_string(path).map_err(|e| e.to_string())?;
    let document = roxmltree::Document::parse(&text).map_err(|e| e.to_string())?;
    // Its reader goes down by recursion.
    if document.descendants().any(|node| node.ancestors().nth(MOST_LEVELS).is_some()) {
        return Err(format!("expected at most {MOST_LEVELS} levels of elements, got more"));
    }
    let axis = document.descendants().find(|node| node.tag_name().name() == "up_axis").and_then(|node| node.text());
    match axis.map(str::trim) {
        Some("Z_UP") => Ok(()),
        other => Err(format!("expected COLLADA with <up_axis> Z_UP, got {}", other.unwrap_or("none (which is Y_UP)"))),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn read(name: &str, bytes: &[u8]) -> Result<Triangles, String> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        MeshFile { path, scale: [1.0; 3], collides: true }.triangles()
    }

    #[test]
    fn an_stl_that_was_cut_is_refused_wherever() {
        let triangle = |z: f32| {
            let mut bytes: Vec<u8> = [0.0_f32, 0.0, 1.0, 0.0, 0.0, z, 1.0, 0.0, z, 0.0, 1.0, z]
                .iter()
                .flat_map(|x| x.to_le_bytes())
                .collect();
            bytes.extend([0, 0]);
            bytes
        };
        let file = [vec![b' '; 80], 2_u32.to_le_bytes().to_vec(), triangle(0.0), triangle(1.0)].concat();
        assert_eq!(read("a.stl", &file).unwrap().faces.len(), 2);
        for length in [84, 133, 134, 183] {
            let error = read("a.stl", &file[..length]).unwrap_err();
            assert!(error.contains("2 triangles") && error.contains(&format!("got {length} bytes")), "{error}");
        }
    }

    #[test]
    fn a_pointer_of_git_lfs_is_called_so() {
        let pointer = format!("{POINTER}.github.com/spec/v1\noid sha256:4d7a\nsize 12345\n");
        for name in ["a.stl", "a.obj", "a.dae", "a.glb"] {
            assert!(read(name, pointer.as_bytes()).unwrap_err().contains("git lfs pull"), "{name}");
        }
    }

    #[test]
    fn collada_of_many_levels_is_refused() {
        let nested = |levels: usize| {
            let (open, close) = ("<node>".repeat(levels), "</node>".repeat(levels));
            format!("<COLLADA><asset><up_axis>Z_UP</up_axis></asset>{open}{close}</COLLADA>")
        };
        let error = read("a.dae", nested(16_000).as_bytes()).unwrap_err();
        assert!(error.contains("at most 200 levels"), "{error}");
        assert!(!read("a.dae", nested(100).as_bytes()).unwrap_err().contains("levels"));
    }

    #[test]
    fn points_that_are_no_numbers_are_refused() {
        let obj = |x: &str| format!("v {x} 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
        assert_eq!(read("a.obj", obj("0").as_bytes()).unwrap().points.len(), 3);
        for x in ["-nan", "inf", "nan"] {
            assert!(read("a.obj", obj(x).as_bytes()).unwrap_err().contains("not finite"), "{x}");
        }
    }
}
