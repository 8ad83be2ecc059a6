//! The tables of a study.

use lifelike_evaluation::{ClipScore, ThesisErrors};
use lifelike_report::{Cell, Column, Table};

use super::Run;
use super::study::{Class, Published, Study};
use crate::seeds::spread;
use lifelike::output::fitted;

/// Returns the tables of the study's protocols.
pub fn all(study: &Study, runs: &[Run]) -> Vec<Table> {
    let (clips, thesis) = study.protocols();
    let own = clips.then(|| clip_table(study, runs));
    let thesis = thesis.then(|| [thesis_table(study, runs), root_table(study, runs)]);
    own.into_iter().chain(thesis.into_iter().flatten()).collect()
}

/// Returns the same as text.
pub fn text(study: &Study, runs: &[Run]) -> String {
    all(study, runs).iter().map(|table| format!("{}\n{}\n", table.title, fitted(table))).collect()
}

/// Joint error, end-effector error, survival and steps taken by class, by our own protocol.
fn clip_table(study: &Study, runs: &[Run]) -> Table {
    let unit = "deg | m | survival % | steps %";
    let mut table = by_class("Our protocol: before a fall", unit, study, runs, |own, class| {
        let of = |value: fn(&ClipScore) -> f64| spread(own.iter().map(|r| value(&r.scores[class])));
        let errors = [say(of(|s| s.joint_error_deg), 2), say(of(|s| s.effector_error_m), 3)];
        let rates = [say(of(|s| 100.0 * s.survival), 0), say(of(|s| 100.0 * s.steps_taken), 0)];
        [errors, rates].concat().join(" | ")
    });
    table.caption = format!(
        "{} episodes of each clip of at most {} s; errors over the frames before a fall.{SEEDS}",
        study.starts, study.seconds
    );
    table
}

/// Joint error, end-effector error and terminations by class, by the thesis' protocol, below the rows that others publish.
fn thesis_table(study: &Study, runs: &[Run]) -> Table {
    let title = "Thesis protocol: all frames (Table 4.3)";
    let mut table = by_class(title, "deg | m | survival % | ends/min", study, runs, |own, class| {
        let of = |value: fn(&ThesisErrors) -> f64| spread(own.iter().map(|r| value(&r.thesis[class])));
        let errors = [say(of(|e| e.joint_error_deg), 2), say(of(|e| e.effector_error_m), 3)];
        let rates = [say(of(|e| 100.0 * e.survival), 0), say(of(|e| e.terminations_per_minute), 2)];
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
    table.caption = format!(
        "{} episodes of {} s a class that begin at random frames and go on with another motion where one ends or an end effector stays \
         beyond t^p for {} s; errors over all frames. survival: episodes without a fall; ends: terminations.{SEEDS}",
        study.thesis.episodes, study.thesis.seconds, study.thesis.patience
    );
    table
}

/// Root by class, by the thesis' protocol.
fn root_table(study: &Study, runs: &[Run]) -> Table {
    let title = "Thesis protocol: root rotation and tilt (Table 5.3)";
    let mut table = by_class(title, "root deg | tilt deg | m/s", study, runs, |own, class| {
        let of = |value: fn(&ThesisErrors) -> f64| spread(own.iter().map(|r| value(&r.thesis[class])));
        let angles = [say(of(|e| e.root_rotation_error_deg), 2), say(of(|e| e.root_tilt_error_deg), 2)];
        format!("{} | {}", angles.join(" | "), say(of(|e| e.root_velocity_error), 3))
    });
    table.caption = format!("root: heading included; tilt: without heading, as in eq. 4.6.{SEEDS}");
    table
}

const SEEDS: &str = " With several seeds: mean ± half the range, each seed below.";

/// A row for each variant that has runs, stage after stage, and one for each of its seeds where there are several. A
/// column for each class.
fn by_class(title: &str, unit: &str, study: &Study, runs: &[Run], cell: impl Fn(&[&Run], usize) -> String) -> Table {
    let mut columns = vec![Column::text("input"), Column::number("runs", "")];
    columns.extend(study.class.iter().map(|class| Column::number(&class.name, unit)));
    let mut table = Table::new(title, columns);
    let row = |label: String, count: String, own: &[&Run]| {
        let cells = (0..study.class.len()).map(|class| cell(own, class));
        [label, count].into_iter().chain(cells).map(Cell::text).collect::<Vec<_>>()
    };
    for stage in study.stages() {
        for variant in &study.variant {
            let name = stage.map(|stage| &stage.name);
            let is_own = |r: &&Run| r.variant == variant.name && r.stage.as_ref() == name;
            let own: Vec<&Run> = runs.iter().filter(is_own).collect();
            if own.is_empty() {
                continue;
            }
            let label = name.map_or_else(|| variant.name.clone(), |stage| format!("{}, {stage}", variant.name));
            table.rows.push(row(label, own.len().to_string(), &own));
            if own.len() > 1 {
                table.rows.extend(own.iter().map(|run| row(format!("  seed {}", run.seed), String::new(), &[*run])));
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
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn means_and_half_ranges_are_said_in_few_digits() {
        assert_eq!(say((3.0, 2.5), 1), "3.0 ± 2.5");
        assert_eq!(say((3.0, 0.0), 2), "3.00");
        assert_eq!(say((f64::NAN, f64::NAN), 2), "–");
    }

    #[test]
    fn every_seed_has_a_row_below_the_mean_and_what_is_published_stands_above() {
        let text = "plan = 'p'\nprotocol = 'thesis'\n[[variant]]\nname = 'M'\nseeds = [1, 2]\n[[variant]]\nname = 'L'\nseeds = [1]\n\
                    [[class]]\nname = 'walk'\nclips = []\n[[published]]\nname = 'M (thesis)'\nerrors = { walk = [8.63, 0.044] }";
        let study: Study = toml::from_str(text).unwrap();
        let run = |variant: &str, seed: u64, degrees: f64| Run {
            variant: variant.into(),
            stage: None,
            seed,
            steps: 0,
            minutes: 0.0,
            scores: Vec::new(),
            thesis: vec![ThesisErrors {
                frames: 100,
                survival: 0.9,
                joint_error_deg: degrees,
                joint_error_interval_deg: [degrees; 2],
                effector_error_m: 0.05,
                root_velocity_error: 0.2,
                root_angular_velocity_error: 0.3,
                root_rotation_error_deg: 9.0,
                root_tilt_error_deg: 3.0,
                upper_joint_error_deg: 1.0,
                lower_joint_error_deg: 2.0,
                terminations: 1,
                terminations_per_minute: 0.5,
            }],
            deviation: Some(0.3),
            place: 0,
        };
        let runs = [run("M", 1, 5.0), run("M", 2, 7.0), run("L", 1, 4.0)];
        let tables = all(&study, &runs);
        let rows: Vec<String> = tables[0].rows.iter().map(|row| format!("{}: {}", row[0].text, row[2].text)).collect();
        let expected = [
            "M (thesis): 8.63 | 0.044",
            "M: 6.00 ± 1.00 | 0.050 | 90 | 0.50",
            "  seed 1: 5.00 | 0.050 | 90 | 0.50",
            "  seed 2: 7.00 | 0.050 | 90 | 0.50",
            "L: 4.00 | 0.050 | 90 | 0.50",
        ];
        assert_eq!(rows, expected);
        assert_eq!((tables.len(), tables[1].rows[0][2].text.as_str()), (2, "9.00 | 3.00 | 0.200"));
    }
}
