//! The contract of a kind of motion prior.

use std::fmt::Debug;

use lifelike_checkpoint::Checkpoint;
use lifelike_motion::FeatureLayout;
use lifelike_train::TrainingTask;
use serde::Serialize;
use serde::de::DeserializeOwned;

use super::dataset::{PriorClip, Windows};
use super::motion_prior::MotionPrior;
use super::window_plan::WindowPlan;
use crate::RepresentationError;

/// A trained encoder and decoder of windows. Windows, statistics, names, file and reconstruction errors are the same
/// for every kind and belong to [`super::MotionPrior`]. A kind is listed in `kinds.rs` and nowhere else.
pub trait PriorKind: Clone + Debug + Sized {
    /// `kind` of its files.
    const NAME: &'static str;
    /// Name in messages, with its article.
    const TITLE: &'static str;
    /// Settings of the network and of its training.
    type Plan: KindPlan;
    /// Its training.
    type Trainer: PriorTraining;

    /// Begins a training.
    ///
    /// # Errors
    /// A plan out of range, no training frames, or a clip that does not fit the layout.
    fn trainer(plan: &Self::Plan, data: PriorData) -> Result<Self::Trainer, RepresentationError>;

    /// Encodes normalised windows.
    ///
    /// # Shapes
    /// `[N, samples, features]` to `[N, d_z]`, row-major.
    ///
    /// # Errors
    /// Numbers that are not whole windows.
    fn encode(&self, windows: Vec<f32>, shape: [usize; 2]) -> Result<Vec<f32>, RepresentationError>;

    /// Decodes codes to normalised windows.
    ///
    /// # Shapes
    /// `[N, d_z]` to `[N, samples, features]`, row-major.
    ///
    /// # Errors
    /// Numbers that are not whole codes.
    fn decode(&self, codes: &[f32], samples: usize) -> Result<Vec<f32>, RepresentationError>;

    /// Puts its arrays into a prior's file.
    ///
    /// # Errors
    /// Two arrays of one name.
    fn save_into(&self, checkpoint: &mut Checkpoint) -> Result<(), RepresentationError>;

    /// Reads its arrays from a prior's file, for windows of `features` numbers per sample.
    ///
    /// # Errors
    /// Arrays that are missing or of another shape than the plan's.
    fn load_from(plan: &Self::Plan, checkpoint: &Checkpoint, features: usize) -> Result<Self, RepresentationError>;
}

/// Clips of a prior's training.
#[derive(Debug, Clone, PartialEq)]
pub struct PriorData {
    /// Joints and end effectors of all clips.
    pub layout: FeatureLayout,
    /// Clips to train on.
    pub training: Vec<PriorClip>,
    /// Clips to report on, never trained on.
    pub held_out: Vec<PriorClip>,
}

/// A training of one kind of prior: a task of the one training loop that becomes a [`MotionPrior`] at any time.
pub trait PriorTraining: TrainingTask<Error = RepresentationError> {
    /// Describes a step in a few words.
    fn describe(metrics: &Self::Metrics) -> String;

    /// Returns the number of the network's parameters.
    fn parameters(&self) -> usize;

    /// Returns the prior as it stands.
    ///
    /// # Errors
    /// Windows that cannot be made.
    fn prior(&self) -> Result<MotionPrior, RepresentationError>;

    /// Returns the windows to report errors on: those of the held-out clips, or of the training clips where none were held out.
    fn watched(&self) -> &Windows;
}

/// Work with a training, whichever its kind: [`super::PriorPlan::train`].
pub trait WithTrainer {
    /// Result of the work.
    type Output;

    /// Does the work.
    fn run<T: PriorTraining>(self, trainer: T) -> Self::Output;
}

/// Settings of one kind of prior, a table of a TOML plan.
pub trait KindPlan: Clone + Debug + PartialEq + Default + Serialize + DeserializeOwned {
    /// Windows to train on and to encode.
    fn windows(&self) -> &WindowPlan;

    /// Returns d_z.
    fn latent_size(&self) -> usize;

    /// Names the numbers of a code, for people.
    fn describe_code(&self) -> String;

    /// Checks every range.
    ///
    /// # Errors
    /// The first key out of range.
    fn check(&self) -> Result<(), RepresentationError>;
}
