//! The evaluation of a policy: every score, and how sure their means are.

use super::failure::Failure;
use super::interval::Intervals;
use super::rollout::Rollout;
use super::score::{ClipScore, EpisodeScore};

/// The evaluation of one policy.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Evaluation {
    /// The robot.
    pub robot: String,
    /// The engine.
    pub engine: String,
    /// Names of the joints that errors are listed by.
    pub joints: Vec<String>,
    /// Longest episode (s).
    pub episode_seconds: f64,
    /// One score per clip, in the order in which they were given.
    pub clips: Vec<ClipScore>,
    /// Groups of clips, such as those that are called trackable ([`Evaluation::group`]).
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub groups: Vec<ClipScore>,
    /// All episodes together.
    pub overall: ClipScore,
    /// Confidence of means over clips; `None` for fewer than three.
    pub intervals: Option<Intervals>,
    /// Every episode.
    pub episodes: Vec<EpisodeScore>,
    /// Recorded rollouts, for the eye; not part of the JSON.
    #[serde(skip)]
    pub rollouts: Vec<Rollout>,
}

impl Evaluation {
    /// Sums up episodes, which come clip by clip.
    pub fn new(
        robot: (&str, &[String]),
        engine: &str,
        seconds: f64,
        episodes: Vec<EpisodeScore>,
        rollouts: Vec<Rollout>,
    ) -> Self {
        let clips: Vec<ClipScore> = episodes
            .chunk_by(|a, b| a.clip == b.clip)
            .map(|group| ClipScore::of(&group[0].clip, &group.iter().collect::<Vec<_>>()))
            .collect();
        Self {
            robot: robot.0.into(),
            joints: robot.1.to_vec(),
            engine: engine.into(),
            episode_seconds: seconds,
            intervals: Intervals::of(&clips),
            groups: Vec::new(),
            clips,
            overall: ClipScore::of("all", &episodes.iter().collect::<Vec<_>>()),
            episodes,
            rollouts,
        }
    }

    /// Adds a score of the clips of these names together; of none, nothing.
    pub fn group(&mut self, name: &str, is: impl Fn(&str) -> bool) {
        let episodes: Vec<&EpisodeScore> = self.episodes.iter().filter(|episode| is(&episode.clip)).collect();
        if !episodes.is_empty() {
            let score = ClipScore::of(name, &episodes);
            self.groups.push(score);
        }
    }

    /// All falls.
    pub fn failures(&self) -> impl Iterator<Item = &Failure> {
        self.episodes.iter().filter_map(|e| e.failure.as_ref())
    }
}

#[cfg(test)]
mod tests {
    use lifelike_character::Vec3;

    use super::super::rollout::example::{rollout, snapshot};
    use super::super::rollout::{Cause, Outcome};
    use super::*;

    /// A robot that falls at once.
    fn episode() -> EpisodeScore {
        let mut fallen = rollout(5, |_| snapshot(Vec3::z(), 0.0, 0.0), |_| snapshot(Vec3::z(), 0.0, 3.0));
        fallen.outcome = Outcome::Fell { frame: 1, cause: Cause::Tilt };
        EpisodeScore::of(&fallen)
    }

    #[test]
    fn no_number_becomes_null_in_json() {
        let evaluation = Evaluation::new(("post", &["knee".to_string()]), "none", 10.0, vec![episode()], vec![]);
        let json = serde_json::to_value(&evaluation).unwrap_or_default();
        assert!(json["clips"][0]["joint_error_deg"].is_null());
        assert_eq!(json["overall"]["survival"], 0.0);
        assert_eq!(json["episodes"][0]["failure"]["cause"], "tilt");
        assert_eq!(evaluation.failures().count(), 1);
    }
}
