//! `train --dry-run`: a few seconds of a training, from which its speed, memory and time follow.

use std::time::{Duration, Instant};

use lifelike_report::run::RunFolder;
use lifelike_train::Budget;
use serde_json::json;

use crate::commands::machine::peak_memory;
use crate::error::CliError;
use crate::output::Output;
use crate::progress::duration;

/// Time that a training is tried for.
const TRIED: Duration = Duration::from_secs(5);

/// A training that is tried: its work is timed from the end of its first step, which also prepares what later steps reuse.
pub struct Rehearsal {
    began: Instant,
    /// End of the first step, and the work done by then.
    first: Option<(Instant, u64)>,
    /// The last step likewise.
    last: Option<(Instant, u64)>,
}

impl Rehearsal {
    /// Starts the clock.
    pub fn begin() -> Self {
        Self { began: Instant::now(), first: None, last: None }
    }

    /// Notes the work done after a step, and returns whether the speed is known well enough.
    pub fn is_enough(&mut self, done: u64) -> bool {
        let now = (Instant::now(), done);
        self.last = self.first.map(|_| now);
        let (start, _) = *self.first.get_or_insert(now);
        self.last.is_some() && start.elapsed() >= TRIED
    }

    /// Returns the work done in a second; of the first step where there was no other.
    fn rate(&self) -> f64 {
        let (start, end) = match (self.first, self.last) {
            (Some(first), Some(last)) => (first, last),
            (Some(first), None) => ((self.began, 0), first),
            _ => return 0.0,
        };
        (end.1 - start.1) as f64 / (end.0 - start.0).as_secs_f64().max(1e-9)
    }

    /// Prints the resolved plan, and what a run of it takes on this machine.
    ///
    /// # Errors
    /// [`CliError::Failed`] where the plan cannot be read back or standard output cannot be written.
    pub fn report(&self, budget: &Budget, run: &RunFolder, output: &Output) -> Result<(), CliError> {
        let plan = std::fs::read_to_string(run.plan_path()).map_err(CliError::write(&run.plan_path()))?;
        let rate = self.rate();
        let by_work = budget.total as f64 / rate.max(1e-9);
        let seconds = budget.minutes.map_or(by_work, |minutes| by_work.min(60.0 * minutes));
        let memory = peak_memory();
        let value = json!({
            "plan": plan, "total": budget.total, "per_second": rate, "seconds": seconds, "memory_bytes": memory,
        });
        output.result(&value, || {
            let memory = memory.map_or_else(|| "unknown".into(), |bytes| format!("{:.0} MB", bytes as f64 / 1e6));
            format!(
                "{plan}\nspeed:   {} per second (measured here, now)\nbudget:  {}\ntime:    {}\nmemory:  {memory} so far\n\
                 Nothing was written. Run the same without --dry-run to train.\n",
                significant(rate),
                words(budget),
                duration(seconds),
            )
        })
    }
}

/// Returns the budget in words.
fn words(budget: &Budget) -> String {
    match budget.minutes {
        Some(minutes) => format!("{} or {minutes} min, whichever ends first", budget.total),
        None => budget.total.to_string(),
    }
}

/// Returns a rate with the digits that mean something.
fn significant(rate: f64) -> String {
    if rate >= 10.0 { format!("{rate:.0}") } else { format!("{rate:.2}") }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn the_first_step_is_not_timed_where_there_is_another() {
        let began = Instant::now();
        let at = |seconds: f64| began + Duration::from_secs_f64(seconds);
        let slow_start = Rehearsal { began, first: Some((at(10.0), 100)), last: Some((at(12.0), 300)) };
        assert!((slow_start.rate() - 100.0).abs() < 1e-9);
        let one_step = Rehearsal { began, first: Some((at(10.0), 100)), last: None };
        assert!((one_step.rate() - 10.0).abs() < 1e-9);
        assert_eq!(Rehearsal::begin().rate(), 0.0);
    }
}
