//! Floor 4: evaluation of controllers: the measures of thesis Table 4.3 and of today's trackers, and explanations of
//! falls. It runs the frozen controller, as a robot does, without training code.
//!
//! The main path: [`EvaluationSetup::evaluate`] → [`Rollout`] (reference and executed motion, frame by frame) →
//! [`EpisodeScore`] → [`Evaluation`] (per clip and overall). [`Evaluation::tables`] and [`Evaluation::playbacks`] serve
//! terminal and report, `serde` serves `--json`.
//!
//! [`EvaluationSetup::evaluate`] creates an [`EvaluationSuite`] (the episodes) and runs a
//! [`Controller`](lifelike_robot::Controller) on it in physics. Episodes start from states of the reference, optionally
//! under [`EpisodeConditions`].
//!
//! [`EvaluationSetup::evaluate_thesis`] is the thesis' own protocol beside it: fixed-length episodes, errors over all frames.
//!
//! ```
//! use lifelike_evaluation::{EvaluationOptions, EvaluationSetup};
//! use lifelike_robot::{Controller, Robot, clips};
//! use lifelike_sim::SimulationSpec;
//! use std::sync::Arc;
//!
//! let robot = Arc::new(Robot::load("lima")?);
//! # let assets = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../lifelike/assets");
//! let controller = Controller::load(&assets.join("lima-path.controller.safetensors"), Arc::clone(&robot))?;
//! let simulate = |terrain, environments| {
//!     SimulationSpec { terrain, ..SimulationSpec::new(environments) }.build(Arc::clone(&robot))
//! };
//! let setup = EvaluationSetup { controller: &controller, encoder: None, simulate: &simulate, environments: 16 };
//! let walk = clips::builtin(&robot).clips.into_iter().filter(|clip| clip.name == "walk").collect::<Vec<_>>();
//! let evaluation = setup.evaluate(&walk, &EvaluationOptions::default(), |_, _| {})?;
//! assert_eq!(evaluation.overall.survival, 1.0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Everything between a rollout and a score is a pure function, one idea per file:
//!
//! | file | measure |
//! | --- | --- |
//! | `accuracy` | joint error (deg), end-effector error (m), body error (m) |
//! | `root` | velocities (m/s, rad/s) and orientation (deg) of the root |
//! | `drift` | position and heading of the root against the reference (m, deg) |
//! | `smoothness` | jerk (rad/s³) |
//! | `slip` | soles that slide while they stand (m/s) |
//! | `steps` | steps of the reference that are taken |
//! | `heat` | squared torque beside the continuous rating |
//! | `field` | HumanTracker's rule, mjlab's key-body errors |
//! | `thesis` | errors over all frames of fixed-length episodes |
//! | `interval` | bootstrap intervals of means |
//! | `fall` | definition of a fall |
//! | `explain` | a failure in plain words, and the change of the clip that would help |
//! | `get_up` | robots that stand up after they were dropped |
//! | `robustness` | all of it against the size of a disturbance |
//! | `particles` | the motion that physics makes of a clip at its best |
//! | `verdict` | one verdict a clip, with its thresholds |
//! | `failure` | the body that left first, the joints at their limit, the moment the ground was lost |

pub mod accuracy;
pub mod drift;
mod episode;
mod error;
mod evaluate;
mod evaluation;
pub mod explain;
pub mod failure;
pub mod fall;
pub mod field;
pub mod get_up;
pub mod heat;
mod interval;
mod mcap;
mod options;
pub mod particles;
mod played;
mod recorder;
pub mod robustness;
mod rollout;
pub mod root;
mod runner;
pub mod schedule;
mod score;
mod setup;
pub mod slip;
pub mod smoothness;
pub mod steps;
mod suite;
mod tables;
#[cfg(test)]
mod tests;
mod thesis;
pub mod verdict;

pub use episode::{Episode, EpisodeConditions, ReferenceSegment, TimedPush};
pub use error::EvaluationError;
pub use evaluation::Evaluation;
pub use failure::Failure;
pub use interval::Intervals;
pub use mcap::mcap;
pub use options::EvaluationOptions;
pub use recorder::Recorder;
pub use rollout::{Cause, Names, Outcome, Rollout, Snapshot};
pub use runner::Moment;
pub use score::{ClipScore, EpisodeScore};
pub use setup::{EvaluationSetup, SimulationFactory};
pub use suite::EvaluationSuite;
pub use thesis::{ThesisErrors, ThesisEvaluation, ThesisProtocol, thesis_tables};
pub use verdict::Verdict;
