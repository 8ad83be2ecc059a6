//! A trained network with everything that it needs to be used: names, rate, scales, as one file (`*.spline.safetensors`).

use std::path::Path;

use lifelike_checkpoint::Checkpoint;
use lifelike_motion::MotionClip;
use lifelike_nn::transformer::passes::PassError;
use lifelike_nn::transformer::{Sampling, SplineAutoencoder};

use super::plan::MotionSplinePlan;
use super::poses::Poses;
use super::space::{PoseSpace, poses_of};
use crate::spline_transformer::passes::{control_points, sequences};
use crate::spline_transformer::{Recording, RecordingWindows, SequenceTrainer, Sequences, Split};
use crate::standardizer::Moments;
use crate::{FromInput, RepresentationError};

/// In files.
const KIND: &str = "motion spline";

/// A network that makes control points of a robot's motion, and motion of control points.
#[derive(Debug, Clone)]
pub struct MotionSpline {
    plan: MotionSplinePlan,
    space: PoseSpace,
    usual: Usual,
    network: SplineAutoencoder,
}

/// Mean and standard deviation of the training windows' control points: the unit of edits.
///
/// # Shapes
/// Both `[control points][latent]`.
#[derive(Debug, Clone, PartialEq)]
pub struct Usual {
    /// Mean of each number.
    pub mean: Vec<Vec<f32>>,
    /// Standard deviation of each number.
    pub deviation: Vec<Vec<f32>>,
}

/// Training windows that this is taken of.
const USUAL_OF: usize = 1024;

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
    /// Returns the training data: rows of all clips at the plan's rate, and what their numbers are, by the training
    /// clips' statistics.
    ///
    /// # Errors
    /// Clips with other joints than the first; none as long as a segment; a plan out of range.
    pub fn data(
        plan: &MotionSplinePlan,
        clips: &SplitClips,
    ) -> Result<(RecordingWindows, PoseSpace), RepresentationError> {
        plan.check()?;
        let joints = clips.training.first().map(|clip| clip.joint_names.clone()).unwrap_or_default();
        let poses = |clips: &[MotionClip]| -> Result<Vec<(String, Poses)>, RepresentationError> {
            clips.iter().map(|clip| Ok((clip.name.clone(), poses_of(clip, &joints, plan.frame_rate)?))).collect()
        };
        let all = [poses(&clips.training)?, poses(&clips.validation)?, poses(&clips.test)?];
        let space = PoseSpace::of(joints.clone(), all[0].iter().map(|(_, poses)| poses));
        let [training, validation, test] = all.map(|all| {
            all.into_iter().map(|(name, poses)| Recording { name, rows: space.normalized(&poses.rows) }).collect()
        });
        let what = format!("{} at {} Hz", plan.robot, plan.frame_rate);
        let split = Split { training, validation, test };
        Ok((RecordingWindows::new(&what, space.width(), plan.frames, plan.training.seed, split)?, space))
    }

    /// Returns the model of a training on [`Self::data`].
    ///
    /// # Errors
    /// Windows that cannot be made.
    pub fn new(
        plan: MotionSplinePlan,
        space: PoseSpace,
        trainer: &SequenceTrainer<RecordingWindows>,
    ) -> Result<Self, RepresentationError> {
        // The first batch there is: windows drawn evenly from all training clips.
        let windows = trainer.data().batch(0, USUAL_OF);
        let network = trainer.network().clone();
        let control = control_points(&network, &windows, [plan.frames, space.width()])?;
        let latent = plan.training.latent;
        let size = network.tokens().control_points() * latent;
        let mut moments = Moments::new(size);
        control.chunks_exact(size).for_each(|points| moments.add(points.iter().copied().map(f64::from)));
        let rows = |numbers: Vec<f64>| {
            numbers.chunks_exact(latent).map(|row| row.iter().map(|x| *x as f32).collect()).collect()
        };
        let (mean, deviation) = moments.finish();
        Ok(Self { plan, space, usual: Usual { mean: rows(mean), deviation: rows(deviation) }, network })
    }

    /// Returns the plan it was trained by.
    pub fn plan(&self) -> &MotionSplinePlan {
        &self.plan
    }

    /// Joints by name, in its order.
    pub fn joints(&self) -> &[String] {
        self.space.joints()
    }

    /// Returns the numbers of a control point.
    pub fn latent(&self) -> usize {
        self.plan.training.latent
    }

    /// Returns control points of a segment.
    pub fn control_points(&self) -> usize {
        self.network.tokens().control_points()
    }

    /// Returns the time between neighbouring control points (s).
    pub fn spacing(&self) -> f64 {
        let length = (self.plan.frames - 1) as f64 / self.plan.frame_rate;
        length / (self.control_points() - 1) as f64
    }

    /// Returns the mean and standard deviation of the training windows' control points.
    pub fn usual(&self) -> &Usual {
        &self.usual
    }

    /// Returns the clip's poses, joints in this model's order, at a rate (Hz).
    pub(super) fn poses(&self, clip: &MotionClip, fps: f64) -> Result<Poses, RepresentationError> {
        poses_of(clip, self.space.joints(), fps)
    }

    /// Returns control points of segments.
    ///
    /// # Shapes
    /// Poses `[segments, frames, width]` (SI) to `[segments, control points, latent]`.
    pub(super) fn control(&self, rows: &[f64]) -> Result<Vec<f32>, RepresentationError> {
        control_points(&self.network, &self.space.normalized(rows), [self.plan.frames, self.space.width()])
    }

    /// Poses of one segment.
    ///
    /// # Shapes
    /// `[control points, latent]` to `[sampling, width]` (SI).
    pub(super) fn poses_at(
        &self,
        control_points: &[f32],
        sampling: &Sampling,
    ) -> Result<Vec<f64>, RepresentationError> {
        let y = sequences(&self.network, control_points, sampling)?;
        Ok(self.space.denormalized(&y))
    }

    /// Returns the latent curve of control points.
    ///
    /// # Shapes
    /// `[control points, latent]` to `[samples, latent]`.
    pub(super) fn curve(&self, control_points: &[f32], samples: usize) -> Result<Vec<f32>, RepresentationError> {
        let sampling = Sampling::even(self.plan.frames, samples);
        let curve = self.network.tokens().tokens(control_points, self.latent(), &sampling);
        Ok(curve.map_err(PassError::from)?)
    }

    /// Writes it, all at once or not at all.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn save(&self, path: &Path) -> Result<(), RepresentationError> {
        let mut checkpoint = Checkpoint::new();
        checkpoint.set_meta("kind", &KIND)?;
        checkpoint.set_meta("plan", &self.plan)?;
        self.space.save_into(&mut checkpoint)?;
        for (name, rows) in [("mean", &self.usual.mean), ("deviation", &self.usual.deviation)] {
            let numbers = rows.iter().flatten().copied().collect();
            checkpoint.put_f32(name, &[self.control_points(), self.latent()], numbers)?;
        }
        self.network.parameters().save_into(&mut checkpoint, "network")?;
        Ok(checkpoint.save(path)?)
    }

    /// Reads it.
    ///
    /// # Errors
    /// A damaged file, one that is none, or a plan out of range.
    pub fn load(path: &Path) -> Result<Self, RepresentationError> {
        let checkpoint = Checkpoint::load(path)?;
        let kind: String = checkpoint.meta("kind")?;
        if kind != KIND {
            return Err(RepresentationError::mismatch(path.display(), format!("a {KIND}"), kind));
        }
        let plan: MotionSplinePlan = checkpoint.meta("plan")?;
        plan.check()?;
        let space = PoseSpace::load_from(&checkpoint)?;
        let network = plan.training.network(space.width()).init(0, "loaded")?;
        let parameters = network.parameters().load_from(&checkpoint, "network")?;
        let network = network.with_parameters(parameters);
        let (points, latent) = (network.tokens().control_points(), plan.training.latent);
        let rows = |name: &str| -> Result<Vec<Vec<f32>>, RepresentationError> {
            Ok(checkpoint.f32s(name, &[points, latent])?.chunks_exact(latent).map(<[f32]>::to_vec).collect())
        };
        let usual = Usual { mean: rows("mean")?, deviation: rows("deviation")? };
        Ok(Self { plan, space, usual, network })
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::super::splined::{Segment, SplinedClip};
    use super::super::testing::{model, model_of, walk};
    use super::*;

    fn encoded(model: &MotionSpline, clip: &MotionClip) -> SplinedClip {
        SplinedClip::encode(model, clip).unwrap()
    }

    #[test]
    fn a_file_is_the_model() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("m.spline.safetensors");
        let model = model();
        model.save(&path).unwrap();
        let loaded = MotionSpline::load(&path).unwrap();
        let clip = walk("walk", 120, 50.0);
        assert_eq!(encoded(&loaded, &clip).segments(), encoded(&model, &clip).segments());
        assert_eq!((loaded.usual(), loaded.joints(), loaded.plan()), (model.usual(), model.joints(), model.plan()));
        assert_eq!(encoded(&loaded, &clip).errors(&loaded).unwrap(), encoded(&model, &clip).errors(&model).unwrap());
    }

    #[test]
    fn what_is_usual_is_that_of_training_windows() {
        // As long as a segment, so there is one window only.
        let clip = walk("walk", 50, 25.0);
        let model = model_of(clip.clone());
        let splined = encoded(&model, &clip);
        let own = &splined.segments()[0].control_points;
        let near = |a: &[Vec<f32>], b: &[Vec<f32>]| {
            a.iter().flatten().zip(b.iter().flatten()).all(|(a, b)| (a - b).abs() < 1e-4)
        };
        assert!(near(&model.usual().mean, own), "{:?} {own:?}", model.usual());
        assert!(model.usual().deviation.iter().flatten().all(|d| *d < 1e-4), "{:?}", model.usual());
        // With more windows they differ, and lie about the mean within a few deviations.
        let model = super::super::testing::model();
        let Usual { mean, deviation } = model.usual();
        let std: Vec<f32> = deviation.iter().flatten().copied().collect();
        assert!(std.iter().any(|d| *d > 1e-3), "{std:?}");
        let splined = encoded(&model, &walk("walk", 300, 50.0));
        for segment in splined.segments() {
            let away = segment.control_points.iter().flatten().zip(mean.iter().flatten()).zip(&std);
            assert!(away.clone().all(|((p, m), d)| (p - m).abs() < 6.0 * d + 1e-3), "{:?}", away.collect::<Vec<_>>());
        }
    }

    #[test]
    fn joints_go_by_name_and_others_are_refused() {
        let model = model();
        let clip = walk("walk", 80, 50.0);
        let mut turned = clip.clone();
        turned.joint_names.reverse();
        turned.joints = clip.joints.chunks_exact(2).flat_map(|pair| [pair[1], pair[0]]).collect();
        assert_eq!(encoded(&model, &turned).segments(), encoded(&model, &clip).segments());
        turned.joint_names[0] = "nose".into();
        let error = SplinedClip::encode(&model, &turned).unwrap_err().to_string();
        assert!(error.contains("clip 'walk'") && error.contains("nose"), "{error}");
    }

    #[test]
    fn curves_begin_and_end_at_control_points() {
        let model = model();
        let splined = encoded(&model, &walk("walk", 120, 50.0));
        let segment = &splined.segments()[0];
        let curve = segment.curve(&model, 7).unwrap();
        assert_eq!(curve.len(), 7);
        for (at, point) in [(0, 0), (6, 3)] {
            let near = curve[at].iter().zip(&segment.control_points[point]).all(|(a, b)| (a - b).abs() < 1e-5);
            assert!(near, "a cubic Bezier curve passes through its ends");
        }
        let other = Segment { start: 0.0, control_points: vec![vec![1.0]; 4] };
        assert!(other.curve(&model, 3).unwrap_err().to_string().contains("4 numbers"));
    }
}
