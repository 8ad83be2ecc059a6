//! A training, as the one loop sees it.

use lifelike_checkpoint::Checkpoint;
use lifelike_report::ReportBuilder;
use lifelike_report::run::{RunFolder, Snapshot};

use crate::TrainError;

/// Name and value of a number that is logged. A name may have a group before a slash (`Loss/kl`).
pub type Scalar = (String, f64);

/// Work that is learned step by step. A trainer brings its step and what belongs to it; [`crate::TrainingRun`] does the rest.
///
/// Everything that [`Self::step`] depends on is in [`Self::checkpoint`], and nothing that a clock says: then a run that was
/// stopped and resumed leaves the bytes of one that was not.
pub trait TrainingTask {
    /// Results of one step.
    type Metrics;
    /// Error of this training.
    type Error: From<TrainError>;

    /// Returns the number of steps done.
    fn iteration(&self) -> u64;

    /// Returns how much of the work is done, and when it ends.
    fn budget(&self) -> Budget;

    /// Returns when to validate and to save.
    fn schedule(&self) -> Schedule;

    /// Returns name and text of everything that must be the same when a run is resumed. Examples are its plan and a
    /// digest of its data.
    fn identity(&self) -> Vec<(&'static str, String)>;

    /// Takes one step.
    ///
    /// # Errors
    /// The training cannot go on.
    fn step(&mut self) -> Result<Self::Metrics, Self::Error>;

    /// Returns the numbers to log of a step that has just been taken: only those that an equal run gives again.
    fn scalars(&self, metrics: &Self::Metrics) -> Vec<Scalar>;

    /// Returns what a clock says about the step (seconds, rates); the time since the run began is added to it.
    fn timings(&self, _metrics: &Self::Metrics) -> Vec<Scalar> {
        Vec::new()
    }

    /// Measures on data that is not learned from, where there is any.
    ///
    /// # Errors
    /// The measurement fails.
    fn validate(&mut self) -> Result<Option<Validation>, Self::Error> {
        Ok(None)
    }

    /// Returns values of each of many items (the clips of a tracker), where there are any. They are logged seldom.
    fn snapshot(&self) -> Option<Snapshot> {
        None
    }

    /// Returns everything that the rest of the run depends on. Names that begin with `run.` belong to the loop.
    ///
    /// # Errors
    /// A checkpoint that cannot be made.
    fn checkpoint(&self) -> Result<Checkpoint, Self::Error>;

    /// Goes on from a checkpoint.
    ///
    /// # Errors
    /// The checkpoint is of something else.
    fn restore(&mut self, checkpoint: &Checkpoint) -> Result<(), Self::Error>;

    /// Writes the files that are the result of the training so far: with each checkpoint, and at the end of each sitting.
    ///
    /// # Errors
    /// A file cannot be written.
    fn finish(&mut self, _folder: &RunFolder) -> Result<(), Self::Error> {
        Ok(())
    }

    /// Returns the names of the numbers that say best how it goes.
    fn headlines(&self) -> &'static [&'static str] {
        &[]
    }

    /// Adds facts and tables to the report of the run, which has its curves.
    fn report(&self, report: ReportBuilder) -> ReportBuilder {
        report
    }
}

/// Work done and to do, in whatever unit a training counts (iterations, environment steps).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Budget {
    /// Units done.
    pub done: u64,
    /// Units after which the training ends.
    pub total: u64,
    /// Wall time after which it ends, all sittings together (minutes).
    pub minutes: Option<f64>,
}

impl Budget {
    /// Returns the budget of a training that counts iterations.
    pub fn iterations(done: u64, total: u64) -> Self {
        Self { done, total, minutes: None }
    }

    /// Returns the time that the budget's minutes leave after so many seconds of training (s); none where it has no minutes.
    pub fn seconds_left(&self, seconds: f64) -> Option<f64> {
        self.minutes.map(|minutes| (60.0 * minutes - seconds).max(0.0))
    }

    /// Returns whether it is spent, after so many seconds of training.
    pub fn is_spent(&self, seconds: f64) -> bool {
        self.done >= self.total || self.minutes.is_some_and(|minutes| seconds >= 60.0 * minutes)
    }
}

/// Iterations between two things that are done now and then, all of which are done at the end of a run too.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Schedule {
    /// Between checkpoints.
    pub checkpoint_every: u64,
    /// Between validations; 0 where nothing is validated.
    pub validate_every: u64,
    /// Checkpoints that are kept, besides the best.
    pub keep: usize,
}

impl Schedule {
    /// Returns whether a validation is due after an iteration, `last` if it is the run's last one.
    pub(crate) fn validates(&self, iteration: u64, last: bool) -> bool {
        self.validate_every > 0 && (last || iteration.is_multiple_of(self.validate_every))
    }
}

/// Result of a validation.
#[derive(Debug, Clone, PartialEq)]
pub struct Validation {
    /// Numbers to log.
    pub scalars: Vec<Scalar>,
    /// Quality, higher is better: by it the best checkpoint is kept.
    pub score: Option<f64>,
}
