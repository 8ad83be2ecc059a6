//! Captioned motion in the network's numbers.

use lifelike_language::Split;
use lifelike_robot::Robot;
use rayon::prelude::*;
use sha2::{Digest, Sha256};

use super::GeneratorPlan;
use crate::GenerationError;
use crate::data::CaptionedMotion;
use crate::generator::Generator;
use crate::representation::{FeatureMatrix, RepresentationSpec, Standardizer};
use crate::space::{MotionSpace, SpaceKind};
use crate::text::duration::Durations;
use crate::text::pieces::WordPieces;

/// One motion in the network's numbers.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Sample {
    /// Standardized, `[tokens, width]`.
    pub(super) tokens: Vec<f32>,
    /// Rows that the tokens stand for.
    pub(super) rows: usize,
    pub(super) captions: Vec<Vec<u32>>,
}

/// Everything that a training reads.
#[derive(Debug, Clone)]
pub struct TrainingData {
    pub(crate) space: MotionSpace,
    pub(crate) standardizer: Standardizer,
    pub(crate) pieces: WordPieces,
    /// Every caption trained on, once.
    pub(crate) captions: Vec<String>,
    pub(crate) licences: Vec<String>,
    /// Durations by words.
    pub(crate) durations: Durations,
    /// Median duration of the motion trained on (s).
    pub(crate) median_seconds: f64,
    /// 1 / variance of the differences of neighbouring tokens, for each number of a token that they count of; empty where
    /// tokens hold velocities.
    pub(super) rate_scales: Vec<f32>,
    pub(super) training: Vec<Sample>,
    pub(super) validation: Vec<Sample>,
    digest: String,
}

impl TrainingData {
    /// Returns motions in the numbers of a plan's network; statistics and word pieces are those of what is trained on.
    ///
    /// # Errors
    /// Motion that does not fit the robot, captions that are no sentences.
    pub fn new(plan: &GeneratorPlan, robot: &Robot, motions: &[CaptionedMotion]) -> Result<Self, GenerationError> {
        let space = MotionSpace::new(RepresentationSpec::of(&robot.layout), plan.space);
        let of = || motions.iter().filter(|motion| motion.split == Split::Train);
        let encode = |motion: &CaptionedMotion| FeatureMatrix::new(space.encode(&motion.rows)?, space.width());
        let tokens = of().collect::<Vec<_>>().into_par_iter().map(encode).collect::<Result<Vec<_>, _>>()?;
        let standardizer = Standardizer::of(&tokens, Standardizer::FLOOR)?;
        let captions = of().flat_map(|motion| &motion.captions).map(String::as_str);
        let pieces = WordPieces::learn(captions, plan.pieces)?;
        Self::with(space, standardizer, pieces, motions)
    }

    /// Returns motions in the numbers of a trained generator, with its statistics and word pieces.
    ///
    /// # Errors
    /// As [`Self::new`], and another robot than the generator's.
    pub fn of_generator(
        generator: &Generator,
        robot: &Robot,
        motions: &[CaptionedMotion],
    ) -> Result<Self, GenerationError> {
        generator.check_robot(robot)?;
        let pieces = generator.header().pieces.clone();
        Self::with(generator.space(), generator.standardizer().clone(), pieces, motions)
    }

    fn with(
        space: MotionSpace,
        standardizer: Standardizer,
        pieces: WordPieces,
        motions: &[CaptionedMotion],
    ) -> Result<Self, GenerationError> {
        let of = |split: Split| motions.iter().filter(move |motion| motion.split == split);
        let mut captions: Vec<String> = of(Split::Train).flat_map(|motion| motion.captions.clone()).collect();
        captions.sort();
        captions.dedup();
        let sample = |motion: &CaptionedMotion| -> Result<Sample, GenerationError> {
            let mut tokens = space.encode(&motion.rows)?;
            standardizer.standardize(&mut tokens);
            let captions = motion.captions.iter().map(|text| pieces.encode(text)).collect::<Result<_, _>>()?;
            Ok(Sample { tokens, rows: motion.rows.n, captions })
        };
        let samples = |split| {
            let motions: Vec<_> = of(split).collect();
            motions.into_par_iter().map(sample).collect::<Result<Vec<_>, _>>()
        };
        let (training, validation) = (samples(Split::Train)?, samples(Split::Validation)?);
        let rate_scales = rate_scales(&space, &training);
        let mut seconds: Vec<f64> = of(Split::Train).map(|m| (m.rows.n - 1) as f64 / space.spec().fps).collect();
        seconds.sort_by(f64::total_cmp);
        let durations = Durations::learn(of(Split::Train).flat_map(|motion| {
            let seconds = (motion.rows.n - 1) as f64 / space.spec().fps;
            motion.captions.iter().map(move |caption| (caption.as_str(), seconds))
        }));
        let mut licences: Vec<String> = of(Split::Train).map(|m| m.licence.trim().to_string()).collect();
        licences.sort();
        licences.dedup();
        licences.retain(|licence| !licence.is_empty());
        let mut hash = Sha256::new();
        for sample in training.iter().chain(&validation) {
            sample.tokens.iter().for_each(|x| hash.update(x.to_le_bytes()));
            sample.captions.iter().flatten().for_each(|id| hash.update(id.to_le_bytes()));
        }
        let digest = hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect();
        let median_seconds = seconds.get(seconds.len() / 2).copied().unwrap_or(0.0);
        Ok(Self {
            space,
            standardizer,
            pieces,
            captions,
            licences,
            durations,
            median_seconds,
            rate_scales,
            training,
            validation,
            digest,
        })
    }

    /// Returns counts in a line, with the digest of all numbers.
    pub fn describe(&self) -> String {
        let (training, validation) = (self.training.len(), self.validation.len());
        format!("{training} motions, {validation} for validation, SHA-256 {}", self.digest)
    }
}

/// Returns [`TrainingData::rate_scales`]: of joints only, as the root's numbers are velocities.
fn rate_scales(space: &MotionSpace, samples: &[Sample]) -> Vec<f32> {
    let width = space.width();
    let joints = match space.kind() {
        SpaceKind::Frames => return Vec::new(),
        SpaceKind::Spline { .. } => 7..width,
    };
    let mut sums = vec![0.0_f64; width];
    let mut count = 0.0_f64;
    for sample in samples {
        let tokens: Vec<&[f32]> = sample.tokens.chunks_exact(width).collect();
        for pair in tokens.windows(2) {
            sums.iter_mut().zip(pair[0].iter().zip(pair[1])).for_each(|(sum, (a, b))| *sum += f64::from(b - a).powi(2));
            count += 1.0;
        }
    }
    // A joint that never moves has no velocity to be wrong about.
    let scale = |i: usize| if joints.contains(&i) && sums[i] > 1e-6 * count { (count / sums[i]) as f32 } else { 0.0 };
    (0..width).map(scale).collect()
}
