//! Options of retargeting.

use std::collections::BTreeMap;

use super::bounds::Bounds;
use super::correspondence::Correspondence;
use crate::contacts::ContactOptions;

/// Options of retargeting. The defaults suit a walking robot; every number has a unit.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RetargetOptions {
    /// Frames per second of the result.
    pub fps: f64,
    /// Speed of the motion against the captured one.
    pub tempo: Tempo,
    /// Largest speed of a joint (rad/s or m/s), by joint name: usually 80% of what its actuator can.
    pub velocity_limit: BTreeMap<String, f64>,
    /// Largest speed of joints not named in `velocity_limit` (rad/s).
    pub default_velocity_limit: f64,
    /// Smallest bend of the knees (rad): legs stretched out are singular, and a robot cannot balance on them.
    pub min_knee_bend: f64,
    /// Smallest lift of a swinging foot (m), for a leg of 0.44 m; longer legs lift higher in proportion.
    pub swing_clearance: f64,
    /// Share of the human's heel rise that is kept while the toes are still on the ground (0: the sole stays flat).
    pub heel_rise: f64,
    /// Lean over a foot that carries the body alone for longer than a step.
    pub balance: bool,
    /// Standard deviation of the zero-phase smoothing (s).
    pub smoothing: f64,
    /// When the human's feet touch the ground.
    pub contact: ContactOptions,
    /// Convert also clips in which the human stands on or hangs from things that are not there.
    pub allow_off_ground: bool,
    /// Largest mean errors; a conversion beyond them is refused.
    pub bounds: Bounds,
    /// Overrides of the guessed correspondence between the source's joints and the roles.
    pub correspondence: Correspondence,
}

impl Default for RetargetOptions {
    fn default() -> Self {
        Self {
            fps: 50.0,
            tempo: Tempo::Times(1.0),
            velocity_limit: BTreeMap::new(),
            default_velocity_limit: 12.0,
            min_knee_bend: 0.15,
            swing_clearance: 0.02,
            heel_rise: 0.5,
            balance: true,
            smoothing: 0.02,
            contact: ContactOptions::default(),
            allow_off_ground: false,
            bounds: Bounds::default(),
            correspondence: Correspondence::default(),
        }
    }
}

impl RetargetOptions {
    /// Returns the options that are at least zero, with their values and largest values.
    pub(super) fn limited(&self) -> [(&'static str, f64, f64); 13] {
        let (contact, bounds) = (&self.contact, &self.bounds);
        [
            ("min_knee_bend", self.min_knee_bend, 2.0),
            ("swing_clearance", self.swing_clearance, 1.0),
            ("heel_rise", self.heel_rise, 1.0),
            ("smoothing", self.smoothing, 1.0),
            ("contact.enter_height", contact.enter_height, 1.0),
            ("contact.leave_height", contact.leave_height, 1.0),
            ("contact.enter_speed", contact.enter_speed, 100.0),
            ("contact.leave_speed", contact.leave_speed, 100.0),
            ("contact.shortest_contact", contact.shortest_contact, 10.0),
            ("contact.shortest_gap", contact.shortest_gap, 10.0),
            ("bounds.position", bounds.position, f64::INFINITY),
            ("bounds.angle", bounds.angle, f64::INFINITY),
            ("bounds.skate", bounds.skate, f64::INFINITY),
        ]
    }
}

/// Speed of the motion against the captured one.
///
/// A body of another size that keeps the human's tempo cannot keep the human's balance: a sway or step must take long
/// enough against √(leg length / gravity), the time in which such a body falls.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(untagged)]
pub enum Tempo {
    /// So many times as fast: 1 as captured, 2 in half the time.
    Times(f64),
    /// By a rule.
    Rule(TempoRule),
}

/// A rule for the tempo.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum TempoRule {
    /// √(human leg / own leg) times as fast: dynamic similarity, the same Froude number v² / (g · leg).
    Froude,
}

impl Tempo {
    /// Returns the times as fast for a human leg of `human` and a robot's of `robot` (m).
    pub(super) fn factor(self, human: f64, robot: f64) -> f64 {
        match self {
            Self::Times(factor) => factor,
            Self::Rule(TempoRule::Froude) => (human / robot).sqrt(),
        }
    }
}
