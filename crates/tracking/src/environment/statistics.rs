//! Statistics of episodes, for the metrics.

use std::collections::VecDeque;

use crate::episode::Episode;
use crate::rewards::TERMS;
use crate::terminations::Cause;

/// Episodes that the running means are taken over.
const RECENT: usize = 100;
/// Share of the newest episode in a clip's survival rate.
const NEWEST: f64 = 0.05;

/// Counts and means over the episodes of all environments.
#[derive(Debug, Clone, PartialEq)]
pub struct EpisodeStatistics {
    /// Environment steps since the last [`Self::start`].
    pub steps: u64,
    /// Sum of each reward term since then.
    pub terms: [f64; TERMS.len()],
    /// Sum of the mean absolute joint errors since then (rad).
    pub joint_error: f64,
    /// Failures by cause since then.
    pub causes: [u64; Cause::ALL.len()],
    /// Episodes that ended since then.
    pub episodes: u64,
    /// Return and length of the last episodes.
    recent: VecDeque<[f64; 2]>,
    /// Per clip: share of episodes that did not fail, newest first in weight. NaN before the first.
    pub survival: Vec<f64>,
}

impl EpisodeStatistics {
    /// Returns empty statistics for a library of so many clips.
    pub fn new(clips: usize) -> Self {
        Self {
            steps: 0,
            terms: [0.0; TERMS.len()],
            joint_error: 0.0,
            causes: [0; Cause::ALL.len()],
            episodes: 0,
            recent: VecDeque::new(),
            survival: vec![f64::NAN; clips],
        }
    }

    /// Forgets the counts; running means stay.
    pub fn start(&mut self) {
        self.steps = 0;
        self.terms = [0.0; TERMS.len()];
        self.joint_error = 0.0;
        self.causes = [0; Cause::ALL.len()];
        self.episodes = 0;
    }

    /// Counts one step of one environment.
    pub fn step(&mut self, episode: &Episode, clip: usize) {
        self.steps += 1;
        self.terms.iter_mut().zip(&episode.terms).for_each(|(sum, x)| *sum += f64::from(*x));
        self.joint_error += f64::from(episode.joint_error);
        if !episode.ended() {
            return;
        }
        self.episodes += 1;
        if self.recent.len() == RECENT {
            self.recent.pop_front();
        }
        self.recent.push_back([episode.episode_return.into(), episode.length as f64]);
        let survived = f64::from(u8::from(episode.failed.is_none()));
        let rate = &mut self.survival[clip];
        *rate = if rate.is_nan() { survived } else { *rate + NEWEST * (survived - *rate) };
        if let Some(cause) = episode.failed {
            self.causes[cause.index()] += 1;
        }
    }

    /// Returns the mean return and mean length (steps) of the last episodes; NaN before the first.
    pub fn recent(&self) -> [f64; 2] {
        let n = self.recent.len() as f64;
        [0, 1].map(|i| self.recent.iter().map(|r| r[i]).sum::<f64>() / n)
    }

    /// Returns the mean survival over the clips that have been seen.
    pub fn mean_survival(&self) -> f64 {
        let seen = || self.survival.iter().filter(|s| !s.is_nan());
        seen().sum::<f64>() / seen().count() as f64
    }

    /// Returns `Train/joint_error_deg`, `Reward/<term>`, the mean per step of each term, and `Termination/<rule>`, the failures by each
    /// rule.
    pub fn metrics(&self) -> impl Iterator<Item = (String, f64)> + '_ {
        let per_step = 1.0 / self.steps.max(1) as f64;
        let rewards = TERMS.iter().zip(self.terms);
        let rewards = rewards.map(move |(term, sum)| (format!("Reward/{}", term.name), sum * per_step));
        let causes = Cause::ALL.iter().zip(self.causes);
        let joints = ("Train/joint_error_deg".to_string(), (self.joint_error * per_step).to_degrees());
        [joints]
            .into_iter()
            .chain(rewards)
            .chain(causes.map(|(cause, count)| (format!("Termination/{}", cause.name()), count as f64)))
    }

    /// Returns what a checkpoint holds between two iterations: the last episodes, and survival by clip.
    pub fn save(&self) -> (Vec<f64>, Vec<f64>) {
        (self.recent.iter().flatten().copied().collect(), self.survival.clone())
    }

    /// Returns the statistics that [`Self::save`] gave.
    pub fn restored(recent: &[f64], survival: Vec<f64>) -> Self {
        let recent = recent.chunks_exact(2).map(|r| [r[0], r[1]]).collect();
        Self { recent, survival, ..Self::new(0) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn means_are_over_the_last_hundred_and_survival_moves_slowly() {
        let mut statistics = EpisodeStatistics::new(2);
        let mut episode = Episode { episode_return: 2.0, length: 10, truncated: true, ..Episode::new(0) };
        for _ in 0..100 {
            statistics.step(&episode, 0);
        }
        episode = Episode { episode_return: 4.0, length: 20, truncated: false, failed: Some(Cause::Tilt), ..episode };
        for _ in 0..50 {
            statistics.step(&episode, 1);
        }
        statistics.step(&episode, 0);
        assert_eq!(statistics.recent(), [(49.0 * 2.0 + 51.0 * 4.0) / 100.0, (49.0 * 10.0 + 51.0 * 20.0) / 100.0]);
        assert_eq!((statistics.survival[0], statistics.survival[1]), (0.95, 0.0));
        assert_eq!((statistics.episodes, statistics.causes[2], statistics.steps), (151, 51, 151));
        episode.joint_error = 0.5;
        statistics.start();
        statistics.step(&Episode { joint_error: 0.25, failed: None, ..episode.clone() }, 0);
        statistics.step(&Episode { failed: None, ..episode.clone() }, 0);
        let joints = statistics.metrics().next();
        assert_eq!(joints, Some(("Train/joint_error_deg".into(), 0.375_f64.to_degrees())));
        (statistics.steps, statistics.joint_error) = (151, 0.0);
        let (recent, survival) = statistics.save();
        let mut back = EpisodeStatistics::restored(&recent, survival);
        back.steps = 151;
        assert_eq!((back.recent(), &back.survival), (statistics.recent(), &statistics.survival));
    }
}
