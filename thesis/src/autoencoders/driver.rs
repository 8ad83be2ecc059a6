//! From arguments to runs: which plans there are, training each in its folder, and what is written.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use crate::sequences::DataPlan;
use lifelike_report::run::RunFolder;
use lifelike_representation::spline_transformer::{Method, SequenceTrainer};
use serde_json::json;
use tracing::info;

use super::args::Shared;
use super::results::{Place, PlainRun, Results, Run};
use super::{Column, Experiment, page, tables};
use lifelike::CliError;
use lifelike::Output;
use lifelike::commands::train::driver::Driver;
use lifelike::overrides;

/// Runs an experiment.
pub fn run<E: Experiment>(
    experiment: &E,
    shared: &Shared,
    changes: &[String],
    output: &Output,
) -> Result<(), CliError> {
    shared.check()?;
    let columns = columns(experiment, shared);
    let places = places::<E>(&columns, shared, changes)?;
    let source = experiment.read(output)?;
    let mut results = Results::default();
    for place in &places {
        let data = E::data(&source, &place.plan)?;
        // A sweep chooses by validation, and looks at no test set.
        if !shared.sweeps() && !results.plain.iter().any(|plain| plain.column == place.column) {
            let equal = columns.iter().any(|column| column.key == place.column && column.equal);
            results.plain.extend(PlainRun::all::<E>(place, &data, equal)?);
        }
        if shared.plain {
            std::fs::create_dir_all(&shared.output).map_err(CliError::write(&shared.output))?;
            save(&columns, shared, &results, E::WORDS)?;
            continue;
        }
        let folder = shared.output.join(&place.name);
        info!("{}: {}", place.name, folder.display());
        let trainer = trained::<E>(data, place, &folder, shared, output)?;
        results.runs.push(Run::of::<E>(place, &trainer, &folder, !shared.sweeps())?);
        save(&columns, shared, &results, E::WORDS)?;
    }
    let report = shared.output.join("report.html");
    output.result(&value(&columns, shared, &results), || {
        let all = tables::all(&columns, &results, &E::WORDS, shared.sweeps());
        let tables: String = all.iter().map(|t| lifelike::output::fitted(t) + &t.caption + "\n\n").collect();
        format!("{tables}report: {}\n", report.display())
    })
}

/// The experiment's columns, and beside each, where asked for, one with equal numbers.
pub(super) fn columns<E: Experiment>(experiment: &E, shared: &Shared) -> Vec<Column<E::Plan>> {
    let both = |column: Column<E::Plan>| {
        let equal = shared.equal_numbers.then(|| Column {
            key: format!("{}-equal", column.key),
            title: format!("{}, equal numbers", column.title),
            thesis: None,
            equal: true,
            ..column.clone()
        });
        [column].into_iter().chain(equal)
    };
    experiment.columns(shared.budget).into_iter().flat_map(both).collect()
}

/// Every run's folder name and plan, checked before the first begins.
pub(super) fn places<E: Experiment>(
    columns: &[Column<E::Plan>],
    shared: &Shared,
    changes: &[String],
) -> Result<Vec<Place<E::Plan>>, CliError> {
    // None stands for the budget's.
    let told: BTreeSet<Option<u64>> = shared.warmup.iter().copied().map(Some).collect();
    let warmups = if told.is_empty() { [shared.sweeps().then_some(0)].into() } else { told };
    let default = |method| shared.methods.is_empty() && Method::THESIS.contains(&method);
    let methods = Method::ALL.into_iter().filter(|own| default(*own) || shared.methods.contains(own));
    // All of one seed first: a table that is stopped on the way has all methods.
    let columns = shared.seed.iter().flat_map(|seed| columns.iter().map(move |column| (*seed, column)));
    let mut places = Vec::new();
    for (seed, column) in columns {
        for method in methods.clone() {
            for rate in shared.rates_of(method) {
                for warmup in &warmups {
                    let mut plan = column.plan.clone();
                    let training = plan.training_mut();
                    (training.method, training.seed) = (method, seed);
                    if column.equal {
                        training.latent = Method::Spline.numbers(training.latent) / method.numbers(1);
                    }
                    let iterations = shared.iterations.unwrap_or(training.iterations);
                    // The budget's keeps its share of the iterations.
                    let share = training.warmup * iterations / training.iterations;
                    (training.iterations, training.warmup) = (iterations, warmup.unwrap_or(share));
                    training.learning_rate = rate.unwrap_or(training.learning_rate);
                    let plan: E::Plan = overrides::apply(plan, changes)?;
                    plan.check()?;
                    let warmup = plan.training().warmup;
                    let rate = rate.map_or(String::new(), |rate| format!("-rate-{rate:e}"));
                    let rise = if warmup > 0 { format!("-warmup-{warmup}") } else { String::new() };
                    // The spline's own run serves both columns.
                    let key = match column.equal && method == Method::Spline {
                        true => column.key.trim_end_matches("-equal"),
                        false => &column.key,
                    };
                    let name = format!("{key}-{method}{rate}{rise}-{seed}");
                    places.push(Place { name, column: column.key.clone(), title: column.title.clone(), plan });
                }
            }
        }
    }
    Ok(places)
}

/// Trains until the plan is done or the minutes are over. Ctrl-C ends the command.
fn trained<E: Experiment>(
    data: E::Data,
    place: &Place<E::Plan>,
    folder: &Path,
    shared: &Shared,
    output: &Output,
) -> Result<SequenceTrainer<E::Data>, CliError> {
    let training = place.plan.training();
    let run = RunFolder::open_or_create(folder, &place.plan)?;
    let mut trainer = SequenceTrainer::new(training.clone(), data)?;
    let driver = Driver { minutes: shared.minutes, ..Driver::new(&run, output) };
    let summary =
        driver.train(&mut trainer, |now| format!("{} {} {:.2e}", place.column, training.method, now.metrics.loss))?;
    if summary.is_some_and(|summary| summary.interrupted) {
        return Err(CliError::Interrupted("the same command goes on".into()));
    }
    Ok(trainer)
}

fn value<P>(columns: &[Column<P>], shared: &Shared, results: &Results) -> serde_json::Value {
    let of = |i: usize| -> BTreeMap<&str, Option<f64>> {
        columns.iter().map(|column| (column.key.as_str(), column.thesis.map(|errors| errors[i]))).collect()
    };
    let thesis: BTreeMap<&str, _> = Method::THESIS.iter().enumerate().map(|(i, m)| (m.name(), of(i))).collect();
    json!({ "budget": shared.budget.name(), "thesis": thesis, "plain": results.plain, "runs": results.runs })
}

/// Writes the results as JSON, and report.html.
fn save<P>(columns: &[Column<P>], shared: &Shared, results: &Results, words: super::Words) -> Result<(), CliError> {
    let file = shared.output.join(format!("{}.json", words.name));
    lifelike::output::write_json(&file, &value(columns, shared, results))?;
    let page = page::report(columns, results, &words, shared.budget, shared.sweeps());
    Ok(page.write(&shared.output.join("report.html"))?)
}
