//! Floor 4: training that knows no task.

pub mod collective;
mod error;
pub mod gae;
pub mod gaussian;
pub mod limits;
pub mod losses;
pub mod networks;

pub use error::TrainError;
pub use limits::PlanError;
