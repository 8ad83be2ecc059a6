//! Episodes of one length that go from clip to clip (thesis 5.3.3: "If the selected motion ends \[...\] a new motion is
//! sampled").

use lifelike_checkpoint::rng::stream;
use lifelike_robot::ReferenceLibrary;
use rand::Rng;

use super::episode::{Episode, ReferenceSegment};

/// Episodes of exactly [`EvaluationOptions::seconds`](super::EvaluationOptions::seconds), in place of those that end with
/// their clip.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Chain {
    /// Number of episodes.
    pub episodes: usize,
    /// Key of clips and starts.
    pub seed: u64,
}

impl Chain {
    /// Returns the episodes, sorted by the frame that they begin at: any frame but the last of any clip.
    pub(super) fn episodes(self, library: &ReferenceLibrary, frames: usize) -> Vec<Episode> {
        let start = |number: usize| {
            let mut rng = stream(self.seed, "evaluation chain start", number as u64, 0);
            let range = library.range(rng.random_range(0..library.clips().max(1)));
            range.start + rng.random_range(0..range.len().saturating_sub(1).max(1))
        };
        let mut starts: Vec<usize> = (0..if library.clips() == 0 { 0 } else { self.episodes }).map(start).collect();
        starts.sort_unstable();
        let episode = |(number, frame)| Episode { number, frame, planned: frames + 1 };
        starts.into_iter().enumerate().map(episode).collect()
    }

    /// Returns where an episode of `frames` steps goes on: at the end of each clip, at the beginning of another one.
    pub(super) fn segments(
        self,
        library: &ReferenceLibrary,
        episode: &Episode,
        frames: usize,
    ) -> Vec<ReferenceSegment> {
        let mut rng = stream(self.seed, "evaluation chain", episode.number as u64, 0);
        let (mut step, mut frame) = (1, episode.frame);
        let mut all = Vec::new();
        while step <= frames {
            all.push(ReferenceSegment { step, frame });
            // The last frame of a clip has none to reach: it is not asked for.
            let left = library.range(library.clip_of(frame)).end - frame;
            step += left.saturating_sub(2).max(1);
            frame = library.range(rng.random_range(0..library.clips())).start;
        }
        all
    }
}
