//! The motion asked for and the motion that came of it.

use std::sync::Arc;

use lifelike_character::{Quat, Vec3};

use super::field::FieldBodies;

/// Names of everything that a rollout has columns of.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Names {
    /// Scalar joints.
    pub joints: Vec<String>,
    /// Joints among them that are legs'.
    pub legs: Vec<bool>,
    /// End effectors.
    pub effectors: Vec<String>,
    /// Bodies, the world first.
    pub bodies: Vec<String>,
    /// Feet whose ground force is recorded.
    pub feet: Vec<String>,
    /// Bodies that the field's measures look at.
    pub field: FieldBodies,
    /// Body of each foot, and the middle of its sole in the body's frame (m).
    pub soles: Vec<(usize, Vec3)>,
}

/// One instant of one character.
#[derive(Debug, Clone, PartialEq)]
pub struct Snapshot {
    /// Root position (m, world).
    pub root_position: Vec3,
    /// Root orientation.
    pub root_orientation: Quat,
    /// Height of what it stands on, below the root (m, world).
    pub ground: f64,
    /// Joint positions (rad).
    pub joints: Vec<f64>,
    /// End-effector positions (m, world).
    pub effectors: Vec<Vec3>,
    /// Body frames, the world first (m, world).
    pub bodies: Vec<(Vec3, Quat)>,
}

/// Sign by which a fall is known.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Cause {
    /// The root is below [`HEIGHT_SHARE`](super::fall::HEIGHT_SHARE) of the reference's height.
    Height,
    /// The root's up direction, seen from the root, is off by more than [`TILT`](super::fall::TILT).
    Tilt,
    /// The simulation's state became non-finite.
    Diverged,
}

impl Cause {
    /// In words.
    pub fn words(self) -> &'static str {
        match self {
            Self::Height => "root sank",
            Self::Tilt => "tilted over",
            Self::Diverged => "simulation diverged",
        }
    }
}

/// End of an episode.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Outcome {
    /// On its feet, at the end of its time or of its clip.
    Survived,
    /// It fell at this frame.
    Fell {
        /// First frame in which it has fallen.
        frame: usize,
        /// Sign by which that is known.
        cause: Cause,
    },
}

/// One episode.
///
/// # Shapes
/// `reference` and `simulated` have one snapshot per frame at the policy's rate. Frame 0 is the start, which is exact
/// by construction and counts in no error. `torque_share` and `heat` are `[frame, joint]`, `foot_force`, `sole_speed`
/// and `planned_contact` are `[frame, foot]`. Frames after a fall are recorded for the eye only.
#[derive(Debug, Clone, PartialEq)]
pub struct Rollout {
    /// The clip.
    pub clip: String,
    /// Start within the clip (s).
    pub start: f64,
    /// Frames per second.
    pub fps: f64,
    /// Names of the columns.
    pub names: Arc<Names>,
    /// Motion asked for, laid to where the episode began.
    pub reference: Vec<Snapshot>,
    /// Motion that came of it.
    pub simulated: Vec<Snapshot>,
    /// Actuator torque as a share of the largest, -1 to 1.
    pub torque_share: Vec<f32>,
    /// Mean squared actuator torque of the step over the squared continuous torque.
    pub heat: Vec<f32>,
    /// Normal ground force of each foot as a share of the weight.
    pub foot_force: Vec<f32>,
    /// Speed over the ground of the lowest corner of each sole since the frame before (m/s), `[frame, foot]`.
    pub sole_speed: Vec<f32>,
    /// True where the reference's sole is on the ground, `[frame, foot]`.
    pub planned_contact: Vec<bool>,
    /// Frames whose reference is not what follows on the one before: another clip begins.
    pub jumps: Vec<usize>,
    /// Frames that the episode would have had without a fall.
    pub planned: usize,
    /// Its end.
    pub outcome: Outcome,
}

impl Rollout {
    /// Returns whether it ended on its feet.
    pub fn survived(&self) -> bool {
        self.outcome == Outcome::Survived
    }

    /// The frames that count: from the first after the start to the last before a fall.
    pub fn counted(&self) -> std::ops::Range<usize> {
        let recorded = self.simulated.len().min(self.reference.len());
        let end = match self.outcome {
            Outcome::Survived => recorded,
            Outcome::Fell { frame, .. } => frame.min(recorded),
        };
        1..end.max(1)
    }

    /// Reference and simulation of the frames that count.
    pub fn pairs(&self) -> impl Iterator<Item = (&Snapshot, &Snapshot)> {
        let range = self.counted();
        let end = range.end.min(self.reference.len()).min(self.simulated.len());
        let start = range.start.min(end);
        self.reference[start..end].iter().zip(&self.simulated[start..end])
    }
}

/// Rollouts small enough to calculate by hand.
#[cfg(test)]
pub(super) mod example {
    use super::*;

    /// A root at a place and heading with one hand a metre ahead of it and half a metre up, and one joint.
    pub fn snapshot(position: Vec3, yaw: f64, joint: f64) -> Snapshot {
        let turn = Quat::from_axis_angle(&Vec3::z_axis(), yaw);
        let hand = position + turn * Vec3::new(1.0, 0.0, 0.5);
        Snapshot {
            root_position: position,
            root_orientation: turn,
            ground: 0.0,
            joints: vec![joint],
            effectors: vec![hand],
            bodies: vec![(Vec3::zeros(), Quat::identity()), (position, turn), (hand, turn)],
        }
    }

    /// `frames` frames at 10 Hz in which reference and physics stand where the closures say.
    pub fn rollout(frames: usize, reference: impl Fn(f64) -> Snapshot, simulated: impl Fn(f64) -> Snapshot) -> Rollout {
        let at = |f: usize| f as f64 / 10.0;
        Rollout {
            clip: "walk".into(),
            start: 2.0,
            fps: 10.0,
            names: Arc::new(Names {
                joints: vec!["knee".into()],
                legs: vec![true],
                effectors: vec!["hand".into()],
                bodies: vec!["world".into(), "pelvis".into(), "hand".into()],
                feet: vec!["foot".into()],
                field: FieldBodies { watched: vec![(2, Vec3::zeros())], keys: vec![1, 2] },
                soles: vec![(1, Vec3::zeros())],
            }),
            reference: (0..frames).map(|f| reference(at(f))).collect(),
            simulated: (0..frames).map(|f| simulated(at(f))).collect(),
            torque_share: vec![0.1; frames],
            heat: vec![0.04; frames],
            foot_force: vec![1.0; frames],
            sole_speed: vec![0.0; frames],
            planned_contact: vec![true; frames],
            jumps: Vec::new(),
            planned: frames,
            outcome: Outcome::Survived,
        }
    }

    #[test]
    fn the_start_and_what_follows_a_fall_do_not_count() {
        let still = |_| snapshot(Vec3::z(), 0.0, 0.0);
        let mut r = rollout(10, still, still);
        assert_eq!((r.counted(), r.pairs().count()), (1..10, 9));
        r.outcome = Outcome::Fell { frame: 4, cause: Cause::Tilt };
        assert_eq!((r.counted(), r.pairs().count()), (1..4, 3));
        r.outcome = Outcome::Fell { frame: 0, cause: Cause::Tilt };
        assert_eq!(r.pairs().count(), 0);
    }
}
