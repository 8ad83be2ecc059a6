//! The page: tables, test sequences with what came back of them, and how the loss fell.

use lifelike_report::{Curve, Drawing, ReportBuilder};
use lifelike_representation::spline_transformer::run::ValidationPoint;

use super::budget::Budget;
use super::results::{Results, Run};
use super::{Column, Words, tables};

/// The most panels side by side: a sequence and what came back by all methods.
const MOST: usize = 4;

/// The report.
pub fn report<P>(
    columns: &[Column<P>],
    results: &Results,
    words: &Words,
    budget: Budget,
    sweep: bool,
) -> ReportBuilder {
    let runs = &results.runs;
    let title = if sweep { "Learning rates of sequence autoencoders" } else { words.title };
    let page = ReportBuilder::new(title)
        .subtitle(words.subtitle)
        .fact("budget", budget.name())
        .fact("runs", runs.len().to_string())
        .curves(losses(runs, "iterations", |look| look.iteration as f64))
        .curves(losses(runs, "minutes of training", |look| look.seconds / 60.0))
        .measured();
    let page = tables::all(columns, results, words, sweep).into_iter().fold(page, ReportBuilder::table);
    columns.iter().filter_map(|column| drawing(runs, column, words)).fold(page, ReportBuilder::drawing)
}

/// Logarithms, because the errors of good and bad runs are orders of magnitude apart.
fn losses(runs: &[Run], against: &str, x: impl Fn(&ValidationPoint) -> f64 + Copy) -> Vec<Curve> {
    let curve = |run: &Run| Curve {
        name: format!("log10 of the validation error against {against}/{}", run.title),
        series: format!("{}{}, seed {}", run.method.title(), rate(run), run.seed),
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

fn drawing<P>(runs: &[Run], column: &Column<P>, words: &Words) -> Option<Drawing> {
    // Of the first seed: methods side by side, not their chances.
    let seed = runs.first()?.seed;
    let here: Vec<&Run> = runs.iter().filter(|run| run.column == column.key && run.seed == seed).collect();
    let most = here.iter().map(|run| run.shown.len()).max().filter(|most| *most > 0)?;
    let mut panels = Vec::new();
    for i in 0..most {
        // The same sequence by all methods, side by side.
        let mut shown = here.iter().filter_map(|run| run.shown.get(i)).peekable();
        panels.extend(shown.peek().and_then(|first| first.truth.clone()));
        panels.extend(shown.map(|s| s.back.clone()));
    }
    let across = panels.len() / most;
    Some(Drawing {
        title: format!("{}: {}", column.title, words.items),
        caption: format!("{} Beside the method, the mean squared error.", words.drawing),
        panels,
        // More would be too small to see.
        across: if across <= MOST { across } else { 0 },
    })
}
