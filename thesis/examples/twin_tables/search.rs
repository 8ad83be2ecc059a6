//! A random search over the main keys (thesis 2.4), judged on random motions that no test is made of.

use lifelike_augmentation::model::SatSizes;
use lifelike_augmentation::training::{AugmentationPlan, AugmentationTrainer};
use lifelike_checkpoint::rng::stream;
use rand::Rng;

use crate::common::*;
use crate::sheet::{Cells, Sheet};

/// Draws one setting; trial 0 is the default.
fn drawn(plan: AugmentationPlan, trial: u64) -> AugmentationPlan {
    if trial == 0 {
        return plan;
    }
    let mut rng = stream(0, "hyperparameter search", trial, 0);
    let mut one_of = |values: &[usize]| values[rng.random_range(0..values.len())];
    let (width, embedding, heads) = (one_of(&[8, 16, 32]), one_of(&[2, 4, 8]), one_of(&[1, 2, 4]));
    let (history, stretch) = (one_of(&[16, 32, 64, 128]), one_of(&[128, 256, 512]));
    let mut log_uniform = |low: f64, high: f64| rng.random_range(low.ln()..high.ln()).exp();
    let (learning_rate, noise) = (log_uniform(5e-4, 1e-2), log_uniform(2e-3, 0.1));
    let (weight_decay, physics_weight) = (log_uniform(1e-3, 0.3), log_uniform(0.1, 3.0));
    let model = SatSizes { width, embedding, heads, history, ..plan.model };
    // As many steps in each iteration, whatever the stretch.
    let batch = plan.batch * plan.stretch / stretch;
    AugmentationPlan { model, stretch, batch, learning_rate, noise, weight_decay, physics_weight, ..plan }
}

/// The keys of a setting, as they are written on a command line.
fn keys(plan: &AugmentationPlan) -> String {
    let AugmentationPlan { model, stretch, batch, learning_rate, noise, weight_decay, physics_weight, .. } = plan;
    let SatSizes { width, embedding, heads, history, .. } = model;
    format!(
        "model.width={width} model.embedding={embedding} model.heads={heads} model.history={history} stretch={stretch} batch={batch} \
         learning_rate={learning_rate:.5} noise={noise:.4} weight_decay={weight_decay:.4} physics_weight={physics_weight:.3}"
    )
}

/// Trains every trial once; the sheet's seeds are the number of trials. Settings are judged on random motions of KickBot attached at the pelvis
/// and at a foot with the feedback they are trained for.
pub fn search(sheet: &mut Sheet, form: Form) -> Outcome<()> {
    let settings = sheet.settings();
    let learn = random_runs("kickbot", settings.runs, 1, false)?;
    let validation = [random_runs("kickbot", 3, 2, false)?, random_runs("kickbot_foot", 3, 4, false)?].concat();
    let mut all = Vec::new();
    for trial in 0..settings.seeds {
        let plan = form.of(drawn(plan(SERVO, &["position", "velocity"], settings, 0), trial));
        let name = format!("{trial:03} {}", keys(&plan));
        sheet.rows(form.name(), std::slice::from_ref(&name), || Ok(vec![judged(&plan, &learn, &validation)?]))?;
        let score = sheet.row(form.name(), &name).and_then(|cells| cells.get(SCORE)).map_or(f64::NAN, |n| n.mae[0]);
        all.push((score, name));
    }
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    all.iter().take(3).for_each(|(score, name)| println!("{score:.4}  {name}"));
    Ok(())
}

const SCORE: &str = "error, in units of the simulation's";

/// The least validation error on the way, over both outputs, and that of each.
fn judged(
    plan: &AugmentationPlan,
    learn: &[lifelike_sim::trace::Trace],
    validation: &[lifelike_sim::trace::Trace],
) -> Outcome<Cells> {
    let mut trainer = AugmentationTrainer::new(plan, learn, validation)?;
    let mut best: Option<(f64, Vec<f64>)> = None;
    while trainer.iteration() < plan.iterations {
        trainer.iterate();
        if !trainer.iteration().is_multiple_of(plan.validate_every) {
            continue;
        }
        let Some(errors) = trainer.validate_once() else { continue };
        let mean = errors.iter().sum::<f64>() / errors.len() as f64;
        if best.as_ref().is_none_or(|(least, _)| mean < *least) {
            best = Some((mean, errors));
        }
    }
    let (mean, errors) = best.ok_or("expected a validation on the way, got none")?;
    let cell = |x: f64| Numbers { mae: [x, 0.0], max: [0.0; 2], ccc: 0.0 };
    let names = plan.outputs.iter().cloned().zip(errors);
    Ok(names.chain([(SCORE.to_string(), mean)]).map(|(name, x)| (name, cell(x))).collect())
}
