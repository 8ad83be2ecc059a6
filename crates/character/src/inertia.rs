//! Mass and inertia of geoms and their sums, as MuJoCo's compiler computes them: solids of uniform density.

use nalgebra::SymmetricEigen;

use crate::model::{GeomShape, Inertial};
use crate::rotation::{Mat3, Quat, Vec3};

/// Less mass than this (kg) is none, as in MuJoCo.
pub const MIN_MASS: f64 = 1e-15;
/// Thickness of an ellipsoid's shell (m), as in MuJoCo.
const LAYER: f64 = 1e-6;

/// Returns the volume of a solid (m³). Planes, meshes and height fields have none here.
pub fn volume(shape: &GeomShape) -> f64 {
    use std::f64::consts::PI;
    match shape {
        GeomShape::Sphere(r) => 4.0 / 3.0 * PI * r.powi(3),
        GeomShape::Capsule(r, half) => PI * r * r * (2.0 * half + 4.0 / 3.0 * r),
        GeomShape::Cylinder(r, half) => PI * r * r * 2.0 * half,
        GeomShape::Box(h) => 8.0 * h.x * h.y * h.z,
        GeomShape::Ellipsoid(h) => 4.0 / 3.0 * PI * h.x * h.y * h.z,
        GeomShape::Plane | GeomShape::Mesh(_) | GeomShape::HeightField(_) => 0.0,
    }
}

/// Returns the principal moments (kg m²) about the middle of a solid of this mass (kg), along the axes of its frame.
pub fn moments(shape: &GeomShape, mass: f64) -> Vec3 {
    match shape {
        GeomShape::Sphere(r) => Vec3::repeat(0.4 * mass * r * r),
        GeomShape::Capsule(r, half) => {
            // A cylinder, and one sphere cut in two and moved apart.
            let height = 2.0 * half;
            let ball = mass * 4.0 * r / (4.0 * r + 3.0 * height);
            let tube = mass - ball;
            let across = tube * (3.0 * r * r + height * height) / 12.0
                + ball * (0.4 * r * r + height * (3.0 * r + 2.0 * height) / 8.0);
            Vec3::new(across, across, tube * r * r / 2.0 + 0.4 * ball * r * r)
        }
        GeomShape::Cylinder(r, half) => {
            let across = mass * (3.0 * r * r + 4.0 * half * half) / 12.0;
            Vec3::new(across, across, mass * r * r / 2.0)
        }
        GeomShape::Box(h) => sides(h) * (mass / 3.0),
        GeomShape::Ellipsoid(h) => sides(h) * (mass / 5.0),
        GeomShape::Plane | GeomShape::Mesh(_) | GeomShape::HeightField(_) => Vec3::zeros(),
    }
}

/// Returns the area of a surface (m²). Planes, meshes and height fields have none here.
pub fn area(shape: &GeomShape) -> f64 {
    use std::f64::consts::PI;
    match shape {
        GeomShape::Sphere(r) => 4.0 * PI * r * r,
        GeomShape::Capsule(r, half) => 4.0 * PI * r * (r + half),
        GeomShape::Cylinder(r, half) => 2.0 * PI * r * (r + 2.0 * half),
        GeomShape::Box(h) => 8.0 * (h.x * h.y + h.y * h.z + h.z * h.x),
        // Thomsen's formula, as MuJoCo has it.
        GeomShape::Ellipsoid(h) => {
            let power = |x: f64| x.powf(1.6075);
            4.0 * PI * ((power(h.x * h.y) + power(h.x * h.z) + power(h.y * h.z)) / 3.0).powf(1.0 / 1.6075)
        }
        GeomShape::Plane | GeomShape::Mesh(_) | GeomShape::HeightField(_) => 0.0,
    }
}

/// Returns the principal moments (kg m²) about the middle of a thin shell of this mass (kg), as [`moments`] those of a
/// solid.
pub fn of_shell(shape: &GeomShape, mass: f64) -> Vec3 {
    // Means of the squares of the coordinates over the surface.
    let squares = match shape {
        GeomShape::Sphere(r) => Vec3::repeat(r * r / 3.0),
        GeomShape::Capsule(r, half) => {
            let tube = half / (half + r);
            let across = tube * r * r / 2.0 + (1.0 - tube) * r * r / 3.0;
            let ends = half * half + half * r + r * r / 3.0;
            Vec3::new(across, across, tube * half * half / 3.0 + (1.0 - tube) * ends)
        }
        GeomShape::Cylinder(r, half) => {
            let tube = 2.0 * half / (2.0 * half + r);
            let across = tube * r * r / 2.0 + (1.0 - tube) * r * r / 4.0;
            Vec3::new(across, across, half * half * (tube / 3.0 + 1.0 - tube))
        }
        GeomShape::Box(h) => {
            let plates = Vec3::new(h.y * h.z, h.x * h.z, h.x * h.y);
            let share = plates / plates.sum();
            h.component_mul(h).component_mul(&share.map(|own| own + (1.0 - own) / 3.0))
        }
        // A layer of equal thickness.
        GeomShape::Ellipsoid(h) => {
            let volume = |more: f64| (h.x + more) * (h.y + more) * (h.z + more);
            let square = |k: usize, more: f64| volume(more) * (h[k] + more).powi(2) / 5.0;
            Vec3::from_fn(|k, _| (square(k, LAYER) - square(k, 0.0)) / (volume(LAYER) - volume(0.0)))
        }
        GeomShape::Plane | GeomShape::Mesh(_) | GeomShape::HeightField(_) => Vec3::zeros(),
    };
    Vec3::new(squares.y + squares.z, squares.x + squares.z, squares.x + squares.y) * mass
}

fn sides(h: &Vec3) -> Vec3 {
    let s = h.component_mul(h);
    Vec3::new(s.y + s.z, s.x + s.z, s.x + s.y)
}

/// Returns whether a mass can be spread so that it has these principal moments: none is larger than the two others together.
pub fn balanced(moments: &Vec3) -> bool {
    moments.max() * 2.0 <= moments.sum() * (1.0 + 1e-9)
}

/// Returns the tensor with these principal moments in a frame turned by `orientation`.
pub fn tensor(orientation: &Quat, diagonal: &Vec3) -> Mat3 {
    let r = orientation.to_rotation_matrix().into_inner();
    r * Mat3::from_diagonal(diagonal) * r.transpose()
}

/// Returns the inertia of a point mass at `offset` (the parallel axis theorem).
pub fn parallel_axis(mass: f64, offset: &Vec3) -> Mat3 {
    (Mat3::identity() * offset.norm_squared() - offset * offset.transpose()) * mass
}

/// Returns the principal axes and moments of a symmetric tensor, moments in descending order as in MuJoCo.
pub fn principal(tensor: &Mat3) -> (Quat, Vec3) {
    let eigen = SymmetricEigen::new(*tensor);
    let mut order = [0, 1, 2];
    order.sort_by(|a, b| eigen.eigenvalues[*b].total_cmp(&eigen.eigenvalues[*a]));
    let x: Vec3 = eigen.eigenvectors.column(order[0]).into_owned();
    let y: Vec3 = eigen.eigenvectors.column(order[1]).into_owned();
    let axes = Mat3::from_columns(&[x, y, x.cross(&y)]);
    let orientation = Quat::from_rotation_matrix(&nalgebra::Rotation3::from_matrix_unchecked(axes));
    (orientation, Vec3::from_fn(|i, _| eigen.eigenvalues[order[i]]))
}

/// Returns the sum of several rigid parts, each in the same frame. No mass at all gives zeros.
pub fn sum(parts: &[Inertial]) -> Inertial {
    if let [one] = parts {
        return one.clone();
    }
    let mass: f64 = parts.iter().map(|p| p.mass).sum();
    if mass < MIN_MASS {
        return Inertial { mass: 0.0, com: Vec3::zeros(), orientation: Quat::identity(), diagonal: Vec3::zeros() };
    }
    let com = parts.iter().map(|p| p.com * p.mass).sum::<Vec3>() / mass;
    let total: Mat3 =
        parts.iter().map(|p| tensor(&p.orientation, &p.diagonal) + parallel_axis(p.mass, &(p.com - com))).sum();
    let (orientation, diagonal) = principal(&total);
    Inertial { mass, com, orientation, diagonal }
}

impl Inertial {
    /// Returns the inertia tensor about the centre of mass, along the axes of the body frame (kg m²).
    pub fn tensor(&self) -> Mat3 {
        tensor(&self.orientation, &self.diagonal)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn part(shape: &GeomShape, mass: f64, com: Vec3) -> Inertial {
        Inertial { mass, com, orientation: Quat::identity(), diagonal: moments(shape, mass) }
    }

    #[test]
    fn a_box_is_mass_over_twelve_times_the_squares_of_its_sides() {
        let shape = GeomShape::Box(Vec3::new(0.5, 1.0, 1.5));
        assert_eq!(volume(&shape), 6.0);
        let expected = Vec3::new(4.0 + 9.0, 1.0 + 9.0, 1.0 + 4.0) * (12.0 / 12.0);
        assert!((moments(&shape, 12.0) - expected).norm() < 1e-14);
    }

    #[test]
    fn a_capsule_without_length_is_a_sphere_and_a_long_one_almost_a_rod() {
        let ball = moments(&GeomShape::Sphere(0.3), 2.0);
        assert!((moments(&GeomShape::Capsule(0.3, 0.0), 2.0) - ball).norm() < 1e-15);
        assert!((volume(&GeomShape::Capsule(0.3, 0.0)) - volume(&GeomShape::Sphere(0.3))).abs() < 1e-15);
        // A thin rod of length 2 has m l² / 12 = 1/3 about its middle.
        let rod = moments(&GeomShape::Capsule(1e-6, 1.0), 1.0);
        assert!((rod.x - 1.0 / 3.0).abs() < 1e-5 && rod.z < 1e-11, "{rod}");
    }

    #[test]
    fn two_half_boxes_are_one_box() {
        let half = GeomShape::Box(Vec3::new(0.1, 0.2, 0.15));
        let parts = [part(&half, 1.5, Vec3::new(1.0, 2.0, 0.15)), part(&half, 1.5, Vec3::new(1.0, 2.0, -0.15))];
        let whole = sum(&parts);
        let expected = moments(&GeomShape::Box(Vec3::new(0.1, 0.2, 0.3)), 3.0);
        assert!((whole.com - Vec3::new(1.0, 2.0, 0.0)).norm() < 1e-15);
        assert!((whole.tensor() - Mat3::from_diagonal(&expected)).norm() < 1e-14);
        assert!(whole.diagonal.x >= whole.diagonal.y && whole.diagonal.y >= whole.diagonal.z);
    }

    #[test]
    fn principal_axes_give_the_tensor_back() {
        let q = Quat::from_euler_angles(0.3, -1.1, 2.0);
        let original = tensor(&q, &Vec3::new(0.1, 0.3, 0.2));
        let (axes, diagonal) = principal(&original);
        assert!((tensor(&axes, &diagonal) - original).norm() < 1e-15);
        assert!((diagonal - Vec3::new(0.3, 0.2, 0.1)).norm() < 1e-15);
    }
}
