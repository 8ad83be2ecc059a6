//! Volume and inertia of meshes that weigh something, as MuJoCo's compiler computes them.
//!
//! The surface is a fan of tetrahedra from one point. `legacy`, MuJoCo's default, counts all of them as solid, which overestimates
//! surfaces with dents; `exact` counts those that point outwards as holes. `shell` is the surface alone. Points without faces are
//! those of their convex hull.

use std::f64::consts::PI;
use std::path::Path;

use crate::error::CharacterError;
use crate::inertia;
use crate::mesh::{MeshFile, Triangles};
use crate::mjcf::attributes::Attributes;
use crate::mjcf::compiler::Compiler;
use crate::mjcf::defaults::Defaults;
use crate::mjcf::document::Element;
use crate::model::Inertial;
use crate::outline::outline;
use crate::rotation::{Mat3, Quat, Vec3, from_wxyz};

/// Most points of a mesh whose hull is computed.
const MOST_POINTS: usize = 128;
/// Least height above a plane, as a share of a mesh's size: files have 32-bit numbers.
const FLAT: f64 = 1e-6;

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
        if a.text("builtin").is_some() {
            return Err(format!("mesh '{name}' with 'builtin'"));
        }
        let surface = self.surface(&a)?;
        let moved = moved(&a).map_err(|e| e.to_string())?;
        let points: Vec<Vec3> = surface.points.iter().map(|point| moved(Vec3::from(point.map(f64::from)))).collect();
        let mut faces: Vec<[Vec3; 3]> = surface.faces.iter().map(|face| face.map(|i| points[i as usize])).collect();
        let kind = a.text("inertia").unwrap_or("legacy");
        if faces.is_empty() || kind == "convex" {
            if points.len() > MOST_POINTS {
                let got = format!("mesh '{name}' of {} points, whose convex hull is needed", points.len());
                return Err(format!("{got}; at most {MOST_POINTS} are read"));
            }
            faces = hull(&points);
        }
        let sum = match kind {
            "legacy" | "convex" => solid(&faces, false),
            "exact" => solid(&faces, true),
            "shell" => shell(&faces),
            other => return Err(format!("mesh '{name}' with inertia=\"{other}\"")),
        };
        sum.ok_or_else(|| format!("mesh '{name}' without volume"))
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
        let is_whole = points.iter().chain(&faces).all(|x| x.is_finite()) && all.points.len() > 3;
        let name = a.text("name").unwrap_or_default();
        is_whole.then_some(all).ok_or_else(|| format!("mesh '{name}' without a 'file' and without numbers in 'vertex'"))
    }
}

/// Returns the name of a mesh: its own, or that of its file.
fn name_of(mesh: &Element) -> Option<String> {
    let file = || Some(Path::new(mesh.attribute("file")?).file_stem()?.to_string_lossy().into_owned());
    mesh.attribute("name").map(str::to_string).or_else(file)
}

/// Returns the map of a file's points into the frame of the mesh, which `refpos` and `refquat` place in the file's.
fn moved(a: &Attributes) -> Result<impl Fn(Vec3) -> Vec3, CharacterError> {
    let scale: Vec3 = a.numbers::<3>("scale")?.unwrap_or([1.0; 3]).into();
    let place: Vec3 = a.numbers::<3>("refpos")?.unwrap_or_default().into();
    let turn = a.numbers::<4>("refquat")?.and_then(from_wxyz).unwrap_or_else(Quat::identity);
    // The scale comes last, and was applied already.
    Ok(move |point: Vec3| (turn.inverse() * (point.component_div(&scale) - place)).component_mul(&scale))
}

/// Returns triangles of the convex hull: the outlines of the points in all planes that have the others below them.
fn hull(points: &[Vec3]) -> Vec<[Vec3; 3]> {
    let size = points.iter().map(|point| (point - points[0]).norm()).fold(0.0, f64::max);
    let mut planes: Vec<(Vec3, Vec3)> = Vec::new();
    let mut faces = Vec::new();
    let height = |(origin, normal): &(Vec3, Vec3), point: &Vec3| normal.dot(&(point - origin));
    let is_on = |plane: &(Vec3, Vec3), point: &Vec3| height(plane, point).abs() < FLAT * size;
    for (i, a) in points.iter().enumerate() {
        for (j, b) in points.iter().enumerate().skip(i + 1) {
            for c in &points[j + 1..] {
                let Some(normal) = (b - a).cross(&(c - a)).try_normalize(FLAT * size * size) else { continue };
                if planes.iter().any(|plane| [a, b, c].into_iter().all(|point| is_on(plane, point))) {
                    continue;
                }
                let is_above = |normal: Vec3| points.iter().any(|p| height(&(*a, normal), p) > FLAT * size);
                let Some(normal) = [normal, -normal].into_iter().find(|normal| !is_above(*normal)) else { continue };
                let plane = (*a, normal);
                let flat = Quat::rotation_between(&normal, &Vec3::z())
                    .unwrap_or_else(|| Quat::from_scaled_axis(Vec3::x() * PI));
                let on: Vec<Vec3> = points.iter().filter(|p| is_on(&plane, p)).map(|p| flat * p).collect();
                let outline: Vec<Vec3> = outline(on).into_iter().map(|p| flat.inverse() * p).collect();
                faces.extend(outline.windows(2).skip(1).map(|pair| [outline[0], pair[0], pair[1]]));
                planes.push(plane);
            }
        }
    }
    faces
}

/// Sums up triangles whose masses are their areas; `None` without any.
fn shell(faces: &[[Vec3; 3]]) -> Option<Inertial> {
    let mass: f64 = faces.iter().map(area).sum();
    let com = faces.iter().map(|face| middle(face) * area(face)).sum::<Vec3>() / mass;
    inertial(mass, com, faces.iter().map(|face| squares(face, &com) * (area(face) / 12.0)).sum())
}

/// Sums up the tetrahedra from a point to all faces; `None` without volume.
fn solid(faces: &[[Vec3; 3]], are_holes: bool) -> Option<Inertial> {
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
    inertial(mass, com, faces.iter().map(|face| squares(face, &com) * (volume(face, &com) / 20.0)).sum())
}

fn middle(face: &[Vec3; 3]) -> Vec3 {
    (face[0] + face[1] + face[2]) / 3.0
}

fn area(face: &[Vec3; 3]) -> f64 {
    0.5 * (face[1] - face[0]).cross(&(face[2] - face[0])).norm()
}

/// Returns the sum of the products of coordinates over corners and their sum, about a point.
fn squares(face: &[Vec3; 3], about: &Vec3) -> Mat3 {
    let [a, b, c] = face.map(|p| p - about);
    let sum = a + b + c;
    a * a.transpose() + b * b.transpose() + c * c.transpose() + sum * sum.transpose()
}

/// Returns the inertia of a sum of products; `None` for what has no mass or moments.
fn inertial(mass: f64, com: Vec3, products: Mat3) -> Option<Inertial> {
    let (orientation, diagonal) = inertia::principal(&(Mat3::identity() * products.trace() - products));
    let is_solid = mass > inertia::MIN_MASS && diagonal.min() > 0.0 && com.iter().all(|x| x.is_finite());
    is_solid.then_some(Inertial { mass, com, orientation, diagonal })
}
