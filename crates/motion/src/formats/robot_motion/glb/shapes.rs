//! Triangles of the shapes that robots are made of.

use std::f64::consts::PI;

use lifelike_character::{Character, GeomShape, Vec3};

use super::Surface;

/// Cells around a round shape, and from pole to pole.
const AROUND: u32 = 24;
const ALONG: u32 = 12;

/// Returns the surface of a shape in its own frame; none of ground, and of meshes that cannot be read.
pub(super) fn surface(robot: &Character, shape: &GeomShape) -> Option<Surface> {
    match shape {
        GeomShape::Sphere(radius) => Some(rounded(Vec3::repeat(*radius), 0.0)),
        GeomShape::Ellipsoid(half) => Some(rounded(*half, 0.0)),
        GeomShape::Capsule(radius, half) => Some(rounded(Vec3::repeat(*radius), *half)),
        GeomShape::Cylinder(radius, half) => Some(cylinder(*radius, *half)),
        GeomShape::Box(half) => Some(cuboid(*half)),
        GeomShape::Mesh(name) => mesh(robot, name),
        GeomShape::Plane | GeomShape::HeightField(_) => None,
    }
}

fn mesh(robot: &Character, name: &str) -> Option<Surface> {
    let triangles = robot.meshes.get(name)?.triangles().ok()?;
    let points: Vec<Vec3> = triangles.points.iter().map(|p| Vec3::from(p.map(f64::from))).collect();
    (!triangles.faces.is_empty()).then_some(Surface { points, normals: Vec::new(), faces: triangles.faces })
}

/// Returns an ellipsoid whose halves are `apart` from the middle along z.
fn rounded(half: Vec3, apart: f64) -> Surface {
    let mut surface = Surface::default();
    // The equator stands twice: the tube of a capsule is between.
    let rows: Vec<(u32, f64)> =
        (0..=ALONG / 2).map(|row| (row, apart)).chain((ALONG / 2..=ALONG).map(|row| (row, -apart))).collect();
    for (row, shift) in &rows {
        for column in 0..=AROUND {
            let (polar, turn) =
                (PI * f64::from(*row) / f64::from(ALONG), 2.0 * PI * f64::from(column) / f64::from(AROUND));
            let unit = Vec3::new(polar.sin() * turn.cos(), polar.sin() * turn.sin(), polar.cos());
            surface.points.push(unit.component_mul(&half) + Vec3::z() * *shift);
            surface.normals.push(unit.component_div(&half).normalize());
        }
    }
    grid(&mut surface, 0, rows.len() as u32 - 1, AROUND);
    surface
}

fn cylinder(radius: f64, half: f64) -> Surface {
    let mut surface = Surface::default();
    let rim = |column: u32| {
        let turn = 2.0 * PI * f64::from(column) / f64::from(AROUND);
        Vec3::new(turn.cos(), turn.sin(), 0.0)
    };
    let mut row = |radius: f64, z: f64, normal: Option<Vec3>| {
        for column in 0..=AROUND {
            surface.points.push(rim(column) * radius + Vec3::z() * z);
            surface.normals.push(normal.unwrap_or_else(|| rim(column)));
        }
    };
    for (from, to, normal) in [
        ([0.0, half], [radius, half], Some(Vec3::z())),
        ([radius, half], [radius, -half], None),
        ([radius, -half], [0.0, -half], Some(-Vec3::z())),
    ] {
        row(from[0], from[1], normal);
        row(to[0], to[1], normal);
    }
    for band in 0..3 {
        grid(&mut surface, 2 * band * (AROUND + 1), 1, AROUND);
    }
    surface
}

fn cuboid(half: Vec3) -> Surface {
    let mut surface = Surface::default();
    for axis in 0..3 {
        for side in [1.0, -1.0] {
            let first = surface.points.len() as u32;
            for (a, b) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
                let mut point = Vec3::zeros();
                (point[axis], point[(axis + 1) % 3], point[(axis + 2) % 3]) = (side, a * side, b);
                surface.points.push(point.component_mul(&half));
                surface.normals.push(Vec3::ith(axis, side));
            }
            surface.faces.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
        }
    }
    surface
}

/// Adds the triangles between rows of points, from a first one on, each with `columns` cells.
fn grid(surface: &mut Surface, first: u32, rows: u32, columns: u32) {
    for row in 0..rows {
        for column in 0..columns {
            let a = first + row * (columns + 1) + column;
            let b = a + columns + 1;
            for face in [[a, b, a + 1], [a + 1, b, b + 1]] {
                let [p, q, r] = face.map(|index| surface.points[index as usize]);
                // At a pole, cells are triangles.
                if (q - p).cross(&(r - p)).norm() > 1e-14 {
                    surface.faces.push(face);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn surfaces_are_closed_and_hold_their_volume() {
        let robot = crate::fixtures::swing();
        let volume = |shape: &GeomShape| {
            let surface = surface(&robot, shape).unwrap();
            let corner = |index: u32| surface.points[index as usize];
            surface.faces.iter().map(|[a, b, c]| corner(*a).dot(&corner(*b).cross(&corner(*c))) / 6.0).sum::<f64>()
        };
        for (shape, expected) in [
            (GeomShape::Sphere(0.2), 4.0 / 3.0 * PI * 0.008),
            (GeomShape::Ellipsoid(Vec3::new(0.1, 0.2, 0.3)), 4.0 / 3.0 * PI * 0.006),
            (GeomShape::Capsule(0.1, 0.3), PI * 0.01 * 0.6 + 4.0 / 3.0 * PI * 0.001),
            (GeomShape::Cylinder(0.1, 0.3), PI * 0.01 * 0.6),
            (GeomShape::Box(Vec3::new(0.1, 0.2, 0.3)), 8.0 * 0.006),
        ] {
            // Facets are inside of what is round: a polygon of 24 sides has 98.9% of its circle.
            let share = volume(&shape) / expected;
            assert!((0.96..1.000_001).contains(&share), "{shape:?}: {share}");
        }
    }
}
