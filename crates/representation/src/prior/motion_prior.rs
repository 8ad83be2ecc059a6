//! The trained motion prior as one file, and what the tracker asks of it.

use std::path::Path;

use lifelike_checkpoint::Checkpoint;
use lifelike_motion::{FeatureLayout, Frame};

use super::dataset::{PriorClip, Windows, normalized_window};
use super::kinds::{Coder, PriorPlan};
use super::reconstruction::{ErrorSums, ReconstructionReport};
use super::statistics::FeatureStatistics;
use super::window_plan::WindowPlan;
use crate::{FromInput, RepresentationError};

/// Windows per pass through the network.
const CHUNK: usize = 256;
/// Largest number of windows that [`MotionPrior::reconstruct`] looks at.
const REPORT_WINDOWS: usize = 4000;

/// Encoder, decoder, names and statistics. The file (`*.prior.safetensors`) carries all of them and the plan.
#[derive(Debug, Clone)]
pub struct MotionPrior {
    plan: PriorPlan,
    layout: FeatureLayout,
    statistics: FeatureStatistics,
    coder: Coder,
}

impl MotionPrior {
    pub(super) fn new(
        plan: impl Into<PriorPlan>,
        layout: FeatureLayout,
        statistics: FeatureStatistics,
        coder: impl Into<Coder>,
    ) -> Self {
        Self { plan: plan.into(), layout, statistics, coder: coder.into() }
    }

    /// Returns the plan that it was trained by.
    pub fn plan(&self) -> &PriorPlan {
        &self.plan
    }

    /// Windows that it was trained on and encodes.
    pub fn windows(&self) -> &WindowPlan {
        self.plan.windows()
    }

    /// Joints and end effectors it knows, by name and in order.
    pub fn layout(&self) -> &FeatureLayout {
        &self.layout
    }

    /// Returns the mean and standard deviation of the training data: the tracker normalises m_t by the same (thesis 4.2.2).
    pub fn statistics(&self) -> &FeatureStatistics {
        &self.statistics
    }

    /// Returns d_z.
    pub fn latent_size(&self) -> usize {
        self.plan.latent_size()
    }

    /// Returns one latent per frame of a clip at the plan's frame rate (the mean μ, or the control points by their
    /// scale). Windows beyond the clip's ends repeat its first and last frame.
    ///
    /// # Shapes
    /// `T` frames to `[T, d_z]`, row after row.
    ///
    /// # Errors
    /// Frames with another number of joints or end effectors than the prior was trained for, or non-finite ones.
    pub fn encode_clip(&self, frames: &[Frame]) -> Result<Vec<f32>, RepresentationError> {
        let clip = PriorClip { name: "to encode".into(), frames: frames.to_vec() };
        clip.check(&self.layout)?;
        let spec = self.windows().window();
        let mut window = vec![0.0; spec.len() * self.layout.size()];
        let mut out = Vec::with_capacity(frames.len() * self.latent_size());
        for first in (0..frames.len()).step_by(CHUNK) {
            let last = (first + CHUNK).min(frames.len());
            let mut rows = Vec::with_capacity((last - first) * window.len());
            for centre in first..last {
                normalized_window(frames, self.windows().frame_rate, centre, spec, &self.statistics, &mut window)?;
                rows.extend(window.iter().map(|x| *x as f32));
            }
            out.extend(self.encode_windows(rows)?);
        }
        Ok(out)
    }

    /// Returns the window that a latent stands for: features in SI units in the heading frame of the centre sample.
    ///
    /// # Shapes
    /// `[N, d_z]` to `[N, 2W + 1, F]`, row after row.
    pub fn decode(&self, latents: &[f32]) -> Result<Vec<f64>, RepresentationError> {
        let d = self.latent_size();
        if !latents.len().is_multiple_of(d) {
            let expected = format!("rows of {d} numbers");
            return Err(RepresentationError::mismatch("latents", expected, format!("{} numbers", latents.len())));
        }
        let mut out = Vec::new();
        for rows in latents.chunks(d * CHUNK) {
            let windows = self.coder.decode(rows, self.windows().window().len())?;
            out.extend(windows.into_iter().map(f64::from));
        }
        self.statistics.denormalize(&mut out);
        Ok(out)
    }

    /// Encodes and decodes the windows of these clips (at most some thousands, evenly spread) and reports the errors.
    pub fn reconstruct(&self, windows: &Windows) -> Result<ReconstructionReport, RepresentationError> {
        let stride = windows.len().div_ceil(REPORT_WINDOWS).max(1);
        let (size, samples) = (self.layout.size(), self.windows().window().len());
        let (mut all, mut centre, mut clips, mut count) = (ErrorSums::default(), ErrorSums::default(), Vec::new(), 0);
        let mut start = 0;
        for clip in windows.clips() {
            let end = start + clip.frames.len();
            let centres: Vec<usize> = (start..end).step_by(stride).collect();
            let mut sums = ErrorSums::default();
            for part in centres.chunks(CHUNK) {
                let rows = windows.gather(&self.statistics, part)?;
                let decoded = self.decode(&self.encode_windows(rows.clone())?)?;
                let mut expected: Vec<f64> = rows.into_iter().map(f64::from).collect();
                self.statistics.denormalize(&mut expected);
                let pairs = expected.chunks_exact(size).zip(decoded.chunks_exact(size));
                for (i, (e, g)) in pairs.enumerate() {
                    sums.add(&self.layout, e, g);
                    if i % samples == self.windows().half_width {
                        centre.add(&self.layout, e, g);
                    }
                }
            }
            count += centres.len();
            all.merge(&sums);
            clips.push((clip.name.clone(), sums.mean()));
            start = end;
        }
        clips.sort_by(|a, b| b.1.joints_deg.total_cmp(&a.1.joints_deg));
        Ok(ReconstructionReport { windows: count, window: all.mean(), centre: centre.mean(), clips })
    }

    fn encode_windows(&self, rows: Vec<f32>) -> Result<Vec<f32>, RepresentationError> {
        self.coder.encode(rows, [self.windows().window().len(), self.layout.size()])
    }

    /// Writes the prior, all at once or not at all.
    pub fn save(&self, path: &Path) -> Result<(), RepresentationError> {
        let mut checkpoint = Checkpoint::new();
        self.save_into(&mut checkpoint)?;
        Ok(checkpoint.save(path)?)
    }

    /// Reads a prior.
    ///
    /// # Errors
    /// A damaged file, one that is no prior, or a plan out of range.
    pub fn load(path: &Path) -> Result<Self, RepresentationError> {
        Self::load_from(&Checkpoint::load(path)?)
    }

    /// Returns whether a file holds a prior of any kind.
    pub fn is_in(checkpoint: &Checkpoint) -> bool {
        checkpoint.meta::<String>("kind").is_ok_and(|kind| PriorPlan::is_kind(&kind))
    }

    pub(super) fn save_into(&self, checkpoint: &mut Checkpoint) -> Result<(), RepresentationError> {
        checkpoint.set_meta("kind", &self.plan.kind())?;
        checkpoint.set_meta("layout", &self.layout)?;
        checkpoint.set_meta("plan", &self.plan)?;
        self.statistics.save_into(checkpoint)?;
        self.coder.save_into(checkpoint)
    }

    pub(super) fn load_from(checkpoint: &Checkpoint) -> Result<Self, RepresentationError> {
        let kind: String = checkpoint.meta("kind")?;
        let Some(plan) = PriorPlan::load_from(checkpoint, &kind)? else {
            return Err(RepresentationError::mismatch("file", "a motion prior", kind));
        };
        let layout: FeatureLayout = checkpoint.meta("layout")?;
        let statistics = FeatureStatistics::load_from(checkpoint, layout.size())?;
        let coder = Coder::load_from(&plan, checkpoint, layout.size())?;
        Ok(Self { plan, layout, statistics, coder })
    }
}
