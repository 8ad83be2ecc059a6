//! Many environments in which a policy follows references: PPO collects its experience here.
//!
//! Time: the state at t is compared with frame t. The policy observes the state at t and frame t+1 (and z_{t+1}) and
//! acts. The simulation makes one step, and the reward compares the state at t+1 with frame t+1.

mod checkpoint;
mod evaluator;
mod frozen;
mod reserved;
mod reset;
mod sensor_model;
mod setup;
mod soles;
mod stage;
mod start;
mod state;
pub mod statistics;
mod teachers;
mod vector;

use std::sync::Arc;

use lifelike_robot::{ObservationSpec, ReferenceLibrary, Robot};
use lifelike_sim::randomization::PushSchedule;
use lifelike_sim::{BatchState, Drive, Simulation};
use lifelike_train::StepOutcome;
use rayon::prelude::*;

use self::evaluator::StepEvaluator;
use self::reserved::Reserved;
use self::sensor_model::delay_targets;
use self::setup::{Setup, expect};
use self::soles::Soles;
use self::stage::Stage;
pub use self::start::Start;
use self::statistics::EpisodeStatistics;
use self::teachers::Teachers;
use crate::TrackerError;
use crate::episode::Episode;
use crate::plan::TrackerPlan;
use crate::reference::{Coverage, RsiSampler};

/// Environments that one thread takes at a time.
const CHUNK: usize = 16;

/// The environments, between two steps.
pub struct Environment {
    setup: Setup,
    simulation: Box<dyn Simulation>,
    stage: Stage,
    rsi: RsiSampler,
    /// Samplers of environments that are kept for some of the clips, where some are.
    reserved: Option<Reserved>,
    /// One schedule per environment where the plan has pushes, else none.
    pushes: Vec<PushSchedule>,
    episodes: Vec<Episode>,
    rows: Rows,
    soles: Soles,
    teachers: Teachers,
    /// Numbers of the environments whose episodes the last step ended; kept for its memory.
    ended: Vec<usize>,
    steps: u64,
    statistics: EpisodeStatistics,
}

/// The numbers that go to the motors and to the networks, a row per environment.
struct Rows {
    /// Joint targets, `[N, J]` (rad).
    targets: Vec<f32>,
    /// Observations of the policy, `[N, O]`.
    actor: Vec<f32>,
    /// Observations of the value function, `[N, P]`.
    critic: Vec<f32>,
    /// Features of the environment that each thread is at: a row for each chunk.
    features: Vec<f32>,
}

impl Environment {
    /// Returns environments in fresh episodes.
    ///
    /// # Errors
    /// The library or the simulation is of another robot or size than the plan says.
    pub fn new(
        plan: &TrackerPlan,
        robot: Arc<Robot>,
        library: Arc<ReferenceLibrary>,
        simulation: Box<dyn Simulation>,
    ) -> Result<Self, TrackerError> {
        Self::distributed(plan, robot, library, simulation, (0, 1))
    }

    /// Returns the environments of one of several processes, given its number (from 0) and how many there are; all have
    /// as many environments.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn distributed(
        plan: &TrackerPlan,
        robot: Arc<Robot>,
        library: Arc<ReferenceLibrary>,
        simulation: Box<dyn Simulation>,
        process: (usize, usize),
    ) -> Result<Self, TrackerError> {
        let setup = Setup::new(plan, robot, library, simulation.as_ref(), process)?;
        let plan = &setup.plan;
        let (n, joints) = (plan.ppo.environments, setup.robot.joints());
        let bin = (0.5 * setup.robot.control_hz).round() as usize;
        let idle = PushSchedule { steps: 0, active: None };
        let mut environment = Self {
            stage: Stage::at(plan, 0),
            rsi: RsiSampler::new(plan.rsi, &setup.library.starts, bin, 2 * bin),
            reserved: None,
            pushes: vec![idle; if plan.randomization.pushes.is_some() { n } else { 0 }],
            episodes: vec![Episode::new(joints); n],
            rows: Rows {
                targets: vec![0.0; n * joints],
                actor: vec![0.0; n * setup.observer.actor_size()],
                critic: vec![0.0; n * setup.observer.critic_size()],
                features: vec![0.0; n.div_ceil(CHUNK) * setup.library.layout.size()],
            },
            soles: Soles::new(&setup.robot, &setup.library),
            teachers: Teachers::default(),
            ended: Vec::new(),
            steps: 0,
            statistics: EpisodeStatistics::new(setup.library.clips()),
            setup,
            simulation,
        };
        environment.reset(&(0..n).collect::<Vec<_>>(), None)?;
        Ok(environment)
    }

    /// Returns the number of environments N.
    pub fn len(&self) -> usize {
        self.episodes.len()
    }

    /// Returns true when there are none.
    pub fn is_empty(&self) -> bool {
        self.episodes.is_empty()
    }

    /// Returns the number of environment `i` among those of all processes, which its randomness is addressed by.
    pub fn address(&self, i: usize) -> u64 {
        (self.setup.first + i) as u64
    }

    /// Returns the layout of the policy's observations.
    pub fn observation(&self) -> &ObservationSpec {
        self.setup.observer.spec()
    }

    /// Returns the length of a row of [`Self::actor_rows`].
    pub fn actor_size(&self) -> usize {
        self.setup.observer.actor_size()
    }

    /// Returns the length of a row of [`Self::critic_rows`].
    pub fn critic_size(&self) -> usize {
        self.setup.observer.critic_size()
    }

    /// Returns the present observations of the policy, `[N, O]`, not normalised.
    pub fn actor_rows(&self) -> &[f32] {
        &self.rows.actor
    }

    /// Returns the present observations of the value function, `[N, P]`: the policy's and more, not normalised.
    pub fn critic_rows(&self) -> &[f32] {
        &self.rows.critic
    }

    /// Returns the number of steps after which an episode is truncated.
    pub fn longest_episode(&self) -> u64 {
        self.setup.longest_episode()
    }

    /// Returns the simulated states.
    pub fn state(&self) -> &BatchState {
        self.simulation.state()
    }

    /// Returns the episodes, with the results of the last step.
    pub fn episodes(&self) -> &[Episode] {
        &self.episodes
    }

    /// Returns the statistics since [`EpisodeStatistics::start`].
    pub fn statistics(&self) -> &EpisodeStatistics {
        &self.statistics
    }

    /// Returns the statistics, to begin counting anew.
    pub fn statistics_mut(&mut self) -> &mut EpisodeStatistics {
        &mut self.statistics
    }

    /// Returns the share of the motion that was ever seen, and the floor below which no segment of it is neglected.
    pub fn coverage(&self) -> (Coverage, f64) {
        (self.rsi.coverage(), self.rsi.floor())
    }

    /// Puts the statistics of failures and the curriculum's next stage into force; to be called once per iteration.
    pub fn refresh(&mut self) {
        self.rsi.refresh();
        self.advance_curriculum();
    }

    fn advance_curriculum(&mut self) {
        let steps = self.steps * (self.len() * self.setup.processes) as u64;
        self.stage = Stage::at(&self.setup.plan, steps);
    }

    /// Does one step of all environments with the policy's outputs `[N, J]`. Environments whose episode ends begin another.
    ///
    /// # Errors
    /// `outputs` has the wrong length; the simulation fails as a whole. A single environment that diverges is no error:
    /// its episode ends with no reward, is counted and begun anew.
    pub fn step(&mut self, outputs: &[f32], outcome: &mut StepOutcome) -> Result<(), TrackerError> {
        let joints = self.setup.robot.joints();
        expect("outputs of the policy", self.len() * joints, outputs.len())?;
        self.set_targets(outputs);
        self.push()?;
        self.soles.remember(self.simulation.state());
        self.simulation.step(Drive::Targets(&self.rows.targets))?;
        self.steps += 1;
        self.evaluate();
        let width = self.critic_size();
        outcome.clear();
        self.ended.clear();
        for (i, episode) in self.episodes.iter().enumerate() {
            outcome.rewards.push(episode.reward());
            outcome.terminated.push(episode.failed.is_some());
            outcome.truncated.push(episode.truncated);
            self.statistics.step(episode, self.setup.library.clip_of(episode.frame));
            if episode.truncated {
                outcome.final_critic_observations.extend_from_slice(&self.rows.critic[i * width..(i + 1) * width]);
            }
            if let Some((from, to)) = episode.finished_segment {
                self.rsi.record(from, to, false);
            }
            if episode.ended() {
                self.rsi.record(episode.segment_start, episode.frame, episode.failed.is_some());
                self.ended.push(i);
            }
        }
        if self.ended.is_empty() {
            return Ok(());
        }
        let ended = std::mem::take(&mut self.ended);
        let result = self.reset(&ended, None);
        self.ended = ended;
        result
    }

    /// Computes joint targets from the policy's outputs.
    fn set_targets(&mut self, outputs: &[f32]) {
        let Setup { robot, actions, library, .. } = &self.setup;
        let (joints, targets) = (robot.joints(), &mut self.rows.targets);
        let rows = self.episodes.par_iter_mut().zip(outputs.par_chunks_exact(joints));
        let rows = rows.zip(targets.par_chunks_exact_mut(joints)).with_min_len(CHUNK);
        rows.for_each(|((episode, output), target)| {
            std::mem::swap(&mut episode.before, &mut episode.oldest);
            std::mem::swap(&mut episode.last, &mut episode.before);
            for (last, y) in episode.last.iter_mut().zip(output) {
                // A non-finite output counts as zero; its environment goes on, and the update will not step with it.
                *last = if y.is_finite() { actions.spec.clamp_output(*y) } else { 0.0 };
            }
            let next = library.ahead(episode.frame, 1);
            episode.asked = [next, episode.asked[0]];
            actions.write(&episode.last, library.joints_at(next), target);
            target.iter_mut().zip(&episode.offset).for_each(|(t, o)| *t -= o);
            delay_targets(target, episode);
        });
    }

    /// Begins and ends random pushes.
    fn push(&mut self) -> Result<(), TrackerError> {
        let Some(spec) = &self.stage.randomization.pushes else {
            // No pushes at this stage: one that lasts from the stage before ends.
            for (i, schedule) in self.pushes.iter_mut().enumerate() {
                if schedule.active.take().is_some() {
                    self.simulation.clear_pushes(i);
                }
            }
            return Ok(());
        };
        for (i, schedule) in self.pushes.iter_mut().enumerate() {
            if !schedule.waits() {
                let mut rng = self.setup.stream("push", i, self.steps);
                schedule.change(spec, self.simulation.as_mut(), i, &mut rng)?;
            }
        }
        Ok(())
    }

    /// Computes rewards, terminations and observations after a step, each environment by itself.
    fn evaluate(&mut self) {
        let (setup, stage, soles) = (&self.setup, &self.stage, &self.soles);
        let (rsi, reserved) = (&self.rsi, self.reserved.as_ref());
        let (state, step) = (self.simulation.state(), self.steps);
        let evaluator = StepEvaluator { setup, stage, rsi, reserved, soles, state, step };
        let (a, c) = (setup.observer.actor_size(), setup.observer.critic_size());
        let Rows { actor, critic, features, .. } = &mut self.rows;
        self.episodes
            .par_chunks_mut(CHUNK)
            .zip(actor.par_chunks_mut(CHUNK * a))
            .zip(critic.par_chunks_mut(CHUNK * c))
            .zip(features.par_chunks_mut(setup.library.layout.size()))
            .enumerate()
            .for_each(|(chunk, (((episodes, actor), critic), features))| {
                let rows = episodes.iter_mut().zip(actor.chunks_exact_mut(a)).zip(critic.chunks_exact_mut(c));
                for (k, ((episode, actor), critic)) in rows.enumerate() {
                    evaluator.evaluate(chunk * CHUNK + k, episode, features, actor, critic);
                }
            });
    }
}
