//! Names, layouts and provenance of a controller, as its file carries them.

use super::prior::PriorHeader;
use crate::action::ActionSpec;
use crate::network::Layer;
use crate::observation::ObservationSpec;
use crate::robot::Robot;
use crate::{FromInput, RobotError};

/// Everything about a controller that is not an array.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ControllerHeader {
    /// [`Self::VERSION`].
    pub version: u32,
    /// Name of the robot that it was trained for.
    pub robot: String,
    /// Layout of its observations.
    pub observation: ObservationSpec,
    /// Parts of that layout with their sizes, in order: another builder would give others, and is noticed.
    pub parts: Vec<(String, usize)>,
    /// Meaning of its outputs.
    pub action: ActionSpec,
    /// Rate of its steps (Hz).
    pub control_hz: f64,
    /// Widths of the hidden layers.
    pub hidden: Vec<usize>,
    /// The layers of a network that was not trained here; none: linear layers of those widths with ELU between them.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub layers: Vec<Layer>,
    /// Hidden layers of the encoder of its window, and the size of its code, where it has one.
    pub encoder: Option<(Vec<usize>, usize)>,
    /// Size of the state of the recurrent unit that reads its history, where it has one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub memory: Option<usize>,
    /// The motion prior whose encoder it carries.
    pub prior: Option<PriorHeader>,
    /// Training that it comes from.
    pub provenance: Provenance,
    /// Plan of the environment that it was trained in, as TOML without clips and networks; none in older files.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub environment: Option<String>,
}

/// Origin of a controller.
#[derive(Debug, Clone, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Provenance {
    /// SHA-256 of the policy's arrays, hexadecimal; of its file in controllers that were made of one.
    pub policy: String,
    /// SHA-256 of the motion prior's file that it was trained with, hexadecimal; empty without.
    pub prior: String,
    /// Environment steps of its training.
    pub steps: u64,
}

impl ControllerHeader {
    /// Version of the file.
    pub const VERSION: u32 = 1;
    /// Longest plan of an environment (bytes).
    pub const MAX_ENVIRONMENT: usize = 1 << 16;

    /// Returns the header of a policy with these hidden layers of its own, of no training yet.
    pub fn new(robot: &Robot, observation: ObservationSpec, action: ActionSpec, hidden: Vec<usize>) -> Self {
        Self {
            version: Self::VERSION,
            robot: robot.name.clone(),
            parts: Self::parts_of(&observation),
            observation,
            action,
            control_hz: robot.control_hz,
            hidden,
            layers: Vec::new(),
            encoder: None,
            memory: None,
            prior: None,
            provenance: Provenance::default(),
            environment: None,
        }
    }

    /// Checks that a policy with this header may drive a robot.
    ///
    /// # Errors
    /// Names, order, default pose or rate are others.
    pub fn check_robot(&self, robot: &Robot) -> Result<(), RobotError> {
        self.observation.check(robot)?;
        if self.control_hz == robot.control_hz {
            return Ok(());
        }
        let expected = self.control_hz;
        Err(RobotError::mismatch(format!("policy rate for robot '{}' (Hz)", robot.name), expected, robot.control_hz))
    }

    /// Parts of a layout as a header names them.
    pub(super) fn parts_of(observation: &ObservationSpec) -> Vec<(String, usize)> {
        observation.parts().into_iter().map(|part| (part.name, part.range.len())).collect()
    }

    /// Checks what does not depend on a robot.
    pub(super) fn check(&self) -> Result<(), RobotError> {
        let mismatch = |what: &str, expected: String, got: String| {
            Err(RobotError::mismatch(format!("controller: {what}"), expected, got))
        };
        if self.version != Self::VERSION {
            return mismatch("version", Self::VERSION.to_string(), self.version.to_string());
        }
        let bytes = self.environment.as_ref().map_or(0, String::len);
        if bytes > Self::MAX_ENVIRONMENT {
            let expected = format!("at most {} bytes", Self::MAX_ENVIRONMENT);
            return mismatch("plan of its environment", expected, bytes.to_string());
        }
        self.observation.check_sizes()?;
        if !(self.control_hz.is_finite() && self.control_hz > 0.0) {
            return mismatch("rate (Hz)", "a number above 0".into(), self.control_hz.to_string());
        }
        let own = Self::parts_of(&self.observation);
        if let Some(i) = (0..own.len().max(self.parts.len())).find(|&i| own.get(i) != self.parts.get(i)) {
            let say = |part: Option<&(String, usize)>| {
                part.map_or("none".to_string(), |(name, size)| format!("'{name}' of {size} numbers"))
            };
            return mismatch(&format!("part {i} of the observation"), say(own.get(i)), say(self.parts.get(i)));
        }
        Ok(())
    }
}
