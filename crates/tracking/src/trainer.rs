//! A training run: iterations, metrics, checkpoints, and going on after a stop.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use lifelike_checkpoint::Checkpoint;
use lifelike_nn::device::Device;
use lifelike_robot::controller::PolicyHeader;
use lifelike_robot::{ReferenceLibrary, Robot};
use lifelike_sim::Simulation;

use super::environment::Environment;
use super::errors::Cause;
use super::plan::TrackerPlan;
use super::policy::{EXTENSION, Policy};
use super::ppo::{Iteration, Learner};
use super::progress::{ClipProgress, Progress, Summary};
use super::rewards::TERMS;
use crate::TrackerError;
use lifelike_report::run::{CheckpointInfo, Checkpoints, MetricsWriter, RunFolder};
use lifelike_train::collective::{Alone, Collective};

/// Checkpoints that are kept, besides the best.
const KEEP: usize = 2;

/// Environments and learner of one plan, between two iterations.
pub struct Trainer {
    plan: TrackerPlan,
    robot: Arc<Robot>,
    library: Arc<ReferenceLibrary>,
    environment: Environment,
    learner: Learner,
    all: Arc<dyn Collective>,
    prior_digest: String,
    iteration: u64,
    steps: u64,
    /// Wall time of earlier parts of the run (s).
    earlier: f64,
}

impl Trainer {
    /// Fresh networks and environments.
    ///
    /// # Errors
    /// Plan, robot, library and simulation do not fit each other.
    pub fn new(
        plan: &TrackerPlan,
        robot: Arc<Robot>,
        library: Arc<ReferenceLibrary>,
        simulation: Box<dyn Simulation>,
    ) -> Result<Self, TrackerError> {
        Self::among(plan, robot, library, simulation, Arc::new(Alone))
    }

    /// The same as one of several processes, each with `ppo.environments` environments of its own, that take the same
    /// gradient steps.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn among(
        plan: &TrackerPlan,
        robot: Arc<Robot>,
        library: Arc<ReferenceLibrary>,
        simulation: Box<dyn Simulation>,
        all: Arc<dyn Collective>,
    ) -> Result<Self, TrackerError> {
        plan.check()?;
        let environment =
            Environment::among(plan, Arc::clone(&robot), Arc::clone(&library), simulation, (all.rank(), all.size()))?;
        let learner = Learner::new(plan, &environment, robot.joints(), Arc::clone(&all));
        Ok(Self {
            plan: plan.clone(),
            robot,
            library,
            environment,
            learner,
            all,
            prior_digest: String::new(),
            iteration: 0,
            steps: 0,
            earlier: 0.0,
        })
    }

    /// With its networks on another device; everything else stays on the CPU.
    #[must_use]
    pub fn to_device(mut self, device: &Device) -> Self {
        self.learner = self.learner.to_device(device);
        self
    }

    /// Begins with the networks of `plan.init`, where it names any.
    ///
    /// # Errors
    /// There is nothing of the kind, or it sees or moves something else than this plan's policy.
    pub fn initialised(mut self) -> Result<Self, TrackerError> {
        let Some(path) = self.plan.init.clone() else { return Ok(self) };
        if path.is_dir() {
            let checkpoints = RunFolder::open(&path)?.checkpoints(KEEP);
            let Some((info, bytes)) = checkpoints.latest() else {
                return Err(TrackerError::Mismatch {
                    what: path.display().to_string(),
                    expected: "a run with a checkpoint".into(),
                    got: "none".into(),
                });
            };
            let checkpoint = Checkpoint::from_bytes(&bytes, &checkpoints.path(info.iteration))?;
            self.alike(&path, &checkpoint.meta::<PolicyHeader>("policy")?)?;
            self.learner.adopt(&checkpoint, "learner")?;
        } else {
            let policy = Policy::load(&path, &self.robot)?;
            self.alike(&path, policy.header())?;
            self.learner.adopt_policy(&policy);
        }
        Ok(self)
    }

    /// Whether a policy sees what this one sees, in this order, and its outputs mean the same.
    fn alike(&self, path: &Path, other: &PolicyHeader) -> Result<(), TrackerError> {
        let parts = |header: &PolicyHeader| {
            let prior = if header.observation.reference.latent > 0 { header.prior.as_str() } else { "none" };
            [
                ("inputs", format!("{:?}", header.observation)),
                ("action", format!("{:?}", header.action)),
                ("hidden layers", format!("{:?}", header.hidden)),
                ("encoder", format!("{:?}", header.encoder)),
                ("prior", prior.to_string()),
            ]
        };
        let different = parts(&self.header()).into_iter().zip(parts(other)).find(|(own, other)| own != other);
        match different {
            None => Ok(()),
            Some(((what, expected), (_, got))) => Err(TrackerError::Mismatch {
                what: format!("{what} of the policy of {}", path.display()),
                expected,
                got,
            }),
        }
    }

    /// What became of each clip.
    pub fn clips(&self) -> Vec<ClipProgress<'_>> {
        let (coverage, _) = self.environment.coverage();
        let survival = &self.environment.tally().survival;
        let clips = self.library.names.iter().zip(survival).zip(coverage.clips);
        clips.map(|((name, survival), seen)| ClipProgress { name, survival: *survival, seen }).collect()
    }

    /// Remembers which prior (by the SHA-256 of its file, hexadecimal) made the library's latent codes.
    #[must_use]
    pub fn with_prior_digest(mut self, digest: &str) -> Self {
        self.prior_digest = digest.into();
        self
    }

    /// Iterations done.
    pub fn iteration(&self) -> u64 {
        self.iteration
    }

    /// Environment steps done.
    pub fn steps(&self) -> u64 {
        self.steps
    }

    /// The environments.
    pub fn environment(&self) -> &Environment {
        &self.environment
    }

    /// One iteration of PPO.
    ///
    /// # Errors
    /// The simulation fails as a whole.
    pub fn iterate(&mut self) -> Result<Iteration, TrackerError> {
        self.environment.tally_mut().start();
        let report = self.learner.iterate(&mut self.environment, self.iteration)?;
        self.environment.refresh();
        self.iteration += 1;
        self.steps += self.environment.tally_mut().steps * self.all.size() as u64;
        Ok(report)
    }

    /// The policy as it is now.
    pub fn policy(&self) -> Policy {
        Policy::new(self.header(), self.learner.actor(), self.learner.normalizer())
    }

    fn header(&self) -> PolicyHeader {
        PolicyHeader {
            robot: self.robot.name.clone(),
            observation: self.environment.observation().clone(),
            action: self.plan.action,
            control_hz: self.robot.control_hz,
            hidden: self.plan.network.actor.clone(),
            encoder: Some((self.plan.network.encoder.clone(), self.plan.network.code)).filter(|(_, code)| *code > 0),
            prior: self.prior_digest.clone(),
            steps: self.steps,
        }
    }

    /// Runs until the budget is spent or `stop` is set, from where the run in `folder` stands. Writes metrics,
    /// checkpoints and at the end `tracker.policy.safetensors`.
    ///
    /// # Errors
    /// Files that cannot be written; a checkpoint of another plan; a simulation that fails as a whole.
    pub fn run(
        &mut self,
        folder: &RunFolder,
        stop: &AtomicBool,
        mut progress: impl FnMut(&Progress),
    ) -> Result<Summary, TrackerError> {
        let checkpoints = match self.all.rank() {
            0 => folder.checkpoints(KEEP),
            rank => folder.checkpoints_of(rank, KEEP),
        };
        let position = match self.common(&checkpoints)? {
            None => None,
            Some((info, bytes)) => Some(self.load(&bytes, &checkpoints.path(info.iteration))?),
        };
        // The first process tells how it went in its own environments.
        let mut metrics = match (self.all.rank(), position) {
            (0, None) => Some(folder.start_metrics()?),
            (0, Some(position)) => Some(folder.resume_metrics(position, self.iteration)?),
            _ => None,
        };
        let began = Instant::now();
        let earlier = self.earlier;
        let mut latest = None;
        let mut saved = Some(self.iteration).filter(|i| *i > 0);
        let mut interrupted = false;
        while !self.all.any(self.spent()) {
            if self.all.any(stop.load(Ordering::SeqCst)) {
                interrupted = true;
                break;
            }
            let report = self.iterate()?;
            self.earlier = earlier + began.elapsed().as_secs_f64();
            let now = self.progress(&report);
            if let Some(metrics) = &mut metrics {
                self.log(&report, &now, metrics)?;
            }
            progress(&now);
            latest = Some(now);
            if self.iteration.is_multiple_of(self.plan.checkpoint_every) {
                self.save(&checkpoints, metrics.as_mut())?;
                saved = Some(self.iteration);
            }
        }
        if saved != Some(self.iteration) {
            self.save(&checkpoints, metrics.as_mut())?;
        }
        let policy = folder.path().join(format!("tracker{EXTENSION}"));
        if self.all.rank() == 0 {
            self.policy().save(&policy)?;
        }
        Ok(Summary { policy, progress: latest, interrupted })
    }

    /// The checkpoint to go on from: the latest that every process has. A kill may have come when only some had saved.
    fn common(&self, checkpoints: &Checkpoints) -> Result<Option<(CheckpointInfo, Vec<u8>)>, TrackerError> {
        if self.all.size() == 1 {
            return Ok(checkpoints.latest());
        }
        let own = checkpoints.latest().map_or(0, |(info, _)| info.iteration);
        let least = self.all.gather(own as f64).into_iter().fold(f64::INFINITY, f64::min) as u64;
        if least == 0 {
            return Ok(None);
        }
        let found = checkpoints.list().into_iter().find(|info| info.iteration == least);
        let Some(info) = found else {
            return Err(TrackerError::Mismatch {
                what: format!("checkpoints of process {}", self.all.rank()),
                expected: format!("one of iteration {least}, the latest that another process has"),
                got: format!("up to {own}, but not that one"),
            });
        };
        let bytes = checkpoints.read(&info)?;
        Ok(Some((info, bytes)))
    }

    fn spent(&self) -> bool {
        let late = self.plan.budget.minutes.is_some_and(|m| self.earlier >= 60.0 * m);
        late || self.steps >= self.plan.budget.steps
    }

    fn progress(&mut self, report: &Iteration) -> Progress {
        let hz = self.robot.control_hz;
        let seconds = self.earlier;
        let (steps, budget, iteration) = (self.steps, self.plan.budget.steps, self.iteration);
        let (processes, overlap) = (self.all.size() as f64, self.plan.ppo.overlap);
        let tally = self.environment.tally_mut();
        Progress {
            iteration,
            steps,
            budget,
            seconds,
            steps_per_second: tally.steps as f64 * processes / seconds_of(report, overlap),
            episode_seconds: tally.recent()[1] / hz,
            survival: tally.mean_survival(),
            reward: report.reward,
        }
    }

    fn log(&mut self, report: &Iteration, now: &Progress, metrics: &mut MetricsWriter) -> Result<(), TrackerError> {
        let (iteration, steps) = (self.iteration, self.steps);
        let coverage = self.environment.coverage();
        let tally = self.environment.tally_mut();
        let [gain, length] = tally.recent();
        let mut values: Vec<(String, f64)> = [
            ("Train/mean_reward", gain),
            ("Train/mean_episode_length", length),
            ("Train/mean_step_reward", report.reward),
            ("Train/survival", tally.mean_survival()),
            ("Train/steps", steps as f64),
            ("Train/episodes", tally.episodes as f64),
            ("Loss/value_function", report.value_loss),
            ("Loss/surrogate", report.surrogate),
            ("Loss/entropy", report.entropy),
            ("Loss/kl", report.divergence),
            ("Loss/explained_variance", report.explained_variance),
            ("Loss/gradient_norm", report.gradient_norm),
            ("Loss/skipped_steps", report.skipped as f64),
            ("Loss/learning_rate", report.rate),
            ("Policy/mean_std", report.std),
        ]
        .map(|(name, value)| (name.to_string(), value))
        .to_vec();
        let per_step = 1.0 / tally.steps.max(1) as f64;
        values.extend(TERMS.iter().zip(tally.terms).map(|(name, sum)| (format!("Reward/{name}"), sum * per_step)));
        let causes = Cause::ALL.iter().zip(tally.causes);
        values.extend(causes.map(|(cause, count)| (format!("Termination/{}", cause.name()), count as f64)));
        let (coverage, floor) = coverage;
        values.push(("Coverage/frames".into(), coverage.overall));
        let whole = coverage.clips.iter().filter(|share| **share > 0.0).count();
        values.push(("Coverage/clips".into(), whole as f64 / coverage.clips.len().max(1) as f64));
        values.push(("Coverage/floor".into(), floor));
        let clips = self.library.names.iter().zip(&tally.survival);
        values.extend(clips.map(|(name, rate)| (format!("Survival/{name}"), *rate)));
        let values: Vec<(&str, f64)> = values.iter().map(|(n, v)| (n.as_str(), *v)).collect();
        metrics.log(iteration, &values)?;
        let timing = [
            ("Perf/total_fps", now.steps_per_second),
            ("Perf/collection_time", report.collecting),
            ("Perf/simulation_time", report.stepping),
            ("Perf/learning_time", report.learning),
            ("Perf/wall_time", now.seconds),
        ];
        Ok(metrics.log_timing(iteration, &timing)?)
    }

    /// Everything that the rest of the run depends on.
    fn save(&self, checkpoints: &Checkpoints, metrics: Option<&mut MetricsWriter>) -> Result<(), TrackerError> {
        let position = metrics.map(MetricsWriter::sync).transpose()?.unwrap_or(0);
        let checkpoint = self.checkpoint(position)?;
        checkpoints.save(self.iteration, None, &checkpoint.to_bytes()?)?;
        Ok(())
    }

    /// The checkpoint of now; `metrics_position` is the length of the metrics file that belongs to it (bytes).
    ///
    /// # Errors
    /// The device does not hand out its numbers.
    pub fn checkpoint(&self, metrics_position: u64) -> Result<Checkpoint, TrackerError> {
        let mut checkpoint = Checkpoint::new();
        checkpoint.set_meta("plan", &self.resumable_plan())?;
        checkpoint.set_meta("policy", &self.header())?;
        checkpoint.put_u64("run.counters", &[3], vec![self.iteration, self.steps, metrics_position])?;
        checkpoint.put_f64("run.seconds", &[1], vec![self.earlier])?;
        checkpoint.put_u64("run.processes", &[1], vec![self.all.size() as u64])?;
        self.learner.save_into(&mut checkpoint, "learner")?;
        self.environment.save_into(&mut checkpoint, "environment")?;
        Ok(checkpoint)
    }

    /// The plan less what may change when a run is resumed: when it stops, and how often it saves.
    fn resumable_plan(&self) -> TrackerPlan {
        TrackerPlan { budget: Default::default(), checkpoint_every: 1, ..self.plan.clone() }
    }

    /// Goes on from a checkpoint's bytes; returns the position in the metrics file.
    ///
    /// # Errors
    /// The checkpoint is damaged, or of another plan.
    pub fn load(&mut self, bytes: &[u8], path: &Path) -> Result<u64, TrackerError> {
        let checkpoint = Checkpoint::from_bytes(bytes, path)?;
        let plan: TrackerPlan = checkpoint.meta("plan")?;
        if plan != self.resumable_plan() {
            return Err(TrackerError::Mismatch {
                what: format!("{}: plan", path.display()),
                expected: "the plan of this run".into(),
                got: "another (only budget and checkpoint_every may change)".into(),
            });
        }
        // A checkpoint from before there were processes is of one.
        let key = "run.processes";
        let processes = if checkpoint.contains(key) { checkpoint.u64s(key, &[1])?[0] } else { 1 };
        if processes != self.all.size() as u64 {
            return Err(TrackerError::Mismatch {
                what: format!("{}: processes of the run", path.display()),
                expected: processes.to_string(),
                got: self.all.size().to_string(),
            });
        }
        let counters = checkpoint.u64s("run.counters", &[3])?;
        self.learner.load(&checkpoint, "learner")?;
        self.environment.load(&checkpoint, "environment")?;
        (self.iteration, self.steps) = (counters[0], counters[1]);
        self.earlier = checkpoint.f64s("run.seconds", &[1])?[0];
        Ok(counters[2])
    }
}

/// Wall time of an iteration, whose two halves may run at once (s).
fn seconds_of(report: &Iteration, overlap: bool) -> f64 {
    if overlap { report.collecting.max(report.learning) } else { report.collecting + report.learning }
}
