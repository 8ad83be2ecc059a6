//! Rotations, exactly once for the whole project.
//!
//! Quaternions are `wxyz` whenever they are numbers in a row ([`from_wxyz`], [`to_wxyz`]). Inside the program they are
//! nalgebra's [`UnitQuaternion`], whose storage order nobody ever sees.

use nalgebra::{Matrix3, RealField, UnitQuaternion, Vector3};

/// A vector in three dimensions (m, m/s, ... as the field says).
pub type Vec3 = Vector3<f64>;
/// A rotation matrix or an inertia tensor.
pub type Mat3 = Matrix3<f64>;
/// A rotation.
pub type Quat = UnitQuaternion<f64>;

/// Returns the rotation with these components, normalised. `None` when they have no direction (zero or non-finite
/// norm).
pub fn from_wxyz<T: RealField + Copy>([w, x, y, z]: [T; 4]) -> Option<UnitQuaternion<T>> {
    UnitQuaternion::try_new(nalgebra::Quaternion::new(w, x, y, z), T::default_epsilon())
        .filter(|q| q.coords.iter().all(|c| c.is_finite()))
}

/// Returns the components of a rotation in the order `w, x, y, z`.
pub fn to_wxyz<T: RealField + Copy>(q: &UnitQuaternion<T>) -> [T; 4] {
    [q.w, q.i, q.j, q.k]
}

/// Returns the continuous 6D representation of Zhou et al. 2019 (thesis 2.4.1): the first two columns of the rotation
/// matrix, column after column.
pub fn to_6d<T: RealField + Copy>(q: &UnitQuaternion<T>) -> [T; 6] {
    let m = q.to_rotation_matrix().into_inner();
    [m[(0, 0)], m[(1, 0)], m[(2, 0)], m[(0, 1)], m[(1, 1)], m[(2, 1)]]
}

/// Converts back from 6D by Gram-Schmidt. Degenerate input (zero or parallel columns) gives `None`.
pub fn from_6d<T: RealField + Copy>(d: [T; 6]) -> Option<UnitQuaternion<T>> {
    let a = Vector3::new(d[0], d[1], d[2]);
    let b = Vector3::new(d[3], d[4], d[5]);
    let x = a.try_normalize(T::default_epsilon())?;
    let y = (b - x * x.dot(&b)).try_normalize(T::default_epsilon())?;
    let m = Matrix3::from_columns(&[x, y, x.cross(&y)]);
    Some(UnitQuaternion::from_rotation_matrix(&nalgebra::Rotation3::from_matrix_unchecked(m)))
}

/// A rotation about the vertical, as the cosine and sine of its angle: turning and undoing it takes no trigonometry.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Turn<T> {
    /// Cosine of the angle.
    pub cos: T,
    /// Sine of the angle.
    pub sin: T,
}

impl<T: RealField + Copy> Turn<T> {
    /// Returns the turn by an angle (rad).
    #[inline]
    pub fn by(angle: T) -> Self {
        let (sin, cos) = angle.sin_cos();
        Self { cos, sin }
    }

    /// Returns the turn by [`heading_angle`].
    #[inline]
    pub fn heading(q: &UnitQuaternion<T>) -> Self {
        let [x, y] = forward(q);
        let length = (x * x + y * y).sqrt();
        Self { cos: x / length, sin: y / length }
    }

    /// Returns its angle (rad), in −π..π.
    #[inline]
    pub fn angle(self) -> T {
        self.sin.atan2(self.cos)
    }

    /// Returns the turn that undoes it.
    #[inline]
    #[must_use]
    pub fn inverse(self) -> Self {
        Self { cos: self.cos, sin: -self.sin }
    }

    /// Returns the turn by both angles.
    #[inline]
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        Self { cos: self.cos * other.cos - self.sin * other.sin, sin: self.sin * other.cos + self.cos * other.sin }
    }

    /// Returns a vector turned.
    #[inline]
    pub fn apply(self, v: Vector3<T>) -> Vector3<T> {
        let [x, y] = self.on_ground([v.x, v.y]);
        Vector3::new(x, y, v.z)
    }

    /// Returns a vector on the ground turned.
    #[inline]
    pub fn on_ground(self, [x, y]: [T; 2]) -> [T; 2] {
        [self.cos * x - self.sin * y, self.sin * x + self.cos * y]
    }

    /// Returns [`to_6d`] of a rotation followed by this turn.
    #[inline]
    pub fn apply_6d(self, q: &UnitQuaternion<T>) -> [T; 6] {
        let [a, b, c, d, e, f] = to_6d(q);
        let ([a, b], [d, e]) = (self.on_ground([a, b]), self.on_ground([d, e]));
        [a, b, c, d, e, f]
    }
}

/// Returns the heading (yaw, rad) of a rotation: the direction in which its forward (x) axis points on the ground.
/// Looking straight up or down, x has no ground direction. The z axis (the back of the head, or the face) takes its
/// place, so the heading stays continuous through a forward roll.
#[inline]
pub fn heading_angle<T: RealField + Copy>(q: &UnitQuaternion<T>) -> T {
    let [x, y] = forward(q);
    y.atan2(x)
}

/// Returns the direction on the ground, of any length but zero, that [`heading_angle`] is the angle of.
#[inline]
fn forward<T: RealField + Copy>(q: &UnitQuaternion<T>) -> [T; 2] {
    let x = q * Vector3::x();
    let flat = x.x * x.x + x.y * x.y;
    if flat > nalgebra::convert(1e-6) {
        return [x.x, x.y];
    }
    let z = q * Vector3::z();
    let sign = if x.z > T::zero() { -T::one() } else { T::one() };
    [sign * z.x, sign * z.y]
}

/// Returns the rotation about the vertical by [`heading_angle`]: the heading frame of a root orientation.
pub fn heading<T: RealField + Copy>(q: &UnitQuaternion<T>) -> UnitQuaternion<T> {
    UnitQuaternion::from_axis_angle(&Vector3::z_axis(), heading_angle(q))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::expect_used)]

    use super::*;

    #[test]
    fn six_numbers_bring_the_rotation_back() {
        for i in 0..50 {
            let t = f64::from(i);
            let q = Quat::from_euler_angles(t.sin() * 3.0, (t * 0.7).cos() * 1.5, t * 1.3);
            let back = from_6d(to_6d(&q)).expect("a rotation");
            assert!(q.angle_to(&back) < 1e-7, "{}", q.angle_to(&back));
        }
        assert!(from_6d([0.0_f64; 6]).is_none());
        assert!(from_6d([1.0, 0.0, 0.0, 2.0, 0.0, 0.0_f64]).is_none());
    }

    #[test]
    fn the_order_of_numbers_is_wxyz() {
        let half = std::f64::consts::FRAC_1_SQRT_2;
        let q = from_wxyz([half, 0.0, 0.0, half]).expect("unit");
        assert!((q * Vec3::x() - Vec3::y()).norm() < 1e-12, "a quarter turn about z brings x to y");
        assert_eq!(to_wxyz(&q)[3], half);
        assert!(from_wxyz([0.0_f64; 4]).is_none());
        assert!(from_wxyz([f64::NAN, 0.0, 0.0, 1.0]).is_none());
    }

    #[test]
    fn heading_is_yaw_even_through_a_forward_roll() {
        for pitch in [0.0, 0.5, 1.0, 1.4, std::f64::consts::FRAC_PI_2] {
            let q = Quat::from_euler_angles(0.0, pitch, 0.8);
            assert!((heading_angle(&q) - 0.8).abs() < 1e-6, "pitch {pitch}: {}", heading_angle(&q));
        }
    }

    #[test]
    fn a_turn_is_the_rotation_about_the_vertical() {
        let v = Vec3::new(0.3, -0.7, 0.4);
        for i in 0..50 {
            let t = f64::from(i);
            let q = Quat::from_euler_angles(t.sin() * 3.0, (t * 0.7).cos() * 1.5, t * 1.3);
            let (turn, rotation) = (Turn::heading(&q), heading(&q));
            assert!((turn.angle() - heading_angle(&q)).abs() < 1e-12);
            assert!((turn.apply(v) - rotation * v).norm() < 1e-12);
            let back = turn.inverse().apply_6d(&q);
            assert!(back.iter().zip(to_6d(&(rotation.inverse() * q))).all(|(a, b)| (a - b).abs() < 1e-12));
            let further = turn.and(Turn::by(0.4));
            assert!((further.apply(v) - rotation * (Quat::from_euler_angles(0.0, 0.0, 0.4) * v)).norm() < 1e-12);
            // In single precision it is the same within some units in the last place.
            let single = Turn::heading(&q.cast::<f32>());
            assert!((f64::from(single.sin) - turn.sin).abs() < 1e-5 && (f64::from(single.cos) - turn.cos).abs() < 1e-5);
        }
    }
}
