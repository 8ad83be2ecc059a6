//! Training of the motion prior: the whole algorithm in [`VaeTrainer::step`].

use lifelike_checkpoint::Checkpoint;
use lifelike_checkpoint::rng::stream;
use lifelike_motion::FeatureLayout;
use lifelike_nn::adam::{AdamConfig, Descent};
use lifelike_nn::losses::kl_from_standard_normal;
use lifelike_nn::rows::add;
use lifelike_train::supervised::{StepMetrics, SupervisedCore};
use rand_distr::{Distribution, StandardNormal};
use rayon::prelude::*;

use super::network::{Encoded, MotionVae, NETWORK, VaeWeights};
use super::plan::VaePlan;
use crate::components::{Components, Subspace};
use crate::prior::kind::KindPlan;
use crate::prior::loss::reconstruction;
use crate::prior::pca::{Normalized, PcaPlan};
use crate::prior::{FeatureStatistics, MotionPrior, PriorClip, PriorPlan, ReconstructionReport, Windows};
use crate::{FromInput, RepresentationError};

/// Metrics of one iteration. All of it is determined by plan and data.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct VaeMetrics {
    /// Those of every training.
    #[serde(flatten)]
    pub step: StepMetrics,
    /// Eq. 4.3, before the step.
    pub reconstruction: f64,
    /// KL divergence from the standard normal (nats per window), before the step.
    pub kl: f64,
    /// Weight of the KL divergence in this iteration.
    pub kl_weight: f64,
}

/// Windows that a core takes at a time.
const PART: usize = 32;

/// The two terms of the loss, over a batch.
#[derive(Debug, Clone, Copy, Default)]
struct Losses {
    reconstruction: f64,
    kl: f64,
}

/// A training run of a motion prior.
#[derive(Debug)]
pub struct VaeTrainer {
    plan: VaePlan,
    layout: FeatureLayout,
    statistics: FeatureStatistics,
    training: Windows,
    held_out: Windows,
    vae: MotionVae,
    core: SupervisedCore,
}

impl VaeTrainer {
    /// A run that has not begun. `held_out` clips are only looked at by [`Self::report`].
    ///
    /// # Errors
    /// A plan out of range, no training frames, or a clip that does not fit the layout.
    pub fn new(
        plan: VaePlan,
        layout: FeatureLayout,
        training: Vec<PriorClip>,
        held_out: Vec<PriorClip>,
    ) -> Result<Self, RepresentationError> {
        plan.check()?;
        let windows = plan.windows;
        let training = Windows::to_train_on(&windows, &layout, training)?;
        let held_out = Windows::new(&windows, &layout, held_out)?;
        let statistics = training.statistics(&layout, &windows.floors);
        let vae = MotionVae::new(&plan, layout.size());
        let config = AdamConfig { rule: plan.optimizer, ..AdamConfig::adam() };
        let core = SupervisedCore::new(config, vae.parameters().len());
        Ok(Self { plan, layout, statistics, training, held_out, vae, core })
    }

    /// The plan.
    pub fn plan(&self) -> &VaePlan {
        &self.plan
    }

    /// Iterations done.
    pub fn iteration(&self) -> u64 {
        self.core.iteration()
    }

    /// Parameters of encoder and decoder together.
    pub fn parameters(&self) -> usize {
        self.vae.parameters().len()
    }

    /// Fits the linear path, where the plan has one.
    fn fit_linear_path(&mut self) -> Result<(), RepresentationError> {
        let data = Normalized { windows: &self.training, statistics: &self.statistics };
        let VaePlan { latent, windows, .. } = self.plan;
        let mut subspace = Subspace::new(&data, latent, windows.window().len() * self.layout.size(), windows.seed)?;
        for _ in 0..PcaPlan::ITERATIONS {
            subspace.iterate(&data)?;
        }
        self.vae = self.vae.clone().with_linear_path(subspace.components());
        Ok(())
    }

    /// One iteration: draw windows, encode, sample, decode, step.
    pub fn step(&mut self) -> Result<VaeMetrics, RepresentationError> {
        if self.plan.linear_path && self.vae.linear_path().is_none() {
            self.fit_linear_path()?;
        }
        let (plan, i) = (&self.plan, self.core.iteration());
        let (kl_weight, learning_rate) = (plan.kl_weight_at(i), plan.learning_rate_at(i));

        let rows =
            self.training.sample(&self.statistics, plan.batch, &mut stream(plan.windows.seed, "prior.batch", 0, i))?;
        let mut rng = stream(plan.windows.seed, "prior.noise", 0, i);
        let noise: Vec<f32> = (0..plan.batch * plan.latent).map(|_| StandardNormal.sample(&mut rng)).collect();
        let (losses, gradient) = self.gradient(&rows, &noise, kl_weight);

        let descent = Descent { gradient: &gradient, max_norm: plan.max_gradient_norm, rate: learning_rate };
        let loss = losses.reconstruction + kl_weight * losses.kl;
        let step = self.core.step_of(self.vae.parameters_mut(), loss, descent);
        Ok(VaeMetrics { step, reconstruction: losses.reconstruction, kl: losses.kl, kl_weight })
    }

    /// Losses and gradient of a batch, a core for each part of it. Sums are in the parts' order, whichever core had which, so the
    /// number of cores changes no bit.
    fn gradient(&self, rows: &[f32], noise: &[f32], kl_weight: f64) -> (Losses, Vec<f32>) {
        let (plan, weights) = (&self.plan, self.vae.weights());
        let window = plan.windows.window().len() * self.layout.size();
        let parts = rows.par_chunks(PART * window).zip(noise.par_chunks(PART * plan.latent));
        let parts: Vec<(Losses, Vec<f32>)> =
            parts.map(|(rows, noise)| self.part(&weights, rows, noise, kl_weight)).collect();
        let mut total = (Losses::default(), vec![0.0; self.vae.parameters().len()]);
        for (losses, gradient) in parts {
            total.0.reconstruction += losses.reconstruction;
            total.0.kl += losses.kl;
            add(&mut total.1, &gradient);
        }
        total
    }

    /// The share of some windows in losses and gradient.
    fn part(&self, weights: &VaeWeights<'_>, rows: &[f32], noise: &[f32], kl_weight: f64) -> (Losses, Vec<f32>) {
        let (batch, samples, latent) =
            (self.plan.batch as f64, self.plan.windows.window().len() as f64, self.plan.latent);
        let mut sums = vec![0.0; self.vae.parameters().len()];
        let (encoded, encoder) = weights.encode(rows);
        let Encoded { mean, log_variance } = &encoded;
        let draws = mean.iter().zip(log_variance).zip(noise);
        let z = draws.map(|((mean, log_variance), noise)| mean + (0.5 * log_variance).exp() * noise).collect();
        let (back, decoder) = weights.decode(z);

        let mut by_back = vec![0.0; back.len()];
        let scale = 1.0 / (batch * samples);
        let reconstruction = scale * reconstruction(rows, &back, self.layout.size(), &mut by_back);
        by_back.iter_mut().for_each(|x| *x *= scale as f32);
        let by_z = weights.decode_backward(decoder, &by_back, &mut sums);

        let through = by_z.iter().zip(log_variance).zip(noise);
        let by_log_variance = through.map(|((by, log_variance), noise)| by * noise * 0.5 * (0.5 * log_variance).exp());
        let mut by = Encoded { log_variance: by_log_variance.collect(), mean: by_z };
        let mut kl = 0.0;
        for first in (0..mean.len()).step_by(latent) {
            let own = first..first + latent;
            let by = [&mut by.mean[own.clone()], &mut by.log_variance[own.clone()]];
            let weight = (kl_weight / batch) as f32;
            kl += f64::from(kl_from_standard_normal([&mean[own.clone()], &log_variance[own]], weight, by)) / batch;
        }
        weights.encode_backward(encoder, &by, &mut sums);
        (Losses { reconstruction, kl }, sums)
    }

    /// The prior as it stands.
    pub fn prior(&self) -> MotionPrior {
        let (layout, statistics) = (self.layout.clone(), self.statistics.clone());
        MotionPrior::new(self.plan.clone(), layout, statistics, self.vae.clone())
    }

    /// Returns the windows of the held-out clips, or of the training clips when none were held out.
    pub fn watched(&self) -> &Windows {
        if self.held_out.is_empty() { &self.training } else { &self.held_out }
    }

    /// Returns whether clips are held out.
    pub(super) fn has_held_out(&self) -> bool {
        !self.held_out.is_empty()
    }

    /// Reconstructs [`Self::watched`].
    ///
    /// # Errors
    /// Windows that cannot be made.
    pub fn report(&self) -> Result<ReconstructionReport, RepresentationError> {
        self.prior().reconstruct(self.watched())
    }

    /// Returns everything needed to continue bit for bit. [`MotionPrior::load`] reads a file of it.
    ///
    /// # Errors
    /// Two entries of one name.
    pub fn checkpoint(&self) -> Result<Checkpoint, RepresentationError> {
        let mut checkpoint = Checkpoint::new();
        self.prior().save_into(&mut checkpoint)?;
        checkpoint.set_meta("data", &self.training.digest())?;
        self.core.save_into(self.vae.parameters().layout(), &mut checkpoint, "training")?;
        Ok(checkpoint)
    }

    /// Continues from a checkpoint of a training by the same plan.
    ///
    /// # Errors
    /// A checkpoint of another plan or kind of prior, or training clips that are not those the run began with.
    pub fn restore(&mut self, checkpoint: &Checkpoint) -> Result<(), RepresentationError> {
        let mismatch = |what: &str, expected: String, got: String| {
            Err(RepresentationError::mismatch(format!("{}{what}", checkpoint.origin()), expected, got))
        };
        let saved = MotionPrior::load_from(checkpoint)?;
        match saved.plan() {
            PriorPlan::Vae(plan) if *plan == self.plan => {}
            PriorPlan::Vae(_) => return mismatch(": plan", "the plan of this run".into(), "another".into()),
            other => return mismatch("", "a beta-VAE's run".into(), format!("a {}", other.kind())),
        }
        let (expected, got): (String, _) = (checkpoint.meta("data")?, self.training.digest());
        if expected != got {
            return mismatch(": training clips", format!("digest {expected}"), got);
        }
        self.statistics = saved.statistics().clone();
        *self.vae.parameters_mut() = self.vae.parameters().load_from(checkpoint, NETWORK)?;
        if self.plan.linear_path {
            let size = self.plan.windows.window().len() * self.layout.size();
            let components = Components::read(checkpoint, self.plan.latent, size)?;
            self.vae = self.vae.clone().with_linear_path(components);
        }
        Ok(self.core.load_from(self.vae.parameters().layout(), checkpoint, "training")?)
    }

    /// Returns what identifies the clips it learns from.
    pub(super) fn data(&self) -> String {
        self.training.digest()
    }
}
