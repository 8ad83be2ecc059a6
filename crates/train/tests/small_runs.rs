//! A promise: what a run writes stays small however long it is, and resuming changes no byte of it.
//!
//! Nothing is learned here: the task makes up the numbers of a tracker on 1000 clips (45 metrics with all their digits).

#![allow(clippy::unwrap_used)]

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

use lifelike_checkpoint::Checkpoint;
use lifelike_report::run::{RunFolder, Snapshot};
use lifelike_train::collective::Alone;
use lifelike_train::{Budget, LogSchedule, Scalar, Schedule, TrainError, TrainingRun, TrainingTask, Validation};

const CLIPS: usize = 1000;
const METRICS: usize = 45;
/// Environment steps of an iteration: the default plan's 256 environments with 12 steps.
const STEPS: u64 = 3072;

/// A training that only counts.
struct Counter {
    iteration: u64,
    iterations: u64,
    checkpoint_every: u64,
    data: &'static str,
}

/// A number that looks like a measured one.
fn number(a: u64, b: usize) -> f64 {
    ((a as f64 + 0.37) * (b as f64 + 1.7)).sin()
}

impl TrainingTask for Counter {
    type Metrics = ();
    type Error = TrainError;

    fn iteration(&self) -> u64 {
        self.iteration
    }

    fn budget(&self) -> Budget {
        Budget { done: STEPS * self.iteration, total: STEPS * self.iterations, minutes: None }
    }

    fn schedule(&self) -> Schedule {
        Schedule { checkpoint_every: self.checkpoint_every, validate_every: 100, keep: 2 }
    }

    fn identity(&self) -> Vec<(&'static str, String)> {
        vec![("data", self.data.into())]
    }

    fn step(&mut self) -> Result<(), TrainError> {
        self.iteration += 1;
        Ok(())
    }

    fn scalars(&self, (): &()) -> Vec<Scalar> {
        (0..METRICS).map(|k| (format!("Reward/some_term_of_it_{k:02}"), number(self.iteration, k))).collect()
    }

    fn timings(&self, (): &()) -> Vec<Scalar> {
        (0..4).map(|k| (format!("Perf/some_time_{k}"), number(self.iteration, k))).collect()
    }

    fn validate(&mut self) -> Result<Option<Validation>, TrainError> {
        let mse = number(self.iteration, 0);
        Ok(Some(Validation { scalars: vec![("Validation/mse".into(), mse)], score: Some(-mse) }))
    }

    fn snapshot(&self) -> Option<Snapshot> {
        let column = |k: usize| (0..CLIPS).map(|clip| number(self.iteration, k + clip)).collect();
        let items = (0..CLIPS).map(|clip| format!("a_clip_with_a_name_{clip:04}")).collect();
        Some(Snapshot { items, columns: vec![("survival", column(0)), ("seen", column(1))] })
    }

    fn checkpoint(&self) -> Result<Checkpoint, TrainError> {
        let mut checkpoint = Checkpoint::new();
        checkpoint.put_u64("progress", &[1], vec![self.iteration])?;
        Ok(checkpoint)
    }

    fn restore(&mut self, checkpoint: &Checkpoint) -> Result<(), TrainError> {
        self.iteration = checkpoint.u64s("progress", &[1])?[0];
        Ok(())
    }
}

fn plan() -> BTreeMap<String, u64> {
    BTreeMap::from([("seed".to_string(), 1)])
}

/// Goes on with a run of so many iterations, until it is done or stopped after an iteration.
fn go_on(folder: &Path, iterations: u64, checkpoint_every: u64, stop: u64) -> Result<RunFolder, TrainError> {
    let folder = RunFolder::open_or_create(folder, &plan())?;
    let flag = AtomicBool::new(false);
    let mut task = Counter { iteration: 0, iterations, checkpoint_every, data: "these" };
    let run = TrainingRun { folder: &folder, stop: &flag, collective: &Alone };
    let summary = run.run(&mut task, |now| flag.store(now.iteration == stop, Ordering::SeqCst))?;
    assert_eq!((summary.iteration, summary.interrupted), (iterations.min(stop), stop < iterations));
    Ok(folder)
}

fn bytes(folder: &Path) -> u64 {
    let entries = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap());
    entries.map(|e| if e.path().is_dir() { bytes(&e.path()) } else { e.metadata().unwrap().len() }).sum()
}

#[test]
fn a_thousand_million_steps_on_a_thousand_clips_write_less_than_a_hundred_megabytes() {
    let place = tempfile::tempdir().unwrap();
    let iterations = 1_000_000_000 / STEPS;
    go_on(place.path(), iterations, 10_000, u64::MAX).unwrap();
    let written = bytes(place.path());
    for entry in std::fs::read_dir(place.path()).unwrap().map(|e| e.unwrap()) {
        println!("{:>12} {}", entry.metadata().unwrap().len(), entry.file_name().display());
    }
    println!("{written} bytes of {iterations} iterations");
    assert!(written < 50_000_000, "{written} bytes");
    // Even iterations of one step each: lines grow with the logarithm of their number.
    let lines = |n| LogSchedule::SCALARS.lines(n) as f64;
    assert!(written as f64 * lines(1_000_000_000) / lines(iterations) < 1e8);
}

#[test]
fn a_resumed_run_leaves_the_bytes_of_one_that_ran_through_where_lines_are_thinned_too() {
    let place = tempfile::tempdir().unwrap();
    let (whole, parts) = (place.path().join("whole"), place.path().join("parts"));
    go_on(&whole, 5000, 500, u64::MAX).unwrap();
    for stop in [7, 1999, 3001, 4444, u64::MAX] {
        go_on(&parts, 5000, 500, stop).unwrap();
    }
    for file in ["metrics.jsonl", "snapshots.jsonl", "checkpoints/00005000.safetensors"] {
        assert!(std::fs::read(whole.join(file)).unwrap() == std::fs::read(parts.join(file)).unwrap(), "{file}");
    }
    let folder = RunFolder::open(&whole).unwrap();
    let validations = folder.metrics().unwrap().into_iter().filter(|row| row.values.len() == 1).count();
    assert_eq!(validations, 50, "a validation is logged whichever iteration it falls on");
}

#[test]
fn the_best_checkpoint_stays_beside_the_last_two() {
    let place = tempfile::tempdir().unwrap();
    let folder = go_on(place.path(), 1500, 100, u64::MAX).unwrap();
    let checkpoints = folder.checkpoints(2);
    // The least of the made-up errors.
    let best = (1..=15).map(|k| 100 * k).min_by(|a, b| number(*a, 0).total_cmp(&number(*b, 0))).unwrap();
    assert_eq!((best, checkpoints.best().unwrap().iteration), (1200, 1200));
    assert_eq!(checkpoints.list().iter().map(|info| info.iteration).collect::<Vec<_>>(), [1200, 1400, 1500]);
}

#[test]
fn a_run_of_other_data_is_refused_with_the_reason() {
    let place = tempfile::tempdir().unwrap();
    let folder = go_on(place.path(), 10, 5, 6).unwrap();
    let mut other = Counter { iteration: 0, iterations: 10, checkpoint_every: 5, data: "those" };
    let run = TrainingRun { folder: &folder, stop: &AtomicBool::new(false), collective: &Alone };
    let error = run.run(&mut other, |_| {}).unwrap_err().to_string();
    assert!(error.contains("00000006.safetensors: data: expected the data that the run began with"), "{error}");
}

#[test]
fn progress_tells_what_is_left() {
    let place = tempfile::tempdir().unwrap();
    let folder = RunFolder::open_or_create(place.path(), &plan()).unwrap();
    let mut task = Counter { iteration: 0, iterations: 4, checkpoint_every: 10, data: "these" };
    let run = TrainingRun { folder: &folder, stop: &AtomicBool::new(false), collective: &Alone };
    let mut seen = Vec::new();
    run.run(&mut task, |now| {
        assert_eq!(now.remaining_seconds > 0.0, now.iteration < 4);
        seen.push((now.done, now.total));
    })
    .unwrap();
    assert_eq!(seen, [1, 2, 3, 4].map(|i| (i * STEPS, 4 * STEPS)));
}
