//! Floor 7: how well a policy follows: the measures of thesis Table 4.3 and of today's trackers, and why it fails where it fails.
//!
//! The main path: [`evaluate`] makes a [`Course`] (the episodes) and runs a [`Policy`](lifelike_tracking::Policy) on it in
//! physics, from states of the reference, under a [`Hardship`] where one is asked for →
//! [`Rollout`] (what was asked and what happened, frame by frame) → [`EpisodeScore`] → [`Evaluation`] (per clip and
//! overall) → [`Evaluation::tables`] and [`Evaluation::playbacks`] for terminal and report, `serde` for `--json`.
//!
//! Everything between a rollout and a score is a pure function, one idea per file:
//!
//! | file | measure |
//! | --- | --- |
//! | `accuracy` | joint error (deg), end-effector error (m), body error (m) |
//! | `drift` | where the root is, and where it faces, against the reference (m, deg) |
//! | `smoothness` | jerk (rad/s³) |
//! | `fall` | what counts as a fall |
//! | `explain` | a failure in plain words, and what change of the clip would help |
//! | `robustness` | all of it against the size of a disturbance |
//! | `failure` | which body left first, which joints were at their limit, when the ground was lost |

pub mod accuracy;
mod course;
pub mod drift;
mod driver;
mod error;
pub mod explain;
pub mod failure;
pub mod fall;
mod hardship;
mod options;
mod recorder;
pub mod robustness;
mod rollout;
pub mod schedule;
mod score;
pub mod smoothness;
mod tables;
#[cfg(test)]
mod tests;

pub use course::{Course, Task};
pub use driver::evaluate;
pub use error::EvaluationError;
pub use failure::Failure;
pub use hardship::{Hardship, Stretch, TimedPush};
pub use options::EvaluationOptions;
pub use rollout::{Cause, Names, Outcome, Rollout, Snapshot};
pub use score::{ClipScore, EpisodeScore, Evaluation};
