//! Windows to normalised control points and back.

use burn::module::Module;
use lifelike_checkpoint::Checkpoint;
use lifelike_nn::ModuleCheckpoint;
use lifelike_nn::device;
use lifelike_nn::transformer::{Sampling, SplineAutoencoder};

use super::plan::SplinePriorPlan;
use super::sequences::WindowSequences;
use crate::RepresentationError;
use crate::spline_transformer::Sequences;
use crate::spline_transformer::passes::{control_points, sequences};
use crate::standard::{Moments, Standard};

/// Training windows that are held at a time.
const READ: usize = 1024;
/// Smallest spread to divide by, as a part of the largest: what the network does not use would otherwise be as large as what it
/// does, and be its rounding.
const FLOOR: f64 = 1e-3;

/// A trained network and the scale of its codes.
#[derive(Debug, Clone)]
pub(crate) struct SplineCoder {
    plan: SplinePriorPlan,
    network: SplineAutoencoder,
    scale: Standard,
}

impl SplineCoder {
    /// With the scale of the codes of all training windows.
    pub(crate) fn of(
        plan: SplinePriorPlan,
        network: &SplineAutoencoder,
        data: &WindowSequences,
    ) -> Result<Self, RepresentationError> {
        let network = network.valid().fork(&device::inference());
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
        let scale = Standard::new(mean, deviation.into_iter().map(|s| s.max(floor)).collect());
        Ok(Self { plan, network, scale })
    }

    pub(crate) fn plan(&self) -> &SplinePriorPlan {
        &self.plan
    }

    /// # Shapes
    /// Normalised windows `[N, samples, F]` to codes `[N, d_z]`: control point after control point.
    pub(crate) fn encode(&self, rows: &[f32], [samples, size]: [usize; 2]) -> Result<Vec<f32>, RepresentationError> {
        let points = control_points(&self.network, rows, [samples, size])?;
        let mut codes: Vec<f64> = points.into_iter().map(f64::from).collect();
        self.scale.normalize(&mut codes);
        Ok(codes.into_iter().map(|x| x as f32).collect())
    }

    /// # Shapes
    /// Codes `[N, d_z]` to normalised windows `[N, samples, F]`.
    pub(crate) fn decode(&self, codes: &[f32], samples: usize) -> Result<Vec<f32>, RepresentationError> {
        let mut points: Vec<f64> = codes.iter().copied().map(f64::from).collect();
        self.scale.denormalize(&mut points);
        let points: Vec<f32> = points.into_iter().map(|x| x as f32).collect();
        sequences(&self.network, &points, self.plan.training.latent, &Sampling::each(samples))
    }

    pub(crate) fn save_into(&self, checkpoint: &mut Checkpoint) -> Result<(), RepresentationError> {
        checkpoint.set_meta("plan", &self.plan)?;
        self.scale.save_into(checkpoint, SCALE)?;
        Ok(checkpoint.put_module(NETWORK, &self.network)?)
    }

    /// For windows of `features` numbers per sample.
    pub(crate) fn load_from(checkpoint: &Checkpoint, features: usize) -> Result<Self, RepresentationError> {
        let plan: SplinePriorPlan = checkpoint.meta("plan")?;
        plan.check()?;
        let network = plan.training.network(features).init(plan.training.seed, NETWORK, &device::inference())?;
        let network = checkpoint.load_module(NETWORK, network)?;
        let scale = Standard::load_from(checkpoint, SCALE, plan.latent_size())?;
        Ok(Self { plan, network, scale })
    }
}

/// In files.
const NETWORK: &str = "spline";
const SCALE: &str = "codes";
