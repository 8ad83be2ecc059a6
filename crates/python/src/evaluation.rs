//! Evaluation of a controller in physics.

use std::sync::Arc;

use lifelike_evaluation::{EvaluationOptions, EvaluationSetup};
use lifelike_motion::MotionClip;
use lifelike_sim::{EngineKind, SimulationSpec};
use pyo3::prelude::*;

use crate::arrays::plain;
use crate::clip::Clip;
use crate::controller::Controller;
use crate::error::{Error, Raise};
use crate::interrupt::Interrupt;

/// Most episodes that run at once.
const ENVIRONMENTS: usize = 128;

/// Evaluates a controller on clips in physics, and returns what `lifelike eval --json` prints, as dictionaries.
///
/// Each clip is followed from `starts` frames for at most `seconds`, without noise. `overall`, `clips` and `episodes`
/// have the measures of `docs/evaluation.md`. Raises `Error` for clips of another robot.
#[pyfunction]
#[pyo3(signature = (controller, clips, *, seconds=10.0, starts=5, engine="lifelike", threads=0))]
pub fn evaluate<'py>(
    py: Python<'py>,
    controller: &Controller,
    clips: Vec<PyRef<'py, Clip>>,
    seconds: f64,
    starts: usize,
    engine: &str,
    threads: usize,
) -> PyResult<Bound<'py, PyAny>> {
    if !(seconds > 0.0 && seconds <= 3600.0 && (1..=10_000).contains(&starts)) {
        return Err(Error::new_err("seconds must be above 0 and at most 3600, starts from 1 to 10000"));
    }
    let engine: EngineKind = engine.parse().or_raise()?;
    let clips: Vec<MotionClip> = clips.iter().map(|clip| clip.0.clone()).collect();
    let loaded = &controller.0;
    let interrupt = Interrupt::default();
    let simulate = |terrain, environments| {
        let spec = SimulationSpec { engine, environments, threads, terrain };
        Ok(interrupt.guard(spec.build(Arc::clone(loaded.controller.robot()))?))
    };
    let options = EvaluationOptions { seconds, starts, ..EvaluationOptions::default() };
    let result = py.detach(|| {
        let setup = EvaluationSetup { environments: ENVIRONMENTS, ..loaded.setup(&simulate) };
        setup.evaluate(&clips, &options, |_, _| {}).or_raise()
    });
    plain(py, &interrupt.result(result)?)
}
