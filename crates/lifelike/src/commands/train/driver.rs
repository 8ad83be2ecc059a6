//! Any training in a run's folder, with a progress bar and Ctrl-C.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use lifelike_report::run::RunFolder;
use lifelike_train::collective::{Alone, Collective};
use lifelike_train::{Summary, TrainingRun, TrainingTask};

use super::rehearsal::Rehearsal;
use super::source::{Run, Source};
use super::watch::{Look, Watch};
use crate::commands::machine::Machine;
use crate::error::CliError;
use crate::interrupt;
use crate::output::Output;
use crate::progress::{Progress, duration};

/// Surroundings of a training.
pub struct Driver<'a> {
    /// The run's folder; the run in it is gone on with.
    pub folder: &'a RunFolder,
    /// The processes that train together; only the first shows progress.
    pub collective: &'a dyn Collective,
    /// After which this sitting is stopped, done or not.
    pub minutes: Option<f64>,
    /// Destination of progress and results.
    pub output: &'a Output,
    /// Write a page that follows the training.
    pub watch: bool,
    /// The policy that the page shows.
    pub look: Option<&'a Look<'a>>,
    /// Train for a few seconds only, and report speed, memory and total time.
    pub rehearsal: bool,
}

impl<'a> Driver<'a> {
    /// Surroundings of one process, without a limit of time.
    pub fn new(folder: &'a RunFolder, output: &'a Output) -> Self {
        Self { folder, collective: &Alone, minutes: None, output, watch: false, look: None, rehearsal: false }
    }

    /// Surroundings of one process, as its arguments say.
    pub fn of(source: &Source, run: &'a Run, output: &'a Output) -> Self {
        Self { watch: source.watch, rehearsal: run.is_rehearsal(), ..Self::new(run, output) }
    }

    /// Trains until the budget is spent, the minutes are over, or Ctrl-C, which alone counts as an interruption.
    /// Returns nothing after a dry run, whose report is printed.
    pub fn train<T: TrainingTask>(
        &self,
        task: &mut T,
        mut words: impl FnMut(&lifelike_train::Progress<'_, T::Metrics>) -> String,
    ) -> Result<Option<Summary<T::Metrics>>, CliError>
    where
        CliError: From<T::Error>,
    {
        let interrupted = interrupt::flag()?;
        let stop = AtomicBool::new(interrupted.load(Ordering::SeqCst));
        let quiet = Output { quiet: true, ..*self.output };
        let first = self.collective.rank() == 0;
        let _lock = first.then(|| self.folder.lock()).transpose()?;
        if first {
            Machine::this().record(self.folder)?;
        }
        let output = if first { self.output } else { &quiet };
        let mut progress = Progress::new(output, "training", task.budget().total);
        let began = Instant::now();
        let run = TrainingRun { folder: self.folder, stop: &stop, collective: self.collective };
        let mut page =
            (first && self.watch).then(|| Watch::begin(self.folder, task.headlines(), self.look)).transpose()?;
        let mut rehearsal = self.rehearsal.then(Rehearsal::begin);
        let mut summary = run.run(task, |now| {
            let sitting = self.minutes.map(|minutes| 60.0 * minutes - began.elapsed().as_secs_f64());
            let left = sitting.map_or(now.remaining_seconds, |sitting| now.remaining_seconds.min(sitting));
            let share = now.seconds / (now.seconds + left).max(1e-9);
            let words = words(now);
            progress.update_time(share, left, || format!("{words}  {}", steps_of(now.done, now.total)));
            if let Some(page) = page.as_mut().filter(|page| page.is_due()) {
                let facts = facts("trains", now.done, now.total, now.seconds, Some(left), &words);
                // A page that cannot be written is no reason to stop.
                if let Err(error) = page.show(now.iteration, &facts, false) {
                    tracing::warn!("live page: {error}");
                }
            }
            let rehearsed = rehearsal.as_mut().is_some_and(|rehearsal| rehearsal.is_enough(now.done));
            let late = rehearsed || sitting.is_some_and(|sitting| sitting < 0.0);
            stop.store(late || interrupted.load(Ordering::SeqCst), Ordering::SeqCst);
        })?;
        progress.finish();
        if let Some(rehearsal) = rehearsal {
            if first {
                rehearsal.report(&task.budget(), self.folder, self.output)?;
            }
            return Ok(None);
        }
        if let Some(page) = &mut page {
            let state = if interrupted.load(Ordering::SeqCst) { "stopped" } else { "done" };
            let facts = facts(state, summary.done, task.budget().total, summary.seconds, None, "");
            page.show(summary.iteration, &facts, true)?;
        }
        summary.interrupted &= self.collective.size() > 1 || interrupted.load(Ordering::SeqCst);
        Ok(Some(summary))
    }
}

/// Facts at the top of the live page.
fn facts(
    state: &str,
    done: u64,
    total: u64,
    seconds: f64,
    left: Option<f64>,
    words: &str,
) -> Vec<(&'static str, String)> {
    let left = left.map(|left| ("left", duration(left)));
    let mut facts = vec![("state", state.to_string()), ("done", steps_of(done, total)), ("trained", duration(seconds))];
    facts.extend(left);
    facts.extend((!words.is_empty()).then(|| ("now", words.to_string())));
    facts
}

/// Returns the work done of all in a few characters.
fn steps_of(done: u64, total: u64) -> String {
    let short = |n: u64| match n {
        0..10_000 => n.to_string(),
        10_000..10_000_000 => format!("{}k", n / 1000),
        _ => format!("{:.0}M", n as f64 / 1e6),
    };
    format!("{} of {}", short(done), short(total))
}
