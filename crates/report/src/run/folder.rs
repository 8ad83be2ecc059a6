//! The folder of a run.

use std::fs::{self, File, OpenOptions, TryLockError};
use std::path::{Path, PathBuf};

use serde::Serialize;
use serde::de::DeserializeOwned;

use super::checkpoints::Checkpoints;
use super::metrics::{MetricsRow, MetricsWriter, read_metrics};
use super::snapshots::SnapshotWriter;
use crate::atomic::write_atomically;
use crate::{FromInput, ReportError};

/// The folder of a run, with its files by name.
///
/// ```
/// use lifelike_report::run::RunFolder;
///
/// #[derive(serde::Serialize)]
/// struct Plan {
///     steps: u64,
/// }
///
/// # let path = std::env::temp_dir().join(format!("doctest-run-{}", std::process::id()));
/// let run = RunFolder::create(&path, &Plan { steps: 2 })?;
/// let mut metrics = run.start_metrics()?;
/// metrics.log(0, &[("Loss/total", 0.5)])?;
/// metrics.sync()?;
/// assert_eq!(run.metrics()?[0].values, [("Loss/total".to_owned(), 0.5)]);
/// assert!(RunFolder::create(&path, &Plan { steps: 3 }).is_err(), "nothing is overwritten");
/// # std::fs::remove_dir_all(&path).ok();
/// # Ok::<(), lifelike_report::ReportError>(())
/// ```
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RunFolder {
    path: PathBuf,
}

/// File whose lock says that a training writes into the folder.
const LOCK: &str = ".lock";

/// The right to train in a folder; the system takes it back when the process ends, however it ends.
#[derive(Debug)]
pub struct RunLock {
    _file: File,
}

impl RunFolder {
    /// Makes the folder and writes the resolved plan into it.
    ///
    /// # Errors
    /// [`ReportError::Input`] when there is a run already: nothing is ever overwritten.
    pub fn create<P: Serialize>(path: impl Into<PathBuf>, plan: &P) -> Result<Self, ReportError> {
        let folder = Self { path: path.into() };
        Self::require_new(&folder.path)?;
        let text = toml::to_string_pretty(plan)
            .map_err(|e| ReportError::format(folder.plan_path().display(), "a plan that can be written as TOML", e))?;
        fs::create_dir_all(&folder.path).map_err(ReportError::io(&folder.path))?;
        write_atomically(&folder.plan_path(), text.as_bytes())?;
        Ok(folder)
    }

    /// Checks that no run is in a folder.
    ///
    /// # Errors
    /// [`ReportError::Input`] when there is one.
    pub fn require_new(path: &Path) -> Result<(), ReportError> {
        if !(Self { path: path.into() }).plan_path().exists() {
            return Ok(());
        }
        let expected = "a folder without a run";
        Err(ReportError::mismatch(path.display(), expected, "a run (resume it with --resume, or name another folder)"))
    }

    /// Opens the folder of a run.
    ///
    /// # Errors
    /// [`ReportError::Input`] when there is no plan in it.
    pub fn open(path: impl Into<PathBuf>) -> Result<Self, ReportError> {
        let folder = Self { path: path.into() };
        if folder.plan_path().is_file() {
            return Ok(folder);
        }
        let got = if folder.path.is_dir() { "a folder without plan.toml" } else { "no folder" };
        Err(ReportError::mismatch(folder.path.display(), "the folder of a run", got))
    }

    /// Opens the folder of a run of this plan, made if it is not there yet.
    ///
    /// # Errors
    /// [`ReportError::Input`] when there is a run of another plan.
    pub fn open_or_create<P: Serialize + DeserializeOwned + PartialEq>(
        path: impl Into<PathBuf>,
        plan: &P,
    ) -> Result<Self, ReportError> {
        let folder = Self { path: path.into() };
        if !folder.plan_path().exists() {
            return Self::create(folder.path, plan);
        }
        if folder.plan::<P>()? == *plan {
            return Ok(folder);
        }
        let expected = "the plan that is asked for";
        Err(ReportError::mismatch(folder.plan_path().display(), expected, "another one (name another folder)"))
    }

    /// Locks the folder for a training that writes into it, until the lock is dropped or the process ends.
    ///
    /// # Errors
    /// [`ReportError::Input`] while another process has the lock, and where the folder cannot be written.
    pub fn lock(&self) -> Result<RunLock, ReportError> {
        let path = self.path.join(LOCK);
        let file =
            OpenOptions::new().create(true).truncate(false).write(true).open(&path).map_err(ReportError::io(&path))?;
        match file.try_lock() {
            Ok(()) => Ok(RunLock { _file: file }),
            Err(TryLockError::WouldBlock) => Err(ReportError::mismatch(
                self.path.display(),
                "a run that nobody trains",
                "one that another process is training; wait for it, or name another folder",
            )),
            Err(TryLockError::Error(error)) => Err(ReportError::io(&path)(error)),
        }
    }

    /// Returns the plan that the run was started with.
    ///
    /// # Errors
    /// [`ReportError::Input`] with line and column.
    pub fn plan<P: DeserializeOwned>(&self) -> Result<P, ReportError> {
        let path = self.plan_path();
        let text = fs::read_to_string(&path).map_err(ReportError::io(&path))?;
        toml::from_str(&text).map_err(|e| ReportError::format(path.display(), "a plan", e))
    }

    /// Starts the metrics of a new run.
    ///
    /// # Errors
    /// [`ReportError::Input`].
    pub fn start_metrics(&self) -> Result<MetricsWriter, ReportError> {
        self.resume_metrics(0, 0)
    }

    /// Continues the metrics of a run from a checkpoint: lines after its byte `position` ([`MetricsWriter::sync`]) are
    /// cut off. The file therefore ends up as in a run that was never killed.
    ///
    /// # Errors
    /// [`ReportError::Input`] when the file is shorter than the checkpoint says: it is not the file of that run.
    pub fn resume_metrics(&self, position: u64, next_iteration: u64) -> Result<MetricsWriter, ReportError> {
        let path = self.metrics_path();
        let file =
            OpenOptions::new().create(true).truncate(false).write(true).open(&path).map_err(ReportError::io(&path))?;
        let length = file.metadata().map_err(ReportError::io(&path))?.len();
        if length < position {
            let expected = format!("at least the {position} bytes that the checkpoint remembers");
            return Err(ReportError::format(path.display(), expected, format!("{length} bytes")));
        }
        file.set_len(position).and_then(|()| file.sync_all()).map_err(ReportError::io(&path))?;
        drop(file);
        MetricsWriter::append(&path, &self.timing_path(), &self.path, next_iteration)
    }

    /// Continues the snapshots of a run from a checkpoint, as [`Self::resume_metrics`] does; from 0 for a new run.
    ///
    /// # Errors
    /// [`ReportError::Input`] when the file is shorter than the checkpoint says: it is not the file of that run.
    pub fn resume_snapshots(&self, position: u64) -> Result<SnapshotWriter, ReportError> {
        SnapshotWriter::resume(&self.snapshots_path(), position)
    }

    /// Returns all metrics so far; none when nothing was logged yet.
    ///
    /// # Errors
    /// [`ReportError::Input`] with the line.
    pub fn metrics(&self) -> Result<Vec<MetricsRow>, ReportError> {
        let path = self.metrics_path();
        if path.exists() { read_metrics(&path) } else { Ok(Vec::new()) }
    }

    /// Returns the checkpoints, of which the last `keep` and the best stay.
    pub fn checkpoints(&self, keep: usize) -> Checkpoints {
        Checkpoints::new(self.path.join("checkpoints"), keep)
    }

    /// Returns those of another process of the same run: each has environments of its own.
    pub fn checkpoints_of(&self, process: usize, keep: usize) -> Checkpoints {
        Checkpoints::new(self.path.join("checkpoints").join(format!("process-{process}")), keep)
    }

    /// Returns the folder itself.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Returns the path of `plan.toml`.
    pub fn plan_path(&self) -> PathBuf {
        self.path.join("plan.toml")
    }

    /// Returns the path of `metrics.jsonl`.
    pub fn metrics_path(&self) -> PathBuf {
        self.path.join("metrics.jsonl")
    }

    /// Returns the path of `snapshots.jsonl`.
    pub fn snapshots_path(&self) -> PathBuf {
        self.path.join("snapshots.jsonl")
    }

    /// Returns the path of `timing.jsonl`.
    pub fn timing_path(&self) -> PathBuf {
        self.path.join("timing.jsonl")
    }

    /// Returns the path of `machine.jsonl`.
    pub fn machine_path(&self) -> PathBuf {
        self.path.join("machine.jsonl")
    }

    /// Returns the path of `report.html`.
    pub fn report_path(&self) -> PathBuf {
        self.path.join("report.html")
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[derive(Debug, PartialEq, serde::Serialize, serde::Deserialize)]
    #[serde(deny_unknown_fields)]
    struct Plan {
        seed: u64,
        rate: f64,
    }

    #[test]
    fn only_one_process_trains_in_a_folder() {
        let folder = tempfile::tempdir().unwrap();
        let run =
            RunFolder::create(folder.path().join("a"), &std::collections::BTreeMap::from([("steps", 1)])).unwrap();
        let lock = run.lock().unwrap();
        assert!(run.lock().unwrap_err().to_string().contains("another process"));
        drop(lock);
        run.lock().unwrap();
    }

    #[test]
    fn a_plan_comes_back_and_a_run_is_never_overwritten() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("run");
        assert!(RunFolder::open(&path).is_err());
        let plan = Plan { seed: 7, rate: 0.3 };
        RunFolder::create(&path, &plan).unwrap();
        assert_eq!(RunFolder::open(&path).unwrap().plan::<Plan>().unwrap(), plan);
        let error = RunFolder::create(&path, &plan).unwrap_err().to_string();
        assert!(error.contains("resume"), "{error}");
        assert_eq!(RunFolder::open_or_create(&path, &plan).unwrap(), RunFolder::open(&path).unwrap());
        let error = RunFolder::open_or_create(&path, &Plan { seed: 8, rate: 0.3 }).unwrap_err().to_string();
        assert!(error.contains("another one"), "{error}");
    }

    #[test]
    fn a_wrong_plan_is_refused_with_its_line() {
        let folder = tempfile::tempdir().unwrap();
        let run = RunFolder::create(folder.path().join("run"), &Plan { seed: 1, rate: 0.1 }).unwrap();
        fs::write(run.plan_path(), "seed = 1\nrate = 0.1\nspeed = 3\n").unwrap();
        let error = run.plan::<Plan>().unwrap_err().to_string();
        assert!(error.contains("line 3") && error.contains("speed"), "{error}");
    }

    #[test]
    fn a_killed_and_resumed_run_leaves_the_bytes_of_an_uninterrupted_one() {
        let folder = tempfile::tempdir().unwrap();
        let log = |writer: &mut MetricsWriter, iterations: std::ops::Range<u64>| {
            for i in iterations {
                writer.log(i, &[("loss", 1.0 / (i as f64 + 3.0)), ("reward/joints", i as f64)]).unwrap();
            }
        };
        let whole = RunFolder::create(folder.path().join("whole"), &Plan { seed: 1, rate: 0.1 }).unwrap();
        log(&mut whole.start_metrics().unwrap(), 0..10);

        let killed = RunFolder::create(folder.path().join("killed"), &Plan { seed: 1, rate: 0.1 }).unwrap();
        let mut writer = killed.start_metrics().unwrap();
        log(&mut writer, 0..4);
        let position = writer.sync().unwrap();
        log(&mut writer, 4..7);
        drop(writer);
        // The kill tore the line that was being written.
        let mut torn = fs::read(killed.metrics_path()).unwrap();
        torn.truncate(torn.len() - 5);
        fs::write(killed.metrics_path(), torn).unwrap();
        log(&mut killed.resume_metrics(position, 4).unwrap(), 4..10);

        assert_eq!(fs::read(whole.metrics_path()).unwrap(), fs::read(killed.metrics_path()).unwrap());
        assert_eq!(killed.metrics().unwrap().len(), 10);
        assert!(killed.resume_metrics(1 << 20, 0).is_err(), "a position beyond the end is another run's");
    }
}
