//! Velocity and orientation of the root against the reference (thesis Table 5.3).

use lifelike_character::Vec3;

use super::accuracy::mean;
use super::rollout::{Rollout, Snapshot};

/// Errors of the root, means over the frames that count; NaN where there are none.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RootErrors {
    /// Distance of the velocities (m/s), each in its own root's frame.
    pub velocity: f64,
    /// Distance of the angular velocities (rad/s), each in its own root's frame.
    pub angular_velocity: f64,
    /// Angle between the orientations (deg), heading included.
    pub rotation: f64,
    /// Angle between the up directions, each seen from its own root (deg): without heading.
    pub tilt: f64,
}

/// Returns the errors of a rollout. Velocities are differences of neighbouring frames; those across a jump of the reference
/// are none.
pub fn root_errors<'a>(rollout: &'a Rollout) -> RootErrors {
    let steps: Vec<(f64, f64)> = rollout
        .counted()
        .filter(|frame| !rollout.jumps.contains(frame))
        .map(|frame| {
            let step = |all: &'a [Snapshot]| [&all[frame - 1], &all[frame]];
            velocity_errors(step(&rollout.reference), step(&rollout.simulated), rollout.fps)
        })
        .collect();
    RootErrors {
        velocity: mean(steps.iter().map(|step| step.0)),
        angular_velocity: mean(steps.iter().map(|step| step.1)),
        rotation: mean(rollout.pairs().map(|(r, s)| rotation(r, s).to_degrees())),
        tilt: mean(rollout.pairs().map(|(r, s)| tilt(r, s).to_degrees())),
    }
}

/// Returns the distances of velocities (m/s) and of angular velocities (rad/s) from one frame to the next.
pub(super) fn velocity_errors(reference: [&Snapshot; 2], simulated: [&Snapshot; 2], fps: f64) -> (f64, f64) {
    let (asked, done) = (velocities(reference, fps), velocities(simulated, fps));
    ((asked.0 - done.0).norm(), (asked.1 - done.1).norm())
}

/// Returns the angle between the root's orientations (rad), heading included.
pub(super) fn rotation(reference: &Snapshot, simulated: &Snapshot) -> f64 {
    reference.root_orientation.angle_to(&simulated.root_orientation)
}

/// Returns the angle between the up directions, each seen from its own root (rad): the difference of the orientations but for heading.
pub(super) fn tilt(reference: &Snapshot, simulated: &Snapshot) -> f64 {
    let up = |s: &Snapshot| s.root_orientation.inverse() * Vec3::z();
    up(reference).angle(&up(simulated))
}

/// Returns velocity and angular velocity from one frame to the next, in the first one's frame.
fn velocities([from, to]: [&Snapshot; 2], fps: f64) -> (Vec3, Vec3) {
    let back = from.root_orientation.inverse();
    let moved = back * (to.root_position - from.root_position);
    (moved * fps, (back * to.root_orientation).scaled_axis() * fps)
}

#[cfg(test)]
mod tests {
    use super::super::rollout::example::{rollout, snapshot};
    use super::*;

    #[test]
    fn a_walker_beside_one_who_turns_by_hand() {
        let walks = |t: f64| snapshot(Vec3::new(2.0 * t, 0.0, 1.0), 0.0, 0.0);
        let turns = |t: f64| snapshot(Vec3::z(), 0.5 * t, 0.0);
        let mut r = rollout(4, walks, turns);
        let errors = root_errors(&r);
        assert!((errors.velocity - 2.0).abs() < 1e-9 && (errors.angular_velocity - 0.5).abs() < 1e-9, "{errors:?}");
        // 0.05, 0.1 and 0.15 rad.
        assert!((errors.rotation - 0.1_f64.to_degrees()).abs() < 1e-9, "{errors:?}");
        assert!(errors.tilt < 1e-6, "turning is no tilt: {errors:?}");
        let leans = |t: f64| {
            let mut s = snapshot(Vec3::z(), 2.0, 0.0);
            s.root_orientation *= lifelike_character::Quat::from_euler_angles(0.3 * t, 0.0, 0.0);
            s
        };
        let errors = root_errors(&rollout(4, |_| snapshot(Vec3::z(), 0.0, 0.0), leans)).tilt;
        assert!((errors - 0.06_f64.to_degrees()).abs() < 1e-9, "0.03, 0.06 and 0.09 rad: {errors}");
        // The reference jumps ten metres: that is no velocity.
        r.reference[2].root_position.y += 10.0;
        r.reference[3].root_position.y += 10.0;
        assert!(root_errors(&r).velocity > 30.0);
        r.jumps = vec![2];
        assert!((root_errors(&r).velocity - 2.0).abs() < 1e-9);
        assert!(root_errors(&rollout(1, walks, turns)).rotation.is_nan());
    }
}
