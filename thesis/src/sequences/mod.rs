//! Data sets of thesis chapter 3 (curves, images, hair strands, captured people), as
//! [`Sequences`](lifelike_representation::spline_transformer::Sequences).
//!
//! [`CurveSequences`] are the families of 3.3.1, [`ImageSequences`] the patches of 3.3.2. [`HumansPlan`] makes windows
//! of people's joint rotations ([`humans`], 3.3.3). [`StrandSequences`] are the strands of 3.3.4. Table A.1's rows are
//! [`Experiment`]s.

mod curves;
mod data_plan;
mod error;
mod experiments;
mod families;
mod hairstyles;
pub mod humans;
mod image_folder;
mod images;
mod pixels;
mod roughness;
mod strands;
mod subjects;

pub use curves::{CurveSequences, CurvesPlan, HELD_OUT_SEED};
pub use data_plan::DataPlan;
pub use error::SequencesError;
pub use experiments::Experiment;
pub use families::Family;
pub use hairstyles::{Hairstyle, Strand};
pub use image_folder::ImageFolder;
pub use images::{ImageSequences, ImagesPlan};
pub use strands::{StrandSequences, StrandsPlan};
pub use subjects::{HumansPlan, PeopleWindows, group_of};
