//! Motion as a few control points of a latent curve, and editing by them (thesis 3.3.3, Fig. 3.6).
//!
//! The main path: clips → [`Poses`] (numbers that do not depend on where on the ground a clip happens) →
//! [`MotionSplinePlan`] and [`super::spline_transformer::SequenceTrainer`] → [`MotionSpline`], one file →
//! [`SplinedClip`], a clip as segments of control points with what they leave out → [`Edit`]s of the control points →
//! a clip again.

mod comparison;
mod edit;
mod model;
mod plan;
mod poses;
mod space;
mod splined;
#[cfg(test)]
mod testing;

pub use comparison::WindowErrors;
pub use edit::Edit;
pub use model::{MotionSpline, SplitClips, Usual};
pub use plan::MotionSplinePlan;
pub use poses::Poses;
pub use space::PoseSpace;
pub use splined::{ClipErrors, Playing, Segment, SplinedClip};
