//! The iterations whose numbers are written to a run's files: all of them at first, fewer and fewer later.

/// Iterations that are logged before the first thinning of [`LogSchedule::SCALARS`].
const SCALARS: u64 = 1000;
/// The same of [`LogSchedule::SNAPSHOTS`].
const SNAPSHOTS: u64 = 8;

/// A schedule that keeps a file small however long a run becomes: every time that the iterations double beyond the first `2 n`,
/// the distance between two logged ones doubles too, so each doubling adds `n` lines.
///
/// It depends on nothing but the iteration, so a run that was stopped and resumed writes the bytes of one that was not.
///
/// ```
/// use lifelike_train::LogSchedule;
///
/// let schedule = LogSchedule::new(1000);
/// assert!((0..2000).all(|i| schedule.is_due(i)));
/// assert_eq!((4000..8000).filter(|i| schedule.is_due(*i)).count(), 1000); // every fourth
/// assert_eq!(schedule.lines(1_000_000), 10_953);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LogSchedule {
    per_doubling: u64,
}

impl LogSchedule {
    /// Schedule of a run's scalars: metrics, timing and events.
    pub const SCALARS: Self = Self { per_doubling: SCALARS };
    /// Schedule of tables with a value for each item.
    pub const SNAPSHOTS: Self = Self { per_doubling: SNAPSHOTS };

    /// Creates a schedule of so many lines (at least one) per doubling of the iterations.
    pub fn new(per_doubling: u64) -> Self {
        Self { per_doubling: per_doubling.max(1) }
    }

    /// Returns whether an iteration is logged.
    pub fn is_due(self, iteration: u64) -> bool {
        let doublings = (iteration / self.per_doubling).max(1).ilog2();
        iteration.is_multiple_of(1 << doublings)
    }

    /// Returns the number of lines of a run's first iterations, counted from 1.
    pub fn lines(self, iterations: u64) -> u64 {
        let n = self.per_doubling;
        let doublings = (iterations / n).max(1).ilog2();
        if doublings == 0 {
            return iterations;
        }
        (2 * n - 1) + u64::from(doublings - 1) * n + (iterations - (n << doublings)) / (1 << doublings) + 1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_counted_without_going_through_them() {
        let schedule = LogSchedule::new(10);
        let mut count = 0;
        for i in 1..5000 {
            count += u64::from(schedule.is_due(i));
            assert_eq!(schedule.lines(i), count, "{i}");
        }
        assert_eq!(schedule.lines(0), 0);
    }

    #[test]
    fn a_thousand_million_iterations_are_some_twenty_thousand_lines() {
        assert_eq!(LogSchedule::SCALARS.lines(1_000_000_000), 20_907);
        assert!(LogSchedule::SNAPSHOTS.lines(1_000_000_000) < 250);
    }
}
