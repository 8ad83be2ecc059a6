//! Profile of a physics step: time and arithmetic of each stage.

use std::cell::Cell;
use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};
use std::sync::Arc;
use std::time::Instant;

use lifelike_robot::Robot;
use lifelike_simd::Number;

use super::LifelikeSimulation;
use super::lanes::{Scalar, SingleLane};
use super::profiler::Profiler;
pub use super::profiler::Stage;
use super::vector_engine::VectorEngine;
use crate::error::SimError;
use crate::simulation::{Drive, Simulation};
use crate::terrain::Terrain;

/// Wall time of each stage in every step.
struct WallTime {
    last: Instant,
    steps: Vec<[f64; Stage::ALL.len()]>,
}

impl WallTime {
    /// The median over the steps: what other programs take from a few of them does not count.
    fn typical(&self, stage: Stage) -> f64 {
        let mut seconds: Vec<f64> = self.steps.iter().map(|step| step[stage as usize]).collect();
        seconds.sort_by(f64::total_cmp);
        seconds[seconds.len() / 2]
    }
}

impl Profiler for WallTime {
    fn begin(&mut self) {
        self.steps.push([0.0; Stage::ALL.len()]);
        self.last = Instant::now();
    }
    fn end_stage(&mut self, stage: Stage) {
        let now = Instant::now();
        if let Some(step) = self.steps.last_mut() {
            step[stage as usize] += (now - self.last).as_secs_f64();
        }
        self.last = now;
    }
}

thread_local! {
    static OPERATIONS: Cell<u64> = const { Cell::new(0) };
}

/// Floating-point operations of each stage.
struct Counter {
    last: u64,
    operations: [u64; Stage::ALL.len()],
}

impl Profiler for Counter {
    fn begin(&mut self) {
        self.last = OPERATIONS.get();
    }
    fn end_stage(&mut self, stage: Stage) {
        let now = OPERATIONS.get();
        self.operations[stage as usize] += now - self.last;
        self.last = now;
    }
}

/// A number of double precision that counts what is done with it. The engine that oracles are compared with is made of these
/// too, so that the program has one engine less.
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd, Default)]
pub(super) struct Counted(f64);

#[inline(always)]
fn counted(operations: u64, value: f64) -> Counted {
    OPERATIONS.set(OPERATIONS.get() + operations);
    Counted(value)
}

macro_rules! operator {
    ($trait:ident, $method:ident, $op:tt) => {
        impl $trait for Counted {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                counted(1, self.0 $op other.0)
            }
        }
    };
}
operator!(Add, add, +);
operator!(Sub, sub, -);
operator!(Mul, mul, *);
operator!(Div, div, /);

impl Neg for Counted {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self(-self.0)
    }
}

/// Environments of the simulation that is timed: one vector's.
const SIMULATED: usize = 16;

/// Operations of a function that is written out as a polynomial.
const POLYNOMIAL: u64 = 30;

impl Number for Counted {
    #[inline(always)]
    fn from_f64(value: f64) -> Self {
        Self(value)
    }
    #[inline(always)]
    fn least(self, other: Self) -> Self {
        counted(1, self.0.least(other.0))
    }
    #[inline(always)]
    fn most(self, other: Self) -> Self {
        counted(1, self.0.most(other.0))
    }
    #[inline(always)]
    fn tanh(self) -> Self {
        counted(POLYNOMIAL, Number::tanh(self.0))
    }
    #[inline(always)]
    fn tanh_ratio(self) -> Self {
        counted(POLYNOMIAL, self.0.tanh_ratio())
    }
    #[inline(always)]
    fn select_gt(self, limit: Self, yes: Self, no: Self) -> Self {
        if self > limit { yes } else { no }
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        counted(1, self.0.sqrt())
    }
    #[inline(always)]
    fn exp(self) -> Self {
        counted(POLYNOMIAL, self.0.exp())
    }
    #[inline(always)]
    fn powf(self, exponent: Self) -> Self {
        counted(2 * POLYNOMIAL, self.0.powf(exponent.0))
    }
}

impl AddAssign for Counted {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl SubAssign for Counted {
    #[inline(always)]
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}

impl Scalar for Counted {
    #[inline(always)]
    fn new(value: f64) -> Self {
        Self(value)
    }
    #[inline(always)]
    fn to_f64(self) -> f64 {
        self.0
    }
}

impl SingleLane for Counted {
    #[inline(always)]
    fn call<R>(f: impl FnOnce() -> R) -> R {
        f64::call(f)
    }
    #[inline(always)]
    fn fused(self, a: Self, b: Self) -> Self {
        counted(2, self.0.fused(a.0, b.0))
    }
    #[inline(always)]
    fn sine_and_cosine(self) -> (Self, Self) {
        let (sin, cos) = self.0.sine_and_cosine();
        (counted(POLYNOMIAL, sin), Self(cos))
    }
}

/// One stage, per physics step of one environment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cost {
    /// The stage.
    pub stage: Stage,
    /// Time of one core (s).
    pub seconds: f64,
    /// Floating-point operations; a multiplication and an addition are two.
    pub operations: f64,
}

/// Measures all stages while a robot moves: noisy targets around its default pose for `steps` policy steps, put back to
/// `position` now and then.
///
/// Operations are counted, not estimated: the same code runs on a number that counts.
///
/// # Errors
/// As [`LifelikeSimulation::new`].
pub fn costs(
    robot: &Arc<Robot>,
    terrain: Option<&Arc<Terrain>>,
    position: &[f64],
    steps: usize,
) -> Result<Vec<Cost>, SimError> {
    let mut watch = WallTime { last: Instant::now(), steps: Vec::new() };
    let mut simulation = LifelikeSimulation::new(robot.clone(), SIMULATED, 1)?;
    run(&mut simulation, terrain, position, steps, &mut watch)?;
    let mut counter = Counter { last: OPERATIONS.get(), operations: [0; Stage::ALL.len()] };
    let counting = steps.div_ceil(20);
    let counted = Box::new(VectorEngine::<Counted>::new(robot.clone(), 1, 1)?);
    run(&mut LifelikeSimulation::with_engine(robot.clone(), 1, counted), terrain, position, counting, &mut counter)?;
    let cost = |stage: Stage| Cost {
        stage,
        seconds: watch.typical(stage) / (robot.substeps * simulation.lanes()) as f64,
        operations: counter.operations[stage as usize] as f64 / (counting * robot.substeps) as f64,
    };
    Ok(Stage::ALL.map(cost).into())
}

fn run(
    simulation: &mut LifelikeSimulation,
    terrain: Option<&Arc<Terrain>>,
    position: &[f64],
    steps: usize,
    profiler: &mut dyn Profiler,
) -> Result<(), SimError> {
    if let Some(terrain) = terrain {
        simulation.engine.set_terrain(terrain.clone());
    }
    let (robot, lanes) = (simulation.robot().clone(), simulation.len());
    let joints = robot.joints();
    let targets = |step: usize| -> Vec<f32> {
        let wriggle = |i: usize| 0.1 * ((i * 7919 + step * 104_729) as f32).sin();
        (0..lanes * joints).map(|i| robot.default_pose[i % joints] as f32 + wriggle(i)).collect()
    };
    // On its feet first, then measured; and put back on them now and then.
    let velocity = vec![0.0; robot.character.nv];
    for step in 0..steps {
        if step % 25 == 0 {
            for id in 0..lanes {
                simulation.reset(&[id], position, &velocity)?;
            }
            simulation.step(Drive::Targets(&targets(step)))?;
        }
        simulation.step_profiled(&targets(step), profiler);
    }
    Ok(())
}
