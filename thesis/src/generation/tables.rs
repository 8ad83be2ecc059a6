//! The tables of a measurement.

use lifelike_evaluation::thesis_tables;
use lifelike_generation::metrics::{Interval, Scores};
use lifelike_language::checks::Fact;
use lifelike_motion::plausibility;
use lifelike_report::{Cell, Column, Table};

use super::Results;
use super::language::{Checks, Kept};
use lifelike::output::fitted;

/// Rows of thesis Table 5.2, after the method: R-precision top 3, FID, MM-dist, diversity, multimodality, Realism;
/// means and half the 95% interval.
const THESIS: [(&str, [[f64; 2]; 6]); 5] = [
    ("data set", [[0.696, 0.003], [0.002, 0.0], [3.799, 0.014], [8.958, 0.102], [f64::NAN; 2], [6.774, 0.002]]),
    ("MDM-1K", [[0.675, 0.013], [0.688, 0.090], [3.840, 0.039], [8.952, 0.060], [2.355, 0.148], [8.392, 0.036]]),
    ("MDM", [[0.680, 0.008], [0.415, 0.045], [3.831, 0.028], [9.074, 0.135], [2.068, 0.067], [8.730, 0.018]]),
    ("PhysDiff", [[0.482, 0.007], [10.401, 0.089], [5.500, 0.025], [6.546, 0.037], [1.890, 0.113], [8.951, 0.034]]),
    ("RobotMDM", [[0.684, 0.007], [0.472, 0.023], [3.835, 0.020], [9.170, 0.064], [2.087, 0.101], [9.562, 0.017]]),
];

/// Returns everything as text.
pub fn text(results: &Results) -> String {
    let learned = results.evaluator.is_some() || results.critic.is_some();
    let metrics = learned.then(|| metrics(results));
    let tables = metrics.into_iter().chain([language(results), physics(results)]).chain(tracking(results));
    tables.map(|table| format!("{}\n{}{}\n\n", table.title, fitted(&table), table.caption)).collect()
}

/// Thesis Table 5.3, where a tracker followed the motions.
fn tracking(results: &Results) -> Vec<Table> {
    let rows: Vec<_> =
        results.rows.iter().filter_map(|row| Some((row.name.as_str(), row.tracking.as_ref()?))).collect();
    if rows.is_empty() { Vec::new() } else { thesis_tables(rows).to_vec() }
}

fn columns(names: &[&str]) -> Vec<Column> {
    [Column::text("method")].into_iter().chain(names.iter().map(|name| Column::number(name, ""))).collect()
}

fn interval(interval: Option<Interval>) -> Cell {
    let known = interval.filter(|interval| interval.mean.is_finite());
    known.map_or_else(|| Cell::text("–"), |i| Cell { value: Some(i.mean), ..Cell::text(i.to_string()) })
}

fn metrics(results: &Results) -> Table {
    let names = ["R-Prec. 1", "R-Prec. 3", "FID", "MM-dist", "Diversity", "MultiModality", "Realism"];
    let mut table = Table::new("Text to motion (thesis Table 5.2)", columns(&names));
    for row in &results.rows {
        let of = |pick: &dyn Fn(&Scores) -> Option<Interval>| interval(row.scores.as_ref().and_then(pick));
        table.rows.push(vec![
            Cell::text(&row.name),
            of(&|s| s.r_precision.first().copied()),
            of(&|s| s.r_precision.last().copied()),
            of(&|s| s.fid),
            of(&|s| Some(s.mm_dist)),
            of(&|s| Some(s.diversity)),
            of(&|s| s.multimodality),
            interval(row.realism),
        ]);
    }
    let published = |[mean, half_width]: [f64; 2]| interval(Some(Interval { mean, half_width }));
    table.foot = THESIS
        .iter()
        .map(|(name, numbers)| {
            let first = [Cell::text(format!("thesis, {name}")), Cell::text("–")];
            first.into_iter().chain(numbers.map(published)).collect()
        })
        .collect();
    let pool = results.rows.iter().find_map(|row| row.scores).map_or(0, |scores| scores.pool);
    let left_out = match results.left_out {
        0 => String::new(),
        count => format!(" {count} more are longer than a generator can make."),
    };
    table.caption = format!(
        "{} of {} entries of {} ({}), {} repetition(s), pools of {pool}.{left_out} FID to all entries of the split; the \
         data set's own is that of the entries measured. Below the line the thesis' rows: other data, robot, evaluator \
         and critic, to be compared among each other only.",
        results.entries,
        results.of,
        results.data.display(),
        results.split,
        results.repetitions
    );
    table
}

fn language(results: &Results) -> Table {
    let asked: Vec<Fact> = Fact::ALL
        .into_iter()
        .filter(|fact| results.rows.iter().any(|row| row.checks.facts.contains_key(fact)))
        .collect();
    let names: Vec<&str> = asked.iter().map(|fact| fact.name()).chain(["everything"]).collect();
    let mut table = Table::new("Exact checks of what the sentences promise", columns(&names));
    for row in &results.rows {
        let motions = |kept: &Kept| {
            let entries = kept.asked / row.motions_of_each.max(1);
            Cell { value: Some(kept.share()), ..Cell::text(format!("{:.1} ({entries})", 100.0 * kept.share())) }
        };
        let share = |kept: Option<&Kept>| kept.filter(|k| k.asked > 0).map_or_else(|| Cell::text("–"), motions);
        let cells = |name: String, checks: &Checks| {
            let facts = asked.iter().map(|fact| share(checks.facts.get(fact)));
            [Cell::text(name)].into_iter().chain(facts).chain([share(Some(&checks.everything))]).collect::<Vec<_>>()
        };
        table.rows.push(cells(row.name.clone(), &row.checks));
        let parts = row.checks_of_held_out.iter();
        table.rows.extend(parts.map(|(part, checks)| cells(format!("{}, {part}", row.name), checks)));
    }
    table.caption =
        "Motions that pass in %, over all repetitions; in brackets the entries that it was asked of.".into();
    table
}

fn physics(results: &Results) -> Table {
    let mut table = Table::new("Plausibility", columns(&plausibility::HEAD));
    for row in &results.rows {
        let Some(found) = &row.plausibility else { continue };
        table.rows.push([Cell::text(&row.name)].into_iter().chain(found.cells().map(Cell::text)).collect());
    }
    table.caption = "Lower is better, 0 is perfect; means weighted by duration.".into();
    table
}
