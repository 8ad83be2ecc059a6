//! Points of cylinders and ellipsoids that touch the ground: they depend on how the shape lies, as MuJoCo's do.

use super::lanes::{Lanes, Scalar};
use super::spatial::{Vec3, along, cross, dot, rotate_constant};

/// Most points of a curved shape that touch the ground.
pub const MAX_POINTS: usize = 4;
/// Square of the sine of a tilt below which the round faces of a cylinder are level: single precision knows no direction there.
const LEVEL: f64 = 1e-10;

/// A cylinder or ellipsoid in its body's frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Curved<T> {
    /// Middle (m).
    pub center: [T; 3],
    /// Axes of the shape, each in the body's frame.
    pub axes: [[T; 3]; 3],
    pub form: Form<T>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Form<T> {
    /// Radius, half length along the third axis (m).
    Cylinder(T, T),
    /// Half axes (m).
    Ellipsoid([T; 3]),
}

impl<T: Scalar> Curved<T> {
    /// Number of points.
    pub fn count(&self) -> usize {
        match self.form {
            Form::Cylinder(..) => MAX_POINTS,
            Form::Ellipsoid(_) => 1,
        }
    }

    /// Returns the points nearest to a plane with this normal, from the shape's middle (axes of the world); the first [`Self::count`]
    /// count. `rotation` is the body's.
    #[inline(always)]
    pub fn points<V: Lanes<Scalar = T>>(&self, rotation: &[V; 9], normal: &Vec3<V>) -> [Vec3<V>; MAX_POINTS] {
        let axes = self.axes.map(|axis| rotate_constant(rotation, &axis));
        match self.form {
            Form::Cylinder(radius, half) => cylinder(&axes, V::splat(radius), V::splat(half), normal),
            Form::Ellipsoid(half) => [ellipsoid(&axes, &half.map(V::splat), normal); MAX_POINTS],
        }
    }
}

/// The lower end of the lowest line, its upper end, and two points of the lower rim that make a triangle with the first.
#[inline(always)]
fn cylinder<V: Lanes>(axes: &[Vec3<V>; 3], radius: V, half: V, normal: &Vec3<V>) -> [Vec3<V>; MAX_POINTS] {
    let (zero, one) = (V::zero(), V::splat_f64(1.0));
    let slope = dot(&axes[2], normal);
    let down = slope.select_gt(zero, -one, one);
    let end = axes[2].map(|x| x * half * down);
    // What of the downward direction lies across the axis.
    let across = along(&normal.map(|x| -x), &axes[2], slope);
    let square = dot(&across, &across);
    let level = V::splat_f64(LEVEL);
    let scale = radius * square.max(level).sqrt().recip();
    let out = [0, 1, 2].map(|k| (square - level).select_gt(zero, across[k] * scale, axes[0][k] * radius));
    let side = cross(&out, &axes[2]).map(|x| x * V::splat_f64(0.75_f64.sqrt()));
    let rim =
        |sign: f64| [0, 1, 2].map(|k| end[k].sub_mul(out[k], V::splat_f64(0.5)).add_mul(side[k], V::splat_f64(sign)));
    [[0, 1, 2].map(|k| out[k] + end[k]), [0, 1, 2].map(|k| out[k] - end[k]), rim(1.0), rim(-1.0)]
}

/// The lowest point.
#[inline(always)]
fn ellipsoid<V: Lanes>(axes: &[Vec3<V>; 3], half: &Vec3<V>, normal: &Vec3<V>) -> Vec3<V> {
    let scaled = [0, 1, 2].map(|k| half[k] * dot(&axes[k], normal));
    let inverse = dot(&scaled, &scaled).max(V::splat_f64(1e-20)).sqrt().recip();
    let local = [0, 1, 2].map(|k| -half[k] * scaled[k] * inverse);
    [0, 1, 2].map(|k| (axes[0][k] * local[0]).add_mul(axes[1][k], local[1]).add_mul(axes[2][k], local[2]))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use lifelike_character::{Quat, rotation::from_wxyz};

    use super::*;

    #[derive(serde::Deserialize)]
    struct Pose {
        form: String,
        size: [f64; 3],
        position: [f64; 3],
        quaternion: [f64; 4],
        /// Contact points half way between shape and plane, and distances.
        contacts: Vec<([f64; 3], f64)>,
    }

    fn ours(pose: &Pose) -> Vec<([f64; 3], f64)> {
        let turn: Quat = from_wxyz(pose.quaternion).unwrap();
        let axes = [0, 1, 2].map(|k| {
            let axis = turn * lifelike_character::Vec3::ith(k, 1.0);
            [axis.x, axis.y, axis.z]
        });
        let form = match pose.form.as_str() {
            "cylinder" => Form::Cylinder(pose.size[0], pose.size[1]),
            _ => Form::Ellipsoid(pose.size),
        };
        let curved = Curved { center: [0.0; 3], axes, form };
        let points = curved.points(&[1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0], &[0.0, 0.0, 1.0]);
        let places = points.iter().take(curved.count()).map(|p| [0, 1, 2].map(|k| p[k] + pose.position[k]));
        places.filter(|p| p[2] <= 0.0).map(|p| ([p[0], p[1], 0.5 * p[2]], p[2])).collect()
    }

    /// MuJoCo 4.0's contacts at 300 random poses near the ground, by `peers/robots/ground_contacts.py`.
    #[test]
    fn contact_points_are_mujocos() {
        let poses: Vec<Pose> = serde_json::from_str(include_str!("../../tests/fixtures/ground_contacts.json")).unwrap();
        assert!(poses.len() >= 300);
        let mut counts = [0; MAX_POINTS + 1];
        for (i, pose) in poses.iter().enumerate() {
            let mut ours = ours(pose);
            assert_eq!(ours.len(), pose.contacts.len(), "pose {i}: {ours:?} for {:?}", pose.contacts);
            counts[ours.len()] += 1;
            for (point, distance) in &pose.contacts {
                // MuJoCo's order of points that are equally deep is its own.
                let near = |(p, d): &([f64; 3], f64)| {
                    (0..3).all(|k| (p[k] - point[k]).abs() < 1e-9) && (d - distance).abs() < 1e-9
                };
                let found = ours.iter().position(near);
                ours.remove(found.unwrap_or_else(|| panic!("pose {i}: {point:?} {distance} is not in {ours:?}")));
            }
        }
        assert!(counts.iter().all(|count| *count > 10), "every number of points: {counts:?}");
    }

    #[test]
    fn a_level_disk_stands_on_three_points() {
        // Single precision: a tilt of a micro-radian.
        let axes = [[1.0_f32, 0.0, 1e-6], [0.0, 1.0, 0.0], [-1e-6, 0.0, 1.0]];
        let points = cylinder(&axes, 0.06, 0.02, &[0.0, 0.0, 1.0]);
        for p in [points[0], points[2], points[3]] {
            assert!((p[2] + 0.02).abs() < 1e-6 && (p[0].hypot(p[1]) - 0.06).abs() < 1e-6, "{p:?}");
        }
    }
}
