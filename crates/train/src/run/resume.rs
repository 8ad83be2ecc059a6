//! Going on with a run: which checkpoint, by which right, and from where in its files.

use std::collections::BTreeMap;

use lifelike_checkpoint::Checkpoint;
use lifelike_report::run::{Checkpoints, RunFolder, read_metrics};

use super::log::WALL_TIME;
use crate::collective::Collective;
use crate::task::TrainingTask;
use crate::{FromInput, TrainError};

const POSITION: &str = "run.position";
const PROCESSES: &str = "run.processes";
const IDENTITY: &str = "run.identity";

/// Lengths of the files that grow with a run, when a checkpoint was made (bytes).
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Position {
    pub metrics: u64,
    pub snapshots: u64,
}

impl Position {
    /// Reads the position from a checkpoint.
    fn read(checkpoint: &Checkpoint) -> Result<Self, TrainError> {
        let position = checkpoint.u64s(POSITION, &[2])?;
        Ok(Self { metrics: position[0], snapshots: position[1] })
    }

    /// Writes it, with what a resumed run is checked against.
    pub fn write(
        self,
        checkpoint: &mut Checkpoint,
        identity: &[(&'static str, String)],
        processes: usize,
    ) -> Result<(), TrainError> {
        checkpoint.put_u64(POSITION, &[2], vec![self.metrics, self.snapshots])?;
        checkpoint.put_u64(PROCESSES, &[1], vec![processes as u64])?;
        let identity: BTreeMap<&str, &String> = identity.iter().map(|(name, text)| (*name, text)).collect();
        Ok(checkpoint.set_meta(IDENTITY, &identity)?)
    }
}

/// Finds the checkpoint to go on from: the latest that every process has. A kill may have come when only some had saved.
pub fn latest_of_all(
    folder: &RunFolder,
    checkpoints: &Checkpoints,
    collective: &dyn Collective,
) -> Result<Option<Checkpoint>, TrainError> {
    let own = checkpoints.latest();
    let found = if collective.size() == 1 {
        own
    } else {
        let own = own.map_or(0, |(info, _)| info.iteration);
        let least = collective.gather(own as f64).into_iter().fold(f64::INFINITY, f64::min) as u64;
        match checkpoints.list().into_iter().find(|info| info.iteration == least) {
            _ if least == 0 => None,
            Some(info) => Some((info.clone(), checkpoints.read(&info)?)),
            None => {
                let what = format!("checkpoints of process {}", collective.rank());
                let expected = format!("one of iteration {least}, the latest that another process has");
                return Err(TrainError::mismatch(what, expected, format!("up to {own}, but not that one")));
            }
        }
    };
    match found {
        Some((info, bytes)) => Ok(Some(Checkpoint::from_bytes(&bytes, &checkpoints.path(info.iteration))?)),
        // Beginning anew would overwrite what may still be saved.
        None if !checkpoints.list().is_empty() && collective.size() == 1 => Err(TrainError::mismatch(
            folder.path().display(),
            "a checkpoint that is whole",
            "damaged ones only; put back a copy of checkpoints/, or begin anew in another folder",
        )),
        None => Ok(None),
    }
}

/// Restores a task, and returns where its files stood.
pub fn restore<T: TrainingTask>(task: &mut T, checkpoint: &Checkpoint, size: usize) -> Result<Position, T::Error> {
    task.restore(checkpoint)?;
    check(checkpoint, &task.identity(), size)?;
    Ok(Position::read(checkpoint)?)
}

/// Checks that a checkpoint is of the same plan, data and number of processes.
fn check(checkpoint: &Checkpoint, identity: &[(&'static str, String)], size: usize) -> Result<(), TrainError> {
    let origin = checkpoint.origin();
    let processes = checkpoint.u64s(PROCESSES, &[1])?[0];
    if processes != size as u64 {
        return Err(TrainError::mismatch(format!("{origin}: processes of the run"), processes, size));
    }
    let began: BTreeMap<String, String> = checkpoint.meta(IDENTITY)?;
    match identity.iter().find(|(name, text)| began.get(*name) != Some(text)) {
        None => Ok(()),
        Some((name, _)) => Err(TrainError::mismatch(
            format!("{origin}: {name}"),
            format!("the {name} that the run began with"),
            "another",
        )),
    }
}

/// Returns the time spent training until an iteration, by the clock's file (s). After many iterations not each of them is in
/// the file: the latest before it counts.
pub fn seconds_until(folder: &RunFolder, iteration: u64) -> Result<f64, TrainError> {
    let path = folder.timing_path();
    if iteration == 0 || !path.is_file() {
        return Ok(0.0);
    }
    // Iterations after the checkpoint were lost with the kill and are passed again: the last line counts.
    let rows = read_metrics(&path)?;
    let row = rows.iter().rfind(|row| row.iteration <= iteration);
    let seconds = row.and_then(|row| row.values.iter().find(|(name, _)| name == WALL_TIME));
    Ok(seconds.map_or(0.0, |(_, seconds)| *seconds))
}
