//! Training of tracking policies by our PPO.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use lifelike::commands::physics::Physics;
use lifelike::commands::train::tracker;
use lifelike_report::run::RunFolder;
use lifelike_sim::EngineKind;
use lifelike_tracking::{TrackerPlan, Trainer};
use lifelike_train::TrainingRun;
use lifelike_train::collective::Alone;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::error::{Raise, show_warnings};
use crate::interrupt::Interrupt;

/// Trains a tracking policy as `lifelike train tracker` does, and returns the path of the policy.
///
/// `plan` is a built-in plan or a plan's file, `changes` are its keys, such as `budget.minutes=5` or `robot="g1"`.
/// `folder` is the run's folder: new, or with `resume` that of a run to continue. `progress` is called after each iteration with a
/// dictionary: `iteration`, `steps`, `seconds`, `reward`, `survival`, `steps_per_second`.
/// Ctrl-C saves a checkpoint and raises `KeyboardInterrupt`; an exception of `progress` does the same.
/// Raises `Error` for a plan that cannot be used.
#[pyfunction]
#[pyo3(signature = (folder, plan="track".into(), *, changes=vec![], resume=false, threads=0, progress=None))]
pub fn train_tracker(
    py: Python<'_>,
    folder: PathBuf,
    plan: PathBuf,
    changes: Vec<String>,
    resume: bool,
    threads: usize,
    progress: Option<Py<PyAny>>,
) -> PyResult<PathBuf> {
    show_warnings();
    let interrupt = Interrupt::default();
    let result = py.detach(|| train(&folder, &plan, &changes, resume, threads, &interrupt, progress.as_ref()));
    interrupt.result(result)
}

fn train(
    folder: &Path,
    plan: &Path,
    changes: &[String],
    resume: bool,
    threads: usize,
    interrupt: &Interrupt,
    progress: Option<&Py<PyAny>>,
) -> PyResult<PathBuf> {
    let resumed = resume.then(|| RunFolder::open(folder)).transpose().or_raise()?;
    let file = resumed.as_ref().map(RunFolder::plan_path);
    let plan: TrackerPlan = lifelike::plans::load(file.as_deref().unwrap_or(plan), changes).or_raise()?;
    if !resume {
        RunFolder::require_new(folder).or_raise()?;
    }
    let physics = Physics { engine: EngineKind::default(), threads, augment: Vec::new(), twin: None };
    let mut trainer = tracker::prepare(&plan, &physics, Arc::new(Alone)).or_raise()?;
    let run = match resumed {
        Some(run) => run,
        None => {
            if let Some(init) = &plan.init {
                trainer = trainer.initialised(init).or_raise()?.0;
            }
            RunFolder::create(folder, &plan).or_raise()?
        }
    };
    let _lock = run.lock().or_raise()?;
    let stop = AtomicBool::new(false);
    let training = TrainingRun { folder: &run, stop: &stop, collective: &Alone };
    training
        .run(&mut trainer, |now| {
            let told = Python::attach(|py| {
                py.check_signals()?;
                let Some(progress) = progress else { return Ok(()) };
                let values = PyDict::new(py);
                values.set_item("iteration", now.iteration)?;
                values.set_item("steps", now.done)?;
                values.set_item("seconds", now.seconds)?;
                values.set_item("reward", now.metrics.ppo.reward)?;
                values.set_item("survival", now.metrics.survival)?;
                values.set_item("steps_per_second", now.metrics.steps_per_second)?;
                progress.call1(py, (values,)).map(drop)
            });
            if let Err(exception) = told {
                interrupt.set(exception);
                stop.store(true, Ordering::SeqCst);
            }
        })
        .or_raise()?;
    Ok(Trainer::policy_path(run.path()))
}
