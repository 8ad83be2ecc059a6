//! The training as the one loop sees it: its numbers, tables and files.

use std::path::{Path, PathBuf};

use lifelike_checkpoint::Checkpoint;
use lifelike_report::run::{RunFolder, Snapshot};
use lifelike_report::{Cell, Column, ReportBuilder, Table};
use lifelike_robot::controller::EXTENSION;
use lifelike_train::{Budget, Scalar, Schedule, TrainingTask};

use super::Trainer;
use crate::TrackerError;
use crate::progress::{ClipProgress, TrackerMetrics};

/// Checkpoints that are kept, besides the best.
pub(super) const KEEP: usize = 2;

impl Trainer {
    /// Returns the file of the policy in a run's folder.
    pub fn policy_path(folder: &Path) -> PathBuf {
        folder.join(format!("tracker{EXTENSION}"))
    }

    /// Returns a table of what became of each clip, the hardest first.
    fn clip_table(&self) -> Table {
        let columns = vec![Column::text("clip"), Column::number("survival", "%"), Column::number("seen", "%")];
        let mut table = Table::new("Clips", columns);
        let mut clips = self.clips();
        clips.sort_by(|a, b| a.survival.total_cmp(&b.survival));
        let row = |clip: &ClipProgress<'_>| {
            vec![Cell::text(clip.name), Cell::number(100.0 * clip.survival, 0), Cell::number(100.0 * clip.seen, 0)]
        };
        table.rows = clips.iter().map(row).collect();
        table
    }
}

impl TrainingTask for Trainer {
    type Metrics = TrackerMetrics;
    type Error = TrackerError;

    fn iteration(&self) -> u64 {
        self.iteration
    }

    fn budget(&self) -> Budget {
        let budget = self.plan.budget;
        Budget { done: self.steps, total: budget.steps, minutes: budget.minutes }
    }

    fn schedule(&self) -> Schedule {
        Schedule { checkpoint_every: self.plan.checkpoint_every, validate_every: 0, keep: KEEP }
    }

    fn identity(&self) -> Vec<(&'static str, String)> {
        // The plan is compared by [`Trainer::restore`], which knows the defaults of keys that did not exist yet.
        let mut identity = vec![("reference motion", self.library.digest())];
        if !self.teachers.is_empty() {
            identity.push(("teachers", self.teachers.join(" ")));
        }
        identity
    }

    fn step(&mut self) -> Result<TrackerMetrics, TrackerError> {
        let ppo = self.iterate()?;
        Ok(self.metrics(ppo))
    }

    fn scalars(&self, metrics: &TrackerMetrics) -> Vec<Scalar> {
        let (ppo, statistics) = (&metrics.ppo, self.environment.statistics());
        let [episode_return, length] = statistics.recent();
        let mut scalars: Vec<Scalar> = [
            ("Train/mean_reward", episode_return),
            ("Train/mean_episode_length", length),
            ("Train/mean_step_reward", ppo.reward),
            ("Train/survival", metrics.survival),
            ("Train/steps", self.steps as f64),
            ("Train/episodes", statistics.episodes as f64),
            ("Loss/value_function", ppo.value_loss),
            ("Loss/surrogate", ppo.surrogate),
            ("Loss/entropy", ppo.entropy),
            ("Loss/kl", ppo.divergence),
            ("Loss/explained_variance", ppo.explained_variance),
            ("Gradient/norm", ppo.gradient_norm),
            ("Gradient/skipped", ppo.skipped as f64),
            ("Schedule/learning_rate", ppo.learning_rate),
            ("Policy/mean_std", ppo.std),
        ]
        .map(|(name, value)| (name.to_string(), value))
        .to_vec();
        scalars.extend(ppo.imitation.map(|kl| ("Loss/imitation".into(), kl)));
        scalars.extend(statistics.metrics());
        let (coverage, floor) = self.environment.coverage();
        scalars.push(("Coverage/frames".into(), coverage.overall));
        let seen = coverage.clips.iter().filter(|share| **share > 0.0).count();
        scalars.push(("Coverage/clips".into(), seen as f64 / coverage.clips.len().max(1) as f64));
        scalars.push(("Coverage/floor".into(), floor));
        scalars
    }

    fn timings(&self, metrics: &TrackerMetrics) -> Vec<Scalar> {
        [
            ("Perf/total_fps", metrics.steps_per_second),
            ("Perf/collection_time", metrics.ppo.collecting),
            ("Perf/simulation_time", metrics.ppo.stepping),
            ("Perf/learning_time", metrics.ppo.learning),
        ]
        .map(|(name, value)| (name.to_string(), value))
        .to_vec()
    }

    fn snapshot(&self) -> Option<Snapshot> {
        let clips = self.clips();
        let column = |of: fn(&ClipProgress<'_>) -> f64| clips.iter().map(of).collect();
        Some(Snapshot {
            items: self.library.names.clone(),
            columns: vec![("survival", column(|clip| clip.survival)), ("seen", column(|clip| clip.seen))],
        })
    }

    fn checkpoint(&self) -> Result<Checkpoint, TrackerError> {
        Self::checkpoint(self)
    }

    fn restore(&mut self, checkpoint: &Checkpoint) -> Result<(), TrackerError> {
        Self::restore(self, checkpoint)
    }

    fn finish(&mut self, folder: &RunFolder) -> Result<(), TrackerError> {
        self.policy().save(&Self::policy_path(folder.path()))
    }

    fn headlines(&self) -> &'static [&'static str] {
        &["Train/survival", "Train/mean_step_reward", "Train/joint_error_deg", "Train/mean_episode_length"]
    }

    fn report(&self, report: ReportBuilder) -> ReportBuilder {
        let steps = format!("{} of {}", self.steps, self.plan.budget.steps);
        report.fact("robot", self.plan.robot.clone()).fact("steps", steps).table(self.clip_table())
    }
}
