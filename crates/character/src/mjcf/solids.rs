//! Volume and inertia of meshes that weigh something, as MuJoCo's compiler computes them.
//!
//! The surface is a fan of tetrahedra from one point. `legacy`, MuJoCo's default, counts all of them as solid, which overestimates
//! surfaces with dents; `exact` counts those that point outwards as holes.

use std::path::Path;

use crate::inertia;
use crate::mesh::{MeshFile, Triangles};
use crate::mjcf::attributes::Attributes;
use crate::mjcf::compiler::Compiler;
use crate::mjcf::defaults::Defaults;
use crate::mjcf::document::Element;
use crate::model::Inertial;
use crate::rotation::{Mat3, Vec3};

/// Meshes of a model.
pub(crate) struct Solids<'a> {
    pub root: &'a Element,
    pub compiler: &'a Compiler,
    pub defaults: &'a Defaults,
    pub folder: Option<&'a Path>,
}

impl Solids<'_> {
    /// Returns the inertia of a mesh of density 1 in its own frame; its mass is its volume (m³).
    ///
    /// # Errors
    /// A sentence: what keeps it from being known.
    pub fn of(&self, name: &str) -> Result<Inertial, String> {
        let assets = self.root.children_named("asset").flat_map(|section| section.children_named("mesh"));
        let asset = assets.into_iter().find(|mesh| name_of(mesh).as_deref() == Some(name));
        let asset = asset.ok_or_else(|| format!("no mesh '{name}' among the assets"))?;
        let a = self.defaults.resolve(asset, None).map_err(|e| e.to_string())?;
        if let Some(other) = ["refpos", "refquat", "builtin"].into_iter().find(|other| a.text(other).is_some()) {
            return Err(format!("mesh '{name}' with '{other}'"));
        }
        let are_holes = match a.text("inertia") {
            None | Some("legacy") => false,
            Some("exact") => true,
            Some(other) => return Err(format!("mesh '{name}' with inertia=\"{other}\"")),
        };
        let surface = self.surface(&a)?;
        let point = |i: u32| Vec3::from(surface.points[i as usize].map(f64::from));
        let faces: Vec<[Vec3; 3]> = surface.faces.iter().map(|face| face.map(point)).collect();
        solid(&faces, are_holes).ok_or_else(|| format!("mesh '{name}' without volume"))
    }

    fn surface(&self, a: &Attributes) -> Result<Triangles, String> {
        let scale = a.numbers::<3>("scale").map_err(|e| e.to_string())?.unwrap_or([1.0; 3]);
        if let Some(file) = a.text("file") {
            let path = self.compiler.mesh_path(self.folder, file).ok_or_else(|| format!("no file '{file}'"))?;
            return MeshFile { path, scale, collides: false }.triangles();
        }
        let numbers = |name: &str| -> Vec<f32> {
            a.text(name).unwrap_or_default().split_whitespace().map(|x| x.parse().unwrap_or(f32::NAN)).collect()
        };
        let (points, faces) = (numbers("vertex"), numbers("face"));
        let place = |p: &[f32]| [0, 1, 2].map(|k| p[k] * scale[k] as f32);
        let mut all = Triangles::default();
        all.append(
            points.chunks_exact(3).map(place).collect(),
            faces.chunks_exact(3).map(|f| [0, 1, 2].map(|k| f[k] as u32)).collect(),
        );
        let is_whole = points.iter().chain(&faces).all(|x| x.is_finite()) && !all.faces.is_empty();
        let name = a.text("name").unwrap_or_default();
        is_whole
            .then_some(all)
            .ok_or_else(|| format!("mesh '{name}': expected numbers in 'vertex' and in 'face', got none"))
    }
}

/// Returns the name of a mesh: its own, or that of its file.
fn name_of(mesh: &Element) -> Option<String> {
    let file = || Some(Path::new(mesh.attribute("file")?).file_stem()?.to_string_lossy().into_owned());
    mesh.attribute("name").map(str::to_string).or_else(file)
}

/// Sums up the tetrahedra from a point to all faces; `None` without volume.
fn solid(faces: &[[Vec3; 3]], are_holes: bool) -> Option<Inertial> {
    let middle = |face: &[Vec3; 3]| (face[0] + face[1] + face[2]) / 3.0;
    let area = |face: &[Vec3; 3]| 0.5 * (face[1] - face[0]).cross(&(face[2] - face[0])).norm();
    let volume = |face: &[Vec3; 3], apex: &Vec3| {
        let signed = (face[0] - apex).dot(&(face[1] - apex).cross(&(face[2] - apex))) / 6.0;
        if are_holes { signed } else { signed.abs() }
    };
    let surface: f64 = faces.iter().map(area).sum();
    let apex = faces.iter().map(|face| middle(face) * area(face)).sum::<Vec3>() / surface;
    let total: f64 = faces.iter().map(|face| volume(face, &apex)).sum();
    let com = faces.iter().map(|face| (middle(face) * 0.75 + apex * 0.25) * volume(face, &apex)).sum::<Vec3>() / total;
    // Not the same volume, where tetrahedra overlap.
    let mass: f64 = faces.iter().map(|face| volume(face, &com)).sum();
    let products: Mat3 = faces
        .iter()
        .map(|face| {
            let [a, b, c] = face.map(|p| p - com);
            let sum = a + b + c;
            let squares = a * a.transpose() + b * b.transpose() + c * c.transpose() + sum * sum.transpose();
            squares * (volume(face, &com) / 20.0)
        })
        .sum();
    let (orientation, diagonal) = inertia::principal(&(Mat3::identity() * products.trace() - products));
    let is_solid = mass > inertia::MIN_MASS && diagonal.min() > 0.0 && com.iter().all(|x| x.is_finite());
    is_solid.then_some(Inertial { mass, com, orientation, diagonal })
}
