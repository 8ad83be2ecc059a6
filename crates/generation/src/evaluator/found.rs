//! How well an evaluator tells motions it has not learned from apart: the upper bound of any method's scores.

use lifelike_checkpoint::rng::stream;

use super::data::{CaptionedMotion, caption_kinds};
use super::file::Evaluator;
use crate::GenerationError;
use crate::metrics::{DIVERSITY_PAIRS, Interval, POOL, Retrieval, TOP, diversity, pools};
use crate::representation::FeatureMatrix;

/// Scores of real motions under their own sentences.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct RealScores {
    /// R-precision, top 1 to top 3.
    pub r_precision: [Interval; TOP],
    /// MM-dist.
    pub mm_dist: Interval,
    /// Diversity.
    pub diversity: Interval,
    /// Motions measured.
    pub motions: usize,
    /// Size of a pool: [`POOL`], or the number of different sentences where that is smaller.
    pub pool: usize,
}

impl Evaluator {
    /// Measures motions under their first sentences, `repetitions` times with other pools; none where there are fewer
    /// than two different sentences.
    ///
    /// # Errors
    /// A motion or sentence that does not fit.
    pub fn scores(
        &self,
        items: &[CaptionedMotion],
        repetitions: u64,
        seed: u64,
    ) -> Result<Option<RealScores>, GenerationError> {
        let captions: Vec<&str> = items.iter().filter_map(|item| item.captions.first()).map(String::as_str).collect();
        let kinds = caption_kinds(captions.iter().copied());
        let different = kinds.iter().max().map_or(0, |last| last + 1);
        if different < 2 {
            return Ok(None);
        }
        let pool = POOL.min(different);
        let motions: Vec<FeatureMatrix> = items.iter().map(|item| item.motion.clone()).collect();
        let (text, motion) = (self.sentences(&captions)?, self.motions(&motions)?);
        let mut found: Vec<Retrieval> = Vec::new();
        let mut apart = Vec::new();
        for repetition in 0..repetitions.max(1) {
            let pools = pools(&kinds, pool, &mut stream(seed, "evaluator.pools", 0, repetition));
            found.push(Retrieval::of(&text, &motion, &pools)?);
            let mut rng = stream(seed, "evaluator.diversity", 0, repetition);
            apart.push(diversity(&motion, DIVERSITY_PAIRS, &mut rng)?);
        }
        let interval = |of: &dyn Fn(&Retrieval) -> f64| Interval::of(&found.iter().map(of).collect::<Vec<_>>());
        Ok(Some(RealScores {
            r_precision: std::array::from_fn(|k| interval(&|r: &Retrieval| r.precision[k])),
            mm_dist: interval(&|r: &Retrieval| r.distance),
            diversity: Interval::of(&apart),
            motions: items.len(),
            pool,
        }))
    }
}
