//! Results of runs and of plain baselines.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use crate::sequences::DataPlan;
use crate::sequences::SequencesError;
use lifelike_report::Panel;
use lifelike_report::write_atomically;
use lifelike_representation::spline_transformer::run::{ValidationPoint, validation_points};
use lifelike_representation::spline_transformer::{Method, Plain, SequenceTrainer, Sequences};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use super::{Experiment, Shown, TABLE};
use lifelike::CliError;

/// Test sequences that are drawn of each run.
const DRAWN: usize = 4;
/// Test sequences that are measured at a time.
const MEASURED: usize = 64;
/// File of a run's folder that keeps what was measured.
const FILE: &str = "measured.toml";

/// A run before it begins.
#[derive(Debug)]
pub struct Place<P> {
    /// Of its folder.
    pub name: String,
    /// Key and title of its column.
    pub column: String,
    pub title: String,
    pub plan: P,
}

/// All that was measured.
#[derive(Debug, Default)]
pub struct Results {
    /// Plain baselines of each column; none in a sweep.
    pub plain: Vec<PlainRun>,
    /// Networks.
    pub runs: Vec<Run>,
}

/// One run, measured.
#[derive(Debug, Serialize)]
pub struct Run {
    pub column: String,
    #[serde(skip)]
    pub title: String,
    pub method: Method,
    pub seed: u64,
    /// Numbers that it keeps of a sequence.
    pub numbers: usize,
    pub learning_rate: f64,
    pub warmup: u64,
    /// Done, and what the plan wants.
    pub iterations: u64,
    pub of: u64,
    /// Time spent training (validation not counted).
    pub minutes: f64,
    pub parameters: usize,
    pub tokens: usize,
    pub batch: usize,
    /// The test set, in the table's unit. Not of sweeps: what is chosen by them must not have seen it.
    #[serde(flatten)]
    pub test: Option<Measured>,
    /// Validation on the way, in the table's unit.
    pub looks: Vec<ValidationPoint>,
    #[serde(skip)]
    pub shown: Vec<Shown>,
}

/// Errors of the test set, in the table's unit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Measured {
    /// Sequences.
    pub test: usize,
    /// Mean error over all of them.
    pub mse: f64,
    /// Median of theirs.
    pub median: f64,
    /// Root mean square distance of control points from their sequence's mean.
    pub spread: f64,
    /// Further measures of the experiment, by name with unit.
    pub also: BTreeMap<String, f64>,
}

/// A plain baseline, measured.
#[derive(Debug, Serialize)]
pub struct PlainRun {
    pub column: String,
    pub name: &'static str,
    /// Numbers that it keeps of a sequence.
    pub numbers: usize,
    #[serde(flatten)]
    pub test: Measured,
}

impl PlainRun {
    /// The plain baselines of a column's data. Principal components have as many numbers as the baselines' latent vector, and as many
    /// as the curve's control points.
    pub fn all<E: Experiment>(place: &Place<E::Plan>, data: &E::Data, equal: bool) -> Result<Vec<Self>, CliError> {
        let training = place.plan.training();
        // A column of equal numbers has one count, whichever method is first in it.
        let (latent, own) = (training.latent, training.method.numbers(training.latent));
        let counts: BTreeSet<usize> = match equal {
            true => [own].into(),
            false => Method::ALL.into_iter().map(|method| method.numbers(latent)).collect(),
        };
        let measured = |plain: Plain| {
            let test = measure::<E>(data, |x| Ok(plain.reconstruct(x)?), 0.0)?;
            Ok(Self { column: place.column.clone(), name: plain.name, numbers: plain.numbers, test })
        };
        let plain = Plain::all(data, latent, &counts.into_iter().collect::<Vec<_>>())?;
        plain.into_iter().map(measured).collect()
    }
}

/// Measured numbers as the folder keeps them, and of what they are.
#[derive(Debug, Serialize, Deserialize)]
struct Kept<P> {
    iteration: u64,
    data: String,
    measured: Measured,
    plan: P,
}

impl Run {
    /// Of a run and, where it is to be `tested`, what is measured on the test set or was before.
    pub fn of<E: Experiment>(
        place: &Place<E::Plan>,
        trainer: &SequenceTrainer<E::Data>,
        folder: &Path,
        tested: bool,
    ) -> Result<Self, CliError> {
        let mut test = None;
        if tested {
            let measure = || {
                let spread = trainer.errors(TABLE)?.spread;
                measure::<E>(trainer.data(), |x| Ok(trainer.reconstruct(x)?.1), spread)
            };
            test = Some(measured(folder, &place.plan, trainer, measure)?);
        }
        let scaled = |look: ValidationPoint| ValidationPoint { mse: E::SCALE * look.mse, ..look };
        let looks: Vec<ValidationPoint> = validation_points(folder)?.into_iter().map(scaled).collect();
        let training = place.plan.training();
        Ok(Self {
            column: place.column.clone(),
            title: place.title.clone(),
            method: training.method,
            seed: training.seed,
            numbers: training.method.numbers(training.latent),
            learning_rate: training.learning_rate,
            warmup: training.warmup,
            iterations: trainer.iteration(),
            of: training.iterations,
            minutes: looks.last().map_or(f64::NAN, |look| look.seconds / 60.0),
            parameters: trainer.parameters(),
            tokens: trainer.data().tokens(),
            batch: training.batch,
            shown: if tested { drawn::<E>(trainer)? } else { Vec::new() },
            test,
            looks,
        })
    }

    /// True when the plan's iterations are done.
    pub fn is_done(&self) -> bool {
        self.iterations >= self.of
    }
}

/// Returns what the folder keeps of this plan, these sequences and this iteration; else what `measure` says, which is kept then.
fn measured<P: Serialize + DeserializeOwned + PartialEq + Clone, S: Sequences>(
    folder: &Path,
    plan: &P,
    trainer: &SequenceTrainer<S>,
    measure: impl FnOnce() -> Result<Measured, SequencesError>,
) -> Result<Measured, CliError> {
    let file = folder.join(FILE);
    let (iteration, data) = (trainer.iteration(), trainer.data().describe());
    let text = std::fs::read_to_string(&file).ok();
    // A file that is no such thing is written anew, like one of another iteration.
    let kept = text.and_then(|text| toml::from_str::<Kept<P>>(&text).ok());
    if let Some(kept) = kept.filter(|k| k.iteration == iteration && k.data == data && k.plan == *plan) {
        return Ok(kept.measured);
    }
    let kept = Kept { iteration, data, measured: measure()?, plan: plan.clone() };
    let text = toml::to_string(&kept).map_err(|e| CliError::Failed(format!("{}: {e}", file.display())))?;
    write_atomically(&file, text.as_bytes())?;
    Ok(kept.measured)
}

/// Measures what comes `back` of the test set's sequences.
fn measure<E: Experiment>(
    data: &E::Data,
    back: impl Fn(&[f32]) -> Result<Vec<f32>, SequencesError>,
    spread: f64,
) -> Result<Measured, SequencesError> {
    let (unit, count) = (data.tokens() * data.width(), data.held_out_len(TABLE));
    let (mut errors, mut sums) = (Vec::with_capacity(count), BTreeMap::<String, f64>::new());
    for first in (0..count).step_by(MEASURED) {
        let x = data.held_out(TABLE, first..(first + MEASURED).min(count));
        let y = back(&x)?;
        for (x, y) in x.chunks_exact(unit).zip(y.chunks_exact(unit)) {
            errors.push(E::error(data, x, y));
            for (name, value) in E::also(data, x, y) {
                *sums.entry(name.to_owned()).or_default() += value;
            }
        }
    }
    let mse = errors.iter().sum::<f64>() / count.max(1) as f64;
    errors.sort_by(f64::total_cmp);
    let median = errors.get(count / 2).copied().unwrap_or(f64::NAN);
    let also = sums.into_iter().map(|(name, sum)| (name, sum / count as f64)).collect();
    Ok(Measured { test: count, mse, median, spread, also })
}

/// Test sequences from all over the set and what comes back of them.
fn drawn<E: Experiment>(trainer: &SequenceTrainer<E::Data>) -> Result<Vec<Shown>, CliError> {
    let data = trainer.data();
    let count = data.held_out_len(TABLE);
    let draw = |i: usize| {
        let at = i * count / DRAWN.min(count);
        let x = data.held_out(TABLE, at..at + 1);
        let (_, y) = trainer.reconstruct(&x)?;
        let error = E::error(data, &x, &y);
        let shown = E::shown(data, &x, &y);
        let name = trainer.plan().method.title().into();
        let back = Panel { name, note: format!("{error:.1e} {}", E::WORDS.unit), ..shown.back };
        let truth = shown.truth.map(|panel| Panel { name: "original".into(), ..panel });
        Ok(Shown { truth, back })
    };
    (0..DRAWN.min(count)).map(draw).collect()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use crate::sequences::{CurveSequences, CurvesPlan, Family};

    use super::*;
    use crate::autoencoders::budget::Budget;

    #[test]
    fn what_was_measured_counts_for_its_plan_and_iteration_only() {
        let folder = tempfile::tempdir().unwrap();
        let mut plan = CurvesPlan::new(Family::Bezier2);
        plan.training = Budget::Smoke.training(plan.training);
        (plan.samples, plan.training.learning_rate) = (4, 0.1 + 0.2);
        let mut trainer = SequenceTrainer::new(plan.training.clone(), CurveSequences::new(&plan).unwrap()).unwrap();
        let answer = |mse: f64| Measured { test: 1, mse, median: f64::NAN, spread: 0.0, also: BTreeMap::new() };
        let ask = |plan: &CurvesPlan, trainer: &SequenceTrainer<CurveSequences>, mse: f64| {
            measured(folder.path(), plan, trainer, || Ok(answer(mse))).unwrap().mse
        };
        assert_eq!(ask(&plan, &trainer, 1.0 / 3.0), 1.0 / 3.0);
        assert_eq!(ask(&plan, &trainer, 2.0), 1.0 / 3.0, "kept to the last bit");
        assert_eq!(ask(&CurvesPlan { test: 7, ..plan.clone() }, &trainer, 3.0), 3.0, "another test set");
        assert_eq!(ask(&plan, &trainer, 4.0), 4.0);
        trainer.step().unwrap();
        assert_eq!(ask(&plan, &trainer, 5.0), 5.0, "an iteration later");
        std::fs::write(folder.path().join(FILE), "iteration = 1").unwrap();
        assert_eq!(ask(&plan, &trainer, 6.0), 6.0, "a broken file");
    }
}
