//! An evaluation as tables and playbacks.

use std::collections::{BTreeMap, BTreeSet};

use super::evaluation::Evaluation;
use super::rollout::{Cause, Outcome, Rollout, Snapshot};
use super::score::{ClipScore, EpisodeScore};
use super::verdict::Verdict;
use lifelike_character::Vec3;
use lifelike_report::{Cell, Column, Foot, Playback, Table, Tone};

impl Evaluation {
    /// The table of clips.
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
            ],
        )
        .main_columns(&["clip", "verdict", "survival", "success", "joints", "at end"]);
        table.caption = format!(
            "Episodes of at most {} s from states of the reference, no noise. survival: no fall (root below 60% of the \
             reference's height, or tilted more than 1 rad off). success: no fall, and the mean body error never above \
             0.5 m. joints: mean absolute error; worst joint: the one with the largest. contacts: frames in which the feet are \
             in contact as in the reference. steps: steps of the reference in which the robot's foot leaves the ground, too. effectors: mean distance of hands and feet, relative to root and \
             heading. drift and heading: mean distance on the ground and mean heading error. jerk: mean over joints, of \
             physics and of the reference. slip: mean speed of standing soles over the ground. Errors are means over the frames before a fall.",
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

    /// The errors of thesis Table 5.3, all episodes together.
    pub fn root_table(&self) -> Table {
        let columns = [
            ("episodes", ""),
            ("fell", "%"),
            ("frames", "%"),
            ("lin. vel.", "m/s"),
            ("ang. vel.", "rad/s"),
            ("root rot.", "deg"),
            ("upper DoFs", "deg"),
            ("lower DoFs", "deg"),
            ("MPJPE_g", "mm"),
            ("MPJPE_l", "mm"),
        ];
        let columns = columns.map(|(name, unit)| Column::number(name, unit)).to_vec();
        let mut table = Table::new("Root, limbs (thesis Table 5.3) and bodies (PHC)", columns);
        table.caption = "Mean distances over the frames before a fall, of which there are so many in percent of all: \
                         velocities each in its own root's frame, the angle between the root's orientations (heading \
                         included), joints of legs and all others; bodies in the world (MPJPE_g) and with both roots in one \
                         place (MPJPE_l)."
            .into();
        let all = &self.overall;
        table.rows = vec![vec![
            Cell::number(all.episodes as f64, 0),
            Cell::number(100.0 * (1.0 - all.survival), 1),
            Cell::number(100.0 * all.covered, 1),
            Cell::number(all.root_velocity_error, 3),
            Cell::number(all.root_angular_velocity_error, 3),
            Cell::number(all.root_rotation_error_deg, 2),
            Cell::number(all.upper_joint_error_deg, 2),
            Cell::number(all.lower_joint_error_deg, 2),
            Cell::number(1000.0 * all.body_error_m, 0),
            Cell::number(1000.0 * all.root_relative_body_error_m, 0),
        ]];
        table
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
        let columns = vec![Column::text("falls"), Column::number("episodes", ""), Column::number("clips", ""), Column::text("left first")];
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
        [self.table(), self.root_table()].into_iter().chain(self.failure_table()).collect()
    }

    /// The recorded rollouts, to look at.
    pub fn playbacks(&self) -> Vec<Playback> {
        self.rollouts.iter().map(playback).collect()
    }
}

fn row(score: &ClipScore, verdict: String, joints: &[String]) -> Vec<Cell> {
    let worst = score
        .worst_joint
        .and_then(|j| joints.get(j))
        .map_or_else(String::new, |name| format!("{name} {:.1}", score.worst_joint_error_deg));
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
    let end = match &score.failure {
        Some(failure) => format!("fell at {:.2} s: {}", failure.second, failure.cause.words()),
        None => format!("survived {:.1} s", score.planned_seconds),
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
        note: format!("{} · {errors} · {end}", Verdict::of(&[&score])),
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
        let falls = evaluation.failure_table().unwrap();
        assert_eq!(texts(&falls.rows[0])[..4], ["run", "0.50", "2.50", "root sank"]);
        let causes = evaluation.fall_summary().map(|table| table.rows).unwrap_or_default();
        assert_eq!(texts(&causes[0])[..3], ["root sank", "1", "1"]);
        let playbacks = evaluation.playbacks();
        assert_eq!(playbacks[0].note, "follows · 2.0° · 0.0 cm · survived 1.0 s");
        assert_eq!((playbacks[1].fall, playbacks[1].simulated.len()), (Some(0.5), 11));
    }
}
