//! Many environments in which a policy follows references: what PPO collects experience in.
//!
//! Time: the state at t is compared with frame t. The policy sees the state at t and frame t+1 (and z_{t+1}), acts, the
//! simulation goes one step, and the reward compares the state at t+1 with frame t+1.

mod begin;
mod saving;
mod vector;

use std::sync::Arc;

use lifelike_checkpoint::rng::stream;
use lifelike_robot::{ActionMap, ActionSpec, ObservationSpec, ReferenceLibrary, Robot};
use lifelike_sim::randomization::{PushSchedule, RandomizationSpec};
use lifelike_sim::{BatchState, Drive, Ground, Simulation};
use lifelike_train::StepOutcome;
use rayon::prelude::*;

use super::episode::Episode;
use super::judge::{Judge, Scratch};
use super::observe::Observer;
use super::plan::{Termination, TrackerPlan};
use super::rewards::Reward;
use super::senses::Senses;
use super::starts::{Coverage, StartSampler};
use super::tally::Tally;
use crate::TrackerError;

/// Environments that one thread takes at a time.
const CHUNK: usize = 16;

/// The environments, between two steps.
pub struct Environment {
    plan: TrackerPlan,
    /// Number of the first environment among those of all processes: what its randomness is addressed by.
    first: usize,
    processes: usize,
    robot: Arc<Robot>,
    library: Arc<ReferenceLibrary>,
    simulation: Box<dyn Simulation>,
    observer: Observer,
    ground: Ground,
    actions: ActionMap,
    divisor: Vec<f32>,
    sampler: StartSampler,
    senses: Senses,
    /// Randomisation, limits and the factor on penalties at this stage of the curriculum.
    randomization: RandomizationSpec,
    limits: Termination,
    smoothness: f32,
    /// One per environment where the plan has pushes, else none.
    pushes: Vec<PushSchedule>,
    episodes: Vec<Episode>,
    targets: Vec<f32>,
    actor: Vec<f32>,
    critic: Vec<f32>,
    steps: u64,
    tally: Tally,
}

impl Environment {
    /// Environments in fresh episodes.
    ///
    /// # Errors
    /// The library or the simulation is of another robot or size than the plan says.
    pub fn new(
        plan: &TrackerPlan,
        robot: Arc<Robot>,
        library: Arc<ReferenceLibrary>,
        simulation: Box<dyn Simulation>,
    ) -> Result<Self, TrackerError> {
        Self::among(plan, robot, library, simulation, (0, 1))
    }

    /// The same as that process of so many (counted from 0), which all have as many environments.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn among(
        plan: &TrackerPlan,
        robot: Arc<Robot>,
        library: Arc<ReferenceLibrary>,
        simulation: Box<dyn Simulation>,
        (process, processes): (usize, usize),
    ) -> Result<Self, TrackerError> {
        let n = plan.ppo.environments;
        expect("environments of the simulation", n, simulation.len())?;
        expect("latent size of the library", plan.inputs.latent, library.latent)?;
        if simulation.robot().layout != robot.layout || library.layout != robot.layout {
            return Err(TrackerError::Mismatch {
                what: "joints and end effectors of simulation and library".into(),
                expected: format!("those of robot '{}'", robot.name),
                got: "others".into(),
            });
        }
        let spec = ObservationSpec::new(&robot, plan.inputs.clone(), plan.anchor);
        let spec = if plan.linear_velocity { spec } else { spec.without_linear_velocity() };
        let observer = Observer::new(&robot, spec);
        let bin = (0.5 * robot.control_hz).round() as usize;
        let divisor = match &plan.reward {
            Reward::Thesis(reward) => reward.floors.apply(&library.layout, &library.deviation),
            Reward::Exponential(_) => Vec::new(),
        };
        let mut environment = Self {
            actions: ActionMap::new(plan.action, &robot),
            divisor,
            sampler: StartSampler::new(plan.starts, &library.starts, bin, 2 * bin),
            senses: Senses::new(plan.senses, observer.spec()),
            randomization: plan.randomization.clone(),
            limits: plan.termination,
            smoothness: 1.0,
            pushes: vec![
                PushSchedule { steps: 0, active: None };
                if plan.randomization.pushes.is_some() { n } else { 0 }
            ],
            episodes: vec![Episode::new(robot.joints()); n],
            targets: vec![0.0; n * robot.joints()],
            actor: vec![0.0; n * observer.actor_size()],
            critic: vec![0.0; n * observer.critic_size()],
            steps: 0,
            tally: Tally::new(library.clips()),
            plan: plan.clone(),
            first: process * n,
            processes,
            ground: Ground::of(simulation.as_ref(), &robot),
            robot,
            library,
            simulation,
            observer,
        };
        environment.advance_curriculum();
        environment.reset(&(0..n).collect::<Vec<_>>(), None)?;
        Ok(environment)
    }

    /// Number of environments N.
    pub fn len(&self) -> usize {
        self.episodes.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.episodes.is_empty()
    }

    /// What the randomness of environment `i` is addressed by.
    pub fn address(&self, i: usize) -> u64 {
        (self.first + i) as u64
    }

    /// The layout of what the policy sees.
    pub fn observation(&self) -> &ObservationSpec {
        self.observer.spec()
    }

    /// Length of a row of [`Self::actor_rows`].
    pub fn actor_size(&self) -> usize {
        self.observer.actor_size()
    }

    /// Length of a row of [`Self::critic_rows`].
    pub fn critic_size(&self) -> usize {
        self.observer.critic_size()
    }

    /// What the policy sees now, `[N, O]`, not normalised.
    pub fn actor_rows(&self) -> &[f32] {
        &self.actor
    }

    /// What the value function sees now, `[N, P]`: the same and more, not normalised.
    pub fn critic_rows(&self) -> &[f32] {
        &self.critic
    }

    /// What they stand on.
    pub fn ground(&self) -> &Ground {
        &self.ground
    }

    /// The simulation, to disturb it.
    pub fn simulation_mut(&mut self) -> &mut dyn Simulation {
        self.simulation.as_mut()
    }

    /// The simulated states.
    pub fn state(&self) -> &BatchState {
        self.simulation.state()
    }

    /// The episodes, with what the last step gave.
    pub fn episodes(&self) -> &[Episode] {
        &self.episodes
    }

    /// What happened since [`Tally::start`].
    pub fn tally(&self) -> &Tally {
        &self.tally
    }

    /// The same, to begin counting anew.
    pub fn tally_mut(&mut self) -> &mut Tally {
        &mut self.tally
    }

    /// How much of the motion was ever seen, and the floor below which no stretch of it is neglected.
    pub fn coverage(&self) -> (Coverage, f64) {
        (self.sampler.coverage(), self.sampler.floor())
    }

    /// Once per iteration: puts what was learnt about hard stretches into force, and the curriculum's next stage.
    pub fn refresh(&mut self) {
        self.sampler.refresh();
        self.advance_curriculum();
    }

    fn advance_curriculum(&mut self) {
        let [share, forgiving, smoothness] = self.plan.curriculum.at(self.steps * (self.len() * self.processes) as u64);
        if self.plan.curriculum.randomization.is_some() {
            self.randomization = self.plan.randomization.scaled(share);
        }
        if self.plan.curriculum.termination.is_some() {
            self.limits = self.plan.termination.scaled(forgiving);
        }
        self.smoothness = smoothness as f32;
    }

    /// One step of all environments with the policy's outputs `[N, J]`. Environments whose episode ends begin another.
    ///
    /// # Errors
    /// `outputs` has the wrong length; the simulation fails as a whole. A single environment that diverges is no error:
    /// its episode ends with no reward, is counted and begun anew.
    pub fn step(&mut self, outputs: &[f32], outcome: &mut StepOutcome) -> Result<(), TrackerError> {
        let joints = self.robot.joints();
        expect("outputs of the policy", self.len() * joints, outputs.len())?;
        self.aim(outputs);
        self.push()?;
        self.simulation.step(Drive::Targets(&self.targets))?;
        self.steps += 1;
        self.judge();
        let width = self.critic_size();
        outcome.clear();
        let mut ended = Vec::new();
        for (i, episode) in self.episodes.iter().enumerate() {
            outcome.rewards.push(episode.reward());
            outcome.terminated.push(episode.failed.is_some());
            outcome.truncated.push(episode.cut);
            self.tally.step(episode, self.library.clip_of(episode.frame));
            if episode.cut {
                outcome.final_critic_observations.extend_from_slice(&self.critic[i * width..(i + 1) * width]);
            }
            if let Some((from, to)) = episode.finished {
                self.sampler.record(from, to, false);
            }
            if episode.ended() {
                self.sampler.record(episode.stretch, episode.frame, episode.failed.is_some());
                ended.push(i);
            }
        }
        if ended.is_empty() { Ok(()) } else { self.reset(&ended, None) }
    }

    /// Joint targets from the policy's outputs.
    fn aim(&mut self, outputs: &[f32]) {
        let joints = self.robot.joints();
        let (actions, library) = (&self.actions, &self.library);
        let rows =
            self.episodes.iter_mut().zip(outputs.chunks_exact(joints)).zip(self.targets.chunks_exact_mut(joints));
        for ((episode, output), target) in rows {
            std::mem::swap(&mut episode.before, &mut episode.oldest);
            std::mem::swap(&mut episode.last, &mut episode.before);
            for (last, y) in episode.last.iter_mut().zip(output) {
                // A policy that says NaN says nothing; its environment goes on, and the update will not step with it.
                *last = if y.is_finite() { ActionSpec::clamp_output(*y) } else { 0.0 };
            }
            actions.write(&episode.last, library.joints_at(library.ahead(episode.frame, 1)), target);
            target.iter_mut().zip(&episode.offset).for_each(|(t, o)| *t -= o);
            Senses::delay(target, episode);
        }
    }

    /// Begins and ends random pushes.
    fn push(&mut self) -> Result<(), TrackerError> {
        let Some(spec) = &self.randomization.pushes else {
            // Nobody pushes at this stage: a push that lasts from the one before ends.
            for (i, schedule) in self.pushes.iter_mut().enumerate() {
                if schedule.active.take().is_some() {
                    self.simulation.clear_pushes(i);
                }
            }
            return Ok(());
        };
        for (i, schedule) in self.pushes.iter_mut().enumerate() {
            let mut rng = stream(self.plan.seed, "push", (self.first + i) as u64, self.steps);
            schedule.advance(spec, self.simulation.as_mut(), i, &mut rng)?;
        }
        Ok(())
    }

    /// Rewards, ends and observations after a step, each environment by itself.
    fn judge(&mut self) {
        let this = Judge {
            plan: &self.plan,
            robot: &self.robot,
            library: &self.library,
            observer: &self.observer,
            ground: &self.ground,
            sampler: &self.sampler,
            senses: &self.senses,
            limits: self.limits,
            smoothness: self.smoothness,
            divisor: &self.divisor,
            state: self.simulation.state(),
            step: self.steps,
            first: self.first,
            longest: (self.plan.episode.seconds * self.robot.control_hz).round().max(1.0) as u64,
        };
        let (a, c) = (self.observer.actor_size(), self.observer.critic_size());
        self.episodes
            .par_chunks_mut(CHUNK)
            .zip(self.actor.par_chunks_mut(CHUNK * a))
            .zip(self.critic.par_chunks_mut(CHUNK * c))
            .enumerate()
            .for_each_init(Scratch::new, |scratch, (chunk, ((episodes, actor), critic))| {
                let rows = episodes.iter_mut().zip(actor.chunks_exact_mut(a)).zip(critic.chunks_exact_mut(c));
                for (k, ((episode, actor), critic)) in rows.enumerate() {
                    this.judge(chunk * CHUNK + k, episode, scratch, actor, critic);
                }
            });
    }
}

fn expect(what: &str, expected: usize, got: usize) -> Result<(), TrackerError> {
    if expected == got {
        return Ok(());
    }
    Err(TrackerError::Mismatch { what: what.into(), expected: expected.to_string(), got: got.to_string() })
}
