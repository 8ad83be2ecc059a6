//! Thesis Table 3.1 with ours below it, what the runs were, and the sweep of learning rates.

use std::collections::BTreeMap;

use lifelike_learn::report::{Cell, Column, Table};
use lifelike_learn::representation::spline_transformer::{Family, Method};

use super::results::Run;

/// Thesis Table 3.1, families in [`Family::ALL`]'s order.
const THESIS: [(Method, [f64; 4]); 3] = [
    (Method::Alibi, [1e-4, 2e-3, 1.76e-2, 3.88e-3]),
    (Method::AlibiCat, [8e-4, 5.3e-3, 1.78e-2, 3.89e-3]),
    (Method::Spline, [3e-5, 1.4e-3, 2e-6, 3.87e-3]),
];

/// Table 3.1 by method and family, for the JSON.
pub fn thesis() -> BTreeMap<&'static str, BTreeMap<&'static str, f64>> {
    let of = |errors: [f64; 4]| Family::ALL.map(Family::name).into_iter().zip(errors).collect();
    THESIS.into_iter().map(|(method, errors)| (method.name(), of(errors))).collect()
}

/// The tables of a comparison, or of a sweep.
pub fn all(runs: &[Run], sweep: bool) -> Vec<Table> {
    if sweep { vec![rates(runs), details(runs)] } else { vec![comparison(runs), details(runs)] }
}

fn small(value: f64) -> Cell {
    Cell { text: format!("{value:.2e}"), ..Cell::number(value, 9) }
}

fn comparison(runs: &[Run]) -> Table {
    let present = |family: &Family| runs.iter().any(|run| run.family == *family);
    let families: Vec<(usize, Family)> = Family::ALL.into_iter().enumerate().filter(|(_, f)| present(f)).collect();
    let heads = families.iter().map(|(_, family)| Column::number(family.title(), ""));
    let mut table =
        Table::new("Reconstruction of curves (Table 3.1)", [Column::text("method")].into_iter().chain(heads).collect());
    for (method, errors) in THESIS {
        let cells = families.iter().map(|(i, _)| small(errors[*i]));
        table.rows.push([Cell::text(format!("thesis: {}", method.title()))].into_iter().chain(cells).collect());
    }
    for method in Method::ALL {
        let of = |family: Family| runs.iter().find(|run| run.method == method && run.family == family);
        if runs.iter().any(|run| run.method == method) {
            let cells = families.iter().map(|(_, family)| of(*family).map_or(Cell::text("–"), |run| small(run.mse)));
            table.rows.push([Cell::text(method.title())].into_iter().chain(cells).collect());
        }
    }
    table.caption = "Mean squared error of (x, y) over test curves that were never trained on. The thesis does not state the \
                     domains of its curves or the length of its training, so its rows are of the same kind, not of the same data."
        .into();
    table
}

fn rates(runs: &[Run]) -> Table {
    let head = ["family", "method"].map(Column::text).into_iter();
    let head = head.chain(
        ["learning rate", "warm-up", "validation, best", "validation, last", "test", "spread"]
            .map(|n| Column::number(n, "")),
    );
    let mut table = Table::new("Sensitivity to the learning rate (3.3.5)", head.collect());
    for run in runs {
        let best = run.looks.iter().map(|look| look.mse).fold(f64::INFINITY, f64::min);
        let last = run.looks.last().map_or(f64::NAN, |look| look.mse);
        table.rows.push(vec![
            Cell::text(run.family.title()),
            Cell::text(run.method.title()),
            Cell { text: format!("{:e}", run.learning_rate), ..Cell::number(run.learning_rate, 9) },
            Cell::number(run.warmup as f64, 0),
            small(best),
            small(last),
            small(run.mse),
            Cell::number(run.spread, 3),
        ]);
    }
    table.caption = "Spread: root mean square distance of control points from the mean of their sequence's. Where it nears 0 they are \
                     one point, the thesis' collapse; one control point, as the baselines have, has none."
        .into();
    table
}

fn details(runs: &[Run]) -> Table {
    let head = ["family", "method"].map(Column::text).into_iter();
    let numbers = ["parameters", "points", "batch", "iterations", "of", "test curves", "median"];
    let head = head.chain(numbers.map(|n| Column::number(n, ""))).chain([Column::number("time", "min")]);
    let mut table = Table::new("The runs", head.collect());
    for run in runs {
        let whole = |n: usize| Cell::number(n as f64, 0);
        table.rows.push(vec![
            Cell::text(run.family.title()),
            Cell::text(run.method.title()),
            whole(run.parameters),
            whole(run.samples),
            whole(run.batch),
            Cell::number(run.iterations as f64, 0),
            Cell::number(run.of as f64, 0),
            whole(run.test_curves),
            small(run.median),
            Cell::number(run.minutes, 1),
        ]);
    }
    let unfinished = runs.iter().filter(|run| !run.is_done()).count();
    table.caption = "Median: that of the test curves' errors. Time is that of training, without validation.".into();
    if unfinished > 0 {
        table.caption += &format!(
            " {unfinished} of the runs were stopped before their learning rate had fallen; the same command goes on."
        );
    }
    table
}
