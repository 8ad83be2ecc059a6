//! A reference that jumps from clip to clip (thesis 4.3.3, "Reactivity").

use lifelike_checkpoint::rng::stream;
use rand::Rng;

use crate::{Episode, ReferenceSegment};
use lifelike_robot::ReferenceLibrary;

/// Draws the places at which an episode of `frames` frames goes on every `every` frames: a random frame of a random
/// clip that then lasts for so long. Clips too short for that are left out; where all are, the longest is used, and
/// switches come sooner.
pub(super) fn segments(
    library: &ReferenceLibrary,
    episode: &Episode,
    frames: usize,
    every: usize,
    seed: u64,
) -> Vec<ReferenceSegment> {
    let mut rng = stream(seed, "robustness switch", episode.number as u64, 0);
    // The last frame of a clip is never asked for: the environment ends an episode there.
    let enough: Vec<usize> = (0..library.clips()).filter(|clip| library.range(*clip).len() >= every + 2).collect();
    let longest = (0..library.clips()).max_by_key(|clip| library.range(*clip).len());
    let clips = if enough.is_empty() { longest.into_iter().collect() } else { enough };
    let mut all = Vec::new();
    let (mut step, every) = (1, every.max(1));
    while step < frames && !clips.is_empty() {
        let range = library.range(clips[rng.random_range(0..clips.len())]);
        let room = range.len().saturating_sub(every + 2);
        let frame = range.start + rng.random_range(0..=room);
        all.push(ReferenceSegment { step, frame });
        step += every.min(range.len().saturating_sub(2)).max(1);
    }
    all
}
