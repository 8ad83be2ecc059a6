//! Normalised windows as sequences to learn from.

use std::ops::Range;

use lifelike_checkpoint::rng::stream;
use lifelike_motion::FeatureLayout;

use crate::RepresentationError;
use crate::prior::loss;
use crate::prior::{FeatureStatistics, PriorClip, WindowPlan, Windows};
use crate::spline_transformer::{HeldOut, Sequences};

/// Largest number of windows that the loss is watched on.
const WATCHED: usize = 512;

/// The windows around all frames of some clips, as the β-VAE meets them: drawn uniformly, normalised by the same statistics.
#[derive(Debug)]
pub struct WindowSequences {
    plan: WindowPlan,
    seed: u64,
    layout: FeatureLayout,
    statistics: FeatureStatistics,
    training: Windows,
    held_out: Windows,
    digest: String,
}

impl WindowSequences {
    /// `seed` is the key of the batches. `held_out` clips are never trained on.
    ///
    /// # Errors
    /// A plan out of range, no training frames, or a clip that does not fit the layout.
    pub fn new(
        plan: WindowPlan,
        seed: u64,
        layout: FeatureLayout,
        training: Vec<PriorClip>,
        held_out: Vec<PriorClip>,
    ) -> Result<Self, RepresentationError> {
        plan.check()?;
        let training = Windows::to_train_on(&plan, &layout, training)?;
        let held_out = Windows::new(&plan, &layout, held_out)?;
        let statistics = training.statistics(&layout, &plan.floors);
        let digest = training.digest();
        Ok(Self { plan, seed, layout, statistics, training, held_out, digest })
    }

    /// Settings of the windows.
    pub fn plan(&self) -> &WindowPlan {
        &self.plan
    }

    /// Joints and end effectors of their features.
    pub fn layout(&self) -> &FeatureLayout {
        &self.layout
    }

    /// Returns the mean and standard deviation over the training frames, which windows are normalised by.
    pub fn statistics(&self) -> &FeatureStatistics {
        &self.statistics
    }

    /// Returns the windows that are trained on.
    pub fn training(&self) -> &Windows {
        &self.training
    }

    /// Windows that the loss is watched and errors are reported on: those of the held-out clips, or the training clips
    /// where none were held out.
    pub fn watched(&self) -> &Windows {
        if self.held_out.is_empty() { &self.training } else { &self.held_out }
    }

    fn stride(&self) -> usize {
        self.watched().len().div_ceil(WATCHED).max(1)
    }

    /// Returns normalised windows around frames. All clips were checked, so each frame has its window.
    fn gather(&self, windows: &Windows, centres: &[usize]) -> Vec<f32> {
        windows.gather(&self.statistics, centres).unwrap_or_default()
    }
}

impl Sequences for WindowSequences {
    fn describe(&self) -> String {
        let WindowPlan { frame_rate, half_width, window_seconds, .. } = self.plan;
        let (samples, seed, digest) = (2 * half_width + 1, self.seed, &self.digest);
        let windows = format!("windows of {samples} samples over {window_seconds} s at {frame_rate} Hz");
        format!("{windows}, loss of eq. 4.3, seed {seed}, clips {digest}")
    }

    fn width(&self) -> usize {
        self.layout.size()
    }

    fn tokens(&self) -> usize {
        self.plan.window().len()
    }

    fn batch(&self, iteration: u64, count: usize) -> Vec<f32> {
        let mut rng = stream(self.seed, "prior.batch", 0, iteration);
        self.gather(&self.training, &self.training.draw(count, &mut rng))
    }

    fn loss(&self, x: &[f32], y: &[f32], gradient: &mut [f32]) -> f64 {
        loss::reconstruction(x, y, self.width(), gradient)
    }

    /// Counts the only set: what is watched during training is what is reported on.
    fn held_out_len(&self, _: HeldOut) -> usize {
        self.watched().len().div_ceil(self.stride())
    }

    fn held_out(&self, _: HeldOut, range: Range<usize>) -> Vec<f32> {
        let centres: Vec<usize> = range.map(|i| i * self.stride()).collect();
        self.gather(self.watched(), &centres)
    }
}
