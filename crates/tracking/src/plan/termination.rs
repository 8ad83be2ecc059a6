//! When an episode has failed.

use crate::TrackerError;
use lifelike_train::limits::range;

/// When an episode has failed. A limit that the table does not name is not applied; without the table the recipe's limits
/// are. A diverged simulation always ends the episode.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields, default = "Termination::none")]
pub struct Termination {
    /// The thesis' rule: the largest end-effector deviation (heading frame, relative to the root) ...
    #[serde(skip_serializing_if = "Option::is_none")]
    pub persistent: Option<Persistent>,
    /// Root height off by more than this (m).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub height: Option<f32>,
    /// The direction of gravity in the root's frame off by more than this angle (rad).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tilt: Option<f32>,
    /// An end effector (heading frame, relative to the root) off by more than this (m).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub effector: Option<f32>,
    /// On the ground, off the reference by more than this (m).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub path: Option<f32>,
    /// Heading off by more than this (rad).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub heading: Option<f32>,
}

/// t^p and f of Table 4.1.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Persistent {
    /// ... is above this distance (m) ...
    pub distance: f32,
    /// ... for longer than this (s).
    pub seconds: f64,
}

impl Default for Termination {
    fn default() -> Self {
        Self { persistent: None, height: Some(0.12), tilt: Some(0.7), effector: Some(0.25), path: None, heading: None }
    }
}

impl Termination {
    /// With every limit multiplied (above 1: forgiving more); times stay.
    #[must_use]
    pub fn scaled(self, factor: f64) -> Self {
        let scale = |limit: Option<f32>| limit.map(|l| (f64::from(l) * factor) as f32);
        Self {
            persistent: self.persistent.map(|p| Persistent { distance: (f64::from(p.distance) * factor) as f32, ..p }),
            height: scale(self.height),
            tilt: scale(self.tilt),
            effector: scale(self.effector),
            path: scale(self.path),
            heading: scale(self.heading),
        }
    }

    /// No limit at all: for evaluation, which has its own idea of failure.
    pub const NONE: Self =
        Self { persistent: None, height: None, tilt: None, effector: None, path: None, heading: None };

    fn none() -> Self {
        Self::NONE
    }

    /// Whether every limit is in its range.
    ///
    /// # Errors
    /// [`TrackerError::Plan`] with the key, the range and the value.
    pub fn check(&self) -> Result<(), TrackerError> {
        let t = self;
        let limits = [
            ("termination.height", t.height),
            ("termination.tilt", t.tilt),
            ("termination.effector", t.effector),
            ("termination.path", t.path),
            ("termination.heading", t.heading),
            ("termination.persistent.distance", t.persistent.map(|p| p.distance)),
        ];
        for (key, limit) in limits {
            if let Some(limit) = limit {
                range(key, limit.into(), 1e-6, 1e3)?;
            }
        }
        if let Some(p) = t.persistent {
            range("termination.persistent.seconds", p.seconds, 0.0, 1e3)?;
        }
        Ok(())
    }
}
