//! The one training loop, over one run's folder.

mod clock;
mod log;
mod resume;
mod skips;

use std::sync::atomic::{AtomicBool, Ordering};

use lifelike_report::run::{Checkpoints, RunFolder};

use self::clock::Clock;
use self::log::RunLog;
use self::resume::{Position, latest_of_all, restore, seconds_until};
use self::skips::Skips;
use crate::TrainError;
use crate::collective::Collective;
use crate::task::TrainingTask;

/// Surroundings of a training: its folder, the flag by which it is stopped, and the processes that train together.
///
/// ```no_run
/// # fn train<T: lifelike_train::TrainingTask>(task: &mut T, folder: &lifelike_report::run::RunFolder) -> Result<(), T::Error> {
/// use std::sync::atomic::AtomicBool;
/// use lifelike_train::{TrainingRun, collective::Alone};
///
/// let stop = AtomicBool::new(false); // set by Ctrl-C
/// let run = TrainingRun { folder, stop: &stop, collective: &Alone };
/// let summary = run.run(task, |now| println!("{} of {}", now.done, now.total))?;
/// assert!(!summary.interrupted);
/// # Ok(()) }
/// ```
#[derive(Clone, Copy)]
pub struct TrainingRun<'a> {
    /// The run's folder. A run that stands in it is gone on with, from its latest checkpoint.
    pub folder: &'a RunFolder,
    /// Asks to save and stop, once it is set.
    pub stop: &'a AtomicBool,
    /// The processes; the first writes metrics, report and results, and each its own checkpoints.
    pub collective: &'a dyn Collective,
}

/// State of a run after an iteration.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Progress<'a, M> {
    /// Iterations done.
    pub iteration: u64,
    /// Units of the budget done.
    pub done: u64,
    /// Units of the budget.
    pub total: u64,
    /// Time spent training, all sittings together (s).
    pub seconds: f64,
    /// Time until the end (s): the lesser of the work left, at this sitting's rate, and the minutes left.
    pub remaining_seconds: f64,
    /// Results of the step.
    pub metrics: &'a M,
}

/// End of a sitting.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Summary<M> {
    /// Results of the last step; none where there was nothing left to do.
    pub metrics: Option<M>,
    /// Iterations done.
    pub iteration: u64,
    /// Units of the budget done.
    pub done: u64,
    /// Time spent training, all sittings together (s).
    pub seconds: f64,
    /// It was asked to stop before the budget was spent; it can be resumed.
    pub interrupted: bool,
}

impl TrainingRun<'_> {
    /// Trains until the budget is spent or the flag is set, and calls `each` after every iteration.
    ///
    /// # Errors
    /// The checkpoint in the folder is of another plan, data or number of processes; a file cannot be written; a step fails.
    pub fn run<T: TrainingTask>(
        &self,
        task: &mut T,
        mut each: impl FnMut(&Progress<'_, T::Metrics>),
    ) -> Result<Summary<T::Metrics>, T::Error> {
        let (folder, collective) = (self.folder, self.collective);
        let schedule = task.schedule();
        let checkpoints = match collective.rank() {
            0 => folder.checkpoints(schedule.keep),
            rank => folder.checkpoints_of(rank, schedule.keep),
        };
        let position = match latest_of_all(folder, &checkpoints, collective)? {
            Some(checkpoint) => restore(task, &checkpoint, collective.size())?,
            None => Position::default(),
        };
        let first = task.iteration();
        let mut clock = Clock::after(seconds_until(folder, first)?);
        // The first process tells how it went in its own part.
        let mut log = (collective.rank() == 0).then(|| RunLog::open(folder, position, first)).transpose()?;
        let began = (clock.seconds(), task.budget().done);
        let mut skips = Skips::default();
        let (mut latest, mut score, mut interrupted) = (None, None, false);
        let mut saved = Some(first).filter(|iteration| *iteration > 0);
        let mut last = collective.any(task.budget().is_spent(clock.seconds()));
        while !last {
            if collective.any(self.stop.load(Ordering::SeqCst)) {
                interrupted = true;
                break;
            }
            let metrics = task.step()?;
            skips.follow(&task.scalars(&metrics), task.iteration())?;
            let (iteration, budget, seconds) = (task.iteration(), task.budget(), clock.seconds());
            last = collective.any(budget.is_spent(seconds));
            if let Some(log) = &mut log {
                log.step(task, &metrics, seconds)?;
            }
            score = None;
            if schedule.validates(iteration, last) {
                // Validation is not training: the clock stands still.
                clock.stop();
                let validation = task.validate()?;
                clock.go_on();
                score = validation.as_ref().and_then(|v| v.score);
                if let (Some(log), Some(validation)) = (&mut log, validation) {
                    let index = iteration / schedule.validate_every;
                    log.validation(iteration, if last { None } else { Some(index) }, &validation)?;
                }
            }
            let rate = (seconds - began.0) / (budget.done - began.1).max(1) as f64;
            let by_work = rate * budget.total.saturating_sub(budget.done) as f64;
            each(&Progress {
                iteration,
                done: budget.done,
                total: budget.total,
                seconds,
                remaining_seconds: budget.seconds_left(seconds).map_or(by_work, |by_clock| by_work.min(by_clock)),
                metrics: &metrics,
            });
            latest = Some(metrics);
            if iteration.is_multiple_of(schedule.checkpoint_every) {
                self.save(task, &checkpoints, log.as_mut(), score)?;
                saved = Some(iteration);
                // A run that goes on can be looked at.
                if log.is_some() {
                    task.finish(folder)?;
                }
            }
        }
        if saved != Some(task.iteration()) {
            self.save(task, &checkpoints, log.as_mut(), score)?;
        }
        let seconds = clock.seconds();
        if let Some(log) = log {
            task.finish(folder)?;
            log.end(folder, task, latest.as_ref(), seconds)?;
        }
        let budget = task.budget();
        Ok(Summary { metrics: latest, iteration: task.iteration(), done: budget.done, seconds, interrupted })
    }

    /// Saves everything that the rest of the run depends on.
    fn save<T: TrainingTask>(
        &self,
        task: &T,
        checkpoints: &Checkpoints,
        log: Option<&mut RunLog>,
        score: Option<f64>,
    ) -> Result<(), T::Error> {
        let position = log.map(RunLog::sync).transpose()?.unwrap_or_default();
        let mut checkpoint = task.checkpoint()?;
        position.write(&mut checkpoint, &task.identity(), self.collective.size())?;
        let bytes = checkpoint.to_bytes().map_err(TrainError::from)?;
        checkpoints.save(task.iteration(), score, &bytes).map_err(TrainError::from)?;
        Ok(())
    }
}
