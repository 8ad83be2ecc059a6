//! Meshes small enough for a page: vertices merged by cells (Lindstrom 2000: one vertex a cell, where the quadric error of the
//! faces in it is least), numbers of 16 bits.

use std::collections::{BTreeMap, BTreeSet, HashMap};

use lifelike_character::{Character, GeomShape, Mat3, Triangles, Vec3};
use serde_json::{Value, json};

use super::base64::encode;

/// Triangles of a whole character at most.
const MOST_TRIANGLES: usize = 90_000;
/// Cells that a character's height has at first.
const CELLS: f64 = 420.0;
/// Weight of a cell's mean against its quadric, which alone may have no single minimum.
const PULL: f64 = 0.02;

/// Reads the meshes that a character is drawn with, and makes them small enough. Files that cannot be read are left out.
pub(super) fn surfaces(character: &Character, height: f64) -> BTreeMap<String, Triangles> {
    let drawn = |name: &&String| {
        let shows = |shape: &GeomShape| matches!(shape, GeomShape::Mesh(mesh) if mesh == *name);
        character.geoms.iter().any(|geom| geom.body != 0 && geom.rgba[3] > 0.0 && shows(&geom.shape))
    };
    let mut raw = BTreeMap::new();
    for name in character.meshes.keys().filter(drawn) {
        match character.meshes[name].triangles() {
            Ok(triangles) => {
                raw.insert(name.clone(), triangles);
            }
            Err(problem) => tracing::warn!("{problem}: it is not drawn"),
        }
    }
    let mut cell = height / CELLS;
    loop {
        let small: BTreeMap<String, Triangles> =
            raw.iter().map(|(name, triangles)| (name.clone(), simplified(triangles, cell))).collect();
        if small.values().map(|t| t.faces.len()).sum::<usize>() <= MOST_TRIANGLES {
            return small;
        }
        cell *= 1.4;
    }
}

/// Points and faces within one cell.
#[derive(Default)]
struct Cluster {
    /// Sum over the corners in it of area² n nᵀ and area² n d of their planes n·x = d.
    planes: Mat3,
    offsets: Vec3,
    points: Vec3,
    count: f64,
}

impl Cluster {
    /// Returns the point with the least quadric error near the mean of its points.
    fn vertex(&self, cell: f64) -> Vec3 {
        let mean = self.points / self.count.max(1.0);
        let pull = (PULL * self.planes.trace()).max(1e-30);
        let matrix = self.planes + Mat3::identity() * pull;
        let best = matrix.try_inverse().map_or(mean, |inverse| inverse * (self.offsets + mean * pull));
        if (best - mean).norm() <= cell { best } else { mean }
    }
}

/// Merges all vertices within a cell of this size (m); faces that lose a side go.
fn simplified(mesh: &Triangles, cell: f64) -> Triangles {
    let point = |i: u32| Vec3::from(mesh.points[i as usize].map(f64::from));
    let mut numbers: HashMap<[i32; 3], u32> = HashMap::new();
    let mut clusters: Vec<Cluster> = Vec::new();
    let mut faces = BTreeSet::new();
    for face in &mesh.faces {
        let corners = face.map(point);
        // Its length is twice the area.
        let normal = (corners[1] - corners[0]).cross(&(corners[2] - corners[0]));
        let (plane, offset) = (normal * normal.transpose(), normal * normal.dot(&corners[0]));
        let mut ids = [0; 3];
        for (id, corner) in ids.iter_mut().zip(&corners) {
            let key = [corner.x, corner.y, corner.z].map(|x| (x / cell).floor() as i32);
            *id = *numbers.entry(key).or_insert_with(|| {
                clusters.push(Cluster::default());
                clusters.len() as u32 - 1
            });
            let cluster = &mut clusters[*id as usize];
            cluster.planes += plane;
            cluster.offsets += offset;
            cluster.points += corner;
            cluster.count += 1.0;
        }
        if ids[0] != ids[1] && ids[1] != ids[2] && ids[2] != ids[0] {
            // The same face begins with its lowest corner, whatever it began with.
            let least = (0..3).min_by_key(|k| ids[*k]).unwrap_or(0);
            faces.insert([ids[least], ids[(least + 1) % 3], ids[(least + 2) % 3]]);
        }
    }
    // Clusters without a face have no place in the result.
    let mut used: BTreeMap<u32, u32> = BTreeMap::new();
    faces.iter().flatten().for_each(|id| {
        let next = used.len() as u32;
        used.entry(*id).or_insert(next);
    });
    let mut points = vec![[0.0; 3]; used.len()];
    for (id, at) in &used {
        let vertex = clusters[*id as usize].vertex(cell);
        points[*at as usize] = [vertex.x, vertex.y, vertex.z].map(|x| x as f32);
    }
    Triangles { points, faces: faces.iter().map(|face| face.map(|id| used[&id])).collect() }
}

/// Returns a mesh for the page: points around `middle` in units of `unit` metres as i16, indices as u32.
pub(super) fn pack(mesh: &Triangles) -> Value {
    let low = bounds(&mesh.points, f32::min, f32::INFINITY);
    let high = bounds(&mesh.points, f32::max, f32::NEG_INFINITY);
    let middle = [0, 1, 2].map(|k| if mesh.points.is_empty() { 0.0 } else { 0.5 * (low[k] + high[k]) });
    let reach = (0..3).map(|k| high[k] - middle[k]).fold(1e-6, f32::max);
    let unit = reach / f32::from(i16::MAX);
    let points = mesh.points.iter().flat_map(|p| [0, 1, 2].map(|k| ((p[k] - middle[k]) / unit).round() as i16));
    let points: Vec<u8> = points.flat_map(i16::to_le_bytes).collect();
    let faces: Vec<u8> = mesh.faces.iter().flatten().flat_map(|i| i.to_le_bytes()).collect();
    json!({ "unit": unit, "middle": middle, "points": encode(&points), "faces": encode(&faces) })
}

/// Returns the least or greatest coordinates, as `pick` says.
fn bounds(points: &[[f32; 3]], pick: fn(f32, f32) -> f32, start: f32) -> [f32; 3] {
    [0, 1, 2].map(|axis| points.iter().map(|p| p[axis]).fold(start, pick))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A unit cube whose sides are grids of n x n cells, two triangles each.
    fn cube(n: u32) -> Triangles {
        let mut mesh = Triangles::default();
        for axis in 0..3 {
            for side in [0.0, 1.0] {
                for k in 0..n * n {
                    let corner = |i: u32, j: u32| {
                        let mut p = [side; 3];
                        p[(axis + 1) % 3] = i as f32 / n as f32;
                        p[(axis + 2) % 3] = j as f32 / n as f32;
                        p
                    };
                    let (i, j) = (k / n, k % n);
                    let first = mesh.points.len() as u32;
                    mesh.points.extend([corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)]);
                    mesh.faces.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
                }
            }
        }
        mesh
    }

    #[test]
    fn a_cube_keeps_its_corners_and_edges() {
        let small = simplified(&cube(40), 0.26);
        assert!(small.faces.len() < 300 && small.faces.len() >= 12, "{} of 19200", small.faces.len());
        for corner in 0..8 {
            let at = [corner & 1, corner >> 1 & 1, corner >> 2].map(|bit| bit as f32);
            let distance = |p: &[f32; 3]| (0..3).map(|k| (p[k] - at[k]).powi(2)).sum::<f32>().sqrt();
            let nearest = small.points.iter().map(distance).fold(f32::INFINITY, f32::min);
            assert!(nearest < 0.03, "corner {at:?} is {nearest} away: quadrics put vertices where planes meet");
        }
        assert!(
            small.points.iter().all(|p| p.iter().any(|x| x.abs() < 0.02 || (x - 1.0).abs() < 0.02)),
            "on the surface"
        );
    }

    #[test]
    fn cells_smaller_than_the_mesh_change_nothing_but_double_points() {
        let small = simplified(&cube(2), 0.01);
        assert_eq!((small.faces.len(), small.points.len()), (48, 26), "3 x 3 x 3 points less the one in the middle");
    }

    #[test]
    fn packed_points_are_within_half_a_unit() {
        let mesh =
            Triangles { points: vec![[0.0, 1.0, 5.0], [2.0, 1.0, 5.0], [1.0, 3.0, 5.0]], faces: vec![[0, 1, 2]] };
        let packed = pack(&mesh);
        assert_eq!(packed["middle"], json!([1.0, 2.0, 5.0]));
        let x: Vec<u8> =
            [-32_767_i16, -32_767, 0, 32_767, -32_767, 0, 0, 32_767, 0].iter().flat_map(|x| x.to_le_bytes()).collect();
        assert_eq!(packed["points"], encode(&x));
        assert_eq!(packed["faces"], encode(&[0, 0, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0]));
    }
}
