//! A root's way over the ground, apart from how high it is and how it leans.
//!
//! Place on the ground and heading say where a motion happens; height and tilt say what it is. Clips are put together by
//! moving the former rigidly and mixing the latter.

use lifelike_character::rotation::{heading, heading_angle};
use lifelike_character::{Quat, Vec3};

use crate::clip::MotionClip;
use crate::resample::slerp;

/// A place on the ground and a heading: a rigid motion of the plane.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Stand {
    /// m, world; z is 0.
    pub place: Vec3,
    /// rad, about the vertical.
    pub heading: f64,
}

impl Stand {
    /// Returns the position in the clip at a frame.
    pub fn of(clip: &MotionClip, frame: usize) -> Self {
        let p = clip.root_position[frame];
        Self { place: Vec3::new(p.x, p.y, 0.0), heading: heading_angle(&clip.root_orientation[frame]) }
    }

    fn turn(&self) -> Quat {
        Quat::from_axis_angle(&Vec3::z_axis(), self.heading)
    }

    /// Returns the step from here to there, as seen from here.
    pub fn step_to(&self, there: &Self) -> Self {
        let turn = (there.heading - self.heading + std::f64::consts::PI).rem_euclid(std::f64::consts::TAU);
        Self { place: self.turn().inverse() * (there.place - self.place), heading: turn - std::f64::consts::PI }
    }

    /// Returns the pose after a step that is seen from here.
    pub fn after(&self, step: &Self) -> Self {
        Self { place: self.place + self.turn() * step.place, heading: self.heading + step.heading }
    }

    /// Returns a step between two steps: half of both at `weight` 0.5.
    pub fn between(&self, other: &Self, weight: f64) -> Self {
        Self {
            place: self.place.lerp(&other.place, weight),
            heading: self.heading + weight * (other.heading - self.heading),
        }
    }
}

/// Height (m) and tilt of the root: what is left of a pose without its [`Stand`].
#[derive(Debug, Clone, Copy)]
pub(super) struct Posture {
    height: f64,
    tilt: Quat,
}

impl Posture {
    /// Returns the clip's at a frame.
    pub fn of(clip: &MotionClip, frame: usize) -> Self {
        let turn = clip.root_orientation[frame];
        Self { height: clip.root_position[frame].z, tilt: heading(&turn).inverse() * turn }
    }

    /// Returns the pose between two, the tilt along the shorter way.
    pub fn between(&self, other: &Self, weight: f64) -> Self {
        let height = (1.0 - weight) * self.height + weight * other.height;
        Self { height, tilt: slerp(&self.tilt, &other.tilt, weight) }
    }

    /// Returns the root's pose at this place.
    pub fn at(&self, stand: &Stand) -> (Vec3, Quat) {
        (Vec3::new(stand.place.x, stand.place.y, self.height), stand.turn() * self.tilt)
    }
}

/// Moves the clip over the ground so that its frame `frame` stands at `stand`.
pub(super) fn lay(clip: &mut MotionClip, frame: usize, stand: &Stand) {
    let from = Stand::of(clip, frame);
    let turn = Quat::from_axis_angle(&Vec3::z_axis(), stand.heading - from.heading);
    for (p, q) in clip.root_position.iter_mut().zip(&mut clip.root_orientation) {
        let height = p.z;
        *p = stand.place + turn * (*p - from.place);
        p.z = height;
        *q = turn * *q;
    }
}

/// Flips the signs of quaternions so that neighbours are near each other.
pub(super) fn continuous(turns: &mut [Quat]) {
    for t in 1..turns.len() {
        if turns[t - 1].coords.dot(&turns[t].coords) < 0.0 {
            turns[t] = Quat::new_unchecked(-turns[t].into_inner());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixtures::clip;

    #[test]
    fn laying_moves_the_way_and_keeps_height_and_tilt() {
        let mut c = clip(2, |_| [0.0, 0.0]);
        c.root_position = vec![Vec3::new(1.0, 0.0, 0.5), Vec3::new(2.0, 0.0, 0.6)];
        c.root_orientation = vec![Quat::from_euler_angles(0.0, 0.3, 0.0); 2];
        let there = Stand { place: Vec3::new(5.0, 5.0, 0.0), heading: std::f64::consts::FRAC_PI_2 };
        lay(&mut c, 0, &there);
        // One metre ahead along x is one metre along y after a quarter turn.
        assert!((c.root_position[1] - Vec3::new(5.0, 6.0, 0.6)).norm() < 1e-12);
        assert!(c.root_orientation[1].angle_to(&Quat::from_euler_angles(0.0, 0.3, there.heading)) < 1e-12);
    }

    #[test]
    fn steps_take_the_shorter_turn_and_bring_one_there() {
        let a = Stand { place: Vec3::new(1.0, 2.0, 0.0), heading: 3.0 };
        let b = Stand { place: Vec3::new(0.0, 2.5, 0.0), heading: -3.0 };
        let step = a.step_to(&b);
        assert!((step.heading - (std::f64::consts::TAU - 6.0)).abs() < 1e-12);
        assert!((a.after(&step).place - b.place).norm() < 1e-12);
    }
}
