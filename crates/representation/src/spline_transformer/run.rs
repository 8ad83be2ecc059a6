//! A training with a folder: metrics, checkpoints, and the loss of validation against iterations and time.

use std::fs;
use std::ops::ControlFlow;
use std::path::Path;
use std::time::Instant;

use lifelike_checkpoint::Checkpoint;
use lifelike_nn::device::Device;
use serde::Serialize;
use serde::de::DeserializeOwned;

use super::plan::SequencePlan;
use super::sequences::{HeldOut, Sequences};
use super::train::{SequenceMetrics, SequenceTrainer};
use crate::RepresentationError;
use lifelike_report::run::{Checkpoints, MetricsWriter, RunFolder, read_metrics};

/// One look at the validation set.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Look {
    /// Iterations done.
    pub iteration: u64,
    /// Time spent training until then, all sittings together (s). NaN where the clock's file does not know.
    pub seconds: f64,
    /// Mean squared error.
    pub mse: f64,
    /// As [`super::SequenceErrors::spread`].
    pub spread: f64,
}

/// Trains in a folder until the plan is done or `each` (called after every iteration) breaks. A folder with a run of the same
/// plan is gone on with; what stands in it in the end is the same, bit for bit, however often it was stopped, but for the
/// clock's file. Returns the trainer, which [`SequenceTrainer::is_done`] or not.
///
/// # Errors
/// A run of another plan in the folder; files that cannot be read or written; a plan out of range.
pub fn train<P, S>(
    folder: &Path,
    plan: &P,
    training: &SequencePlan,
    data: S,
    device: &Device,
    mut each: impl FnMut(&SequenceMetrics) -> ControlFlow<()>,
) -> Result<SequenceTrainer<S>, RepresentationError>
where
    P: Serialize + DeserializeOwned + PartialEq,
    S: Sequences,
{
    let run = open(folder, plan)?;
    let checkpoints = run.checkpoints(1);
    let (mut trainer, mut metrics, mut spent) = match checkpoints.latest() {
        Some((info, bytes)) => {
            let checkpoint = Checkpoint::from_bytes(&bytes, &checkpoints.path(info.iteration))?;
            let position = checkpoint.u64s("metrics", &[1])?[0];
            let spent = seconds(&run)?.into_iter().rfind(|(i, _)| *i == info.iteration).map_or(0.0, |(_, s)| s);
            let metrics = run.resume_metrics(position, info.iteration)?;
            (SequenceTrainer::resume(&checkpoint, data)?.to_device(device), metrics, spent)
        }
        None => (SequenceTrainer::new(training.clone(), data)?.to_device(device), run.start_metrics()?, 0.0),
    };
    let mut began = Instant::now();
    while !trainer.is_done() {
        let now = trainer.step()?;
        let looks = trainer.is_done() || now.iteration % training.validate_every == 0;
        let stops = each(&now).is_break();
        log(&mut metrics, &now)?;
        if looks || stops {
            // Validation is not training: the clock stands still.
            spent += began.elapsed().as_secs_f64();
            if looks {
                let errors = trainer.errors(HeldOut::Validation)?;
                let values = [("Validation/mse", errors.mse), ("Validation/spread", errors.spread)];
                metrics.log(now.iteration, &values)?;
            }
            metrics.log_timing(now.iteration, &[("Perf/wall_time", spent)])?;
            save(&trainer, &mut metrics, &checkpoints)?;
            began = Instant::now();
        }
        if stops {
            break;
        }
    }
    Ok(trainer)
}

/// The looks at the validation set so far.
///
/// # Errors
/// Not a run's folder, or files that are not what they should be.
pub fn looks(folder: &Path) -> Result<Vec<Look>, RepresentationError> {
    let run = RunFolder::open(folder)?;
    let times = seconds(&run)?;
    let of = |values: &[(String, f64)], name: &str| values.iter().find(|(n, _)| n == name).map(|(_, v)| *v);
    let mut looks = Vec::new();
    for row in run.metrics()? {
        let Some(mse) = of(&row.values, "Validation/mse") else { continue };
        // A stopped run may have passed an iteration twice; the later time is the one that counts.
        let seconds = times.iter().rfind(|(i, _)| *i == row.iteration).map_or(f64::NAN, |(_, s)| *s);
        let spread = of(&row.values, "Validation/spread").unwrap_or(f64::NAN);
        looks.push(Look { iteration: row.iteration, seconds, mse, spread });
    }
    Ok(looks)
}

fn open<P: Serialize + DeserializeOwned + PartialEq>(
    folder: &Path,
    plan: &P,
) -> Result<RunFolder, RepresentationError> {
    if !folder.join("plan.toml").exists() {
        return Ok(RunFolder::create(folder, plan)?);
    }
    let run = RunFolder::open(folder)?;
    if run.plan::<P>()? == *plan {
        return Ok(run);
    }
    Err(RepresentationError::Mismatch {
        what: run.plan_path().display().to_string(),
        expected: "the plan that is asked for".into(),
        got: "another one (name another folder)".into(),
    })
}

fn log(metrics: &mut MetricsWriter, now: &SequenceMetrics) -> Result<(), RepresentationError> {
    let values = [
        ("Loss/training", now.loss),
        ("Schedule/learning_rate", now.learning_rate),
        ("Gradient/norm", now.gradient_norm),
        ("Gradient/skipped", now.skipped as f64),
    ];
    Ok(metrics.log(now.iteration, &values)?)
}

fn save<S: Sequences>(
    trainer: &SequenceTrainer<S>,
    metrics: &mut MetricsWriter,
    checkpoints: &Checkpoints,
) -> Result<(), RepresentationError> {
    let mut checkpoint = trainer.checkpoint()?;
    checkpoint.put_u64("metrics", &[1], vec![metrics.sync()?])?;
    checkpoints.save(trainer.iteration(), None, &checkpoint.to_bytes()?)?;
    Ok(())
}

/// Iterations and the time spent until then (s).
fn seconds(run: &RunFolder) -> Result<Vec<(u64, f64)>, RepresentationError> {
    if !fs::exists(run.timing_path()).unwrap_or(false) {
        return Ok(Vec::new());
    }
    let rows = read_metrics(&run.timing_path())?.into_iter();
    Ok(rows.filter_map(|row| Some((row.iteration, row.values.first()?.1))).collect())
}
