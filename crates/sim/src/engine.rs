//! Our own engine: MuJoCo's model of the dynamics, many environments at once on SIMD vectors, nothing but Rust.
//!
//! The main path: [`tree`] (constants of a robot) → [`block`] → [`vector_engine`] (all blocks, on all cores) →
//! [`dispatch`] (choice of vectors) → [`LifelikeSimulation`]. A [`block`] is the environments of a vector and their
//! physics step: actuators, [`rigid_body`], [`constraints`], integration. Numbers are [`lanes`], one environment each;
//! [`spatial`] is their algebra.
//!
//! A block's result is a function of its own numbers, lane by lane. Results are therefore bit-identical for any number
//! of threads and any place in the batch. One environment never affects another.
//!
//! The model:
//!
//! - trees of free, ball, hinge and slide joints with armature, damping, springs, dry friction and limits;
//! - a fixed or floating root, and loops closed by welds and ball joints (`<equality>`);
//! - the actuator law of `robot::actuator` at every substep;
//! - spheres, capsules and boxes in contact with level or uneven ground and each other, with pyramids of friction.
//!
//! [`unsupported`] lists the parts of a robot that are not simulated.

mod block;
mod box_collision;
mod closure;
mod closure_rows;
mod collision;
mod command;
mod constraint_wrenches;
mod constraints;
mod contact;
mod coupling;
mod curved;
mod dispatch;
mod dof_chain;
mod factors;
mod invweight;
mod lanes;
mod model_parameters;
mod native;
mod outputs;
mod pair;
pub mod profile;
mod profiler;
mod rigid_body;
mod row_block;
mod shapes;
mod solver_context;
mod spatial;
mod surface;
mod tree;
mod unsupported;
mod vector_engine;

use std::sync::Arc;

use lifelike_robot::Robot;
use lifelike_simd::InstructionSet;

use crate::batched::Batched;
use crate::error::SimError;
use crate::simulation::Simulation;
use crate::terrain::Terrain;
use profile::Counted;
use profiler::Profiler;
use vector_engine::{AnyVectors, VectorEngine};

pub(crate) use surface::{SOLIMP, SOLREF};
pub use unsupported::unsupported;

/// The name of this engine.
pub const ENGINE: &str = "lifelike";

/// N environments of one robot in our engine.
pub type LifelikeSimulation = Batched<Box<dyn AnyVectors>>;

/// Returns the number of pairs of a robot's own geoms that may collide.
pub fn self_contacts(robot: &Robot) -> usize {
    shapes::collision_pairs(&robot.character).len()
}

/// M a + c = f.
#[derive(Debug, Clone, PartialEq)]
pub struct Dynamics {
    /// Mass matrix M, `[nv, nv]`.
    pub mass: Vec<f64>,
    /// Bias forces c: Coriolis, centrifugal, gravity.
    pub bias: Vec<f64>,
    /// Acceleration a.
    pub acceleration: Vec<f64>,
}

impl LifelikeSimulation {
    /// `environments` copies of a robot, each in its default pose with the root where the model puts it, stepped by
    /// `threads` threads (0: one per processor), with the vector instructions of this process.
    ///
    /// # Errors
    /// [`SimError::Model`] for ground that is not level, gravity compensation, and springs on balls.
    pub fn new(robot: Arc<Robot>, environments: usize, threads: usize) -> Result<Self, SimError> {
        Self::with_instructions(InstructionSet::chosen(), robot, environments, threads)
    }

    /// Likewise, with other vector instructions: the same bits at another speed.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn with_instructions(
        instructions: InstructionSet,
        robot: Arc<Robot>,
        environments: usize,
        threads: usize,
    ) -> Result<Self, SimError> {
        let engine = dispatch::engine(instructions, &robot, environments, threads)?;
        Ok(Self::with_engine(robot, environments, engine))
    }

    /// Likewise in double precision and without vectors: what an oracle compares with.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn in_double_precision(robot: Arc<Robot>, environments: usize, threads: usize) -> Result<Self, SimError> {
        let engine = VectorEngine::<Counted>::new(robot.clone(), environments, threads)?;
        Ok(Self::with_engine(robot, environments, Box::new(engine)))
    }

    /// Returns the memory of each environment: state, parameters, forces and outputs (bytes).
    pub fn bytes_per_environment(&self) -> usize {
        self.engine.bytes_per_environment() + size_of::<f32>() * self.sizes.columns() + 1
    }

    /// Returns how many environments are stepped together.
    pub fn lanes(&self) -> usize {
        self.engine.lanes()
    }

    /// Sets another number of visits of all constraint rows per physics step: more are nearer to MuJoCo's converged forces.
    #[must_use]
    pub fn with_iterations(mut self, iterations: usize) -> Self {
        self.engine.set_iterations(iterations);
        self
    }

    /// Puts uneven ground in place of the level one.
    #[must_use]
    pub fn with_terrain(mut self, terrain: Arc<Terrain>) -> Self {
        self.engine.set_terrain(terrain);
        self
    }

    /// Returns the equations of motion in a state under joint forces `applied`, constraints left out: what an oracle is asked
    /// about.
    ///
    /// # Errors
    /// As [`Simulation::reset`].
    pub fn dynamics(&mut self, position: &[f64], velocity: &[f64], applied: &[f64]) -> Result<Dynamics, SimError> {
        self.reset(&[0], position, velocity)?;
        Ok(self.engine.dynamics(applied))
    }

    fn step_profiled(&mut self, targets: &[f32], profiler: &mut dyn Profiler) {
        self.engine.step_profiled(targets, profiler);
    }
}
