//! Edits of a block's own clip, as the scene has them: points of the body and control points.

use lifelike_character::Vec3;
use lifelike_character::rotation::heading;
use lifelike_motion::MotionClip;
use lifelike_motion::edit::{Key, Target};
use serde::{Deserialize, Serialize};

/// Time before and after an edit in which the motion deviates, where nothing else is said (s).
const REACH: f64 = 0.5;
/// Edits of one point that are nearer than this are one (s).
const SAME: f64 = 0.015;

/// A point of the body at another place at a time.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Edit {
    /// A site, a body, or a role such as `left_hand`.
    pub body: String,
    /// Time within the block's own clip (s).
    pub at: f64,
    /// Way from the clip's own place: forward, left, up, as the robot is turned (m).
    pub by: [f64; 3],
    /// Time before and after it in which the motion deviates (s).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reach: Option<f64>,
}

impl Edit {
    pub(crate) fn check(&self) -> Result<(), String> {
        within("at", self.at, 0.0, 3600.0)?;
        self.reach.map_or(Ok(()), |reach| within("reach", reach, 0.05, 10.0))?;
        self.by.iter().try_for_each(|way| within("by", *way, -3.0, 3.0))
    }

    /// Returns whether it is of the same point and time.
    pub(crate) fn is_of(&self, other: &Self) -> bool {
        self.body == other.body && (self.at - other.at).abs() < SAME
    }

    /// Adds the way of another.
    pub(crate) fn add(&mut self, other: &Self) {
        self.by.iter_mut().zip(&other.by).for_each(|(way, more)| *way = ((*way + more) * 1e4).round() / 1e4);
        self.reach = other.reach.or(self.reach);
    }

    /// Returns what the editor of motion calls it; `at` is the time within the clip (s).
    pub(crate) fn key(&self, clip: &MotionClip, at: f64) -> Key {
        let frame = ((at * clip.fps).round() as usize).min(clip.len() - 1);
        let way = heading(&clip.root_orientation[frame]) * Vec3::from(self.by);
        let reach = self.reach.unwrap_or(REACH);
        Key { body: self.body.clone(), point: None, time: at, target: Target::By(way), before: reach, after: reach }
    }
}

/// A control point of the motion spline, further from or nearer to where such points usually are.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PointGain {
    /// Time within the block's own clip (s); the nearest inner control point is meant.
    pub at: f64,
    /// Factor on the distance: above 1 exaggerates, below 1 tones down.
    pub gain: f64,
}

impl PointGain {
    pub(crate) fn check(&self) -> Result<(), String> {
        within("at", self.at, 0.0, 3600.0)?;
        within("gain", self.gain, 0.0, 4.0)
    }
}

/// Refuses a number that is out of range.
pub(crate) fn within(what: &str, value: f64, low: f64, high: f64) -> Result<(), String> {
    if (low..=high).contains(&value) { Ok(()) } else { Err(format!("{what}: expected {low} to {high}, got {value}")) }
}
