//! The thesis' table with ours below it, what the runs were, and the sweep of learning rates.

use lifelike_report::{Cell, Column as Head, Table};
use lifelike_representation::spline_transformer::Method;

use super::results::{PlainRun, Results, Run};
use super::{Column, Words};
use crate::seeds::spread;

/// The tables of a comparison, or of a sweep.
pub fn all<P>(columns: &[Column<P>], results: &Results, words: &Words, sweep: bool) -> Vec<Table> {
    let first = if sweep { rates(&results.runs, words) } else { comparison(columns, results, words) };
    let details = (!results.runs.is_empty()).then(|| details(&results.runs, words));
    [first].into_iter().chain(details).collect()
}

fn small(value: f64) -> Cell {
    Cell { text: format!("{value:.2e}"), ..Cell::number(value, 9) }
}

fn seed(run: &Run) -> Cell {
    Cell::text(run.seed.to_string())
}

fn rate(run: &Run) -> Cell {
    Cell { text: format!("{:e}", run.learning_rate), ..Cell::number(run.learning_rate, 9) }
}

fn comparison<P>(columns: &[Column<P>], results: &Results, words: &Words) -> Table {
    let runs = &results.runs;
    let heads = columns.iter().map(|column| Head::number(&column.title, words.unit));
    let mut table = Table::new(words.table, [Head::text("method")].into_iter().chain(heads).collect());
    for (i, method) in Method::THESIS.into_iter().enumerate() {
        let cells = columns.iter().map(|column| column.thesis.map_or(Cell::text("–"), |errors| small(errors[i])));
        table.rows.push([Cell::text(format!("thesis: {}", method.title()))].into_iter().chain(cells).collect());
    }
    // Plain baselines of a column stand in one order in all of them.
    let of = |key: &str| results.plain.iter().filter(|plain| plain.column == key).collect::<Vec<_>>();
    let plain: Vec<_> = columns.iter().map(|column| of(&column.key)).collect();
    for i in 0..plain.iter().map(Vec::len).max().unwrap_or(0) {
        let Some(name) = plain.iter().find_map(|column| column.get(i)).map(|plain| plain.name) else { continue };
        let cell = |column: &Vec<&PlainRun>| {
            column.get(i).map_or(Cell::text("–"), |plain| with_numbers(plain.test.mse, plain.numbers))
        };
        table.rows.push([Cell::text(format!("plain: {name}"))].into_iter().chain(plain.iter().map(cell)).collect());
    }
    for method in Method::ALL {
        if runs.iter().any(|run| run.method == method) {
            let cells = columns.iter().map(|column| {
                let own = runs.iter().filter(|run| run.method == method && run.column == column.key);
                let errors: Vec<f64> = own.clone().filter_map(|run| Some(run.test.as_ref()?.mse)).collect();
                own.last().map_or(Cell::text("–"), |run| of_seeds(&errors, run.numbers))
            });
            table.rows.push([Cell::text(method.title())].into_iter().chain(cells).collect());
        }
    }
    table.caption = format!(
        "{} In brackets, how many numbers are kept of a sequence. Of several seeds, the mean and half the range. Plain: the mean of \
         training sequences; each channel a cubic polynomial; principal components of whole \
         training sequences; as many principal components of a frame as the latent dimension, each a cubic polynomial, which is what a \
         linear map reads from a cubic curve.",
        words.caption
    );
    table
}

/// An error, and how many numbers it cost.
fn with_numbers(error: f64, numbers: usize) -> Cell {
    Cell { text: format!("{error:.2e} [{numbers}]"), ..small(error) }
}

/// The errors of several seeds: their mean, and half the range where there is one.
fn of_seeds(errors: &[f64], numbers: usize) -> Cell {
    match spread(errors.iter().copied()) {
        (mean, half_range) if half_range > 0.0 => {
            Cell { text: format!("{mean:.2e} ± {half_range:.1e} [{numbers}]"), ..small(mean) }
        }
        (mean, _) => with_numbers(mean, numbers),
    }
}

fn rates(runs: &[Run], words: &Words) -> Table {
    let head = [words.column, "method"].map(Head::text).into_iter();
    let numbers = ["seed", "learning rate", "warm-up"].map(|n| Head::number(n, ""));
    let errors = ["best", "last"].map(|n| Head::number(n, words.validation_unit));
    let head = head.chain(numbers).chain(errors).chain([Head::number("spread", "")]);
    let mut table = Table::new("Sensitivity to the learning rate (3.3.5)", head.collect());
    for run in runs {
        let best = run.looks.iter().map(|look| look.mse).fold(f64::INFINITY, f64::min);
        let (last, spread) = run.looks.last().map_or((f64::NAN, f64::NAN), |look| (look.mse, look.spread));
        table.rows.push(vec![
            Cell::text(run.title.clone()),
            Cell::text(run.method.title()),
            seed(run),
            rate(run),
            Cell::number(run.warmup as f64, 0),
            small(best),
            small(last),
            Cell::number(spread, 3),
        ]);
    }
    table.caption = "Errors of validation, for choosing a rate: a sweep never looks at the test set. Spread: root mean square distance of \
                     control points from the mean of their sequence's. Where it nears 0 they are one point, the thesis' collapse; one \
                     control point, as the baselines have, has none."
        .into();
    table
}

fn details(runs: &[Run], words: &Words) -> Table {
    let head = [words.column, "method"].map(Head::text).into_iter();
    let numbers =
        ["seed", "parameters", words.tokens, "batch", "rate", "iterations", "of"].map(|n| Head::number(n, ""));
    let tests = || runs.iter().filter_map(|run| run.test.as_ref());
    let test = if tests().next().is_some() {
        vec![Head::number(words.items, ""), Head::number("median", words.unit)]
    } else {
        vec![]
    };
    let also: Vec<&String> = tests().next().map(|test| test.also.keys().collect()).unwrap_or_default();
    let head = head.chain(numbers).chain(test).chain(also.iter().map(|name| Head::number(name, "")));
    let mut table = Table::new("The runs", head.chain([Head::number("time", "min")]).collect());
    for run in runs {
        let whole = |n: usize| Cell::number(n as f64, 0);
        let mut row = vec![
            Cell::text(run.title.clone()),
            Cell::text(run.method.title()),
            seed(run),
            whole(run.parameters),
            whole(run.tokens),
            whole(run.batch),
            rate(run),
            Cell::number(run.iterations as f64, 0),
            Cell::number(run.of as f64, 0),
        ];
        if let Some(test) = &run.test {
            row.extend([whole(test.test), small(test.median)]);
            row.extend(also.iter().map(|name| Cell::number(test.also.get(*name).copied().unwrap_or(f64::NAN), 2)));
        }
        row.push(Cell::number(run.minutes, 1));
        table.rows.push(row);
    }
    let unfinished = runs.iter().filter(|run| !run.is_done()).count();
    table.caption = "Time is that of training, without validation.".into();
    if tests().next().is_some() {
        table.caption += &format!(" Median: that of the {}' errors.", words.items);
    }
    if unfinished > 0 {
        table.caption += &format!(
            " {unfinished} of the runs were stopped before their learning rate had fallen; the same command goes on."
        );
    }
    table
}
