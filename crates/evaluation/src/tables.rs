//! An evaluation as tables and playbacks.

use std::collections::{BTreeMap, BTreeSet};

use super::evaluation::Evaluation;
use super::rollout::{Cause, Outcome, Rollout, Snapshot};
use super::score::{ClipScore, EpisodeScore};
use super::verdict::Verdict;
use lifelike_character::Vec3;
use lifelike_report::{Cell, Column, Foot, Playback, Table, Tone};

impl Evaluation {
    /// The table of clips, with every column.
    pub fn table(&self) -> Table {
        let mut table = Table::new(
            "Tracking",
            vec![
                Column::text("clip"),
                Column::text("verdict"),
                Column::number("survival", "%"),
                Column::number("success", "%"),
                Column::number("joints", "deg"),
                Column::number("episodes", ""),
                Column::number("length", "s"),
                Column::text("worst joint"),
                Column::number("contacts", "%"),
                Column::number("steps", "%"),
                Column::number("effectors", "m"),
                Column::number("drift", "m"),
                Column::number("at end", "m"),
                Column::number("heading", "deg"),
                Column::number("jerk", "rad/s³"),
                Column::number("reference", "rad/s³"),
                Column::number("slip", "cm/s"),
                Column::number("heat", ""),
                Column::text("hottest joint"),
            ],
        )
        .main_columns(&["clip", "verdict", "survival", "success", "joints", "at end"]);
        table.caption = format!(
            "Episodes of at most {} s from states of the reference, without noise. Errors are means over the frames before a fall. \
             docs/evaluation.md defines every column.",
            self.episode_seconds
        );
        if let Some(own) = &self.intervals {
            let percent = |[low, high]: [f64; 2]| format!("{:.0} to {:.0}%", 100.0 * low, 100.0 * high);
            let [low, high] = own.joint_error_deg;
            table.caption += &format!(
                " 95% intervals over clips: survival {}, success {}, joints {low:.2} to {high:.2} deg.",
                percent(own.survival),
                percent(own.success)
            );
        }
        table.rows = self.clips.iter().map(|clip| row(clip, clip.verdict.to_string(), &self.joints)).collect();
        let group = |score| row(score, String::new(), &self.joints);
        table.foot = self.groups.iter().map(group).collect();
        let follow = self.clips.iter().filter(|clip| clip.verdict.is_good()).count();
        table.foot.push(row(&self.overall, format!("{follow} of {} follow", self.clips.len()), &self.joints));
        table
    }

    /// Groups of clips, and all of them.
    fn sums(&self) -> impl Iterator<Item = &ClipScore> {
        self.groups.iter().chain([&self.overall])
    }

    /// A table with a row for each group, and for all clips.
    fn sum_table(&self, title: &str, caption: &str, columns: &[SumColumn]) -> Table {
        let heads = columns.iter().map(|(name, unit, ..)| Column::number(name, unit));
        let mut table = Table::new(title, [Column::text("clips")].into_iter().chain(heads).collect());
        table.caption = caption.into();
        let cells = |score: &ClipScore| {
            let numbers = columns.iter().map(|(_, _, digits, value)| Cell::number(value(score), *digits));
            [Cell::text(&score.clip)].into_iter().chain(numbers).collect()
        };
        table.rows = self.sums().map(cells).collect();
        table
    }

    /// Place, contacts and smoothness.
    pub fn quality_table(&self) -> Table {
        let caption = "drift and heading: from the reference's path. of asked: jerk over the reference's. heat: squared torque over the continuous rating squared, mean \
                       and hottest joint; 1 is what the motors bear for any time.";
        self.sum_table(
            "Place and smoothness",
            caption,
            &[
                ("drift", "m", 2, |s| s.position_drift_mean_m),
                ("heading", "deg", 1, |s| s.heading_drift_mean_deg),
                ("jerk", "rad/s³", 0, |s| s.jerk),
                ("of asked", "", 1, |s| s.jerk / s.reference_jerk),
                ("slip", "cm/s", 1, |s| 100.0 * s.sole_slip),
                ("heat", "", 2, |s| s.heat),
                ("hottest", "", 2, |s| s.worst_heat),
            ],
        )
    }

    /// Root and limbs, in the terms of thesis Table 5.3, over the frames before a fall.
    pub fn root_table(&self) -> Table {
        let caption = "Over the frames before a fall; --protocol thesis has them over all frames. eff.: end effectors; lin., \
                       ang.: root velocities; root: its rotation, heading included; tilt: without; upper, lower: joints.";
        self.sum_table(
            "Root and limbs",
            caption,
            &[
                ("eff.", "m", 3, |s| s.effector_error_m),
                ("lin.", "m/s", 3, |s| s.root_velocity_error),
                ("ang.", "rad/s", 3, |s| s.root_angular_velocity_error),
                ("root", "deg", 2, |s| s.root_rotation_error_deg),
                ("tilt", "deg", 2, |s| s.root_tilt_error_deg),
                ("upper", "deg", 2, |s| s.upper_joint_error_deg),
                ("lower", "deg", 2, |s| s.lower_joint_error_deg),
            ],
        )
    }

    /// The measures of published trackers.
    pub fn field_table(&self) -> Table {
        let caption = "HumanTracker: share without a failure by its rule, and joint error before it. mpkpe, r_mpkpe: mjlab 1.6.0. PHC \
                       g and l: MPJPE_g and MPJPE_l. Success by falls only and by PHC's rule: survival and success above.";
        self.sum_table(
            "The field's measures",
            caption,
            &[
                ("HumanTracker", "%", 1, |s| 100.0 * s.human_tracker_success),
                ("MPJPE", "rad", 3, |s| s.human_tracker_mpjpe_rad),
                ("mpkpe", "mm", 0, |s| 1000.0 * s.mpkpe_m),
                ("r_mpkpe", "mm", 0, |s| 1000.0 * s.r_mpkpe_m),
                ("PHC g", "mm", 0, |s| 1000.0 * s.body_error_m),
                ("PHC l", "mm", 0, |s| 1000.0 * s.root_relative_body_error_m),
            ],
        )
    }

    /// The table of falls; `None` when there are none.
    pub fn failure_table(&self) -> Option<Table> {
        let mut table = Table::new(
            "Falls",
            vec![
                Column::text("clip"),
                Column::number("after", "s"),
                Column::number("clip at", "s"),
                Column::text("how"),
                Column::text("what came before"),
            ],
        );
        table.caption =
            "The first body more than 15 cm off the reference's posture until the fall; joints above 95% of \
                         their largest torque in the last half second."
                .into();
        table.rows = self
            .failures()
            .map(|f| {
                vec![
                    Cell::text(&f.clip),
                    Cell::number(f.second, 2),
                    Cell::number(f.clip_second, 2),
                    Cell::text(f.cause.words()),
                    Cell::text(f.why()),
                ]
            })
            .collect();
        if table.rows.is_empty() { None } else { Some(table) }
    }

    /// The falls in one line a cause; `None` when there are none.
    pub fn fall_summary(&self) -> Option<Table> {
        let columns = vec![
            Column::text("falls"),
            Column::number("episodes", ""),
            Column::number("clips", ""),
            Column::text("left first"),
        ];
        let mut table = Table::new("Falls by cause", columns);
        for cause in [Cause::Height, Cause::Tilt, Cause::Diverged] {
            let of_cause = || self.failures().filter(move |failure| failure.cause == cause);
            let clips: BTreeSet<&str> = of_cause().map(|failure| failure.clip.as_str()).collect();
            let mut bodies: BTreeMap<&str, usize> = BTreeMap::new();
            for first in of_cause().filter_map(|failure| failure.first_body.as_ref()) {
                *bodies.entry(&first.body).or_default() += 1;
            }
            let first = bodies.into_iter().max_by_key(|(_, count)| *count);
            let first = first.map_or_else(String::new, |(body, count)| format!("{body} ({count} times)"));
            if !clips.is_empty() {
                let numbers = [of_cause().count(), clips.len()].map(|n| Cell::number(n as f64, 0));
                let words = [Cell::text(cause.words())].into_iter().chain(numbers);
                table.rows.push(words.chain([Cell::text(first)]).collect());
            }
        }
        if table.rows.is_empty() { None } else { Some(table) }
    }

    /// All tables, for a report.
    pub fn tables(&self) -> Vec<Table> {
        [self.table()].into_iter().chain(self.group_tables()).chain(self.failure_table()).collect()
    }

    /// Tables with a row for each group of clips: quality, root and limbs, the field's measures.
    pub fn group_tables(&self) -> [Table; 3] {
        [self.quality_table(), self.root_table(), self.field_table()]
    }

    /// The recorded rollouts, to look at.
    pub fn playbacks(&self) -> Vec<Playback> {
        self.rollouts.iter().map(playback).collect()
    }
}

/// Head, unit, digits and value of a column of [`Evaluation::sum_table`].
type SumColumn = (&'static str, &'static str, usize, fn(&ClipScore) -> f64);

fn row(score: &ClipScore, verdict: String, joints: &[String]) -> Vec<Cell> {
    let named = |joint: Option<usize>, value: String| {
        joint.and_then(|j| joints.get(j)).map_or_else(String::new, |name| format!("{name} {value}"))
    };
    let worst = named(score.worst_joint, format!("{:.1}", score.worst_joint_error_deg));
    let hottest = named(score.worst_heat_joint, format!("{:.2}", score.worst_heat));
    let rate = |share: f64| {
        let tone = (share < 1.0).then_some(Tone::Bad);
        Cell::number(100.0 * share, if share > 0.0 && share < 1.0 { 1 } else { 0 }).tone(tone)
    };
    vec![
        Cell::text(&score.clip),
        Cell::text(verdict),
        rate(score.survival),
        rate(score.success),
        Cell::number(score.joint_error_deg, 2),
        Cell::number(score.episodes as f64, 0),
        Cell::number(score.seconds, 1),
        Cell::text(worst),
        Cell::number(100.0 * score.contact_agreement, 0),
        Cell::number(100.0 * score.steps_taken, 0),
        Cell::number(score.effector_error_m, 3),
        Cell::number(score.position_drift_mean_m, 2),
        Cell::number(score.position_drift_end_m, 2),
        Cell::number(score.heading_drift_mean_deg, 1),
        Cell::number(score.jerk, 0),
        Cell::number(score.reference_jerk, 0),
        Cell::number(100.0 * score.sole_slip, 1),
        Cell::number(score.heat, 2),
        Cell::text(hottest),
    ]
}

/// A rollout to look at.
pub(super) fn playback(rollout: &Rollout) -> Playback {
    let bodies = |frames: &[Snapshot]| frames.iter().map(|f| f.bodies.clone()).collect();
    let score = EpisodeScore::of(rollout);
    let fall = match rollout.outcome {
        Outcome::Survived => None,
        Outcome::Fell { frame, .. } => Some(frame as f64 / rollout.fps),
    };
    let errors = if score.joint_error_deg.is_finite() {
        format!("{:.1}° · {:.1} cm", score.joint_error_deg, 100.0 * score.effector_error_m)
    } else {
        "no frame survived".into()
    };
    let verdict = Verdict::of(&[&score]);
    let verdict = match &score.failure {
        Some(failure) => format!("{verdict}: {}", failure.cause.words()),
        None => verdict.to_string(),
    };
    let start = if rollout.start > 0.0 { format!(" from {:.1} s", rollout.start) } else { String::new() };
    let columns = rollout.names.feet.len();
    let foot = |(column, (body, middle)): (usize, &(usize, Vec3))| Foot {
        body: *body,
        middle: *middle,
        force: rollout.foot_force.iter().skip(column).step_by(columns).copied().collect(),
        down: rollout.planned_contact.iter().skip(column).step_by(columns).copied().collect(),
    };
    let joints = |frames: &[Snapshot]| frames.iter().map(|f| f.joints.clone()).collect();
    Playback {
        name: format!("{}{start}", rollout.clip),
        note: format!("{verdict} · {errors} · {:.1} s", score.planned_seconds),
        fps: rollout.fps,
        simulated: bodies(&rollout.simulated),
        reference: bodies(&rollout.reference),
        fall,
        feet: rollout.names.soles.iter().enumerate().map(foot).collect(),
        joint_names: rollout.names.joints.clone(),
        joints: [joints(&rollout.simulated), joints(&rollout.reference)],
        ..Playback::default()
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::super::rollout::example::{rollout, snapshot};
    use super::*;

    #[test]
    fn an_evaluation_can_be_read_and_looked_at() {
        let still = |_| snapshot(Vec3::z(), 0.0, 0.0);
        let good = rollout(11, still, |_| snapshot(Vec3::z(), 0.0, std::f64::consts::PI / 90.0));
        let mut bad = good.clone();
        bad.clip = "run".into();
        bad.outcome = Outcome::Fell { frame: 5, cause: Cause::Height };
        let scores = [&good, &bad].map(EpisodeScore::of).to_vec();
        let evaluation = Evaluation::new(("post", &["knee".to_string()]), "none", 10.0, scores, vec![good, bad]);
        let table = evaluation.table();
        let texts = |row: &[Cell]| row.iter().map(|c| c.text.clone()).collect::<Vec<_>>();
        assert_eq!(texts(&table.rows[0])[..7], ["walk", "follows", "100", "100", "2.00", "1", "1.0"]);
        assert_eq!(texts(&table.rows[1])[1], "falls at 2.5 s");
        assert_eq!(texts(&table.foot[0])[..7], ["all", "1 of 2 follow", "50.0", "50.0", "2.00", "2", "1.0"]);
        assert!(table.rows.iter().chain(&table.foot).all(|r| r.len() == table.columns.len()));
        // Half of the continuous torque throughout: 0.2 squared in the example.
        assert_eq!(texts(&table.foot[0])[17..], ["0.04", "knee 0.04"]);
        let field = evaluation.field_table();
        assert_eq!(texts(&field.rows[0]), ["all", "50.0", "0.035", "0", "0", "0", "0"]);
        let falls = evaluation.failure_table().unwrap();
        assert_eq!(texts(&falls.rows[0])[..4], ["run", "0.50", "2.50", "root sank"]);
        let causes = evaluation.fall_summary().map(|table| table.rows).unwrap_or_default();
        assert_eq!(texts(&causes[0])[..3], ["root sank", "1", "1"]);
        let playbacks = evaluation.playbacks();
        assert_eq!(playbacks[0].note, "follows · 2.0° · 0.0 cm · 1.0 s");
        assert_eq!((playbacks[1].fall, playbacks[1].simulated.len()), (Some(0.5), 11));
    }
}
