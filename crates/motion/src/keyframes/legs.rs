//! The leg that reaches a foot: two bones, in closed form.

use lifelike_character::{Quat, Vec3};

use super::figure::{SHANK, THIGH};

/// Rotations of hip, knee and ankle, each relative to its parent.
pub(super) type Leg = [Quat; 3];

/// Returns the leg from a hip to an ankle (m, world), the knee towards `forward` (a direction of the world). `pelvis`
/// and `foot` are world rotations. `None` when the ankle is farther away than the leg is long, or at the hip.
pub(super) fn reach(pelvis: &Quat, hip: &Vec3, ankle: &Vec3, foot: &Quat, forward: &Vec3) -> Option<Leg> {
    let way = ankle - hip;
    let distance = way.norm();
    if !(0.2 * THIGH..=0.9995 * (THIGH + SHANK)).contains(&distance) {
        return None;
    }
    let down = way / distance;
    let side = down.cross(forward).try_normalize(1e-6)?;
    // The law of cosines: the knee's bend, and the angle between thigh and the line from hip to ankle.
    let bend = std::f64::consts::PI
        - ((THIGH * THIGH + SHANK * SHANK - distance * distance) / (2.0 * THIGH * SHANK)).clamp(-1.0, 1.0).acos();
    let lift = (SHANK * bend.sin() / distance).clamp(-1.0, 1.0).asin();
    // The frame of a straight leg along the line: z against it, y to the left.
    let left = -side;
    let axes = nalgebra::Matrix3::from_columns(&[left.cross(&-down), left, -down]);
    let straight = Quat::from_rotation_matrix(&nalgebra::Rotation3::from_matrix_unchecked(axes));
    let about_y = |angle: f64| Quat::from_axis_angle(&Vec3::y_axis(), angle);
    let thigh = straight * about_y(-lift);
    let shank = thigh * about_y(bend);
    Some([pelvis.inverse() * thigh, about_y(bend), shank.inverse() * foot])
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn the_ankle_is_reached_with_the_foot_as_asked_and_the_knee_in_front() {
        for at in 0..200 {
            let t = f64::from(at);
            let hip = Vec3::new(0.1 * t.sin(), 0.09, 0.78);
            let ankle = Vec3::new(0.2 * (0.7 * t).cos(), 0.15 * (1.3 * t).sin(), 0.16 + 0.08 * (0.3 * t).sin());
            let pelvis = Quat::from_euler_angles(0.1 * t.cos(), 0.2 * t.sin(), 0.3);
            let foot = Quat::from_euler_angles(0.0, 0.2, 0.3 * t.sin());
            let forward = Vec3::new(1.0, 0.1, 0.0);
            let [hip_turn, knee, ankle_turn] = reach(&pelvis, &hip, &ankle, &foot, &forward).unwrap();
            let thigh = pelvis * hip_turn;
            let knee_place = hip + thigh * Vec3::new(0.0, 0.0, -THIGH);
            let shank = thigh * knee;
            let reached = knee_place + shank * Vec3::new(0.0, 0.0, -SHANK);
            assert!((reached - ankle).norm() < 1e-9, "{reached} {ankle}");
            assert!((shank * ankle_turn).angle_to(&foot) < 1e-7);
            assert!((knee_place - 0.5 * (hip + ankle)).dot(&forward) > 0.0, "the knee bends backwards");
        }
    }

    #[test]
    fn what_is_too_far_is_not_reached() {
        let (turn, forward) = (Quat::identity(), Vec3::x());
        assert!(reach(&turn, &Vec3::zeros(), &Vec3::new(0.0, 0.0, -0.83), &turn, &forward).is_none());
        assert!(reach(&turn, &Vec3::zeros(), &Vec3::zeros(), &turn, &forward).is_none());
    }
}
