//! Paths of both feet: planted, or on an arc to the next position.

use lifelike_character::{Quat, Vec3};

use super::curve::{Curve, bump, minimum_jerk, quick_bump};
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
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Step {
    pub foot: usize,
    pub start: f64,
    pub end: f64,
    pub to: Place,
    /// Greatest height of the sole (m), where there is no place on the way.
    pub height: f64,
    /// Places on the way: time (s), x, y, height of the sole (m).
    pub via: Vec<[f64; 4]>,
    /// Flag of a step that may be in the air together with one of the other foot.
    pub flies: bool,
}

/// The pose of one foot.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Foot {
    pub ankle: Vec3,
    pub yaw: f64,
    /// Heel up is positive (rad).
    pub pitch: f64,
}

impl Foot {
    pub(super) fn turn(&self) -> Quat {
        Quat::from_axis_angle(&Vec3::z_axis(), self.yaw) * Quat::from_axis_angle(&Vec3::y_axis(), self.pitch)
    }

    /// Returns this flat foot tilted about the end of its sole that stays down: about the toes when the heel rises.
    pub(super) fn tilted(self, pitch: f64) -> Self {
        let edge = Vec3::new(if pitch > 0.0 { figure::TOE } else { figure::HEEL }, 0.0, -figure::ANKLE);
        let tilted = Self { pitch, ..self };
        Self { ankle: self.ankle + self.turn() * edge - tilted.turn() * edge, ..tilted }
    }
}

/// Returns the last place of a foot before a time, by steps that are in order and over.
pub(super) fn standing_place(steps: &[Step], foot: usize, time: f64) -> Place {
    let over = steps.iter().rev().find(|step| step.foot == foot && step.end <= time);
    over.map_or_else(|| Place::standing(foot), |step| step.to)
}

/// Returns the pose of a foot at a time (s), flat. Steps are in order of time.
pub(super) fn foot_at(steps: &[Step], foot: usize, time: f64) -> Foot {
    let from = standing_place(steps, foot, time);
    let swing = steps.iter().find(|step| step.foot == foot && step.start < time && time < step.end);
    let Some(step) = swing else {
        return Foot { ankle: Vec3::new(from.x, from.y, figure::ANKLE), yaw: from.yaw, pitch: 0.0 };
    };
    let share = (time - step.start) / (step.end - step.start);
    let way = minimum_jerk(share);
    let mix = |a: f64, b: f64| a + way * (b - a);
    let [x, y, height] = if step.via.is_empty() {
        // A flight is short: its feet are up soon.
        let up = if step.flies { quick_bump(share) } else { bump(share) };
        [mix(from.x, step.to.x), mix(from.y, step.to.y), step.height * up]
    } else {
        let ends = [[step.start, from.x, from.y, 0.0], [step.end, step.to.x, step.to.y, 0.0]];
        let keys: Vec<[f64; 4]> = [ends[0]].into_iter().chain(step.via.iter().copied()).chain([ends[1]]).collect();
        [1, 2, 3].map(|axis| {
            let values: Vec<(f64, f64)> = keys.iter().map(|key| (key[0], key[axis])).collect();
            Curve::new(&values, None).at(time)
        })
    };
    Foot { ankle: Vec3::new(x, y, figure::ANKLE + height), yaw: mix(from.yaw, step.to.yaw), pitch: 0.0 }
}
