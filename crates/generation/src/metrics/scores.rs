//! All metrics of one method, over several repetitions.

use lifelike_checkpoint::rng::stream;

use super::embeddings::Embeddings;
use super::frechet::{Gaussian, frechet_distance};
use super::interval::Interval;
use super::retrieval::{POOL, Retrieval, TOP, pools};
use super::variety::{DIVERSITY_PAIRS, MULTIMODALITY_PAIRS, diversity, multimodality};
use crate::{FromInput, GenerationError};

/// Motions of one repetition with their sentences; row i of text and motion belongs together.
#[derive(Debug, Clone, PartialEq)]
pub struct Sample {
    /// Embeddings of the sentences, `[n, width]`.
    pub text: Embeddings,
    /// Embeddings of the motions, `[n, width]`.
    pub motion: Embeddings,
    /// The same number for sentences of the same words ([`crate::evaluator::caption_kinds`]), `[n]`.
    pub kinds: Vec<usize>,
    /// Several motions of each of some sentences, `[sentences * each, width]`, and how many of each.
    pub repeated: Option<(Embeddings, usize)>,
}

/// Scores of a method, with 95% intervals over the repetitions.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Scores {
    /// R-precision, top 1 to top 3; higher is better.
    pub r_precision: [Interval; TOP],
    /// Fréchet distance to the reference, where there is one; lower is better.
    pub fid: Option<Interval>,
    /// MM-dist; lower is better.
    pub mm_dist: Interval,
    /// Diversity; nearer to the data's is better.
    pub diversity: Interval,
    /// Multimodality, where motions were repeated; higher is better.
    pub multimodality: Option<Interval>,
    /// Motions of a repetition.
    pub motions: usize,
    /// Size of a pool: [`POOL`], or the number of different sentences where that is smaller.
    pub pool: usize,
}

/// Names of [`Scores::cells`].
pub const HEAD: [&str; 7] = ["R-precision 1", "2", "3", "FID", "MM-dist", "diversity", "multimodality"];

impl Scores {
    /// Measures `repetitions` samples (Guo et al. take 20), each drawn by `sample`; none where sentences are all the
    /// same. Pools and pairs are addressed by seed and repetition, so methods of one seed meet the same ones.
    ///
    /// # Errors
    /// As `sample`; [`GenerationError::Input`] for embeddings that do not fit each other or the reference.
    pub fn of(
        reference: Option<&Gaussian>,
        repetitions: u64,
        seed: u64,
        mut sample: impl FnMut(u64) -> Result<Sample, GenerationError>,
    ) -> Result<Option<Self>, GenerationError> {
        let mut found: Vec<Retrieval> = Vec::new();
        let (mut fid, mut apart, mut modes, mut motions, mut pool) = (Vec::new(), Vec::new(), Vec::new(), 0, 0);
        for repetition in 0..repetitions.max(1) {
            let now = sample(repetition)?;
            if now.kinds.len() != now.text.len() {
                return Err(GenerationError::mismatch("kinds of sentences", now.text.len(), now.kinds.len()));
            }
            let different = now.kinds.iter().collect::<std::collections::BTreeSet<_>>().len();
            if different < 2 {
                return Ok(None);
            }
            let rng = |purpose: &str| stream(seed, purpose, 0, repetition);
            (motions, pool) = (now.motion.len(), POOL.min(different));
            let pools = pools(&now.kinds, pool, &mut rng("metrics.pools"));
            found.push(Retrieval::of(&now.text, &now.motion, &pools)?);
            apart.push(diversity(&now.motion, DIVERSITY_PAIRS, &mut rng("metrics.diversity"))?);
            if let Some(reference) = reference {
                fid.push(frechet_distance(reference, &Gaussian::of(&now.motion)?)?);
            }
            if let Some((repeated, each)) = &now.repeated {
                let mut rng = rng("metrics.multimodality");
                modes.push(multimodality(repeated, *each, MULTIMODALITY_PAIRS, &mut rng)?);
            }
        }
        let interval = |of: &dyn Fn(&Retrieval) -> f64| Interval::of(&found.iter().map(of).collect::<Vec<_>>());
        let some = |values: &[f64]| (!values.is_empty()).then(|| Interval::of(values));
        Ok(Some(Self {
            r_precision: std::array::from_fn(|k| interval(&|r: &Retrieval| r.precision[k])),
            fid: some(&fid),
            mm_dist: interval(&|r: &Retrieval| r.distance),
            diversity: Interval::of(&apart),
            multimodality: some(&modes),
            motions,
            pool,
        }))
    }

    /// Returns a table's row under [`HEAD`].
    pub fn cells(&self) -> [String; HEAD.len()] {
        let [one, two, three] = self.r_precision.map(|interval| interval.to_string());
        let some = |interval: Option<Interval>| interval.map_or_else(|| "-".to_owned(), |i| i.to_string());
        [
            one,
            two,
            three,
            some(self.fid),
            self.mm_dist.to_string(),
            self.diversity.to_string(),
            some(self.multimodality),
        ]
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn motions_that_are_their_sentences_are_perfect() {
        let apart = Embeddings::new((0..128).map(|i| (i * i % 97) as f32).collect(), 2).unwrap();
        let sample = Sample {
            text: apart.clone(),
            motion: apart.clone(),
            kinds: (0..64).collect(),
            repeated: Some((apart.clone(), 4)),
        };
        let reference = Gaussian::of(&apart).unwrap();
        let scores = Scores::of(Some(&reference), 3, 1, |_| Ok(sample.clone())).unwrap().unwrap();
        assert_eq!(scores.r_precision.map(|i| i.mean), [1.0; TOP]);
        assert!(scores.mm_dist.mean == 0.0 && scores.fid.unwrap().mean < 1e-9 && scores.diversity.half_width > 0.0);
        assert_eq!((scores.motions, scores.pool, scores.cells().len()), (64, POOL, HEAD.len()));
        let without = Sample { repeated: None, ..sample.clone() };
        let scores = Scores::of(None, 1, 1, |_| Ok(without.clone())).unwrap().unwrap();
        assert!(scores.fid.is_none() && scores.multimodality.is_none() && scores.cells()[3] == "-");
        let same = Sample { kinds: vec![0; 64], ..sample.clone() };
        assert!(Scores::of(None, 1, 1, |_| Ok(same.clone())).unwrap().is_none());
        let short = Sample { kinds: vec![0; 63], ..sample };
        assert!(Scores::of(None, 1, 1, |_| Ok(short.clone())).unwrap_err().to_string().contains("expected 64, got 63"));
    }
}
