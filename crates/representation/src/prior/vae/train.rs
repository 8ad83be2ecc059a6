//! Training of the motion prior: the whole algorithm in [`VaeTrainer::step`].

use burn::module::Module;
use burn::tensor::{Tensor, TensorData};
use lifelike_checkpoint::Checkpoint;
use lifelike_checkpoint::rng::stream;
use lifelike_motion::FeatureLayout;
use lifelike_nn::ModuleCheckpoint;
use lifelike_nn::adam::{Adam, AdamConfig};
use lifelike_nn::device::{self, Device};
use lifelike_nn::gradients::Gradients;
use lifelike_nn::losses::kl_from_standard_normal;
use rand_distr::{Distribution, StandardNormal};

use super::loss::reconstruction;
use super::network::{MotionVae, NETWORK};
use super::plan::VaePlan;
use crate::RepresentationError;
use crate::components::{Components, Subspace};
use crate::prior::kind::KindPlan;
use crate::prior::pca::{Normalized, PcaPlan};
use crate::prior::{FeatureStatistics, MotionPrior, PriorClip, PriorPlan, ReconstructionReport, Windows};

/// Metrics of one iteration. All of it is determined by plan and data.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct VaeMetrics {
    /// Iterations done, this one included.
    pub iteration: u64,
    /// The loss that was minimised.
    pub loss: f64,
    /// Eq. 4.3, before the step.
    pub reconstruction: f64,
    /// KL divergence from the standard normal (nats per window), before the step.
    pub kl: f64,
    /// Weight of the KL divergence in this iteration.
    pub kl_weight: f64,
    /// Learning rate of this iteration.
    pub learning_rate: f64,
    /// Norm of the gradient before clipping.
    pub gradient_norm: f64,
    /// Iterations so far whose gradient was not finite and was thrown away.
    pub skipped: u64,
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
    optimizer: Adam,
    device: Device,
    iteration: u64,
    skipped: u64,
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
        let device = device::training();
        let vae = MotionVae::new(&plan, layout.size(), &device);
        let optimizer = Adam::new(AdamConfig { rule: plan.optimizer, ..AdamConfig::adam() });
        Ok(Self { plan, layout, statistics, training, held_out, vae, optimizer, device, iteration: 0, skipped: 0 })
    }

    /// With its networks on another device.
    #[must_use]
    pub fn to_device(mut self, device: &Device) -> Self {
        self.device = device.clone().autodiff();
        self.vae = self.vae.fork(&self.device);
        self.optimizer = self.optimizer.to_device(device);
        self
    }

    /// The plan.
    pub fn plan(&self) -> &VaePlan {
        &self.plan
    }

    /// Iterations done.
    pub fn iteration(&self) -> u64 {
        self.iteration
    }

    /// Parameters of encoder and decoder together.
    pub fn parameters(&self) -> usize {
        self.vae.num_params()
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
        let (plan, i) = (&self.plan, self.iteration);
        let device = self.device.clone();
        let (kl_weight, learning_rate) = (plan.kl_weight_at(i), plan.learning_rate_at(i));

        let rows =
            self.training.sample(&self.statistics, plan.batch, &mut stream(plan.windows.seed, "prior.batch", 0, i))?;
        let shape = [plan.batch, plan.windows.window().len(), self.layout.size()];
        let x = Tensor::<3>::from_data(TensorData::new(rows, shape), &device);
        let mut rng = stream(plan.windows.seed, "prior.noise", 0, i);
        let noise: Vec<f32> = (0..plan.batch * plan.latent).map(|_| StandardNormal.sample(&mut rng)).collect();
        let noise = TensorData::new(noise, [plan.batch, plan.latent]);

        let (mean, log_variance) = self.vae.encode(x.clone());
        let deviation = log_variance.clone().mul_scalar(0.5).exp();
        let z = mean.clone() + deviation * Tensor::<2>::from_data(noise, &device);
        let rec = reconstruction(x, self.vae.decode(z));
        let kl = kl_from_standard_normal(mean, log_variance).mean();
        let loss = rec.clone() + kl.clone().mul_scalar(kl_weight);

        let mut gradients = Gradients::of(&self.vae, loss.backward());
        let gradient_norm = gradients.clip_norm(plan.max_gradient_norm)?;
        if gradient_norm.is_finite() {
            self.vae = self.optimizer.step(self.vae.clone(), gradients, learning_rate);
        } else {
            self.skipped += 1;
        }
        self.iteration += 1;
        let number = |t: Tensor<1>| f64::from(t.into_scalar::<f32>());
        Ok(VaeMetrics {
            iteration: self.iteration,
            loss: number(loss),
            reconstruction: number(rec),
            kl: number(kl),
            kl_weight,
            learning_rate,
            gradient_norm,
            skipped: self.skipped,
        })
    }

    /// The prior as it stands.
    pub fn prior(&self) -> MotionPrior {
        let (layout, statistics) = (self.layout.clone(), self.statistics.clone());
        MotionPrior::new(self.plan.clone(), layout, statistics, self.vae.valid().fork(&device::inference()))
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
    /// Tensor data that cannot be read from the device.
    pub fn report(&self) -> Result<ReconstructionReport, RepresentationError> {
        self.prior().reconstruct(self.watched())
    }

    /// Returns everything needed to continue bit for bit. [`MotionPrior::load`] reads a file of it.
    ///
    /// # Errors
    /// Tensor data could not be read from the device.
    pub fn checkpoint(&self) -> Result<Checkpoint, RepresentationError> {
        let mut checkpoint = Checkpoint::new();
        self.prior().save_into(&mut checkpoint)?;
        checkpoint.set_meta("data", &self.training.digest())?;
        checkpoint.put_u64("progress", &[2], vec![self.iteration, self.skipped])?;
        self.optimizer.save_into(&mut checkpoint, "optimizer")?;
        Ok(checkpoint)
    }

    /// Continues from a checkpoint of a training by the same plan.
    ///
    /// # Errors
    /// A checkpoint of another plan or kind of prior, or training clips that are not those the run began with.
    pub fn restore(&mut self, checkpoint: &Checkpoint) -> Result<(), RepresentationError> {
        let mismatch = |what: &str, expected: String, got: String| {
            Err(RepresentationError::Mismatch { what: format!("{}{what}", checkpoint.origin()), expected, got })
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
        self.vae = checkpoint.load_module(NETWORK, self.vae.clone())?;
        if self.plan.linear_path {
            let size = self.plan.windows.window().len() * self.layout.size();
            let components = Components::read(checkpoint, self.plan.latent, size)?;
            self.vae = self.vae.clone().with_linear_path(components);
        }
        self.optimizer = Adam::load_from(self.optimizer.config(), checkpoint, "optimizer", &self.vae)?;
        let progress = checkpoint.u64s("progress", &[2])?;
        (self.iteration, self.skipped) = (progress[0], progress[1]);
        Ok(())
    }

    /// Returns what identifies the clips it learns from.
    pub(super) fn data(&self) -> String {
        self.training.digest()
    }
}
