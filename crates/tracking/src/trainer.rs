//! The training of a tracker: one iteration, and everything that the next one depends on.

mod beginning;
mod task;

use std::sync::Arc;

use lifelike_checkpoint::Checkpoint;
use lifelike_robot::controller::{ControllerHeader, KIND, PriorEncoder, Provenance};
use lifelike_robot::{Controller, ReferenceLibrary, Robot};
use lifelike_sim::Simulation;

use super::environment::Environment;
use super::plan::TrackerPlan;
use super::policy::Policy;
use super::progress::{ClipProgress, TrackerMetrics};
use crate::{FromInput, TrackerError};
use lifelike_train::collective::{Alone, Collective};
use lifelike_train::ppo::{Iteration, Learner};

pub use self::beginning::Beginning;

/// Environments and learner of one plan, between two iterations.
pub struct Trainer {
    plan: TrackerPlan,
    robot: Arc<Robot>,
    library: Arc<ReferenceLibrary>,
    environment: Environment,
    learner: Learner,
    collective: Arc<dyn Collective>,
    prior_digest: String,
    prior: Option<PriorEncoder>,
    /// SHA-256 of the teachers' policies, hexadecimal.
    teachers: Vec<String>,
    iteration: u64,
    steps: u64,
}

impl Trainer {
    /// Creates networks and environments.
    ///
    /// # Errors
    /// Plan, robot, library and simulation do not fit each other.
    pub fn new(
        plan: &TrackerPlan,
        robot: Arc<Robot>,
        library: Arc<ReferenceLibrary>,
        simulation: Box<dyn Simulation>,
    ) -> Result<Self, TrackerError> {
        Self::distributed(plan, robot, library, simulation, Arc::new(Alone))
    }

    /// Creates them as those of one of several processes, each with `ppo.environments` environments of its own, that take the same
    /// gradient steps.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn distributed(
        plan: &TrackerPlan,
        robot: Arc<Robot>,
        library: Arc<ReferenceLibrary>,
        simulation: Box<dyn Simulation>,
        collective: Arc<dyn Collective>,
    ) -> Result<Self, TrackerError> {
        plan.check()?;
        let process = (collective.rank(), collective.size());
        let environment =
            Environment::distributed(plan, Arc::clone(&robot), Arc::clone(&library), simulation, process)?;
        let learner = Learner::new(&plan.ppo, &plan.network, plan.seed, &environment, Arc::clone(&collective));
        Ok(Self {
            plan: plan.clone(),
            robot,
            library,
            environment,
            learner,
            collective,
            prior_digest: String::new(),
            prior: None,
            teachers: Vec::new(),
            iteration: 0,
            steps: 0,
        })
    }

    /// Returns what became of each clip.
    pub fn clips(&self) -> Vec<ClipProgress<'_>> {
        let (coverage, _) = self.environment.coverage();
        let survival = &self.environment.statistics().survival;
        let clips = self.library.names.iter().zip(survival).zip(coverage.clips);
        clips.map(|((name, survival), seen)| ClipProgress { name, survival: *survival, seen }).collect()
    }

    /// Remembers which prior made the library's latent codes, by the SHA-256 of its file (hexadecimal). Its encoder becomes
    /// part of the controller, where a controller can run it.
    #[must_use]
    pub fn with_prior(mut self, digest: &str, encoder: Option<PriorEncoder>) -> Self {
        self.prior_digest = digest.into();
        self.prior = encoder;
        self
    }

    /// With the policies of the plan's `teachers`, in their order; after [`Self::with_prior`].
    ///
    /// # Errors
    /// As [`Environment::set_teachers`]; a teacher sees latent codes of another prior.
    pub fn taught_by(mut self, teachers: Vec<Controller>) -> Result<Self, TrackerError> {
        for (teacher, spec) in teachers.iter().zip(&self.plan.teachers) {
            let (latent, prior) = (teacher.observation().reference.latent, &teacher.header().provenance.prior);
            if latent > 0 && *prior != self.prior_digest {
                let what = format!("motion prior of the teacher {}", spec.policy.display());
                let expected = format!("the plan's (SHA-256 {})", self.prior_digest);
                return Err(TrackerError::mismatch(what, expected, format!("SHA-256 {prior}")));
            }
        }
        self.teachers = teachers.iter().map(|teacher| teacher.header().provenance.policy.clone()).collect();
        self.environment.set_teachers(teachers)?;
        Ok(self)
    }

    /// Returns the iterations done.
    pub fn iteration(&self) -> u64 {
        self.iteration
    }

    /// Returns the environment steps done.
    pub fn steps(&self) -> u64 {
        self.steps
    }

    /// Returns the environments.
    pub fn environment(&self) -> &Environment {
        &self.environment
    }

    /// Takes one iteration of PPO.
    ///
    /// # Errors
    /// The simulation fails as a whole.
    pub fn iterate(&mut self) -> Result<Iteration, TrackerError> {
        self.environment.statistics_mut().start();
        let report = self.learner.iterate(&mut self.environment, self.iteration)?;
        self.environment.refresh();
        self.iteration += 1;
        self.steps += self.environment.statistics().steps * self.collective.size() as u64;
        Ok(report)
    }

    /// Returns the policy as it is now.
    pub fn policy(&self) -> Policy {
        let (critic, normalizer) = self.learner.value_function();
        Policy::new(self.header(), self.learner.actor(), self.learner.normalizer(), Arc::clone(&self.robot))
            .with_prior(self.prior.clone())
            .with_value(critic, normalizer)
    }

    fn header(&self) -> ControllerHeader {
        let (observation, network) = (self.environment.observation().clone(), &self.plan.network);
        ControllerHeader {
            encoder: Some((network.encoder.clone(), network.code)).filter(|(_, code)| *code > 0),
            memory: Some(network.memory).filter(|state| *state > 0),
            provenance: Provenance { prior: self.prior_digest.clone(), steps: self.steps, ..Provenance::default() },
            environment: self.plan.as_environment(&self.robot.name).ok(),
            ..ControllerHeader::new(&self.robot, observation, self.plan.action, network.actor.clone())
        }
    }

    fn metrics(&self, ppo: Iteration) -> TrackerMetrics {
        let statistics = self.environment.statistics();
        // The two halves of an iteration may run at once.
        let seconds =
            if self.plan.ppo.overlap { ppo.collecting.max(ppo.learning) } else { ppo.collecting + ppo.learning };
        TrackerMetrics {
            ppo,
            steps_per_second: statistics.steps as f64 * self.collective.size() as f64 / seconds,
            episode_seconds: statistics.recent()[1] / self.robot.control_hz,
            survival: statistics.mean_survival(),
        }
    }

    /// Returns everything that the rest of the run depends on.
    ///
    /// # Errors
    /// Two entries of one name.
    pub fn checkpoint(&self) -> Result<Checkpoint, TrackerError> {
        let mut checkpoint = Checkpoint::new();
        checkpoint.set_meta("plan", &self.resumable_plan())?;
        checkpoint.set_meta(KIND, &self.header())?;
        checkpoint.put_u64("progress", &[2], vec![self.iteration, self.steps])?;
        self.learner.save_into(&mut checkpoint, "learner")?;
        self.environment.save_into(&mut checkpoint, "environment")?;
        Ok(checkpoint)
    }

    /// Returns the plan less what may change when a run is resumed: when it stops, and how often it saves.
    fn resumable_plan(&self) -> TrackerPlan {
        TrackerPlan { budget: Default::default(), checkpoint_every: 1, ..self.plan.clone() }
    }

    /// Goes on from a checkpoint.
    ///
    /// # Errors
    /// The checkpoint is of another plan.
    pub fn restore(&mut self, checkpoint: &Checkpoint) -> Result<(), TrackerError> {
        let plan: TrackerPlan = checkpoint.meta("plan")?;
        if plan != self.resumable_plan() {
            let got = "another (only budget and checkpoint_every may change)";
            return Err(TrackerError::mismatch(format!("{}: plan", checkpoint.origin()), "the plan of this run", got));
        }
        let progress = checkpoint.u64s("progress", &[2])?;
        self.learner.load(checkpoint, "learner")?;
        self.environment.load(checkpoint, "environment")?;
        (self.iteration, self.steps) = (progress[0], progress[1]);
        Ok(())
    }
}
