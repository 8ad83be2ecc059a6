//! Training of an evaluator: the whole algorithm in [`EvaluatorTrainer::step`].

use lifelike_checkpoint::Checkpoint;
use lifelike_checkpoint::rng::stream;
use lifelike_nn::adam::{Adam, AdamConfig, Descent};
use rand::Rng;
use rand::seq::index;
use rand_distr::{Distribution, StandardNormal};

use super::contrastive::contrastive_loss;
use super::data::{EvaluatorData, caption_kinds};
use super::file::{Evaluator, NETWORK};
use super::network::EvaluatorNetwork;
use super::plan::EvaluatorPlan;
use crate::GenerationError;
use crate::metrics::{Scores, TOP};
use crate::representation::{RepresentationSpec, Standardizer};
use crate::text::pieces::{UNKNOWN, WordPieces};

/// Name of the best networks in a checkpoint.
const BEST: &str = "best";

/// Metrics of one iteration. All of it is determined by plan and data.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct EvaluatorMetrics {
    /// Contrastive loss before the step (nats); ln of the batch where nothing is told apart.
    pub loss: f64,
    /// Learning rate of this iteration.
    pub learning_rate: f64,
    /// Norm of the gradient before clipping.
    pub gradient_norm: f64,
    /// Iterations so far whose gradient was not finite and was thrown away.
    pub skipped: u64,
}

/// A training run of an evaluator.
#[derive(Debug)]
pub struct EvaluatorTrainer {
    data: EvaluatorData,
    /// Everything but the networks being trained: its networks are the best ones so far.
    best: Evaluator,
    score: Option<f64>,
    network: EvaluatorNetwork,
    optimizer: Adam,
    iteration: u64,
    skipped: u64,
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
        let optimizer = Adam::new(AdamConfig::adam(), network.parameters().len());
        let best = Evaluator { plan, spec, standardizer, pieces, network: network.clone() };
        Ok(Self { data, best, score: None, network, optimizer, iteration: 0, skipped: 0 })
    }

    /// Returns the plan.
    pub fn plan(&self) -> &EvaluatorPlan {
        &self.best.plan
    }

    /// Returns the iterations done.
    pub fn iteration(&self) -> u64 {
        self.iteration
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
    pub fn step(&mut self) -> Result<EvaluatorMetrics, GenerationError> {
        let (plan, i) = (self.best.plan.clone(), self.iteration);
        let Batch { rows, ids, kinds } = self.batch(i)?;
        let loss = |text: &[f32], motion: &[f32]| contrastive_loss(text, motion, &kinds);
        let (loss, gradient) = self.network.gradient(&rows, &ids, loss);
        let learning_rate = plan.learning_rate_at(i);
        let descent = Descent { gradient: &gradient, max_norm: plan.max_gradient_norm, rate: learning_rate };
        let stepped = self.network.parameters_mut().step(&mut self.optimizer, descent);
        self.skipped += u64::from(!stepped.taken);
        self.iteration += 1;
        Ok(EvaluatorMetrics { loss, learning_rate, gradient_norm: stepped.norm, skipped: self.skipped })
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
        checkpoint.put_u64("progress", &[2], vec![self.iteration, self.skipped])?;
        self.optimizer.save_into(self.network.parameters().layout(), &mut checkpoint, "optimizer")?;
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
        self.optimizer =
            Adam::load_from(AdamConfig::adam(), self.network.parameters().layout(), checkpoint, "optimizer")?;
        self.score = Some(checkpoint.f64s("score", &[1])?[0]).filter(|score| !score.is_nan());
        let progress = checkpoint.u64s("progress", &[2])?;
        (self.iteration, self.skipped) = (progress[0], progress[1]);
        Ok(())
    }
}
