//! The misfit of a clip: how far it is from standing on the ground, upright, within its joints' ranges.

use std::fmt::{Display, Formatter};

use lifelike_character::{Anatomy, Character, Kinematics, Vec3};

use crate::clip::MotionClip;
use crate::plausibility::lowest_point;

/// Frames that are looked at, in pairs spread over the clip.
const MAX_PAIRS: usize = 150;
/// Soles lower than this above the lowest one may carry the body (share of the root's height).
const NEAR: f64 = 0.03;
/// Cost from which a clip needs an explanation: a mean height of a twelfth of the root's, say.
const BAD: f64 = 0.08;
/// Share of the cost that may remain after the right correction.
const REMAINS: f64 = 0.4;
/// Share of the cost that may remain, and least gain, where something else speaks for the correction.
const CLEARLY: f64 = 0.8;
const LEAST_GAIN: f64 = 0.005;

/// Misfit of a clip. Lengths are shares of the height of the standing character's root.
#[derive(Debug, Clone, PartialEq)]
pub struct Fit {
    /// Mean distance of the lowest point from the ground.
    pub ground: f64,
    /// Mean speed over the ground of the sole that carries the body (per second).
    pub slip: f64,
    /// Mean angle of the root from upright (rad).
    pub tilt: f64,
    /// Mean over frames of the excess of all joints over their ranges, summed (rad).
    pub beyond: f64,
    /// Heights of the lowest point, ascending (m).
    pub(super) heights: Vec<f64>,
    /// Height of the standing character's root (m).
    pub(super) size: f64,
}

impl Fit {
    /// Measures a clip. `columns` is from [`MotionClip::columns_for`].
    pub(crate) fn of(clip: &MotionClip, character: &Character, anatomy: &Anatomy, columns: &[usize]) -> Self {
        let mut pose = Pose::new(character, anatomy, columns);
        let size = pose.standing_height();
        let pairs = clip.len().saturating_sub(1).clamp(1, MAX_PAIRS);
        let stride = (clip.len().saturating_sub(1) / pairs).max(1);
        let (mut heights, mut slips, mut tilt, mut beyond) = (Vec::new(), Vec::new(), 0.0, 0.0);
        for frame in (0..clip.len()).step_by(stride).take(pairs) {
            let (corners, tilted) = pose.at(clip, frame);
            let lowest = corners.iter().map(|corner| corner.z).fold(f64::INFINITY, f64::min);
            heights.push(lowest_point(character, anatomy, &pose.kinematics));
            tilt += tilted;
            beyond += pose.beyond(clip, frame);
            if frame + 1 < clip.len() {
                let next = pose.at(clip, frame + 1).0;
                let carrying = corners.iter().zip(&next).filter(|(now, _)| now.z < lowest + NEAR * size);
                let speeds = carrying.map(|(now, next)| (next - now).xy().norm() * clip.fps / size);
                slips.extend(speeds.min_by(f64::total_cmp));
            }
        }
        let count = heights.len().max(1) as f64;
        heights.sort_by(f64::total_cmp);
        Self {
            ground: heights.iter().map(|height| height.abs()).sum::<f64>() / count / size,
            slip: slips.iter().sum::<f64>() / slips.len().max(1) as f64,
            tilt: tilt / count,
            beyond: beyond / count,
            heights,
            size,
        }
    }

    /// Returns one number for all of it; 0 is perfect.
    pub fn cost(&self) -> f64 {
        // A leap is half a root's height off the ground, a slip of half of it per second is a glide, a tilt of a radian is
        // a fall, and half a radian over the ranges is out of the question.
        self.ground + 0.5 * self.slip + 0.3 * self.tilt * self.tilt + 0.5 * self.beyond
    }

    /// Returns whether the clip needs an explanation.
    pub(super) fn is_bad(&self) -> bool {
        self.cost() > BAD
    }

    /// Returns whether a correction with this fit explains the misfit before it.
    pub(super) fn explains(&self, before: &Self) -> bool {
        self.cost() < REMAINS * before.cost()
    }

    /// Returns whether this fit is better by more than chance.
    pub(super) fn is_clearly_better(&self, before: &Self) -> bool {
        self.cost() < CLEARLY * before.cost() && before.cost() - self.cost() > LEAST_GAIN
    }
}

impl Display for Fit {
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "{:.2} m off the ground, soles slipping at {:.2} m/s, root tilted by {:.0} deg, joints {:.2} rad out of range in all",
            self.ground * self.size,
            self.slip * self.size,
            self.tilt.to_degrees(),
            self.beyond
        )
    }
}

struct Pose<'a> {
    character: &'a Character,
    anatomy: &'a Anatomy,
    columns: &'a [usize],
    kinematics: Kinematics,
    q: Vec<f64>,
    root: usize,
    /// Up of the standing character in the root's frame.
    up: Vec3,
}

impl<'a> Pose<'a> {
    fn new(character: &'a Character, anatomy: &'a Anatomy, columns: &'a [usize]) -> Self {
        let mut kinematics = Kinematics::new(character);
        let q = character.reference_position();
        kinematics.update(character, &q);
        let root = character.root_joint().map_or(0, |joint| joint.body);
        let up = kinematics.body_orientation[root].inverse() * Vec3::z();
        Self { character, anatomy, columns, kinematics, q, root, up }
    }

    /// Returns the height of the root above the soles in the reference pose (m).
    fn standing_height(&self) -> f64 {
        let root = self.kinematics.body_position[self.root].z;
        let lowest = self.corners().iter().map(|corner| corner.z).fold(f64::INFINITY, f64::min);
        let height = root - lowest;
        if height.is_finite() && height > 1e-3 { height } else { 1.0 }
    }

    fn corners(&self) -> Vec<Vec3> {
        let soles = self.anatomy.soles.values();
        soles.flat_map(|sole| sole.corners.iter().map(|corner| self.kinematics.point(sole.body, corner))).collect()
    }

    /// Returns the corners of the soles (m, world), and the root's angle from upright (rad).
    fn at(&mut self, clip: &MotionClip, frame: usize) -> (Vec<Vec3>, f64) {
        clip.write_position(self.character, self.columns, frame, &mut self.q);
        self.kinematics.update(self.character, &self.q);
        let up = self.kinematics.body_orientation[self.root] * self.up;
        (self.corners(), up.angle(&Vec3::z()))
    }

    /// Returns the excess of the joints over their ranges, summed (rad).
    fn beyond(&self, clip: &MotionClip, frame: usize) -> f64 {
        let row = clip.joints_at(frame);
        let joints = self.character.scalar_joints().zip(self.columns);
        let excess = joints.filter_map(|(joint, column)| {
            let (low, high) = joint.range?;
            Some((low - row[*column]).max(row[*column] - high).max(0.0))
        });
        excess.sum()
    }
}
