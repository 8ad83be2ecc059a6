//! The contracts of other stacks: which terms they know, by which names, in which order.

use lifelike_character::Character;
use lifelike_robot::observation::Part;
use lifelike_robot::{ObservationSpec, RobotError};

use crate::mismatch;

/// The contract of a stack.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Dialect {
    /// Plain ONNX of our own observation, for any program that builds it.
    Onnx,
    /// BeyondMimic (whole_body_tracking), joints in Isaac Lab's order.
    BeyondMimic,
    /// mjlab 1.6, joints in MuJoCo's order.
    Mjlab,
    /// holosoma's whole-body tracking, observations in alphabetical order.
    Holosoma,
    /// The deployment folder of unitree_rl_mjlab and unitree_rl_lab.
    Unitree,
    /// wbc-mjlab: a policy without its motion, and `config.yaml`.
    Wbc,
}

/// A term of a stack: its name there, and the parts of ours that it is made of.
type Term = (&'static str, &'static [&'static str]);

/// A term of an observation, with the parts of ours that it is made of.
#[derive(Debug, Clone)]
pub(crate) struct Placed {
    pub(crate) name: &'static str,
    pub(crate) parts: Vec<Part>,
}

impl Placed {
    /// Numbers of the term.
    pub(crate) fn size(&self) -> usize {
        self.parts.iter().map(|part| part.range.len()).sum()
    }
}

/// Returns the numbers of a part, those of joints in this order.
pub(crate) fn in_order(part: &Part, joints: &[usize]) -> Vec<usize> {
    let is_of_joints = part.name.contains("joint_") || part.name.contains("action");
    let Part { range, .. } = part;
    if is_of_joints { joints.iter().map(|joint| range.start + joint).collect() } else { range.clone().collect() }
}

const COMMAND: &[&str] = &["reference_joint_position", "reference_joint_velocity"];

const TRACKING: &[Term] = &[
    ("command", COMMAND),
    ("motion_anchor_pos_b", &["anchor_position_b"]),
    ("motion_anchor_ori_b", &["anchor_orientation_b"]),
    ("base_lin_vel", &["root_linear_velocity_b"]),
    ("base_ang_vel", &["root_angular_velocity_b"]),
    ("joint_pos", &["joint_position"]),
    ("joint_vel", &["joint_velocity"]),
    ("actions", &["last_action"]),
    ("projected_gravity", &["projected_gravity_b"]),
];

/// In alphabetical order, which is that of the observation.
const HOLOSOMA: &[Term] = &[
    ("actions", &["last_action"]),
    ("base_ang_vel", &["root_angular_velocity_b"]),
    ("dof_pos", &["joint_position"]),
    ("dof_vel", &["joint_velocity"]),
    ("motion_command", COMMAND),
    ("motion_ref_ori_b", &["anchor_orientation_b"]),
];

const UNITREE: &[Term] = &[
    ("motion_command", COMMAND),
    ("motion_anchor_ori_b", &["anchor_orientation_b"]),
    ("base_ang_vel", &["root_angular_velocity_b"]),
    ("projected_gravity", &["projected_gravity_b"]),
    ("joint_pos_rel", &["joint_position"]),
    ("joint_vel_rel", &["joint_velocity"]),
    ("last_action", &["last_action"]),
];

const WBC: &[Term] = &[
    ("ref_base_height", &["reference_height"]),
    ("ref_base_lin_vel_b", &["reference_linear_velocity_b"]),
    ("ref_base_ang_vel_b", &["reference_angular_velocity_b"]),
    ("ref_gravity_b", &["reference_gravity_b"]),
    ("ref_joint_pos", &["reference_joint_position"]),
    ("ref_joint_vel", &["reference_joint_velocity"]),
    ("base_lin_vel", &["root_linear_velocity_b"]),
    ("base_ang_vel", &["root_angular_velocity_b"]),
    ("projected_gravity", &["projected_gravity_b"]),
    ("joint_pos", &["joint_position"]),
    ("joint_vel", &["joint_velocity"]),
    ("actions", &["last_action"]),
    ("motion_anchor_pos_b", &["anchor_position_b"]),
    ("motion_anchor_ori_b", &["anchor_orientation_b"]),
    (
        "command",
        &[
            "reference_height",
            "reference_linear_velocity_b",
            "reference_angular_velocity_b",
            "reference_gravity_b",
            "reference_joint_position",
        ],
    ),
];

/// Bodies whose poses BeyondMimic's motions carry, of the Unitree G1.
const BODIES: [&str; 14] = [
    "pelvis",
    "left_hip_roll_link",
    "left_knee_link",
    "left_ankle_roll_link",
    "right_hip_roll_link",
    "right_knee_link",
    "right_ankle_roll_link",
    "torso_link",
    "left_shoulder_roll_link",
    "left_elbow_link",
    "left_wrist_yaw_link",
    "right_shoulder_roll_link",
    "right_elbow_link",
    "right_wrist_yaw_link",
];

impl Dialect {
    /// All of them.
    pub const ALL: [Self; 6] = [Self::Onnx, Self::BeyondMimic, Self::Mjlab, Self::Holosoma, Self::Unitree, Self::Wbc];

    /// Returns its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Onnx => "onnx",
            Self::BeyondMimic => "beyondmimic",
            Self::Mjlab => "mjlab",
            Self::Holosoma => "holosoma",
            Self::Unitree => "unitree",
            Self::Wbc => "wbc",
        }
    }

    /// Returns the built-in plan that trains its observation.
    pub fn plan(self) -> &'static str {
        match self {
            Self::Onnx => "track",
            Self::BeyondMimic | Self::Mjlab => "track-beyondmimic",
            Self::Holosoma | Self::Unitree => "track-deploy",
            Self::Wbc => "track-wbc",
        }
    }

    /// Returns the version of ONNX's operators that it writes, and that of the file's format.
    pub(crate) fn versions(self) -> (i64, i64) {
        match self {
            Self::BeyondMimic => (11, 6),
            Self::Holosoma => (13, 7),
            Self::Onnx | Self::Mjlab | Self::Unitree | Self::Wbc => (18, 8),
        }
    }

    /// Returns true where the motion is in the file, addressed by `time_step`.
    pub(crate) fn has_motion(self) -> bool {
        matches!(self, Self::BeyondMimic | Self::Mjlab | Self::Holosoma)
    }

    /// Returns true where joints are numbered level after level.
    pub(crate) fn is_breadth_first(self) -> bool {
        self == Self::BeyondMimic
    }

    pub(crate) fn terms(self) -> &'static [Term] {
        match self {
            Self::Onnx => &[],
            Self::BeyondMimic | Self::Mjlab => TRACKING,
            Self::Holosoma => HOLOSOMA,
            Self::Unitree => UNITREE,
            Self::Wbc => WBC,
        }
    }

    /// Returns the parts of ours that a term is made of.
    pub(crate) fn parts_of(self, term: &str) -> Option<&'static [&'static str]> {
        self.terms().iter().find(|(name, _)| *name == term).map(|(_, parts)| *parts)
    }

    /// Returns the terms of an observation by this stack's names, in its order, with the parts that they are made of.
    ///
    /// # Errors
    /// The observation has a part that the stack does not know.
    pub(crate) fn layout(self, observation: &ObservationSpec) -> Result<Vec<Placed>, RobotError> {
        let parts = observation.parts();
        let (mut layout, mut at) = (Vec::new(), 0);
        while at < parts.len() {
            let begins = |(_, of): &&Term| {
                of.iter().enumerate().all(|(i, name)| parts.get(at + i).is_some_and(|part| part.name == *name))
            };
            let Some((name, of)) = self.terms().iter().find(begins) else {
                return Err(self.refusal(&format!("'{}' at number {} of its observation", parts[at].name, at + 1)));
            };
            layout.push(Placed { name, parts: parts[at..at + of.len()].to_vec() });
            at += of.len();
        }
        if self == Self::Holosoma {
            layout.sort_by_key(|term| term.name);
            if !layout.iter().map(|term| term.name).eq(HOLOSOMA.iter().map(|(name, _)| *name)) {
                let names: Vec<&str> = layout.iter().map(|term| term.name).collect();
                return Err(self.refusal(&names.join(", ")));
            }
        }
        Ok(layout)
    }

    /// Says that a policy does not fit, and which plan trains one that does.
    pub(crate) fn refusal(self, got: &str) -> RobotError {
        let terms: Vec<&str> = self.terms().iter().map(|(name, _)| *name).collect();
        let which = if self == Self::Holosoma { "all of" } else { "only" };
        mismatch(
            format!("policy for {}", self.name()),
            format!("{which} the observations {}; `--plan {}` trains one", terms.join(", "), self.plan()),
            got,
        )
    }

    /// Returns the bodies whose poses go into the file: the fourteen of the field's G1, or all.
    pub(crate) fn bodies(character: &Character) -> Vec<usize> {
        let named: Option<Vec<usize>> =
            BODIES.iter().map(|name| character.bodies.iter().position(|body| body.name == *name)).collect();
        named.unwrap_or_else(|| (1..character.bodies.len()).collect())
    }
}

impl std::fmt::Display for Dialect {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}

impl std::str::FromStr for Dialect {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let names: Vec<&str> = Self::ALL.iter().map(|dialect| dialect.name()).collect();
        let expected = || format!("expected one of {}, got '{text}'", names.join(", "));
        Self::ALL.into_iter().find(|dialect| dialect.name() == text).ok_or_else(expected)
    }
}
