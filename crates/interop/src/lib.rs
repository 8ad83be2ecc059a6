//! Policies of other stacks: ONNX out and in, with the layout of each stack.
//!
//! Every stack of the field writes its policies as ONNX, and each has its own contract. Contracts differ in the order of
//! observations, the order of joints, and the names in the file. A [`Dialect`] is one contract.
//!
//! - [`export()`] writes a [`lifelike_robot::Controller`] as the files that a stack reads.
//! - [`import()`] makes a controller of a stack's file, so that everything that takes a controller runs it.
//! - [`lint`] compares a layout with the statistics that the policy's own normalizer has seen.
//!
//! ```
//! use lifelike_interop::{Dialect, Motion, export};
//! use lifelike_robot::{Controller, Robot};
//! use std::sync::Arc;
//!
//! let robot = Arc::new(Robot::load("lima")?);
//! # let assets = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../lifelike/assets");
//! let controller = Controller::load(&assets.join("lima-path.controller.safetensors"), robot)?;
//! let files = export(&controller, Dialect::Onnx, Motion::None)?;
//! assert_eq!(files[0].name, "policy.onnx");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod dialect;
mod export;
mod graph;
mod import;
pub mod lint;
mod metadata;
pub mod proto;
mod reading;
mod reference;
mod urdf;
mod yaml;

pub use dialect::Dialect;
pub use export::{ExportedFile, Motion, export, terms};
pub use import::{Imported, import, joints_of};

use lifelike_robot::{FromInput, RobotError};

/// Metadata key of the rows that a reader can replay.
pub const GOLDEN: &str = "lifelike_golden";
/// Metadata key of the layout by our names.
pub const LAYOUT: &str = "lifelike_layout";

fn mismatch(what: impl ToString, expected: impl ToString, got: impl ToString) -> RobotError {
    RobotError::mismatch(what, expected, got)
}
