//! Paths of both feet: planted, or on an arc to the next position.

use lifelike_character::{Quat, Vec3};

use super::curve::{bump, minimum_jerk};
use super::figure;

/// The left foot's index; the right one's is 1.
pub(super) const LEFT: usize = 0;

/// A place for a foot: its ankle above the ground (m), and its heading (rad).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Place {
    pub x: f64,
    pub y: f64,
    pub yaw: f64,
}

impl Place {
    /// Returns the position of a foot when a clip begins.
    pub(super) fn standing(foot: usize) -> Self {
        Self { x: 0.0, y: if foot == LEFT { figure::HALF_HIPS } else { -figure::HALF_HIPS }, yaw: 0.0 }
    }

    /// Returns the point of the sole over which the body stands well: a little before the ankle.
    pub(super) fn centre(&self) -> [f64; 2] {
        const AHEAD: f64 = 0.03;
        [self.x + AHEAD * self.yaw.cos(), self.y + AHEAD * self.yaw.sin()]
    }
}

/// A step: the foot leaves its place at `start` and stands at `to` from `end` on (s).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Step {
    pub foot: usize,
    pub start: f64,
    pub end: f64,
    pub to: Place,
    /// Greatest height of the sole (m).
    pub height: f64,
}

/// The pose of one foot.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Foot {
    pub ankle: Vec3,
    pub yaw: f64,
}

impl Foot {
    pub(super) fn turn(&self) -> Quat {
        Quat::from_axis_angle(&Vec3::z_axis(), self.yaw)
    }
}

/// Returns the last place of a foot before a time, by steps that are in order and over.
pub(super) fn standing_place(steps: &[Step], foot: usize, time: f64) -> Place {
    let over = steps.iter().rev().find(|step| step.foot == foot && step.end <= time);
    over.map_or_else(|| Place::standing(foot), |step| step.to)
}

/// Returns the pose of a foot at a time (s). Steps are in order of time.
pub(super) fn foot_at(steps: &[Step], foot: usize, time: f64) -> Foot {
    let from = standing_place(steps, foot, time);
    let swing = steps.iter().find(|step| step.foot == foot && step.start < time && time < step.end);
    let (share, to, height) = match swing {
        Some(step) => ((time - step.start) / (step.end - step.start), step.to, step.height),
        None => (0.0, from, 0.0),
    };
    let way = minimum_jerk(share);
    let mix = |a: f64, b: f64| a + way * (b - a);
    Foot {
        ankle: Vec3::new(mix(from.x, to.x), mix(from.y, to.y), figure::ANKLE + height * bump(share)),
        yaw: mix(from.yaw, to.yaw),
    }
}
