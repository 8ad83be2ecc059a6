//! Reference-state initialization (Peng et al. 2018): episodes begin in states of the reference, drawn uniformly over all
//! frames or more often before the frames at which the policy fails.

use rand::Rng;
use rand_chacha::ChaCha8Rng;

/// Settings of reference-state initialization.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct RsiSpec {
    /// Share of beginnings drawn by failure rate; the rest is uniform over all frames.
    ///
    /// 0.7 helped a hard clip and hurt an easy one.
    #[schemars(extend("unit" = "1"), range(min = 0.0, max = 1.0))]
    pub failure_share: f64,
    /// Smallest failure rate that counts, so that no segment is forgotten.
    #[schemars(extend("unit" = "1"), range(min = 0.0, max = 1.0))]
    pub floor: f64,
    /// Weight of past iterations in the failure statistics.
    #[schemars(extend("unit" = "1"), range(min = 0.0, max = 1.0))]
    pub memory: f64,
    /// Noise on joint positions, standard deviation (rad).
    #[schemars(extend("unit" = "rad"), range(min = 0.0, max = 10.0))]
    pub joint_noise: f32,
    /// Noise on the root's velocities, standard deviation (m/s, rad/s).
    #[schemars(extend("unit" = "m/s, rad/s"), range(min = 0.0, max = 10.0))]
    pub velocity_noise: f32,
    /// Offset from the reference on the ground, standard deviation on both axes (m).
    #[schemars(extend("unit" = "m"), range(min = 0.0, max = 10.0))]
    pub path_noise: f32,
    /// Heading offset from the reference, standard deviation (rad).
    #[schemars(extend("unit" = "rad"), range(min = 0.0, max = 10.0))]
    pub heading_noise: f32,
    /// Share of episodes that begin in the state of another frame than the one followed (thesis Algorithm 1, line 5).
    #[schemars(extend("unit" = "1"), range(min = 0.0, max = 1.0))]
    pub random_start_share: f64,
    /// Share of episodes that begin at rest on the ground, for learning to get up.
    ///
    /// The state is between the followed frame and one in any orientation, with joints anywhere in their ranges.
    #[schemars(extend("unit" = "1"), range(min = 0.0, max = 1.0))]
    pub fallen_share: f64,
}

impl Default for RsiSpec {
    fn default() -> Self {
        Self {
            failure_share: 0.3,
            floor: 0.02,
            memory: 0.98,
            joint_noise: 0.03,
            velocity_noise: 0.09,
            path_noise: 0.03,
            heading_noise: 0.05,
            random_start_share: 0.0,
            fallen_share: 0.0,
        }
    }
}

/// Failure statistics over segments of half a second, and the draw.
#[derive(Debug, Clone, PartialEq)]
pub struct RsiSampler {
    spec: RsiSpec,
    bin_frames: usize,
    /// First frame and number of allowed start frames of each bin, clip after clip.
    bins: Vec<Bin>,
    /// First bin of each clip, and the number of bins at the end.
    first: Vec<usize>,
    clip_starts: Vec<usize>,
    visits: Vec<f64>,
    failures: Vec<f64>,
    cumulative: Vec<f64>,
    /// True for bins that an episode ever went through.
    seen: Vec<bool>,
}

/// Share of the motion that was ever seen.
#[derive(Debug, Clone, PartialEq)]
pub struct Coverage {
    /// Share of each clip's segments of half a second that some episode went through.
    pub clips: Vec<f64>,
    /// The same of all segments.
    pub overall: f64,
}

#[derive(Debug, Clone, Copy, PartialEq)]
struct Bin {
    start: usize,
    allowed: usize,
}

impl RsiSampler {
    /// Returns a sampler for clips that begin at `clip_starts` (and end where the next begins). No episode starts in the last
    /// `tail_frames` of a clip, as far as the clip is longer.
    pub fn new(spec: RsiSpec, clip_starts: &[usize], bin_frames: usize, tail_frames: usize) -> Self {
        let bin_frames = bin_frames.max(1);
        let (mut bins, mut first) = (Vec::new(), vec![0]);
        for pair in clip_starts.windows(2) {
            let (start, end) = (pair[0], pair[1]);
            let last_allowed = end.saturating_sub(tail_frames).max(start + 1);
            for bin in (start..end).step_by(bin_frames) {
                let allowed = last_allowed.min(bin + bin_frames).saturating_sub(bin);
                bins.push(Bin { start: bin, allowed });
            }
            first.push(bins.len());
        }
        let n = bins.len();
        let clip_starts = clip_starts.to_vec();
        let mut sampler = Self {
            spec,
            bin_frames,
            bins,
            first,
            clip_starts,
            visits: vec![0.0; n],
            failures: vec![0.0; n],
            cumulative: Vec::new(),
            seen: vec![false; n],
        };
        sampler.refresh();
        sampler
    }

    /// Returns a sampler of the frames of these clips alone, one flag per clip; none where no frame is left.
    pub fn only(&self, clips: &[bool]) -> Option<Self> {
        let mut own = self.clone();
        for (bins, _) in self.first.windows(2).zip(clips).filter(|(_, kept)| !**kept) {
            own.bins[bins[0]..bins[1]].iter_mut().for_each(|bin| bin.allowed = 0);
        }
        own.refresh();
        own.bins.iter().any(|bin| bin.allowed > 0).then_some(own)
    }

    fn bin_of(&self, frame: usize) -> usize {
        let clip = self.clip_starts.partition_point(|s| *s <= frame).saturating_sub(1).min(self.first.len() - 2);
        (self.first[clip] + (frame - self.clip_starts[clip]) / self.bin_frames).min(self.first[clip + 1] - 1)
    }

    /// Counts an episode that ran over the frames `from..=to` of one clip, and failed at `to` or did not.
    pub fn record(&mut self, from: usize, to: usize, failed: bool) {
        let (a, b) = (self.bin_of(from), self.bin_of(to));
        for bin in a..=b.max(a) {
            self.visits[bin] += 1.0;
            self.seen[bin] = true;
        }
        if failed {
            self.failures[b] += 1.0;
        }
    }

    /// Puts the new statistics into force and lets the old ones fade; to be called once per iteration.
    pub fn refresh(&mut self) {
        self.visits.iter_mut().chain(&mut self.failures).for_each(|x| *x *= self.spec.memory);
        let rate = |bin: usize| {
            let rate = if self.visits[bin] > 0.5 { self.failures[bin] / self.visits[bin] } else { 0.0 };
            rate.max(self.spec.floor)
        };
        // A failure in a bin often begins in the one before it: half of the next bin's rate counts here.
        let mut hard = vec![0.0; self.bins.len()];
        for clip in self.first.windows(2) {
            for bin in clip[0]..clip[1] {
                let next = if bin + 1 < clip[1] { rate(bin + 1) } else { 0.0 };
                hard[bin] = self.bins[bin].allowed as f64 * (rate(bin) + 0.5 * next);
            }
        }
        let total_hard: f64 = hard.iter().sum();
        let total: f64 = self.bins.iter().map(|b| b.allowed as f64).sum();
        let share = if total_hard > 0.0 { self.spec.failure_share } else { 0.0 };
        let mut sum = 0.0;
        self.cumulative = self
            .bins
            .iter()
            .zip(&hard)
            .map(|(bin, hard)| {
                sum += (1.0 - share) * bin.allowed as f64 / total + share * hard / total_hard.max(1e-300);
                sum
            })
            .collect();
    }

    /// Draws a frame to begin at.
    pub fn draw(&self, rng: &mut ChaCha8Rng) -> usize {
        let total = self.cumulative.last().copied().unwrap_or(0.0);
        let at = rng.random::<f64>() * total;
        let bin = self.cumulative.partition_point(|c| *c <= at).min(self.bins.len() - 1);
        let Bin { start, allowed } = self.bins[bin];
        start + rng.random_range(0..allowed.max(1))
    }

    /// Returns the share of the motion that was ever seen.
    pub fn coverage(&self) -> Coverage {
        let share = |bins: &[bool]| bins.iter().filter(|s| **s).count() as f64 / bins.len().max(1) as f64;
        let clips = self.first.windows(2).map(|clip| share(&self.seen[clip[0]..clip[1]])).collect();
        Coverage { clips, overall: share(&self.seen) }
    }

    /// Returns the smallest ratio of the probability with which a frame is drawn to that of drawing all alike: the floor
    /// below which no segment is neglected, `1 − failure_share` at least.
    pub fn floor(&self) -> f64 {
        let total: f64 = self.bins.iter().map(|b| b.allowed as f64).sum();
        let sum = self.cumulative.last().copied().unwrap_or(1.0);
        let before = [0.0].into_iter().chain(self.cumulative.iter().copied());
        let shares = self.bins.iter().zip(self.cumulative.iter().zip(before)).filter(|(bin, _)| bin.allowed > 0);
        shares.map(|(bin, (to, from))| (to - from) / sum * total / bin.allowed as f64).fold(f64::INFINITY, f64::min)
    }

    /// Returns the statistics for a checkpoint: visits, failures, draws and whether it was ever seen, of every bin.
    pub fn save(&self) -> Vec<f64> {
        let seen = self.seen.iter().map(|s| f64::from(u8::from(*s)));
        let pairs = self.visits.iter().zip(&self.failures).flat_map(|(v, f)| [*v, *f]);
        pairs.chain(self.cumulative.iter().copied()).chain(seen).collect()
    }

    /// Returns the sampler with saved statistics; `None` when they are of another library.
    #[must_use]
    pub fn restored(mut self, saved: &[f64]) -> Option<Self> {
        let n = self.bins.len();
        if saved.len() != 4 * n {
            return None;
        }
        for (i, pair) in saved[..2 * n].chunks_exact(2).enumerate() {
            self.visits[i] = pair[0];
            self.failures[i] = pair[1];
        }
        self.cumulative.copy_from_slice(&saved[2 * n..3 * n]);
        self.seen = saved[3 * n..].iter().map(|s| *s > 0.5).collect();
        Some(self)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use lifelike_checkpoint::rng::stream;

    fn histogram(sampler: &RsiSampler, frames: usize) -> Vec<usize> {
        let mut rng = stream(1, "test", 0, 0);
        let mut counts = vec![0; frames];
        for _ in 0..40_000 {
            counts[sampler.draw(&mut rng)] += 1;
        }
        counts
    }

    #[test]
    fn without_failures_all_allowed_frames_are_alike_and_tails_are_left_out() {
        let counts = histogram(&RsiSampler::new(RsiSpec::default(), &[0, 100, 140], 25, 20), 140);
        assert!(counts[80..100].iter().all(|c| *c == 0) && counts[120..].iter().all(|c| *c == 0));
        // 100 allowed frames, 400 expected in each; five standard deviations.
        let allowed = counts[..80].iter().chain(&counts[100..120]);
        assert!(allowed.clone().count() == 100 && allowed.clone().all(|c| c.abs_diff(400) < 100), "{counts:?}");
    }

    #[test]
    fn a_sampler_of_some_clips_draws_no_frame_of_the_others() {
        let all = RsiSampler::new(RsiSpec { failure_share: 0.0, ..RsiSpec::default() }, &[0, 100, 140, 200], 25, 0);
        let counts = histogram(&all.only(&[false, true, false]).unwrap(), 200);
        assert_eq!(counts[100..140].iter().sum::<usize>(), 40_000);
        // 40 frames, 1000 expected in each; five standard deviations.
        assert!(counts[100..140].iter().all(|c| c.abs_diff(1000) < 160), "{counts:?}");
        assert!(all.only(&[false; 3]).is_none());
    }

    #[test]
    fn a_clip_shorter_than_the_tail_is_begun_at_its_start() {
        let counts = histogram(&RsiSampler::new(RsiSpec::default(), &[0, 10], 25, 50), 10);
        assert_eq!(counts[0], 40_000);
    }

    #[test]
    fn failures_draw_beginnings_near_them_and_the_rest_keeps_its_share() {
        let spec = RsiSpec { failure_share: 0.5, floor: 0.0, memory: 1.0, ..RsiSpec::default() };
        let mut sampler = RsiSampler::new(spec, &[0, 100], 25, 0);
        for _ in 0..10 {
            sampler.record(0, 60, true);
            sampler.record(60, 99, false);
        }
        sampler.refresh();
        let counts = histogram(&sampler, 100);
        let share = |r: std::ops::Range<usize>| counts[r].iter().sum::<usize>() as f64 / 40_000.0;
        // Bin 2 (50..75) failed in 10 of its 20 visits: rate ½; bin 1 leads to it with half of that. Of the failure half
        // of the draws they get 2/3 and 1/3, besides a quarter each of the uniform half.
        assert!((share(50..75) - (0.125 + 0.5 * 2.0 / 3.0)).abs() < 0.02, "{}", share(50..75));
        assert!((share(25..50) - (0.125 + 0.5 / 3.0)).abs() < 0.02, "{}", share(25..50));
        assert!((share(0..25) - 0.125).abs() < 0.02);
    }

    #[test]
    fn coverage_and_floor_by_hand() {
        let spec = RsiSpec { failure_share: 0.4, floor: 0.0, memory: 1.0, ..RsiSpec::default() };
        let mut sampler = RsiSampler::new(spec, &[0, 100, 140], 25, 0);
        assert_eq!(sampler.coverage().overall, 0.0);
        assert!((sampler.floor() - 1.0).abs() < 1e-12, "without failures all are alike");
        sampler.record(30, 60, true);
        // Bins 1 and 2 of the first clip's four; of the second clip's two none.
        assert_eq!(sampler.coverage(), Coverage { clips: vec![0.5, 0.0], overall: 2.0 / 6.0 });
        sampler.refresh();
        assert!((sampler.floor() - 0.6).abs() < 1e-12, "who never fails keeps the uniform share");
    }

    #[test]
    fn saved_statistics_come_back_and_foreign_ones_are_refused() {
        let fresh = || RsiSampler::new(RsiSpec::default(), &[0, 100, 140], 25, 20);
        let mut sampler = fresh();
        sampler.record(3, 40, true);
        sampler.refresh();
        sampler.record(100, 130, true);
        let back = fresh().restored(&sampler.save()).unwrap();
        assert_eq!(back, sampler);
        assert!(RsiSampler::new(RsiSpec::default(), &[0, 100], 25, 20).restored(&sampler.save()).is_none());
    }
}
