//! The set-up of the environments: everything that no step changes.

use std::sync::Arc;

use lifelike_checkpoint::rng::stream;
use lifelike_robot::{ActionMap, ObservationSpec, ReferenceLibrary, Robot};
use lifelike_sim::{Ground, Simulation};
use rand_chacha::ChaCha8Rng;

use super::sensor_model::SensorModel;
use crate::observe::Observer;
use crate::plan::TrackerPlan;
use crate::rewards::Reward;
use crate::{FromInput, TrackerError};

/// Plan, robot and references, and what follows from them.
pub(super) struct Setup {
    /// The plan, with its numbers for this robot's size.
    pub(super) plan: TrackerPlan,
    pub(super) robot: Arc<Robot>,
    pub(super) library: Arc<ReferenceLibrary>,
    pub(super) observer: Observer,
    pub(super) sensors: SensorModel,
    pub(super) ground: Ground,
    pub(super) actions: ActionMap,
    /// Divisors of the reward's errors, `[F]`; empty where it normalises none.
    pub(super) divisor: Vec<f32>,
    /// Number of the first environment among those of all processes: what its randomness is addressed by.
    pub(super) first: usize,
    pub(super) processes: usize,
}

impl Setup {
    /// Returns the set-up of one of several processes.
    ///
    /// # Errors
    /// The library or the simulation is of another robot or size than the plan says.
    pub(super) fn new(
        plan: &TrackerPlan,
        robot: Arc<Robot>,
        library: Arc<ReferenceLibrary>,
        simulation: &dyn Simulation,
        (process, processes): (usize, usize),
    ) -> Result<Self, TrackerError> {
        expect("environments of the simulation", plan.ppo.environments, simulation.len())?;
        expect("latent size of the library", plan.inputs.latent, library.latent)?;
        if simulation.robot().layout != robot.layout || library.layout != robot.layout {
            let what = "joints and end effectors of simulation and library";
            return Err(TrackerError::mismatch(what, format!("those of robot '{}'", robot.name), "others"));
        }
        let plan = plan.scaled_to(&robot)?;
        let spec = ObservationSpec::new(&robot, plan.inputs.clone(), plan.anchor);
        let spec = if plan.linear_velocity { spec } else { spec.without_linear_velocity() };
        spec.check_sizes()?;
        Ok(Self {
            sensors: SensorModel::new(plan.sensors, spec.size(), spec.parts()),
            observer: Observer::new(&robot, spec),
            ground: Ground::of(simulation, &robot),
            actions: ActionMap::new(plan.action, &robot),
            divisor: match &plan.reward {
                Reward::Thesis(reward) => reward.floors.apply(&library.layout, &library.deviation),
                Reward::Exponential(_) => Vec::new(),
            },
            first: process * plan.ppo.environments,
            plan,
            processes,
            robot,
            library,
        })
    }

    /// Returns the stream of random numbers of environment `i` for a purpose at a time.
    pub(super) fn stream(&self, purpose: &str, i: usize, time: u64) -> ChaCha8Rng {
        stream(self.plan.seed, purpose, (self.first + i) as u64, time)
    }

    /// Returns how far an output of 1 moves a joint target from its base (rad).
    pub(super) fn action_scale(&self) -> f32 {
        self.plan.action.scale() as f32
    }

    /// Returns the number of steps after which an episode is truncated.
    pub(super) fn longest_episode(&self) -> u64 {
        (self.plan.episode.seconds * self.robot.control_hz).round().max(1.0) as u64
    }
}

/// Checks a size.
pub(super) fn expect(what: &str, expected: usize, got: usize) -> Result<(), TrackerError> {
    if expected == got {
        return Ok(());
    }
    Err(TrackerError::mismatch(what, expected, got))
}
