//! A robot: a character and all that its control needs, by name.

use std::collections::BTreeMap;
use std::sync::Arc;

use lifelike_character::{Anatomy, Character};
use lifelike_motion::FeatureLayout;

use crate::actuator::{ActuatorParameters, ActuatorSet};

/// The text beside a robot's MJCF (`lima.toml` beside `lima.xml`). Every part is optional: what is missing is guessed
/// from the model.
#[derive(Debug, Clone, Default, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Profile {
    /// Roles that the guess gets wrong: role = body or site name.
    #[serde(default)]
    pub anatomy: lifelike_character::anatomy::Overrides,
    /// Kinds of actuators, by a name of their own.
    #[serde(default)]
    pub actuator: BTreeMap<String, ActuatorGroup>,
    /// Places whose positions are tracked (p of eq. 4.1): site names, or body names.
    #[serde(default)]
    pub end_effectors: Vec<String>,
    /// Further places in the policy's observation; empty for robots that cannot measure them (thesis 4.3.1).
    #[serde(default)]
    pub key_bodies: Vec<String>,
    /// Whether the policy may observe the root's height (thesis 4.3.1: the humanoid may, the robot may not).
    #[serde(default)]
    pub observe_root_height: bool,
    /// Policy rate (Hz); 50 where not said.
    #[serde(default)]
    pub control_hz: Option<f64>,
    /// Physics rate (Hz); 200 where not said. A multiple of the policy rate.
    #[serde(default)]
    pub physics_hz: Option<f64>,
    /// Joint angles of the default pose (rad); joints not named are at zero, or the nearest limit.
    #[serde(default)]
    pub default_pose: BTreeMap<String, f64>,
}

/// One kind of actuator and the joints that have it.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ActuatorGroup {
    /// Joint names; `*` stands for anything.
    pub joints: Vec<String>,
    /// Parameters of Table 4.1.
    pub parameters: ActuatorParameters,
}

/// A robot, ready to be simulated, trained and run.
#[derive(Debug, Clone)]
pub struct Robot {
    /// Its name.
    pub name: String,
    /// Its body.
    pub character: Arc<Character>,
    /// Which body is what.
    pub anatomy: Anatomy,
    /// Its actuators, one per scalar joint, in the character's order.
    pub actuators: ActuatorSet,
    /// Names of its joints and end effectors: the layout of eq. 4.1 for this robot.
    pub layout: FeatureLayout,
    /// Where the end effectors are, in the order of `layout.end_effectors`: body index and point in its frame (m).
    pub effectors: Vec<(usize, lifelike_character::Vec3)>,
    /// Where the key bodies of the observation are, likewise.
    pub key_bodies: Vec<(usize, lifelike_character::Vec3)>,
    /// Default pose, one angle per scalar joint (rad).
    pub default_pose: Vec<f64>,
    /// Policy rate (Hz).
    pub control_hz: f64,
    /// Physics steps per policy step.
    pub substeps: usize,
    /// The profile it was made with.
    pub profile: Profile,
}
