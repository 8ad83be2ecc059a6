//! A trained network with everything that it needs to be used: names, rate, scales, as one file (`*.spline.safetensors`).

use std::path::Path;

use burn::module::Module;
use burn::tensor::{Tensor, TensorData};
use lifelike_motion::MotionClip;
use lifelike_nn::checkpoint::Checkpoint;
use lifelike_nn::device;
use lifelike_nn::numbers::read;
use lifelike_nn::transformer::backprop::PassError;
use lifelike_nn::transformer::{Sampling, SplineAutoencoder};

use super::plan::MotionSplinePlan;
use super::poses::Poses;
use super::space::{PoseSpace, poses_of};
use super::splined::{Segment, SplinedClip};
use crate::LearnError;
use crate::representation::spline_transformer::{Recording, SequenceTrainer, Sequences, Split, Windows};

/// In files.
const KIND: &str = "motion spline";

/// How well a clip comes back from control points alone, without the detail that editing carries along.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct ClipErrors {
    /// The clip.
    pub clip: String,
    /// Frames.
    pub frames: usize,
    /// Root mean square error of joints (deg).
    pub joints_deg: f64,
    /// Of the root's height (mm).
    pub height_mm: f64,
    /// Of the velocity over the ground (m/s).
    pub velocity: f64,
}

/// A network that makes control points of a robot's motion, and motion of control points.
#[derive(Debug, Clone)]
pub struct MotionSpline {
    plan: MotionSplinePlan,
    space: PoseSpace,
    /// Where each control point lies on average over training windows.
    mean: Vec<Vec<f32>>,
    network: SplineAutoencoder,
}

/// Training windows that the mean control points are taken of.
const MEAN_OF: usize = 1024;

/// Clips by what they are for, as in [`Split`].
#[derive(Debug, Clone, Default)]
pub struct SplitClips {
    /// To train on.
    pub training: Vec<MotionClip>,
    /// For the curve of the loss.
    pub validation: Vec<MotionClip>,
    /// For the errors at the end.
    pub test: Vec<MotionClip>,
}

impl MotionSpline {
    /// What to train on: rows of all clips at the plan's rate, and what their numbers are, by the training clips' statistics.
    ///
    /// # Errors
    /// Clips with other joints than the first; none as long as a segment; a plan out of range.
    pub fn data(plan: &MotionSplinePlan, clips: &SplitClips) -> Result<(Windows, PoseSpace), LearnError> {
        plan.check()?;
        let joints = clips.training.first().map(|clip| clip.joint_names.clone()).unwrap_or_default();
        let poses = |clips: &[MotionClip]| -> Result<Vec<(String, Poses)>, LearnError> {
            clips.iter().map(|clip| Ok((clip.name.clone(), poses_of(clip, &joints, plan.frame_rate)?))).collect()
        };
        let all = [poses(&clips.training)?, poses(&clips.validation)?, poses(&clips.test)?];
        let space = PoseSpace::of(joints.clone(), all[0].iter().map(|(_, poses)| poses));
        let [training, validation, test] = all.map(|all| {
            all.into_iter().map(|(name, poses)| Recording { name, rows: space.normalized(&poses.rows) }).collect()
        });
        let what = format!("{} at {} Hz", plan.robot, plan.frame_rate);
        let split = Split { training, validation, test };
        Ok((Windows::new(&what, space.width(), plan.frames, plan.training.seed, split)?, space))
    }

    /// What a training on [`Self::data`] has learned.
    ///
    /// # Errors
    /// The device does not hand out its numbers.
    pub fn new(
        plan: MotionSplinePlan,
        space: PoseSpace,
        trainer: &SequenceTrainer<Windows>,
    ) -> Result<Self, LearnError> {
        // The first batch there is: windows drawn evenly from all training clips.
        let (control, _) = trainer.reconstruct(&trainer.data().batch(0, MEAN_OF))?;
        let latent = plan.training.latent;
        let unit = control.len() / MEAN_OF;
        let mean: Vec<f32> = (0..unit)
            .map(|k| control.iter().skip(k).step_by(unit).map(|x| f64::from(*x)).sum::<f64>() / MEAN_OF as f64)
            .map(|mean| mean as f32)
            .collect();
        let mean = mean.chunks_exact(latent).map(<[f32]>::to_vec).collect();
        Ok(Self { plan, space, mean, network: trainer.network().valid().fork(&device::inference()) })
    }

    /// The plan it was trained by.
    pub fn plan(&self) -> &MotionSplinePlan {
        &self.plan
    }

    /// Joints by name, in its order.
    pub fn joints(&self) -> &[String] {
        self.space.joints()
    }

    /// Numbers of a control point.
    pub fn latent(&self) -> usize {
        self.plan.training.latent
    }

    /// Control points of a segment.
    pub fn control_points(&self) -> usize {
        self.network.tokens().control_points()
    }

    /// Where each control point lies on average over training windows.
    ///
    /// # Shapes
    /// `[control points][latent]`.
    pub fn mean(&self) -> &[Vec<f32>] {
        &self.mean
    }

    /// A clip as control points.
    ///
    /// # Errors
    /// A clip of other joints, or one that is broken.
    pub fn encode(&self, clip: &MotionClip) -> Result<SplinedClip, LearnError> {
        SplinedClip::of(self, clip)
    }

    /// The clip's poses, joints in this model's order, at a rate (Hz).
    pub(super) fn poses(&self, clip: &MotionClip, fps: f64) -> Result<Poses, LearnError> {
        poses_of(clip, self.space.joints(), fps)
    }

    /// Control points of segments.
    ///
    /// # Shapes
    /// Poses `[segments, frames, width]` (SI) to `[segments, control points, latent]`.
    pub(super) fn control(&self, rows: &[f64]) -> Result<Vec<f32>, LearnError> {
        let (tokens, width) = (self.plan.frames, self.space.width());
        let x = self.space.normalized(rows);
        let shape = [x.len() / (tokens * width), tokens, width];
        let x = Tensor::from_data(TensorData::new(x, shape), &device::inference());
        Ok(read(self.network.encode(x))?)
    }

    /// Poses of one segment.
    ///
    /// # Shapes
    /// `[control points, latent]` to `[sampling, width]` (SI).
    pub(super) fn poses_at(&self, control_points: &[f32], sampling: &Sampling) -> Result<Vec<f64>, LearnError> {
        let shape = [1, self.control_points(), self.latent()];
        let points = Tensor::from_data(TensorData::new(control_points.to_vec(), shape), &device::inference());
        let y = self.network.decode(points, sampling).map_err(PassError::from)?;
        Ok(self.space.denormalized(&read(y)?))
    }

    /// A segment's curve in the latent space at `samples` places, evenly from its begin to its end.
    ///
    /// # Shapes
    /// `[samples][latent]`.
    ///
    /// # Errors
    /// A segment of another model.
    pub fn curve(&self, segment: &Segment, samples: usize) -> Result<Vec<Vec<f32>>, LearnError> {
        let numbers: Vec<f32> = segment.control_points.iter().flatten().copied().collect();
        if numbers.len() != self.control_points() * self.latent() {
            let expected = format!("{} control points of {} numbers", self.control_points(), self.latent());
            return Err(LearnError::Mismatch {
                what: "segment".into(),
                expected,
                got: format!("{} numbers", numbers.len()),
            });
        }
        let shape = [1, self.control_points(), self.latent()];
        let points = Tensor::from_data(TensorData::new(numbers, shape), &device::inference());
        let curve = self
            .network
            .tokens()
            .tokens(points, &Sampling::even(self.plan.frames, samples))
            .map_err(PassError::from)?;
        Ok(read(curve)?.chunks_exact(self.latent()).map(<[f32]>::to_vec).collect())
    }

    /// How well clips come back from control points alone, each at its own rate.
    ///
    /// # Errors
    /// As [`Self::encode`].
    pub fn errors(&self, clips: &[MotionClip]) -> Result<Vec<ClipErrors>, LearnError> {
        clips.iter().map(|clip| self.encode(clip)?.errors(self)).collect()
    }

    /// Writes it, all at once or not at all.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn save(&self, path: &Path) -> Result<(), LearnError> {
        let mut checkpoint = Checkpoint::new();
        checkpoint.set_meta("kind", &KIND)?;
        checkpoint.set_meta("plan", &self.plan)?;
        self.space.save_into(&mut checkpoint)?;
        let mean = self.mean.iter().flatten().copied().collect();
        checkpoint.put_f32("mean", &[self.control_points(), self.latent()], mean)?;
        checkpoint.put_module("network", &self.network)?;
        Ok(checkpoint.save(path)?)
    }

    /// Reads it.
    ///
    /// # Errors
    /// A damaged file, one that is none, or a plan out of range.
    pub fn load(path: &Path) -> Result<Self, LearnError> {
        let checkpoint = Checkpoint::load(path)?;
        let kind: String = checkpoint.meta("kind")?;
        if kind != KIND {
            let what = path.display().to_string();
            return Err(LearnError::Mismatch { what, expected: format!("a {KIND}"), got: kind });
        }
        let plan: MotionSplinePlan = checkpoint.meta("plan")?;
        plan.check()?;
        let space = PoseSpace::load_from(&checkpoint)?;
        let network = plan.training.network(space.width()).init(0, "loaded", &device::inference())?;
        let network = checkpoint.load_module("network", network)?;
        let (points, latent) = (network.tokens().control_points(), plan.training.latent);
        let mean = checkpoint.f32s("mean", &[points, latent])?.chunks_exact(latent).map(<[f32]>::to_vec).collect();
        Ok(Self { plan, space, mean, network })
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::super::testing::{model, walk};
    use super::*;

    #[test]
    fn a_file_is_the_model() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("m.spline.safetensors");
        let model = model();
        model.save(&path).unwrap();
        let loaded = MotionSpline::load(&path).unwrap();
        let clip = walk("walk", 120, 50.0);
        assert_eq!(loaded.encode(&clip).unwrap().segments(), model.encode(&clip).unwrap().segments());
        assert_eq!((loaded.mean(), loaded.joints(), loaded.plan()), (model.mean(), model.joints(), model.plan()));
        let clips = [clip];
        assert_eq!(loaded.errors(&clips).unwrap(), model.errors(&clips).unwrap());
    }

    #[test]
    fn joints_go_by_name_and_others_are_refused() {
        let model = model();
        let clip = walk("walk", 80, 50.0);
        let mut turned = clip.clone();
        turned.joint_names.reverse();
        turned.joints = clip.joints.chunks_exact(2).flat_map(|pair| [pair[1], pair[0]]).collect();
        assert_eq!(model.encode(&turned).unwrap().segments(), model.encode(&clip).unwrap().segments());
        turned.joint_names[0] = "nose".into();
        let error = model.encode(&turned).unwrap_err().to_string();
        assert!(error.contains("clip 'walk'") && error.contains("nose"), "{error}");
    }

    #[test]
    fn curves_begin_and_end_at_control_points() {
        let model = model();
        let splined = model.encode(&walk("walk", 120, 50.0)).unwrap();
        let segment = &splined.segments()[0];
        let curve = model.curve(segment, 7).unwrap();
        assert_eq!(curve.len(), 7);
        for (at, point) in [(0, 0), (6, 3)] {
            let near = curve[at].iter().zip(&segment.control_points[point]).all(|(a, b)| (a - b).abs() < 1e-5);
            assert!(near, "a cubic Bezier curve passes through its ends");
        }
        let other = Segment { start: 0.0, control_points: vec![vec![1.0]; 4] };
        assert!(model.curve(&other, 3).unwrap_err().to_string().contains("4 numbers"));
    }
}
