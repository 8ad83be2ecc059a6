//! Windows to normalised control points and back.

use lifelike_checkpoint::Checkpoint;
use lifelike_nn::transformer::{Sampling, SplineAutoencoder};
use lifelike_train::supervised::StepMetrics;

use super::plan::SplinePriorPlan;
use super::sequences::WindowSequences;
use crate::RepresentationError;
use crate::prior::Windows;
use crate::prior::kind::{KindPlan, PriorData, PriorKind, PriorTraining};
use crate::prior::motion_prior::MotionPrior;
use crate::spline_transformer::passes::{control_points, sequences};
use crate::spline_transformer::{SequenceTrainer, Sequences};
use crate::standardizer::{Moments, Standardizer};

/// Training windows that are held at a time.
const READ: usize = 1024;
/// Smallest standard deviation to divide by, as a part of the largest: what the network does not use would otherwise
/// be as large as what it does, and be its rounding.
const FLOOR: f64 = 1e-3;

/// A trained network and the scale of its codes.
#[derive(Debug, Clone)]
pub struct SplineCoder {
    network: SplineAutoencoder,
    scale: Standardizer,
}

impl SplineCoder {
    /// Takes a trained network, and the scale of the codes of all training windows.
    fn of(
        plan: &SplinePriorPlan,
        network: &SplineAutoencoder,
        data: &WindowSequences,
    ) -> Result<Self, RepresentationError> {
        let network = network.clone();
        let (size, all) = (plan.latent_size(), (0..data.training().len()).collect::<Vec<_>>());
        let mut moments = Moments::new(size);
        for centres in all.chunks(READ) {
            let rows = data.training().gather(data.statistics(), centres)?;
            let points = control_points(&network, &rows, [data.tokens(), data.width()])?;
            points.chunks_exact(size).for_each(|point| moments.add(point.iter().copied().map(f64::from)));
        }
        let (mean, deviation) = moments.finish();
        let largest = deviation.iter().copied().fold(0.0, f64::max);
        let floor = if largest > 0.0 { FLOOR * largest } else { 1.0 };
        let scale = Standardizer::new(mean, deviation.into_iter().map(|s| s.max(floor)).collect());
        Ok(Self { network, scale })
    }
}

impl PriorKind for SplineCoder {
    const NAME: &'static str = "spline motion prior";
    const TITLE: &'static str = "a Spline-based Transformer";
    type Plan = SplinePriorPlan;
    type Trainer = SequenceTrainer<WindowSequences>;

    fn trainer(
        plan: &SplinePriorPlan,
        data: PriorData,
    ) -> Result<SequenceTrainer<WindowSequences>, RepresentationError> {
        let PriorData { layout, training, held_out } = data;
        let data = WindowSequences::new(plan.windows, plan.training.seed, layout, training, held_out)?;
        SequenceTrainer::new(plan.training.clone(), data)
    }

    /// # Shapes
    /// A code holds control point after control point.
    fn encode(&self, windows: Vec<f32>, shape: [usize; 2]) -> Result<Vec<f32>, RepresentationError> {
        let points = control_points(&self.network, &windows, shape)?;
        let mut codes: Vec<f64> = points.into_iter().map(f64::from).collect();
        self.scale.normalize(&mut codes);
        Ok(codes.into_iter().map(|x| x as f32).collect())
    }

    fn decode(&self, codes: &[f32], samples: usize) -> Result<Vec<f32>, RepresentationError> {
        let mut points: Vec<f64> = codes.iter().copied().map(f64::from).collect();
        self.scale.denormalize(&mut points);
        let points: Vec<f32> = points.into_iter().map(|x| x as f32).collect();
        sequences(&self.network, &points, &Sampling::each(samples))
    }

    fn save_into(&self, checkpoint: &mut Checkpoint) -> Result<(), RepresentationError> {
        self.scale.save_into(checkpoint, SCALE)?;
        Ok(self.network.parameters().save_into(checkpoint, NETWORK)?)
    }

    fn load_from(
        plan: &SplinePriorPlan,
        checkpoint: &Checkpoint,
        features: usize,
    ) -> Result<Self, RepresentationError> {
        let network = plan.training.network(features).init(plan.training.seed, NETWORK)?;
        let parameters = network.parameters().load_from(checkpoint, NETWORK)?;
        let network = network.with_parameters(parameters);
        let scale = Standardizer::load_from(checkpoint, SCALE, plan.latent_size())?;
        Ok(Self { network, scale })
    }
}

impl PriorTraining for SequenceTrainer<WindowSequences> {
    fn describe(now: &StepMetrics) -> String {
        format!("mean squared error {:.4}", now.loss)
    }

    fn parameters(&self) -> usize {
        Self::parameters(self)
    }

    fn prior(&self) -> Result<MotionPrior, RepresentationError> {
        MotionPrior::of_spline(self)
    }

    fn watched(&self) -> &Windows {
        self.data().watched()
    }
}

impl MotionPrior {
    /// Returns the prior as the training of a Spline-based Transformer stands. Goes through all training windows, for
    /// the scale of the codes.
    ///
    /// # Errors
    /// Windows that cannot be made.
    pub fn of_spline(trainer: &SequenceTrainer<WindowSequences>) -> Result<Self, RepresentationError> {
        let data = trainer.data();
        let plan = SplinePriorPlan { windows: *data.plan(), training: trainer.plan().clone() };
        let coder = SplineCoder::of(&plan, trainer.network(), data)?;
        Ok(Self::new(plan, data.layout().clone(), data.statistics().clone(), coder))
    }
}

/// Names in files.
const NETWORK: &str = "spline";
const SCALE: &str = "codes";
