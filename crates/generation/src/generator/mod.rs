//! A trained generator: one file, and motions of a robot from sentences.

mod file;
mod given;
mod grounded;
mod sample;

pub use file::{Generator, GeneratorHeader};
pub use given::{Given, Pose, join};
pub use grounded::grounded;
pub use sample::{Generated, SampleOptions};

/// Name of the file that a training leaves in its folder.
pub const FILE: &str = "motion.generator.safetensors";
