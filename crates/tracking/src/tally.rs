//! What happened in the environments since the last look.

use std::collections::VecDeque;

use super::episode::Episode;
use super::errors::Cause;
use super::rewards::TERMS;

/// Episodes that the running means are taken over.
const RECENT: usize = 100;
/// Share of the newest episode in a clip's survival rate.
const NEWEST: f64 = 0.05;

/// Counts and means for the metrics.
#[derive(Debug, Clone, PartialEq)]
pub struct Tally {
    /// Environment steps since the last [`Self::start`].
    pub steps: u64,
    /// Sum of each reward term since then.
    pub terms: [f64; TERMS.len()],
    /// Failures by cause since then.
    pub causes: [u64; Cause::ALL.len()],
    /// Episodes that ended since then.
    pub episodes: u64,
    /// Sum of rewards and length of the last episodes.
    recent: VecDeque<[f64; 2]>,
    /// Per clip: share of episodes that did not fail, newest first in weight. NaN before the first.
    pub survival: Vec<f64>,
}

impl Tally {
    /// For a library of so many clips.
    pub fn new(clips: usize) -> Self {
        Self {
            steps: 0,
            terms: [0.0; TERMS.len()],
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
        self.causes = [0; Cause::ALL.len()];
        self.episodes = 0;
    }

    /// One step of one environment.
    pub fn step(&mut self, episode: &Episode, clip: usize) {
        self.steps += 1;
        self.terms.iter_mut().zip(&episode.terms).for_each(|(sum, x)| *sum += f64::from(*x));
        if !episode.ended() {
            return;
        }
        self.episodes += 1;
        if self.recent.len() == RECENT {
            self.recent.pop_front();
        }
        self.recent.push_back([episode.gain.into(), episode.length as f64]);
        let survived = f64::from(u8::from(episode.failed.is_none()));
        let rate = &mut self.survival[clip];
        *rate = if rate.is_nan() { survived } else { *rate + NEWEST * (survived - *rate) };
        if let Some(at) = episode.failed.and_then(|cause| Cause::ALL.iter().position(|c| *c == cause)) {
            self.causes[at] += 1;
        }
    }

    /// Mean sum of rewards and mean length (steps) of the last episodes; NaN before the first.
    pub fn recent(&self) -> [f64; 2] {
        let n = self.recent.len() as f64;
        [0, 1].map(|i| self.recent.iter().map(|r| r[i]).sum::<f64>() / n)
    }

    /// Mean survival over the clips that have been seen.
    pub fn mean_survival(&self) -> f64 {
        let seen = || self.survival.iter().filter(|s| !s.is_nan());
        seen().sum::<f64>() / seen().count() as f64
    }

    /// What a checkpoint holds between two iterations.
    pub fn save(&self) -> (Vec<f64>, Vec<f64>) {
        (self.recent.iter().flatten().copied().collect(), self.survival.clone())
    }

    /// Back from [`Self::save`].
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
        let mut tally = Tally::new(2);
        let mut episode = Episode { gain: 2.0, length: 10, cut: true, ..Episode::new(0) };
        for _ in 0..100 {
            tally.step(&episode, 0);
        }
        episode = Episode { gain: 4.0, length: 20, cut: false, failed: Some(Cause::Tilt), ..episode };
        for _ in 0..50 {
            tally.step(&episode, 1);
        }
        tally.step(&episode, 0);
        assert_eq!(tally.recent(), [(49.0 * 2.0 + 51.0 * 4.0) / 100.0, (49.0 * 10.0 + 51.0 * 20.0) / 100.0]);
        assert_eq!((tally.survival[0], tally.survival[1]), (0.95, 0.0));
        assert_eq!((tally.episodes, tally.causes[2], tally.steps), (151, 51, 151));
        let (recent, survival) = tally.save();
        let mut back = Tally::restored(&recent, survival);
        back.steps = 151;
        assert_eq!((back.recent(), &back.survival), (tally.recent(), &tally.survival));
    }
}
