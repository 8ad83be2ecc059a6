//! Training of an evaluator: the whole algorithm in [`EvaluatorTrainer::step`].

use lifelike_checkpoint::Checkpoint;
use lifelike_checkpoint::rng::stream;
use lifelike_nn::adam::{AdamConfig, Descent};
use lifelike_train::supervised::{StepMetrics, SupervisedCore};
use rand::Rng;
use rand::seq::index;
use rand_distr::{Distribution, StandardNormal};

use super::contrastive::contrastive_loss;
use super::data::{EvaluatorData, caption_kinds};
use super::file::{Evaluator, NETWORK};
use super::network::EvaluatorNetwork;
use super::plan::EvaluatorPlan;
use crate::metrics::{Scores, TOP};
use crate::representation::{RepresentationSpec, Standardizer};
use crate::text::pieces::{UNKNOWN, WordPieces};
use crate::{FromInput, GenerationError};

/// Name of the best networks in a checkpoint.
const BEST: &str = "best";

/// A training run of an evaluator.
#[derive(Debug)]
pub struct EvaluatorTrainer {
    data: EvaluatorData,
    /// Everything but the networks being trained: its networks are the best ones so far.
    best: Evaluator,
    score: Option<f64>,
    network: EvaluatorNetwork,
    core: SupervisedCore,
}

/// Motions with one sentence each.
struct Batch {
    /// Standardized rows with noise.
    rows: Vec<Vec<f32>>,
    /// Word pieces of the sentences, some hidden.
    ids: Vec<Vec<u32>>,
    /// Equal for sentences of the same words.
    kinds: Vec<usize>,
}

impl EvaluatorTrainer {
    /// A run that has not begun. Word pieces and statistics are those of the training motions.
    ///
    /// # Errors
    /// A plan out of range; data that does not fit `spec`, or of which a sentence cannot be read.
    pub fn new(plan: EvaluatorPlan, spec: RepresentationSpec, data: EvaluatorData) -> Result<Self, GenerationError> {
        plan.check()?;
        spec.check()?;
        data.check()?;
        let width = data.training[0].rows.width;
        if width != spec.width() {
            return Err(GenerationError::mismatch("width of a motion", spec.width(), width));
        }
        let captions = data.training.iter().flat_map(|item| &item.captions).map(String::as_str);
        let pieces = WordPieces::learn(captions, plan.pieces)?;
        let motions = data.training.iter().map(|item| &item.rows);
        let standardizer = Standardizer::of(motions, Standardizer::FLOOR)?;
        let network = EvaluatorNetwork::new(&plan, width, pieces.len());
        let core = SupervisedCore::new(AdamConfig::adam(), network.parameters().len());
        let best = Evaluator { plan, spec, standardizer, pieces, network: network.clone() };
        Ok(Self { data, best, score: None, network, core })
    }

    /// Returns the plan.
    pub fn plan(&self) -> &EvaluatorPlan {
        &self.best.plan
    }

    /// Returns the iterations done.
    pub fn iteration(&self) -> u64 {
        self.core.iteration()
    }

    /// Returns the parameters of all networks.
    pub fn parameters(&self) -> usize {
        self.network.parameters().len()
    }

    /// Returns a description of the training data, for resuming.
    pub fn data(&self) -> String {
        self.data.digest()
    }

    /// Returns the evaluator with the best networks so far: those of the best validation, or the present ones where
    /// nothing was validated.
    pub fn evaluator(&self) -> Evaluator {
        if self.score.is_some() { self.best.clone() } else { self.present() }
    }

    /// Returns the evaluator with the networks as they stand.
    fn present(&self) -> Evaluator {
        Evaluator { network: self.network.clone(), ..self.best.clone() }
    }

    /// One iteration: draw motions with one sentence each, embed both, step.
    ///
    /// # Errors
    /// A sentence that cannot be read.
    pub fn step(&mut self) -> Result<StepMetrics, GenerationError> {
        let (plan, i) = (self.best.plan.clone(), self.core.iteration());
        let Batch { rows, ids, kinds } = self.batch(i)?;
        let loss = |text: &[f32], motion: &[f32]| contrastive_loss(text, motion, &kinds);
        let (loss, gradient) = self.network.gradient(&rows, &ids, loss);
        let learning_rate = plan.learning_rate_at(i);
        let descent = Descent { gradient: &gradient, max_norm: plan.max_gradient_norm, rate: learning_rate };
        Ok(self.core.step_of(self.network.parameters_mut(), loss, descent))
    }

    /// Draws a batch.
    fn batch(&self, i: u64) -> Result<Batch, GenerationError> {
        let (plan, all) = (&self.best.plan, &self.data.training);
        let mut rng = stream(plan.seed, "evaluator.batch", 0, i);
        let drawn = index::sample(&mut rng, all.len(), plan.batch.min(all.len()));
        let (mut rows, mut ids, mut captions) = (Vec::new(), Vec::new(), Vec::new());
        for item in drawn.iter().map(|at| &all[at]) {
            let from = rng.random_range(0..=item.rows.n.saturating_sub(plan.max_rows));
            let mut own = self.best.rows(&item.rows, from)?;
            own.iter_mut().for_each(|x| {
                let noise: f64 = StandardNormal.sample(&mut rng);
                *x += (plan.noise * noise) as f32;
            });
            let caption = item.captions[rng.random_range(0..item.captions.len())].as_str();
            let mut read = self.best.pieces.encode(caption)?;
            for id in &mut read {
                if rng.random_bool(plan.word_dropout) {
                    *id = UNKNOWN;
                }
            }
            rows.push(own);
            ids.push(read);
            captions.push(caption);
        }
        Ok(Batch { rows, ids, kinds: caption_kinds(captions) })
    }

    /// Measures the networks as they stand on the validation motions and keeps them if none were better.
    pub(super) fn choose(&mut self) -> Result<Option<Scores>, GenerationError> {
        let present = self.present();
        let Some(found) = present.scores(&self.data.validation, 1, present.plan.seed)? else { return Ok(None) };
        let score = Self::score(&found);
        if self.score.is_none_or(|best| score >= best) {
            (self.score, self.best) = (Some(score), present);
        }
        Ok(Some(found))
    }

    /// Returns the quality by which networks are chosen: the mean of top 1 to top 3, since the last is soon perfect.
    pub(super) fn score(found: &Scores) -> f64 {
        found.r_precision.iter().map(|interval| interval.mean).sum::<f64>() / TOP as f64
    }

    /// Returns everything needed to continue bit for bit. [`Evaluator::load`] reads a file of it.
    pub(super) fn save(&self) -> Result<Checkpoint, GenerationError> {
        let mut checkpoint = Checkpoint::new();
        self.present().save_into(&mut checkpoint)?;
        self.best.network.parameters().save_into(&mut checkpoint, BEST)?;
        checkpoint.put_f64("score", &[1], vec![self.score.unwrap_or(f64::NAN)])?;
        self.core.save_into(self.network.parameters().layout(), &mut checkpoint, "training")?;
        Ok(checkpoint)
    }

    /// Continues from a checkpoint of a training by the same plan.
    pub(super) fn load(&mut self, checkpoint: &Checkpoint) -> Result<(), GenerationError> {
        let saved = Evaluator::load_from(checkpoint)?;
        let equal = saved.plan == self.best.plan && saved.spec == self.best.spec && saved.pieces == self.best.pieces;
        if !equal {
            let what = format!("{}: plan, joints and word pieces", checkpoint.origin());
            return Err(GenerationError::mismatch(what, "those of this run", "others"));
        }
        *self.best.network.parameters_mut() = self.best.network.parameters().load_from(checkpoint, BEST)?;
        *self.network.parameters_mut() = self.network.parameters().load_from(checkpoint, NETWORK)?;
        self.score = Some(checkpoint.f64s("score", &[1])?[0]).filter(|score| !score.is_nan());
        Ok(self.core.load_from(self.network.parameters().layout(), checkpoint, "training")?)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use lifelike_language::Split;

    use super::*;
    use crate::data::CaptionedMotion;
    use crate::representation::FeatureMatrix;

    #[test]
    fn a_gradient_that_is_not_finite_is_skipped_and_counted() {
        let motion = |i: usize| {
            let rows = (0..30 * 9).map(|k| ((k + 3 * i) as f32 * 0.3).sin()).collect();
            let (rows, captions) = (FeatureMatrix::new(rows, 9).unwrap(), vec![format!("a person walks {i} steps")]);
            CaptionedMotion { name: i.to_string(), split: Split::Train, rows, captions, licence: String::new() }
        };
        let data = EvaluatorData { training: (0..8).map(motion).collect(), validation: Vec::new() };
        let plan =
            EvaluatorPlan { width: 8, channels: 8, pieces: 150, batch: 4, warmup: 0, ..EvaluatorPlan::default() };
        let mut trainer = EvaluatorTrainer::new(plan, RepresentationSpec::new(vec!["knee".into()]), data).unwrap();
        trainer.step().unwrap();
        let before = trainer.network.parameters().values().to_vec();
        let mean = std::mem::replace(&mut trainer.best.standardizer.mean[0], f32::NAN);
        assert_eq!(trainer.step().unwrap().skipped, 1);
        assert_eq!(trainer.network.parameters().values(), before);
        trainer.best.standardizer.mean[0] = mean;
        let next = trainer.step().unwrap();
        assert!(next.skipped == 1 && next.loss.is_finite() && trainer.network.parameters().values() != before);
    }
}
