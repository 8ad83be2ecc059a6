//! The files that grow with a run, and stay small.

use lifelike_report::run::{MetricsWriter, RunFolder, SnapshotWriter};
use lifelike_report::{ReportBuilder, curves_from};

use super::resume::Position;
use crate::TrainError;
use crate::log_schedule::LogSchedule;
use crate::task::{Scalar, TrainingTask, Validation};

/// Name of the time since the run began.
pub const WALL_TIME: &str = "Perf/wall_time";

/// Metrics, timing, events and snapshots of a run.
pub struct RunLog {
    metrics: MetricsWriter,
    snapshots: SnapshotWriter,
    /// Iteration of the last line of timing.
    timed: u64,
}

impl RunLog {
    /// Opens the files where a checkpoint of so many iterations left them.
    pub fn open(folder: &RunFolder, position: Position, iteration: u64) -> Result<Self, TrainError> {
        Ok(Self {
            metrics: folder.resume_metrics(position.metrics, iteration)?,
            snapshots: folder.resume_snapshots(position.snapshots)?,
            timed: iteration,
        })
    }

    /// Logs a step, if it is due.
    pub fn step<T: TrainingTask>(&mut self, task: &T, metrics: &T::Metrics, seconds: f64) -> Result<(), TrainError> {
        let iteration = task.iteration();
        if LogSchedule::SNAPSHOTS.is_due(iteration)
            && let Some(snapshot) = task.snapshot()
        {
            self.snapshots.write(iteration, &snapshot)?;
        }
        if LogSchedule::SCALARS.is_due(iteration) {
            self.metrics.log(iteration, &borrowed(&task.scalars(metrics)))?;
            self.time(task, Some(metrics), seconds)?;
        }
        Ok(())
    }

    fn time<T: TrainingTask>(
        &mut self,
        task: &T,
        metrics: Option<&T::Metrics>,
        seconds: f64,
    ) -> Result<(), TrainError> {
        let mut timings = metrics.map_or_else(Vec::new, |metrics| task.timings(metrics));
        timings.push((WALL_TIME.into(), seconds));
        self.timed = task.iteration();
        Ok(self.metrics.log_timing(self.timed, &borrowed(&timings))?)
    }

    /// Logs a validation, the `index`-th of the run, if it is due. One without index is the run's last and always due.
    pub fn validation(
        &mut self,
        iteration: u64,
        index: Option<u64>,
        validation: &Validation,
    ) -> Result<(), TrainError> {
        if index.is_none_or(|index| LogSchedule::SCALARS.is_due(index)) {
            self.metrics.log(iteration, &borrowed(&validation.scalars))?;
        }
        Ok(())
    }

    /// Makes sure that the files are on the disk, and returns their lengths.
    pub fn sync(&mut self) -> Result<Position, TrainError> {
        Ok(Position { metrics: self.metrics.sync()?, snapshots: self.snapshots.sync()? })
    }

    /// Writes the last time and the report.
    pub fn end<T: TrainingTask>(
        mut self,
        folder: &RunFolder,
        task: &T,
        metrics: Option<&T::Metrics>,
        seconds: f64,
    ) -> Result<(), TrainError> {
        if self.timed < task.iteration() {
            self.time(task, metrics, seconds)?;
        }
        let mut report = ReportBuilder::new(format!("Training of {}", folder.path().display()))
            .fact("iterations", task.iteration().to_string())
            .fact("minutes", format!("{:.1}", seconds / 60.0))
            .headlines(task.headlines());
        for (name, value) in metrics.map(|metrics| task.scalars(metrics)).unwrap_or_default() {
            if task.headlines().contains(&name.as_str()) {
                let words = name.rsplit('/').next().unwrap_or(&name).replace('_', " ");
                report = report.fact(&words, format!("{value:.3}"));
            }
        }
        task.report(report).curves(curves_from(&folder.metrics()?)).write(&folder.report_path())?;
        Ok(())
    }
}

fn borrowed(scalars: &[Scalar]) -> Vec<(&str, f64)> {
    scalars.iter().map(|(name, value)| (name.as_str(), *value)).collect()
}
