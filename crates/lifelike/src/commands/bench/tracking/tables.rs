//! The tables of a study.

use lifelike_evaluation::{ClipScore, CommonErrors};
use lifelike_report::{Cell, Column, Table};

use super::Run;
use super::study::{Class, Published, Study};
use crate::commands::bench::seeds::spread;
use crate::output::fitted;

/// All tables as text.
pub fn all(study: &Study, runs: &[Run]) -> String {
    format!("{}\n{}", fitted(&table(study, runs)), fitted(&common_table(study, runs)))
}

/// Joint error, end-effector error, survival and steps taken by class, below what others publish; with several seeds the mean, and ± half
/// the range.
fn table(study: &Study, runs: &[Run]) -> Table {
    let unit = "deg | m | survival % | steps %";
    let mut table = by_class("Tracking errors by class of motion", unit, study, runs, |own, class| {
        let of = |value: fn(&ClipScore) -> f64| spread(own.iter().map(|r| value(&r.scores[class])));
        let errors = [say(of(|s| s.joint_error_deg), 2), say(of(|s| s.effector_error_m), 3)];
        let rates = [say(of(|s| 100.0 * s.survival), 0), say(of(|s| 100.0 * s.steps_taken), 0)];
        [errors, rates].concat().join(" | ")
    });
    let published = |row: &Published, class: &Class| {
        let errors = row.errors.get(&class.name);
        errors.map_or("–".into(), |[d, m]| format!("{} | {}", say((*d, 0.0), 2), say((*m, 0.0), 3)))
    };
    let above = study.published.iter().map(|row| {
        let cells = study.class.iter().map(|class| published(row, class));
        [row.name.clone(), String::new()].into_iter().chain(cells).map(Cell::text).collect()
    });
    table.rows.splice(0..0, above);
    table
}

/// The same over the frames that every run of a stage survives, and the share of all frames that these are.
fn common_table(study: &Study, runs: &[Run]) -> Table {
    let title = "Over the frames that every run survives (of one stage, where there are several)";
    by_class(title, "deg | m | frames %", study, runs, |own, class| {
        let of = |value: fn(&CommonErrors) -> f64| spread(own.iter().map(|r| value(&r.common[class])));
        let (joints, effectors) = (of(|c| c.joint_error_deg), of(|c| c.effector_error_m));
        format!("{} | {} | {}", say(joints, 2), say(effectors, 3), say(of(|c| 100.0 * c.covered), 0))
    })
}

/// A row for each variant that has runs, stage after stage, and a column for each class.
fn by_class(title: &str, unit: &str, study: &Study, runs: &[Run], cell: impl Fn(&[&Run], usize) -> String) -> Table {
    let mut columns = vec![Column::text("input"), Column::number("runs", "")];
    columns.extend(study.class.iter().map(|class| Column::number(&class.name, unit)));
    let mut table = Table::new(title, columns);
    for stage in study.stages() {
        for variant in &study.variant {
            let name = stage.map(|stage| &stage.name);
            let is_own = |r: &&Run| r.variant == variant.name && r.stage.as_ref() == name;
            let own: Vec<&Run> = runs.iter().filter(is_own).collect();
            if !own.is_empty() {
                let cells = (0..study.class.len()).map(|class| cell(&own, class));
                let label = name.map_or_else(|| variant.name.clone(), |stage| format!("{}, {stage}", variant.name));
                table.rows.push([label, own.len().to_string()].into_iter().chain(cells).map(Cell::text).collect());
            }
        }
    }
    table
}

fn say((mean, half_range): (f64, f64), digits: usize) -> String {
    if mean.is_nan() {
        // What a paper does not tell, or nothing was measured of.
        "–".into()
    } else if half_range > 0.0 {
        format!("{mean:.digits$} ± {half_range:.digits$}")
    } else {
        format!("{mean:.digits$}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn means_and_half_ranges_are_said_in_few_digits() {
        assert_eq!(say((3.0, 2.5), 1), "3.0 ± 2.5");
        assert_eq!(say((3.0, 0.0), 2), "3.00");
        assert_eq!(say((f64::NAN, f64::NAN), 2), "–");
    }
}
