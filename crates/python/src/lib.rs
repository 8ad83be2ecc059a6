//! The Python package `lifelike`: classes and functions over the front doors of the crates, without logic of its own.
//!
//! The main path: [`robot`] → [`clip`] → [`controller`] in a [`simulation`] → [`evaluation`]. A policy learns in
//! [`environment`], or in [`training`] by our own PPO. [`generation`] makes motion from sentences. The pure-Python half
//! of the package (`python/lifelike/`) adds types, `gymnasium` and `rsl_rl`.
//!
//! Arrays go in as anything that numpy converts, and are copied. Outputs of physics come back as read-only [`arrays`]
//! over the memory of the engine. Long calls release the GIL and react to Ctrl-C ([`interrupt`]).

mod arrays;
mod clip;
mod controller;
mod environment;
mod error;
mod evaluation;
mod generation;
mod interrupt;
mod robot;
mod simulation;
mod training;

use pyo3::prelude::*;

/// Compiled half of the package `lifelike`.
#[pymodule]
mod _lifelike {
    use pyo3::prelude::*;

    #[pymodule_export]
    use crate::{
        clip::Clip, clip::load_clips, clip::retarget, controller::Controller, controller::ControllerRun,
        environment::TrackingEnvironment, error::Error, evaluation::evaluate, generation::generate, main, robot::Robot,
        simulation::SavedState, simulation::Simulation, training::train_tracker,
    };

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}

/// Runs the command `lifelike` with its arguments, the program's name first, and returns the exit code.
#[pyfunction]
fn main(py: Python<'_>, arguments: Vec<String>) -> u8 {
    py.detach(|| lifelike::Cli::of(arguments).exit_code())
}
