//! The layout of an observation, with all names.

use super::chain::Chain;
use super::inputs::ObservationInputs;
use super::part::{Declaration, Occurs, PARTS, Part, Scene, Source};
use crate::robot::Robot;
use crate::{FromInput, RobotError};

/// Parts of the reference that the policy sees (c_t of thesis 4.2.2).
#[derive(Debug, Clone, Default, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ReferenceSpec {
    /// The policy sees the reference frame to reach, m_{t+1} (input M of Table 4.3).
    pub frame: bool,
    /// Frames further ahead that it sees, as offsets from t (inputs M5, M10 of Table 4.3; policy steps).
    #[serde(default)]
    #[schemars(extend("unit" = "policy steps"), inner(range(min = 1, max = 1000)))]
    pub future: Vec<u32>,
    /// Size of the latent code z_t (input L of Table 4.3); 0: none.
    #[serde(default)]
    #[schemars(extend("unit" = "1"), range(min = 0))]
    pub latent: usize,
    /// Frames around t+1 that an encoder trained with the policy sees, as offsets from it (policy steps).
    ///
    /// These are the end-to-end codes of Table 4.2.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[schemars(extend("unit" = "policy steps"), inner(range(min = -1000, max = 1000)))]
    pub window: Vec<i32>,
    /// Earlier steps of its own sensors and actions that the policy sees (policy steps); 0: none.
    ///
    /// With `network.memory` a recurrent unit reads them.
    #[serde(default, skip_serializing_if = "is_none")]
    #[schemars(extend("unit" = "policy steps"), range(min = 0, max = 256))]
    pub history: usize,
    /// Further parts of the observation that it sees, by name.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub parts: Vec<String>,
    /// The whole observation by its parts, in order: the layout of another stack.
    ///
    /// It takes the place of everything that is said elsewhere about inputs; empty: the layout of the thesis.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub terms: Vec<String>,
    /// Body whose pose `anchor_position_b` and `anchor_orientation_b` compare; empty: the root.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub anchor_body: String,
}

/// Inputs that tell where the robot is against where the reference is. All off in the thesis, whose policies let path
/// and heading drift.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AnchorSpec {
    /// The policy sees the reference's heading against its own.
    ///
    /// Sine and cosine, within ±[`ObservationSpec::ANCHOR_TURN`].
    #[serde(default)]
    pub heading: bool,
    /// The policy sees the reference's place on the ground against its own.
    ///
    /// Position of the reference's root in the robot's heading frame (2 numbers, m), clipped to the norm
    /// [`ObservationSpec::ANCHOR_REACH`].
    #[serde(default)]
    pub position: bool,
}

/// The layout of an observation, with all names: what a checkpoint and a deployed policy carry.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ObservationSpec {
    /// [`Self::VERSION`] of the builder that this is the layout of.
    pub version: u32,
    /// The root's height above the ground is seen (m).
    pub root_height: bool,
    /// The root's linear velocity is seen: few robots can measure it.
    #[serde(default = "seen", skip_serializing_if = "is_seen")]
    pub linear_velocity: bool,
    /// Joint names, in order.
    pub joints: Vec<String>,
    /// Default angle of each joint (rad): positions are seen relative to it.
    pub default_pose: Vec<f32>,
    /// End effectors of the reference frames, in order.
    pub end_effectors: Vec<String>,
    /// Key bodies, in order.
    pub key_bodies: Vec<String>,
    /// Inputs from the reference.
    pub reference: ReferenceSpec,
    /// Inputs that tie it to the reference's path.
    pub anchor: AnchorSpec,
    /// The way from the root to the anchor body.
    #[serde(default, skip_serializing_if = "Chain::is_unnamed")]
    pub anchor_chain: Chain,
}

/// The parts that a layout can be made of, term by term.
const TERMS: [&str; 17] = [
    "root_height",
    "root_linear_velocity_b",
    "root_angular_velocity_b",
    "projected_gravity_b",
    "joint_position",
    "joint_velocity",
    "key_bodies_h",
    "last_action",
    "action_before",
    "reference_joint_position",
    "reference_joint_velocity",
    "reference_height",
    "reference_linear_velocity_b",
    "reference_angular_velocity_b",
    "reference_gravity_b",
    "anchor_position_b",
    "anchor_orientation_b",
];

/// The largest latent code that is believed.
const LATENT_MAX: usize = 1 << 16;

/// The longest history that is believed (steps).
const HISTORY_MAX: usize = 256;

#[allow(clippy::trivially_copy_pass_by_ref)] // serde hands out a reference
fn is_none(n: &usize) -> bool {
    *n == 0
}

fn seen() -> bool {
    true
}

#[allow(clippy::trivially_copy_pass_by_ref)] // serde hands out a reference
fn is_seen(seen: &bool) -> bool {
    *seen
}

impl ObservationSpec {
    /// Version of the layout that [`Self::write`] writes.
    pub const VERSION: u32 = 2;

    /// Greatest distance at which the reference's root is ever shown (m).
    pub const ANCHOR_REACH: f32 = 0.3;

    /// Greatest turn from the reference at which the robot is ever shown (rad).
    pub const ANCHOR_TURN: f32 = 0.5;

    /// Returns the layout for a robot.
    pub fn new(robot: &Robot, reference: ReferenceSpec, anchor: AnchorSpec) -> Self {
        Self {
            version: Self::VERSION,
            root_height: robot.profile.observe_root_height,
            linear_velocity: true,
            joints: robot.layout.joints.clone(),
            default_pose: robot.default_pose.iter().map(|&q| q as f32).collect(),
            end_effectors: robot.layout.end_effectors.clone(),
            key_bodies: robot.profile.key_bodies.clone(),
            // A body that is not there leaves its name, which `check_sizes` refuses.
            anchor_chain: Chain::to(&robot.character, &reference.anchor_body).unwrap_or_default(),
            reference,
            anchor,
        }
    }

    /// Returns the same for a robot that cannot measure how fast its root moves.
    #[must_use]
    pub fn without_linear_velocity(self) -> Self {
        Self { linear_velocity: false, ..self }
    }

    /// Checks that this layout, as saved with a policy, is that of `robot`.
    ///
    /// # Errors
    /// [`RobotError::Input`] for another version or other names, also in another order.
    pub fn check(&self, robot: &Robot) -> Result<(), RobotError> {
        let mismatch = |what: &str, expected: String, got: String| {
            Err(RobotError::mismatch(format!("observation of robot '{}': {what}", robot.name), expected, got))
        };
        if self.version != Self::VERSION {
            return mismatch("version", Self::VERSION.to_string(), self.version.to_string());
        }
        let own = Self::new(robot, self.reference.clone(), self.anchor);
        for (what, expected, got) in [
            ("joints", &own.joints, &self.joints),
            ("end effectors", &own.end_effectors, &self.end_effectors),
            ("key bodies", &own.key_bodies, &self.key_bodies),
        ] {
            if expected != got {
                // The first difference, not two walls of names.
                let at = (0..expected.len()).find(|&i| expected.get(i) != got.get(i)).unwrap_or(expected.len());
                let say = |names: &[String]| match names.get(at) {
                    Some(name) => format!("'{name}' as number {} of {}", at + 1, names.len()),
                    None => format!("no more than {}", names.len()),
                };
                return mismatch(what, say(expected), say(got));
            }
        }
        if own.anchor_chain != self.anchor_chain {
            let say = |chain: &Chain| format!("{chain:?}");
            return mismatch("way to the anchor body", say(&own.anchor_chain), say(&self.anchor_chain));
        }
        if own.root_height != self.root_height {
            return mismatch("root height", own.root_height.to_string(), self.root_height.to_string());
        }
        if own.default_pose != self.default_pose {
            return mismatch("default pose", format!("{:?}", own.default_pose), format!("{:?}", self.default_pose));
        }
        Ok(())
    }

    /// Length F of a reference frame: the feature vector of eq. 4.1.
    pub fn frame_size(&self) -> usize {
        13 + 2 * self.joints.len() + 3 * self.end_effectors.len()
    }

    /// Length of the robot's own state, the last two actions included: 217 for the thesis' humanoid (4.3.1).
    pub fn state_size(&self) -> usize {
        self.parts().iter().filter(|part| part.source.is_own_state()).map(|part| part.range.len()).sum()
    }

    /// Length of an observation.
    pub fn size(&self) -> usize {
        self.declarations().map(|part| self.occurs(part).count() * (part.size)(self)).sum()
    }

    /// A further part: it occurs where it is asked for.
    pub(super) fn named(&self, part: &str) -> Occurs<'_> {
        Occurs::Once(self.reference.parts.iter().any(|name| name == part))
    }

    /// The declarations of its parts, in the order of their numbers.
    fn declarations(&self) -> impl Iterator<Item = &'static Declaration> {
        let terms = &self.reference.terms;
        let all = PARTS.iter().filter(|_| terms.is_empty());
        all.chain(terms.iter().filter_map(|term| PARTS.iter().find(|part| part.name == term)))
    }

    /// The times that a part occurs; a term of a layout once.
    fn occurs(&self, part: &Declaration) -> Occurs<'_> {
        if self.reference.terms.is_empty() { (part.occurs)(self) } else { Occurs::Once(true) }
    }

    /// Length of the window: the last numbers of an observation.
    pub fn window_size(&self) -> usize {
        self.reference.window.len() * self.frame_size()
    }

    /// Length of the history: the last numbers of an observation, where it has one.
    pub fn history_size(&self) -> usize {
        if self.reference.history == 0 {
            return 0;
        }
        self.reference.history
            * self.before_history().filter(|(part, _)| part.is_remembered()).map(|(_, n)| n).sum::<usize>()
    }

    /// The declarations of the parts before the history, and their lengths.
    fn before_history(&self) -> impl Iterator<Item = (&'static Declaration, usize)> {
        let before = self.declarations().take_while(|part| part.source != Source::Past);
        before.map(|part| (part, self.occurs(part).count() * (part.size)(self)))
    }

    /// The numbers of an observation that a history repeats, in order.
    pub fn remembered(&self) -> Vec<usize> {
        let (mut numbers, mut start) = (Vec::new(), 0);
        for (part, size) in self.before_history() {
            if part.is_remembered() {
                numbers.extend(start..start + size);
            }
            start += size;
        }
        numbers
    }

    /// The parts of an observation, in order and without gaps.
    pub fn parts(&self) -> Vec<Part> {
        let mut parts = Vec::new();
        let mut start = 0;
        for part in self.declarations() {
            let (occurs, size) = (self.occurs(part), (part.size)(self));
            for i in (0..occurs.count()).filter(|_| size > 0) {
                parts.push(Part { name: occurs.name(part.name, i), range: start..start + size, source: part.source });
                start += size;
            }
        }
        parts
    }

    /// Checks sizes that come from a file, before anything is made of them.
    ///
    /// # Errors
    /// [`RobotError::Input`] for a default pose of another length than the joints, or absurd sizes.
    pub fn check_sizes(&self) -> Result<(), RobotError> {
        let mismatch = |what: &str, expected: String, got: usize| {
            Err(RobotError::mismatch(format!("observation: {what}"), expected, got))
        };
        if self.default_pose.len() != self.joints.len() {
            return mismatch("angles of the default pose", self.joints.len().to_string(), self.default_pose.len());
        }
        if self.reference.latent > LATENT_MAX {
            return mismatch("size of a latent code", format!("at most {LATENT_MAX}"), self.reference.latent);
        }
        if let Some(unknown) = self.reference.terms.iter().find(|term| !TERMS.contains(&term.as_str())) {
            return Err(RobotError::mismatch("observation: a term (inputs.terms)", TERMS.join(", "), unknown));
        }
        let fits = self.anchor_chain.fits(self.joints.len());
        if !fits || self.anchor_chain.body != self.reference.anchor_body {
            let expected = "a body of the robot behind hinges, or none for the root";
            let got = &self.reference.anchor_body;
            return Err(RobotError::mismatch("observation: the anchor body (inputs.anchor_body)", expected, got));
        }
        if self.reference.history > HISTORY_MAX {
            return mismatch("steps of its history", format!("at most {HISTORY_MAX}"), self.reference.history);
        }
        if self.reference.history > 0 && !(self.reference.window.is_empty() && self.reference.terms.is_empty()) {
            let expected = "none beside inputs.window and inputs.terms".to_string();
            return mismatch("steps of its history (inputs.history)", expected, self.reference.history);
        }
        let known = |name: &String| PARTS.iter().any(|part| part.name == name && (part.occurs)(self).count() > 0);
        if let Some(unknown) = self.reference.parts.iter().find(|name| !known(name)) {
            let expected = "the name of one that this version has";
            return Err(RobotError::mismatch("observation: a further part", expected, unknown));
        }
        Ok(())
    }

    /// Writes one observation. Nothing is normalised: that is the network's part.
    ///
    /// Allocates nothing. A root orientation without a direction (zero or NaN) gives NaN, for the caller to quarantine.
    ///
    /// # Errors
    /// [`RobotError::Input`] when an array has the wrong length, [`RobotError::Unmeasured`] when a part needs what was
    /// not measured.
    pub fn write(&self, inputs: &ObservationInputs<'_>, out: &mut [f32]) -> Result<(), RobotError> {
        let got = out.len();
        let wrong_length = || RobotError::mismatch("length of observation", self.size(), got);
        if self.default_pose.len() != self.joints.len() {
            self.check_sizes()?;
        }
        let scene = Scene::new(inputs);
        let mut rest = out;
        for part in self.declarations() {
            let count = self.occurs(part).count();
            if count == 0 {
                continue;
            }
            let size = (part.size)(self);
            for i in 0..count {
                let Some((slot, after)) = std::mem::take(&mut rest).split_at_mut_checked(size) else {
                    return Err(wrong_length());
                };
                (part.write)(self, &scene, i, slot).map_err(|wrong| wrong.of(part.name))?;
                rest = after;
            }
        }
        if rest.is_empty() { Ok(()) } else { Err(wrong_length()) }
    }

    /// Frames of eq. 4.1 as the policy sees them: joint positions relative to the default pose.
    ///
    /// # Shapes
    /// `frames: [N, F]` into `out: [N, F]`.
    ///
    /// # Errors
    /// [`RobotError::Input`] when the lengths differ or are no multiple of F.
    pub fn write_frames(&self, frames: &[f32], out: &mut [f32]) -> Result<(), RobotError> {
        let size = self.frame_size();
        if frames.len() != out.len() || !frames.len().is_multiple_of(size) {
            let expected = format!("{}, a multiple of {size}", out.len());
            return Err(RobotError::mismatch("length of reference frames", expected, frames.len()));
        }
        let joints = 13..13 + self.joints.len();
        for (frame, out) in frames.chunks_exact(size).zip(out.chunks_exact_mut(size)) {
            out.copy_from_slice(frame);
            out[joints.clone()].iter_mut().zip(&self.default_pose).for_each(|(q, origin)| *q -= origin);
        }
        Ok(())
    }
}
