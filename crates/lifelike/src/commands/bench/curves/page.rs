//! The page: tables, test curves with what came back of them, and how the loss fell.

use lifelike_learn::report::{Curve, Drawing, ReportBuilder};
use lifelike_learn::representation::spline_transformer::Family;

use super::budget::Budget;
use super::results::Run;
use super::tables;

/// The report.
pub fn report(runs: &[Run], budget: Budget, sweep: bool) -> ReportBuilder {
    let title = if sweep { "Learning rates of sequence autoencoders" } else { "Curves by sequence autoencoders" };
    let page = ReportBuilder::new(title)
        .subtitle("The Spline-based Transformer and its baselines on plane curves: same curves, same settings, other latent tokens.")
        .fact("budget", budget.name())
        .fact("runs", runs.len().to_string())
        .curves(losses(runs, "iterations", |look| look.iteration as f64))
        .curves(losses(runs, "minutes of training", |look| look.seconds / 60.0))
        .measured();
    let page = tables::all(runs, sweep).into_iter().fold(page, ReportBuilder::table);
    Family::ALL.into_iter().filter_map(|family| drawing(runs, family)).fold(page, ReportBuilder::drawing)
}

/// Logarithms, because the errors of good and bad runs are orders of magnitude apart.
fn losses(
    runs: &[Run],
    against: &str,
    x: impl Fn(&lifelike_learn::representation::spline_transformer::run::Look) -> f64 + Copy,
) -> Vec<Curve> {
    let curve = |run: &Run| Curve {
        name: format!(
            "log10 of the validation error against {against}/{}, {}{}",
            run.family.title(),
            run.method.title(),
            rate(run)
        ),
        x: run.looks.iter().map(x).collect(),
        y: run.looks.iter().map(|look| look.mse.log10()).collect(),
    };
    runs.iter().map(curve).collect()
}

/// Not before a slash: that would be a group.
fn rate(run: &Run) -> String {
    let rise = if run.warmup > 0 { format!(", warm-up {}", run.warmup) } else { String::new() };
    format!(", rate {:e}{rise}", run.learning_rate)
}

fn drawing(runs: &[Run], family: Family) -> Option<Drawing> {
    let here: Vec<&Run> = runs.iter().filter(|run| run.family == family).collect();
    let most = here.iter().map(|run| run.panels.len()).max()?;
    // The same curve by all methods, side by side.
    let panels = (0..most).flat_map(|i| here.iter().filter_map(move |run| run.panels.get(i).cloned()));
    Some(Drawing {
        title: format!("{}: test curves", family.title()),
        caption: "Behind, the curve; in front, what came back; beside the method, the curve's mean squared error."
            .into(),
        panels: panels.collect(),
    })
}
