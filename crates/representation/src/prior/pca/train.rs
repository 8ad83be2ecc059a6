//! The fit of principal components as the one loop sees it.

use lifelike_checkpoint::Checkpoint;
use lifelike_motion::FeatureLayout;
use lifelike_train::{Budget, Scalar, Schedule, TrainingTask};
use rayon::prelude::*;

use super::plan::PcaPlan;
use crate::RepresentationError;
use crate::components::{Rows, Subspace};
use crate::prior::kind::{KindPlan, PriorData, PriorTraining};
use crate::prior::{FeatureStatistics, MotionPrior, Windows};

/// Clips' windows, normalised.
#[derive(Debug, Clone, Copy)]
pub(in crate::prior) struct Normalized<'a> {
    pub windows: &'a Windows,
    pub statistics: &'a FeatureStatistics,
}

impl Rows for Normalized<'_> {
    fn len(&self) -> usize {
        self.windows.len()
    }

    fn gather(&self, rows: &[usize]) -> Result<Vec<f32>, RepresentationError> {
        let parts = rows.par_chunks(64).map(|part| self.windows.gather(self.statistics, part));
        Ok(parts.collect::<Result<Vec<_>, _>>()?.concat())
    }
}

/// Numbers of one iteration.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct PcaMetrics {
    /// Iterations done, this one included.
    pub iteration: u64,
    /// Part of the variance of normalised windows that the components hold.
    pub explained: f64,
}

/// A fit of principal components.
#[derive(Debug)]
pub struct PcaTrainer {
    plan: PcaPlan,
    layout: FeatureLayout,
    statistics: FeatureStatistics,
    training: Windows,
    held_out: Windows,
    subspace: Subspace,
    iteration: u64,
}

impl PcaTrainer {
    /// Begins with random directions. `held_out` clips are only reported on.
    ///
    /// # Errors
    /// A plan out of range, fewer windows or numbers in them than components, or a clip that does not fit the layout.
    pub fn new(plan: PcaPlan, data: PriorData) -> Result<Self, RepresentationError> {
        plan.check()?;
        let PriorData { layout, training, held_out } = data;
        let training = Windows::to_train_on(&plan.windows, &layout, training)?;
        let held_out = Windows::new(&plan.windows, &layout, held_out)?;
        let statistics = training.statistics(&layout, &plan.windows.floors);
        let size = plan.windows.window().len() * layout.size();
        let data = Normalized { windows: &training, statistics: &statistics };
        let subspace = Subspace::new(&data, plan.latent, size, plan.windows.seed)?;
        Ok(Self { plan, layout, statistics, training, held_out, subspace, iteration: 0 })
    }
}

impl TrainingTask for PcaTrainer {
    type Metrics = PcaMetrics;
    type Error = RepresentationError;

    fn iteration(&self) -> u64 {
        self.iteration
    }

    fn budget(&self) -> Budget {
        Budget::iterations(self.iteration, self.plan.iterations)
    }

    fn schedule(&self) -> Schedule {
        Schedule { checkpoint_every: self.plan.iterations, validate_every: 0, keep: 1 }
    }

    fn identity(&self) -> Vec<(&'static str, String)> {
        vec![("training clips", self.training.digest())]
    }

    fn step(&mut self) -> Result<PcaMetrics, RepresentationError> {
        let data = Normalized { windows: &self.training, statistics: &self.statistics };
        let explained = self.subspace.iterate(&data)?;
        self.iteration += 1;
        Ok(PcaMetrics { iteration: self.iteration, explained })
    }

    fn scalars(&self, now: &PcaMetrics) -> Vec<Scalar> {
        vec![("Variance/explained".into(), now.explained)]
    }

    fn checkpoint(&self) -> Result<Checkpoint, RepresentationError> {
        let mut checkpoint = Checkpoint::new();
        self.prior()?.save_into(&mut checkpoint)?;
        self.subspace.save_into(&mut checkpoint)?;
        checkpoint.put_u64("progress", &[1], vec![self.iteration])?;
        Ok(checkpoint)
    }

    fn restore(&mut self, checkpoint: &Checkpoint) -> Result<(), RepresentationError> {
        self.subspace.restore(checkpoint)?;
        self.iteration = checkpoint.u64s("progress", &[1])?[0];
        Ok(())
    }
}

impl PriorTraining for PcaTrainer {
    fn describe(now: &PcaMetrics) -> String {
        format!("{:.2}% of the variance", 100.0 * now.explained)
    }

    fn parameters(&self) -> usize {
        (self.plan.latent + 1) * self.plan.windows.window().len() * self.layout.size()
    }

    fn prior(&self) -> Result<MotionPrior, RepresentationError> {
        let (layout, statistics) = (self.layout.clone(), self.statistics.clone());
        Ok(MotionPrior::new(self.plan, layout, statistics, self.subspace.components()))
    }

    fn watched(&self) -> &Windows {
        if self.held_out.is_empty() { &self.training } else { &self.held_out }
    }
}
