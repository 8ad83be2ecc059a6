//! The table of a retargeting, and its sums.

use std::path::Path;

use lifelike_evaluation::Verdict;
use lifelike_evaluation::verdict;
use lifelike_motion::retarget::RetargetReport;
use lifelike_report::{Cell, Column, Table, Tone};
use serde::Serialize;

use super::Done;
use crate::next::{self, NextCommand};
use crate::output::fitted;

/// All clips together. Medians are over the converted clips.
#[derive(Debug, Serialize)]
pub struct Summary {
    robot: String,
    converted: usize,
    /// Clips that were refused.
    pub refused: usize,
    frames: usize,
    /// Motion (s).
    seconds: f64,
    /// Distance of key bodies from their targets (m), mean over roles and frames.
    median_position_error: f64,
    /// Orientation error (deg), likewise.
    median_orientation_error: f64,
    /// Speed of standing soles (m/s).
    median_foot_skate: f64,
    /// The largest penetration of each clip (m).
    median_ground_penetration: f64,
    /// Mean height of standing soles (m).
    median_ground_float: f64,
    /// The worst excess of any joint over its range (rad).
    largest_range_excess: f64,
    /// Overlap of the robot's own parts (m), mean over frames.
    median_self_penetration: f64,
    /// Wall time of everything (s).
    wall_seconds: f64,
    threads: usize,
    /// Frames per second of one core: reading, converting and writing.
    frames_per_second_per_core: f64,
}

impl Summary {
    /// Sums up.
    pub(super) fn new(robot: &str, done: &[Done], wall_seconds: f64, threads: usize) -> Self {
        let reports: Vec<&RetargetReport> = done.iter().filter_map(|d| d.report.as_ref()).collect();
        let of = |f: &dyn Fn(&RetargetReport) -> f64| median(reports.iter().map(|r| f(r)).collect());
        let frames = reports.iter().map(|r| r.frames).sum();
        let busy: f64 = done.iter().filter(|d| d.report.is_some()).map(|d| d.seconds).sum();
        Self {
            robot: robot.into(),
            converted: reports.len(),
            refused: done.len() - reports.len(),
            frames,
            seconds: reports.iter().map(|r| r.seconds).sum(),
            median_position_error: of(&RetargetReport::mean_position_error),
            median_orientation_error: of(&RetargetReport::mean_orientation_error),
            median_foot_skate: of(&|r| r.foot_skate.mean),
            median_ground_penetration: of(&|r| r.ground_penetration.max),
            median_ground_float: of(&|r| r.ground_float.mean),
            largest_range_excess: reports.iter().map(|r| r.range_excess).fold(0.0, f64::max),
            median_self_penetration: of(&|r| r.self_penetration.mean),
            wall_seconds,
            threads,
            frames_per_second_per_core: if busy > 0.0 { frames as f64 / busy } else { 0.0 },
        }
    }
}

/// Returns the mean distance (m) and angle (deg) of key bodies from their targets.
pub(super) fn errors(report: &RetargetReport) -> (f64, f64) {
    (report.mean_position_error(), report.mean_orientation_error())
}

/// The table of clips: a verdict and the numbers of each.
pub(super) fn table_of(done: &[Done]) -> Table {
    let columns = [
        ("position", "cm"),
        ("angle", "deg"),
        ("skate", "cm/s"),
        ("sunk", "cm"),
        ("float", "cm"),
        ("at limit", "%"),
        ("self", "cm"),
        ("frames/s", ""),
    ];
    let head = [Column::text("clip"), Column::text("verdict"), Column::number("length", "s")];
    let head = head.into_iter().chain(columns.map(|(name, unit)| Column::number(name, unit)));
    let mut table =
        Table::new("Clips", head.collect()).main_columns(&["clip", "verdict", "length", "position", "angle", "skate"]);
    table.caption = "position and angle: distance of key bodies from where the human has them, and of orientations. skate: \
                     speed of standing soles. sunk: lowest point below the ground. float: height of standing soles. at limit: \
                     frames of the joint that is most often at an end of its range. self: overlap of the robot's own parts."
        .into();
    let rows = done.iter().filter_map(|one| Some(row(one.report.as_ref()?, one.verdict.as_ref()?)));
    table.rows = rows.collect();
    table
}

/// The whole for people. `files` are the report, and the page where there is one.
pub(super) fn text(summary: &Summary, done: &[Done], files: (&Path, Option<&Path>), robot: &str) -> String {
    let (report, page) = files;
    let table = table_of(done);
    let folder = report.parent().unwrap_or(Path::new("."));
    let mut text = if table.rows.is_empty() { String::new() } else { fitted(&table) + "\n" };
    for (file, why) in done.iter().filter_map(|d| d.refused.as_ref().map(|why| (&d.file, why))) {
        // Errors of readers name the file themselves.
        let named = why.starts_with(&file.display().to_string());
        text += &if named { format!("refused {why}\n") } else { format!("refused {}: {why}\n", file.display()) };
    }
    text += &notes(done);
    for report in done.iter().filter_map(|d| d.report.as_ref()) {
        text += &report.unfollowed.iter().map(|limb| format!("warning {}: {limb}\n", report.clip)).collect::<String>();
    }
    let s = summary;
    if s.converted == 0 {
        text += &format!("\nnothing was converted to '{}': {} refused\n", s.robot, counted(s.refused));
        return text + &format!("details: {}\n", report.display());
    }
    text += &format!(
        "\n{} ({:.1} s, {} frames) converted to '{}', {} refused, in {:.1} s on {} threads\n",
        counted(s.converted),
        s.seconds,
        s.frames,
        s.robot,
        s.refused,
        s.wall_seconds,
        s.threads
    );
    if s.converted > 0 {
        text += &format!(
            "medians: position {:.1} cm, angle {:.1} deg, skate {:.2} cm/s, deepest {:.2} cm, float {:.2} cm\n\
             joints outside of their range: {:.1} rad at most; {:.0} frames per second of one core\n",
            100.0 * s.median_position_error,
            s.median_orientation_error,
            100.0 * s.median_foot_skate,
            100.0 * s.median_ground_penetration,
            100.0 * s.median_ground_float,
            s.largest_range_excess,
            s.frames_per_second_per_core
        );
    }
    let verdicts: Vec<&Verdict> = done.iter().filter_map(|one| one.verdict.as_ref()).collect();
    text += &format!("{}, as far as can be told without physics\n", verdict::summary(verdicts.iter().copied()));
    text += &format!("details: {}\n", report.display());
    if let Some(page) = page {
        let page = std::path::absolute(page).unwrap_or_else(|_| page.to_path_buf());
        text += &format!("open this in a browser: {}\n", page.display());
    }
    if s.converted > 0 {
        let check = NextCommand::new("motion check").word(folder.display()).word("--robot").word(robot);
        let train = NextCommand::new("train tracker").word("--plan").word("track").word("--robot").word(robot);
        let clips = toml::Value::from(vec![folder.display().to_string()]);
        text += &next::lines(&[check, train.word(format!("clips={clips}"))]);
    }
    text
}

fn counted(clips: usize) -> String {
    format!("{clips} {}", if clips == 1 { "clip" } else { "clips" })
}

/// Each note of the readers once, with the clips that it is for.
fn notes(done: &[Done]) -> String {
    let mut notes: Vec<(&str, Vec<&str>)> = Vec::new();
    for report in done.iter().filter_map(|one| one.report.as_ref()) {
        for note in &report.notes {
            match notes.iter_mut().find(|(known, _)| known == note) {
                Some((_, clips)) => clips.push(&report.clip),
                None => notes.push((note, vec![&report.clip])),
            }
        }
    }
    let mut text = String::new();
    for (note, clips) in notes {
        let others = if clips.len() > 1 { format!(" and {} more", clips.len() - 1) } else { String::new() };
        text += &format!("note {}{others}: {note}\n", clips[0]);
    }
    text
}

fn row(r: &RetargetReport, verdict: &Verdict) -> Vec<Cell> {
    let numbers = [
        100.0 * r.mean_position_error(),
        r.mean_orientation_error(),
        100.0 * r.foot_skate.mean,
        100.0 * r.ground_penetration.max,
        100.0 * r.ground_float.mean,
        100.0 * r.limit_hits.values().copied().fold(0.0, f64::max),
        100.0 * r.self_penetration.max,
    ];
    let tone = if verdict.is_good() { Tone::Good } else { Tone::Bad };
    let words = [Cell::text(&r.clip), Cell::text(verdict.to_string()).tone(Some(tone)), Cell::number(r.seconds, 1)];
    let numbers = numbers.map(|n| Cell::number(n, 2)).into_iter().chain([Cell::number(r.frames_per_second, 0)]);
    words.into_iter().chain(numbers).collect()
}

/// The middle of the values (of an even number, the mean of the two middle ones); 0 of none.
fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    let n = values.len();
    match n {
        0 => 0.0,
        n if n % 2 == 1 => values[n / 2],
        n => (values[n / 2 - 1] + values[n / 2]) / 2.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_median_is_in_the_middle() {
        assert_eq!(median(vec![3.0, 1.0, 2.0]), 2.0);
        assert_eq!(median(vec![4.0, 1.0, 2.0, 3.0]), 2.5);
        assert_eq!(median(vec![]), 0.0);
    }
}
