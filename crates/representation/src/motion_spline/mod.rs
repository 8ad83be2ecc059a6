//! Motion as a few control points of a latent curve, and editing by them (thesis 3.3.3, Fig. 3.6).
//!
//! The main path: clips → [`Poses`] → [`MotionSplinePlan`] and [`super::spline_transformer::SequenceTrainer`] →
//! [`MotionSpline`], one file → [`SplinedClip`] → [`Edit`]s → a clip. [`Poses`] do not depend on a clip's place on the
//! ground. A [`SplinedClip`] has segments of control points and their residual; [`Edit`]s change the control points.

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
