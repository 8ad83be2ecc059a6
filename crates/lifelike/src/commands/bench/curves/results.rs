//! What became of a run.

use std::path::Path;

use lifelike_learn::report::Panel;
use lifelike_learn::representation::spline_transformer::run::{Look, looks};
use lifelike_learn::representation::spline_transformer::{
    CurveSequences, CurvesPlan, Family, Method, SequenceTrainer, Sequences,
};
use serde::Serialize;

use super::TABLE;
use crate::error::CliError;

/// Test curves that are drawn of each run.
const DRAWN: usize = 4;

/// One run, measured.
#[derive(Debug, Serialize)]
pub struct Run {
    pub family: Family,
    pub method: Method,
    pub seed: u64,
    pub learning_rate: f64,
    pub warmup: u64,
    /// Done, and what the plan wants.
    pub iterations: u64,
    pub of: u64,
    /// Time spent training (validation not counted).
    pub minutes: f64,
    pub parameters: usize,
    pub samples: usize,
    pub batch: usize,
    pub test_curves: usize,
    /// Mean squared error over the test curves.
    pub mse: f64,
    /// Median over the test curves.
    pub median: f64,
    /// Root mean square distance of control points from their sequence's mean.
    pub spread: f64,
    /// Validation on the way.
    pub looks: Vec<Look>,
    #[serde(skip)]
    pub panels: Vec<Panel>,
}

impl Run {
    /// Measures a run on the test curves.
    pub fn of(plan: &CurvesPlan, trainer: &SequenceTrainer<CurveSequences>, folder: &Path) -> Result<Self, CliError> {
        let errors = trainer.errors(TABLE)?;
        let mut sorted = errors.each.clone();
        sorted.sort_by(f64::total_cmp);
        let looks = looks(folder)?;
        let training = &plan.training;
        Ok(Self {
            family: plan.family,
            method: training.method,
            seed: training.seed,
            learning_rate: training.learning_rate,
            warmup: training.warmup,
            iterations: trainer.iteration(),
            of: training.iterations,
            minutes: looks.last().map_or(f64::NAN, |look| look.seconds / 60.0),
            parameters: trainer.parameters(),
            samples: plan.samples,
            batch: training.batch,
            test_curves: errors.each.len(),
            mse: errors.mse,
            median: sorted.get(sorted.len() / 2).copied().unwrap_or(f64::NAN),
            spread: errors.spread,
            looks,
            panels: drawn(trainer, &errors.each)?,
        })
    }

    /// Whether the plan's iterations are done.
    pub fn is_done(&self) -> bool {
        self.iterations >= self.of
    }
}

/// The first test curves and what comes back of them.
fn drawn(trainer: &SequenceTrainer<CurveSequences>, errors: &[f64]) -> Result<Vec<Panel>, CliError> {
    let count = DRAWN.min(errors.len());
    let x = trainer.data().held_out(TABLE, 0..count);
    let (_, y) = trainer.reconstruct(&x)?;
    let unit = trainer.data().tokens() * trainer.data().width();
    let points = |row: &[f32]| row.as_chunks::<2>().0.to_vec();
    let panels = x.chunks(unit).zip(y.chunks(unit)).zip(errors).map(|((x, y), error)| Panel {
        name: trainer.plan().method.title().into(),
        note: format!("{error:.1e}"),
        reference: vec![points(x)],
        lines: vec![points(y)],
    });
    Ok(panels.collect())
}
