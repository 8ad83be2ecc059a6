//! Triangles of the shapes on a page.

use std::f64::consts::{PI, TAU};

use lifelike_character::rotation::from_wxyz;
use lifelike_character::{Quat, Vec3};
use serde_json::Value;

use crate::base64::decode;

/// A point of a surface, and the surface's normal there, in the frame of a body (m).
pub(super) type Corner = (Vec3, Vec3);

/// Triangles of one colour (0 to 1).
#[derive(Debug, Clone, Default)]
pub(super) struct Surface {
    pub corners: Vec<Corner>,
    pub colour: [f64; 3],
}

/// MuJoCo's colour of geoms without one, and the colour that is shown instead.
const GREY: [f64; 3] = [0.5, 0.5, 0.5];
const PLAIN: [f64; 3] = [0.86, 0.52, 0.33];

/// Returns the surfaces of every body of a character on a page.
pub(super) fn bodies(character: &Value) -> Vec<Vec<Surface>> {
    let count = character["bodies"].as_array().map_or(0, Vec::len);
    let mut out = vec![Vec::new(); count];
    for geom in character["geoms"].as_array().into_iter().flatten() {
        let Some(body) = geom["body"].as_u64().and_then(|b| out.get_mut(b as usize)) else { continue };
        let [r, g, b, _] = numbers(&geom["rgba"]);
        let is_grey = [r, g, b].iter().zip(GREY).all(|(c, grey)| (c - grey).abs() < 1e-3);
        let [x, y, z, _] = numbers(&geom["position"]);
        let turn = from_wxyz(numbers(&geom["orientation"])).unwrap_or_else(Quat::identity);
        let place = |(p, n): Corner| (turn * p + Vec3::new(x, y, z), turn * n);
        let corners = shape(geom, &character["meshes"]).into_iter().map(place).collect();
        body.push(Surface { corners, colour: if is_grey { PLAIN } else { [r, g, b] } });
    }
    out
}

fn numbers(value: &Value) -> [f64; 4] {
    [0, 1, 2, 3].map(|k| value[k].as_f64().unwrap_or_default())
}

/// Returns the corners of a geom in its own frame, three a triangle.
fn shape(geom: &Value, meshes: &Value) -> Vec<Corner> {
    let [a, b, c, _] = numbers(&geom["size"]);
    match geom["shape"].as_str().unwrap_or_default() {
        "sphere" => ellipsoid(Vec3::repeat(a), 0.0),
        "ellipsoid" => ellipsoid(Vec3::new(a, b, c), 0.0),
        "capsule" => ellipsoid(Vec3::repeat(a), b),
        "cylinder" => cone([a, a], [-b, b]),
        "box" => cuboid(Vec3::new(a, b, c)),
        "mesh" => geom["mesh"].as_str().map(|name| mesh(&meshes[name])).unwrap_or_default(),
        _ => Vec::new(),
    }
}

/// Returns a grid of cells over (u, v) in [0, 1]² as triangles.
fn grid(rows: usize, columns: usize, at: impl Fn(f64, f64) -> Corner) -> Vec<Corner> {
    let corner = |i: usize, j: usize| at(i as f64 / rows as f64, j as f64 / columns as f64);
    let cells = (0..rows).flat_map(|i| (0..columns).map(move |j| (i, j)));
    cells
        .flat_map(|(i, j)| [(i, j), (i + 1, j), (i, j + 1), (i, j + 1), (i + 1, j), (i + 1, j + 1)])
        .map(|(i, j)| corner(i, j))
        .collect()
}

/// Returns an ellipsoid whose halves are `stretch` above and below the middle: a capsule where its radii are equal.
fn ellipsoid(radii: Vec3, stretch: f64) -> Vec<Corner> {
    grid(13, 20, |u, v| {
        // The middle row of cells is the tube between the two halves.
        let row = (u * 13.0).round();
        let (polar, shift) = if row <= 6.0 { (row / 12.0, stretch) } else { ((row - 1.0) / 12.0, -stretch) };
        let (sin, cos) = (polar * PI).sin_cos();
        let n = Vec3::new(sin * (v * TAU).cos(), sin * (v * TAU).sin(), cos);
        (n.component_mul(&radii) + Vec3::z() * shift, n.component_div(&radii).normalize())
    })
}

/// Returns a closed cone along z between two heights, with the radii there.
pub(super) fn cone(radii: [f64; 2], heights: [f64; 2]) -> Vec<Corner> {
    let rim = |v: f64| Vec3::new((v * TAU).cos(), (v * TAU).sin(), 0.0);
    let slope = (radii[0] - radii[1]) / (heights[1] - heights[0]).max(1e-9);
    let mantle = |u: f64, v: f64| {
        let k = u.round() as usize;
        (rim(v) * radii[k] + Vec3::z() * heights[k], (rim(v) + Vec3::z() * slope).normalize())
    };
    let lid = |k: usize| {
        let normal = Vec3::z() * if k == 1 { 1.0 } else { -1.0 };
        grid(1, 20, move |u, v| (rim(v) * radii[k] * u + Vec3::z() * heights[k], normal))
    };
    [grid(1, 20, mantle), lid(0), lid(1)].concat()
}

fn cuboid(half: Vec3) -> Vec<Corner> {
    let side = |axis: usize, sign: f64| {
        grid(1, 1, move |u, v| {
            let mut p = Vec3::zeros();
            (p[axis], p[(axis + 1) % 3], p[(axis + 2) % 3]) = (sign, 2.0 * u - 1.0, 2.0 * v - 1.0);
            let mut n = Vec3::zeros();
            n[axis] = sign;
            (p.component_mul(&half), n)
        })
    };
    (0..3).flat_map(|axis| [1.0, -1.0].map(|sign| side(axis, sign)).concat()).collect()
}

/// Returns a mesh of the page with flat faces; nothing where it is damaged.
fn mesh(packed: &Value) -> Vec<Corner> {
    let bytes = |name: &str| packed[name].as_str().and_then(decode).unwrap_or_default();
    let (unit, [x, y, z, _]) = (packed["unit"].as_f64().unwrap_or_default(), numbers(&packed["middle"]));
    let short = |b: &[u8]| f64::from(i16::from_le_bytes([b[0], b[1]])) * unit;
    let point = |b: &[u8]| Vec3::new(short(b) + x, short(&b[2..]) + y, short(&b[4..]) + z);
    let points: Vec<Vec3> = bytes("points").chunks_exact(6).map(point).collect();
    let index = |b: &[u8]| points.get(u32::from_le_bytes([b[0], b[1], b[2], b[3]]) as usize).copied();
    let face = |b: &[u8]| {
        let p = [index(b)?, index(&b[4..])?, index(&b[8..])?];
        let n = (p[1] - p[0]).cross(&(p[2] - p[0]));
        Some(p.map(|p| (p, n.try_normalize(1e-30).unwrap_or_else(Vec3::z))))
    };
    bytes("faces").chunks_exact(12).filter_map(face).flatten().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the volume inside of a closed surface (divergence theorem, with the sign of its orientation dropped).
    fn volume(corners: &[Corner]) -> f64 {
        corners.chunks_exact(3).map(|t| (t[0].0.dot(&t[1].0.cross(&t[2].0))).abs() / 6.0).sum()
    }

    #[test]
    fn volumes_of_convex_shapes() {
        // A polyhedron inside of a round shape is a few per cent smaller.
        let cases = [
            (cuboid(Vec3::new(1.0, 2.0, 3.0)), 48.0, 1e-9),
            (ellipsoid(Vec3::repeat(1.0), 0.0), 4.0 / 3.0 * PI, 0.05),
            (ellipsoid(Vec3::new(0.5, 1.0, 2.0), 0.0), 4.0 / 3.0 * PI, 0.05),
            (ellipsoid(Vec3::repeat(1.0), 2.0), 4.0 / 3.0 * PI + 4.0 * PI, 0.05),
            (cone([1.0, 1.0], [-1.0, 1.0]), 2.0 * PI, 0.03),
        ];
        for (corners, expected, share) in cases {
            let found = volume(&corners);
            assert!(found <= expected * 1.000_001 && found >= expected * (1.0 - share), "{found} of {expected}");
        }
    }

    #[test]
    fn normals_point_outwards() {
        for corners in
            [cuboid(Vec3::new(1.0, 2.0, 3.0)), ellipsoid(Vec3::new(0.5, 1.0, 2.0), 0.3), cone([1.0, 0.0], [0.0, 2.0])]
        {
            let middle = corners.iter().map(|c| c.0).sum::<Vec3>() / corners.len() as f64;
            assert!(corners.iter().all(|(p, n)| n.dot(&(p - middle)) > -1e-9 && (n.norm() - 1.0).abs() < 1e-9));
        }
    }
}
