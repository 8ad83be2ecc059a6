//! Training of the Spline-based Transformer and its baselines (thesis chapter 3).
//!
//! The main path: something that has [`Sequences`] ([`CurveSequences`], the families of 3.3.1; [`ImageSequences`], patches of 3.3.2;
//! [`Windows`] of people's joint rotations, [`humans`] of 3.3.3; [`StrandSequences`] of 3.3.4) and a [`SequencePlan`] (Table A.1's rows
//! are [`Experiment`]s) → [`SequenceTrainer`] → [`run::train`], which keeps a run's folder. The three
//! [`Method`]s differ in how the decoder's tokens are made and in nothing else: same seed, same batches.

mod curves;
mod data_plan;
mod experiments;
mod families;
mod hairstyles;
pub mod humans;
mod image_folder;
mod images;
pub(super) mod passes;
mod pixels;
mod plan;
mod recordings;
pub mod run;
mod sequences;
mod spread;
mod strands;
mod subjects;
mod train;

pub use curves::{CurveSequences, CurvesPlan, HELD_OUT_SEED};
pub use data_plan::DataPlan;
pub use experiments::Experiment;
pub use families::Family;
pub use hairstyles::{Hairstyle, Strand};
pub use image_folder::ImageFolder;
pub use images::{ImageSequences, ImagesPlan};
pub use plan::{Method, SequencePlan};
pub use recordings::{Recording, Split, Windows};
pub use sequences::{HeldOut, Sequences};
pub use spread::Spread;
pub use strands::{StrandSequences, StrandsPlan};
pub use subjects::{HumansPlan, group_of};
pub use train::{Errors, SequenceMetrics, SequenceTrainer};
