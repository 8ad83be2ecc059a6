//! One verdict a clip, in words that a person can judge by. The thresholds are documented in docs/evaluation.md.

use std::fmt::{Display, Formatter};

use lifelike_motion::feasibility::{Feasibility, Finding, Kind};

use super::score::EpisodeScore;

/// Steps of the reference from which a clip counts as walking.
pub const WALKING_STEPS: usize = 4;
/// Share of the steps up to which the robot stands instead.
pub const STANDING_SHARE: f64 = 0.25;
/// Share of the steps below which it skips steps.
pub const STEPPING_SHARE: f64 = 0.75;
/// Distance from the reference on the ground above which it lags (m): the greater of the mean and the end.
pub const LAG: f64 = 0.25;
/// Mean heading error above which it faces elsewhere (deg).
pub const HEADING: f64 = 30.0;
/// Mean absolute joint error above which it poses differently (deg).
pub const POSE: f64 = 15.0;

/// Verdict on a clip: the first of these that holds.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Verdict {
    /// An episode ends in a fall, as [`fall`](super::fall) defines it.
    Falls {
        /// Time in the clip of the earliest fall (s).
        second: f64,
        /// Episodes with a fall.
        falls: usize,
        /// Episodes of the clip.
        episodes: usize,
    },
    /// It takes at most [`STANDING_SHARE`] of the steps.
    Stands {
        /// Steps that are taken.
        taken: usize,
        /// Steps of the reference.
        planned: usize,
    },
    /// It takes less than [`STEPPING_SHARE`] of the steps.
    SkipsSteps {
        /// Steps that are taken.
        taken: usize,
        /// Steps of the reference.
        planned: usize,
    },
    /// It is farther than [`LAG`] from the reference's position.
    Lags {
        /// Distance on the ground (m).
        metres: f64,
    },
    /// It is turned by more than [`HEADING`].
    FacesElsewhere {
        /// Mean heading error (deg).
        degrees: f64,
    },
    /// Its joints are off by more than [`POSE`].
    PosesDifferently {
        /// Mean absolute joint error (deg).
        degrees: f64,
    },
    /// Nothing of the above.
    Follows,
    /// Without physics: kinematics and masses rule it out.
    Untrackable {
        /// Longest of the reasons.
        reason: String,
    },
    /// Without physics: nothing rules it out.
    Trackable,
}

impl Verdict {
    /// Judges the episodes of one clip.
    pub fn of(episodes: &[&EpisodeScore]) -> Self {
        let falls = || episodes.iter().filter_map(|e| e.failure.as_ref()).map(|failure| failure.clip_second);
        if let Some(second) = falls().min_by(f64::total_cmp) {
            return Self::Falls { second, falls: falls().count(), episodes: episodes.len() };
        }
        let planned = episodes.iter().map(|e| e.steps_planned).sum();
        let taken = episodes.iter().map(|e| e.steps_taken).sum();
        let mean = |value: fn(&EpisodeScore) -> f64| {
            let known = || episodes.iter().map(|e| value(e)).filter(|v| v.is_finite());
            known().sum::<f64>() / known().count() as f64
        };
        let metres = mean(|e| e.position_drift_mean_m.max(e.position_drift_end_m));
        let share = taken as f64 / planned as f64;
        let walks = planned >= WALKING_STEPS;
        let (heading, pose) = (mean(|e| e.heading_drift_mean_deg), mean(|e| e.joint_error_deg));
        match () {
            () if walks && share <= STANDING_SHARE => Self::Stands { taken, planned },
            () if walks && share < STEPPING_SHARE => Self::SkipsSteps { taken, planned },
            () if metres > LAG => Self::Lags { metres },
            () if heading > HEADING => Self::FacesElsewhere { degrees: heading },
            () if pose > POSE => Self::PosesDifferently { degrees: pose },
            () => Self::Follows,
        }
    }

    /// Judges a clip by kinematics and masses, without physics.
    pub fn without_physics(found: &Feasibility) -> Self {
        match found.reasons().next() {
            None => Self::Trackable,
            Some(longest) => Self::Untrackable { reason: finding_words(longest) },
        }
    }

    /// Returns whether the robot does, or could do, as the clip says.
    pub fn is_good(&self) -> bool {
        matches!(self, Self::Follows | Self::Trackable)
    }
}

impl Display for Verdict {
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Falls { second, episodes: 1, .. } => write!(f, "falls at {second:.1} s"),
            Self::Falls { second, falls, episodes } => {
                write!(f, "falls at {second:.1} s ({falls} of {episodes} starts)")
            }
            Self::Stands { taken, planned } => write!(f, "stands instead of walking ({taken} of {planned} steps)"),
            Self::SkipsSteps { taken, planned } => write!(f, "skips steps (takes {taken} of {planned})"),
            Self::Lags { metres } => write!(f, "lags {metres:.1} m"),
            Self::FacesElsewhere { degrees } => write!(f, "faces {degrees:.0} deg away"),
            Self::PosesDifferently { degrees } => write!(f, "joints {degrees:.0} deg off"),
            Self::Follows => f.write_str("follows"),
            Self::Untrackable { reason } => f.write_str(reason),
            Self::Trackable => f.write_str("trackable"),
        }
    }
}

/// Returns a finding in a few words.
pub fn finding_words(finding: &Finding) -> String {
    let part = finding.part.replace('_', " ");
    let what = match finding.kind {
        Kind::Unsupported => "held up by nothing".into(),
        Kind::Unbalanced => "leans out of its support".into(),
        Kind::Slipping => "slips".into(),
        Kind::TooFast => format!("{part} faster than its motor"),
        Kind::Jump => format!("{part} jumps by {:.1} rad", finding.worst),
        Kind::Spike => format!("{part} {:.1} rad off its path in one frame", finding.worst),
        Kind::BeyondRange => format!("{part} {:.1} rad beyond its range", finding.worst),
        Kind::OtherParts => format!("{part} on the ground"),
        Kind::Underground => format!("{part} in the ground"),
    };
    format!("{what} at {:.1} s", finding.from)
}

/// Test whether a verdict is of a kind.
type IsKind = fn(&Verdict) -> bool;

/// Returns the verdicts of several clips in one line: the number that follow, and the number of each other kind.
pub fn summary<'a>(verdicts: impl Iterator<Item = &'a Verdict> + Clone) -> String {
    let total = verdicts.clone().count();
    let kinds: [(&str, IsKind); 9] = [
        ("follow", |v| matches!(v, Verdict::Follows)),
        ("trackable", |v| matches!(v, Verdict::Trackable)),
        ("fall", |v| matches!(v, Verdict::Falls { .. })),
        ("stand instead of walking", |v| matches!(v, Verdict::Stands { .. })),
        ("skip steps", |v| matches!(v, Verdict::SkipsSteps { .. })),
        ("lag", |v| matches!(v, Verdict::Lags { .. })),
        ("face elsewhere", |v| matches!(v, Verdict::FacesElsewhere { .. })),
        ("pose differently", |v| matches!(v, Verdict::PosesDifferently { .. })),
        ("not trackable", |v| matches!(v, Verdict::Untrackable { .. })),
    ];
    let counted = kinds.iter().map(|(words, is)| (verdicts.clone().filter(|v| is(v)).count(), words));
    let parts: Vec<String> = counted.filter(|(n, _)| *n > 0).map(|(n, words)| format!("{n} {words}")).collect();
    format!("{total} {}: {}", if total == 1 { "clip" } else { "clips" }, parts.join(", "))
}

#[cfg(test)]
mod tests {
    use lifelike_character::Vec3;

    use super::super::rollout::example::{rollout, snapshot};
    use super::super::rollout::{Cause, Outcome};
    use super::*;

    /// An episode without any error, which begins 2 s into its clip.
    fn perfect() -> EpisodeScore {
        let still = |_| snapshot(Vec3::z(), 0.0, 0.0);
        EpisodeScore::of(&rollout(11, still, still))
    }

    fn words(change: impl Fn(&mut EpisodeScore)) -> String {
        let mut score = perfect();
        change(&mut score);
        Verdict::of(&[&score]).to_string()
    }

    #[test]
    fn each_threshold_by_hand() {
        assert_eq!(words(|_| ()), "follows");
        let steps = |planned, taken| words(|s| (s.steps_planned, s.steps_taken) = (planned, taken));
        assert_eq!(steps(14, 0), "stands instead of walking (0 of 14 steps)");
        assert_eq!(steps(4, 1), "stands instead of walking (1 of 4 steps)", "a quarter is standing");
        assert_eq!(steps(14, 4), "skips steps (takes 4 of 14)");
        assert_eq!(steps(4, 3), "follows", "three quarters are walking");
        assert_eq!(steps(3, 0), "follows", "three steps are not a walk");
        assert_eq!(words(|s| s.position_drift_mean_m = 0.4), "lags 0.4 m");
        assert_eq!(words(|s| s.position_drift_end_m = 0.31), "lags 0.3 m", "at the end alone");
        assert_eq!(words(|s| s.position_drift_end_m = 0.25), "follows");
        assert_eq!(words(|s| s.heading_drift_mean_deg = 44.6), "faces 45 deg away");
        assert_eq!(words(|s| s.heading_drift_mean_deg = 30.0), "follows");
        assert_eq!(words(|s| s.joint_error_deg = 18.0), "joints 18 deg off");
        assert_eq!(words(|s| s.joint_error_deg = 15.0), "follows");
    }

    #[test]
    fn the_worst_comes_first_and_a_fall_is_told_by_the_clips_time() {
        let still = |_| snapshot(Vec3::z(), 0.0, 0.0);
        let mut fallen = rollout(11, still, still);
        fallen.outcome = Outcome::Fell { frame: 3, cause: Cause::Tilt };
        let mut fell = EpisodeScore::of(&fallen);
        (fell.steps_planned, fell.steps_taken, fell.joint_error_deg) = (14, 0, 90.0);
        assert_eq!(Verdict::of(&[&fell]).to_string(), "falls at 2.3 s", "0.3 s after a start at 2 s");
        let good = perfect();
        assert_eq!(Verdict::of(&[&good, &fell]).to_string(), "falls at 2.3 s (1 of 2 starts)");
        let all = [Verdict::of(&[&good]), Verdict::of(&[&fell]), Verdict::of(&[&good])];
        assert_eq!(summary(all.iter()), "3 clips: 2 follow, 1 fall");
        assert_eq!(summary(all[..1].iter()), "1 clip: 1 follow");
    }

    #[test]
    fn means_leave_out_episodes_without_numbers() {
        let (mut none, good) = (perfect(), perfect());
        (none.position_drift_mean_m, none.position_drift_end_m, none.joint_error_deg) = (f64::NAN, f64::NAN, f64::NAN);
        assert_eq!(Verdict::of(&[&none, &good]), Verdict::Follows);
    }
}
