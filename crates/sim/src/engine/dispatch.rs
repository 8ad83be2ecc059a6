//! The engine's vectors, chosen when it is made: one compiled engine per instruction set.

use std::sync::Arc;

use lifelike_robot::Robot;
use lifelike_simd::prelude::*;
use lifelike_simd::{InstructionSet, Simd, Task};

use super::lanes::Pair;
use super::native::Native;
use super::vector_engine::{AnyVectors, VectorEngine};
use crate::error::SimError;

/// The engine with the vectors of an instruction set: sixteen environments to a vector, or to several as one.
///
/// # Errors
/// As [`super::LifelikeSimulation::new`].
pub fn engine(
    instructions: InstructionSet,
    robot: &Arc<Robot>,
    environments: usize,
    threads: usize,
) -> Result<Box<dyn AnyVectors>, SimError> {
    instructions.run(Make { robot, environments, threads })
}

struct Make<'a> {
    robot: &'a Arc<Robot>,
    environments: usize,
    threads: usize,
}

impl Task for Make<'_> {
    type Output = Result<Box<dyn AnyVectors>, SimError>;

    fn run<S: Simd>(self, _: S) -> Self::Output {
        let robot = self.robot.clone();
        // Only one of these is compiled.
        Ok(match const { <S::f32s as SimdBase<S>>::LEN } {
            16 => Box::new(VectorEngine::<Native<S>>::new(robot, self.environments, self.threads)?),
            8 => Box::new(VectorEngine::<Pair<Native<S>>>::new(robot, self.environments, self.threads)?),
            _ => Box::new(VectorEngine::<Pair<Pair<Native<S>>>>::new(robot, self.environments, self.threads)?),
        })
    }
}
