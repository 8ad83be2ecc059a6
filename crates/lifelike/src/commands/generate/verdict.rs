//! Verdict on a generated motion for a robot, in plain words.

use std::cmp::Ordering;

use lifelike_evaluation::verdict::finding_words;
use lifelike_generation::critic::{Critic, RewardSurrogate};
use lifelike_generation::representation::FeatureMatrix;
use lifelike_motion::MotionClip;
use lifelike_motion::feasibility;
use lifelike_motion::plausibility::{Collision, collisions};
use lifelike_robot::Robot;

use crate::error::CliError;

/// Overlap of two parts from which they are told to be inside of each other (m): shapes are padded, and a hand that
/// rests on the body is no fault.
const INSIDE: f64 = 0.02;
/// A collision of at least this length (s) rules a motion out, as the other findings of [`feasibility::Kind::patience`] do.
const PATIENCE: f64 = 0.15;

/// A verdict on one motion.
#[derive(Debug, Clone, serde::Serialize)]
pub struct Verdict {
    /// Nothing rules it out, as far as can be told without physics.
    pub feasible: bool,
    /// Reasons against it, in the order of time.
    pub reasons: Vec<String>,
    /// Length of what rules it out, summed over reasons (s).
    pub bad_seconds: f64,
    /// Limbs that physics made gentler, of a motion that physics made.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub softened: Vec<String>,
    /// The critic's opinion, where there is a critic.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub critic: Option<Opinion>,
}

/// A critic's opinion of one motion.
#[derive(Debug, Clone, serde::Serialize)]
pub struct Opinion {
    /// Realism: mean value over all windows.
    pub realism: f64,
    /// Lowest value of a window.
    pub lowest: f64,
    /// Time of that window (s).
    pub at: f64,
}

impl Opinion {
    fn of(critic: &Critic, rows: &FeatureMatrix) -> Result<Self, CliError> {
        let values = critic.values(rows)?;
        let lowest = values.iter().enumerate().min_by(|a, b| a.1.total_cmp(b.1));
        let (row, lowest) = lowest.map_or((0, f64::NAN), |(row, value)| (row, f64::from(*value)));
        let at = row as f64 / critic.header().representation.fps;
        Ok(Self { realism: critic.realism(rows)?, lowest, at })
    }
}

impl Verdict {
    /// Judges a clip by momentum, limits and collisions, and by the critic's values for the rows it was made of.
    pub fn of(
        clip: &MotionClip,
        rows: &FeatureMatrix,
        robot: &Robot,
        critic: Option<&Critic>,
    ) -> Result<Self, CliError> {
        let reasons = reasons(clip, robot)?;
        Ok(Self {
            feasible: reasons.is_empty(),
            bad_seconds: reasons.iter().map(|reason| reason.seconds).sum(),
            reasons: reasons.into_iter().map(|reason| reason.words).collect(),
            softened: Vec::new(),
            critic: critic.map(|critic| Opinion::of(critic, rows)).transpose()?,
        })
    }

    /// Compares two candidates, the better one first: fewer seconds that rule a motion out, then the critic's higher lowest
    /// value. A critic alone tells falls no better than plain kinematics do (docs/results/critic.md), so it does not overrule them.
    pub fn compare(&self, other: &Self) -> Ordering {
        let lowest = |verdict: &Self| verdict.critic.as_ref().map_or(0.0, |opinion| opinion.lowest);
        self.bad_seconds.total_cmp(&other.bad_seconds).then(lowest(other).total_cmp(&lowest(self)))
    }

    /// Returns one line.
    pub fn words(&self) -> String {
        /// Most reasons of a line.
        const MOST: usize = 4;
        let softened: String = self.softened.iter().map(|line| format!("; {line}")).collect();
        if self.feasible {
            return format!("feasible{softened}");
        }
        let more = self.reasons.len().saturating_sub(MOST);
        let more = if more > 0 { format!("; and {more} more") } else { String::new() };
        format!("not feasible: {}{more}", self.reasons[..self.reasons.len().min(MOST)].join("; ")) + &softened
    }
}

/// A reason against a motion, without physics.
pub struct Reason {
    /// Start (s).
    pub from: f64,
    /// Duration (s).
    pub seconds: f64,
    /// Reason and time.
    pub words: String,
}

/// Returns the reasons against a clip by momentum, limits and collisions, in the order of time.
///
/// # Errors
/// The clip is not the robot's.
pub fn reasons(clip: &MotionClip, robot: &Robot) -> Result<Vec<Reason>, CliError> {
    let found = feasibility::check(clip, &robot.character, &robot.anatomy, &robot.speeds())?;
    let inside = collisions(clip, &robot.character, INSIDE)?;
    let inside = inside.iter().filter(|collision| collision.seconds >= PATIENCE - 1e-9);
    let found = found.reasons().map(|f| Reason { from: f.from, seconds: f.seconds, words: finding_words(f) });
    let mut reasons: Vec<Reason> = found.chain(inside.map(collided)).collect();
    reasons.sort_by(|a, b| a.from.total_cmp(&b.from));
    Ok(reasons)
}

fn collided(collision: &Collision) -> Reason {
    let [a, b] = collision.parts.each_ref().map(|part| part.replace('_', " "));
    let words = format!("{a} inside {b} at {:.1} s", collision.from);
    Reason { from: collision.from, seconds: collision.seconds, words }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use lifelike_generation::representation::RepresentationSpec;
    use lifelike_robot::clips;

    fn judged(change: impl Fn(&mut MotionClip)) -> Verdict {
        let robot = Robot::load("lima").unwrap();
        let mut clip = clips::load_one(std::path::Path::new("builtin:walk"), &robot).unwrap();
        change(&mut clip);
        let rows = FeatureMatrix::from_clip(&clip, &RepresentationSpec::of(&robot.layout)).unwrap();
        Verdict::of(&clip, &rows, &robot, None).unwrap()
    }

    #[test]
    fn our_walk_is_feasible_and_what_is_done_to_it_is_named() {
        let good = judged(|_| ());
        assert_eq!((good.words().as_str(), good.bad_seconds), ("feasible", 0.0));
        let high = judged(|clip| clip.root_position.iter_mut().for_each(|p| p.z += 0.5));
        assert!(high.words().starts_with("not feasible: held up by nothing at "), "{}", high.words());
        assert!(good.compare(&high) == Ordering::Less && !high.feasible);
        let arm = judged(|clip| {
            let column = clip.joint_names.iter().position(|name| name == "left_shoulder_roll").unwrap();
            let width = clip.joint_names.len();
            // Through the trunk, further than its range allows.
            clip.joints.iter_mut().skip(column).step_by(width).for_each(|q| *q = -1.0);
        });
        assert!(arm.reasons.iter().any(|reason| reason.contains(" inside ")), "{}", arm.words());
    }
}
