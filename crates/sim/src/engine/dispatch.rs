//! The engine's vectors, chosen when it is made: one compiled engine per instruction set and width.

use std::sync::Arc;

use lifelike_robot::Robot;
use lifelike_simd::prelude::*;
use lifelike_simd::{InstructionSet, Simd, Task};

use super::lanes::Lanes;
use super::native::{Native, fuses};
use super::pair::Pair;
use super::vector_engine::{AnyVectors, VectorEngine};
use crate::error::SimError;

/// Environments that are few enough for narrow vectors: a robot's twin, one that is looked at.
const FEW: usize = 8;

/// The engine with the vectors of an instruction set: sixteen environments to a vector, or to several as one. A few
/// environments get vectors of eight or four: those are through with a step earlier.
///
/// # Errors
/// As [`super::LifelikeSimulation::new`].
pub fn engine(
    instructions: InstructionSet,
    robot: &Arc<Robot>,
    environments: usize,
    threads: usize,
) -> Result<Box<dyn AnyVectors>, SimError> {
    // A machine that has 512 bits has 256 too.
    let narrow = environments <= FEW && instructions == InstructionSet::Avx512;
    let instructions = if narrow { InstructionSet::Avx2 } else { instructions };
    instructions.run(Make { robot, environments, threads })
}

struct Make<'a> {
    robot: &'a Arc<Robot>,
    environments: usize,
    threads: usize,
}

impl Make<'_> {
    fn with<V: Lanes>(self) -> Result<Box<dyn AnyVectors>, SimError> {
        Ok(Box::new(VectorEngine::<V>::new(self.robot.clone(), self.environments, self.threads)?))
    }
}

impl Task for Make<'_> {
    type Output = Result<Box<dyn AnyVectors>, SimError>;

    fn run<S: Simd>(self, _: S) -> Self::Output {
        // What does not match is not compiled.
        match const { <S::f32s as SimdBase<S>>::LEN } {
            16 => self.with::<Native<S>>(),
            _ if self.environments <= FEW => self.with::<Native<S>>(),
            8 => self.with::<Pair<Native<S>>>(),
            // Where a fused product is a function, more of them at once gain nothing.
            _ if const { !fuses::<S>() } => self.with::<Native<S>>(),
            _ => self.with::<Pair<Pair<Native<S>>>>(),
        }
    }
}
