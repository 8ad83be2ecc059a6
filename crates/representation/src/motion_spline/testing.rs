//! Clips and models for the tests of this folder.
#![allow(clippy::unwrap_used)]

use lifelike_character::{Quat, Vec3};
use lifelike_motion::{Contacts, MotionClip, Provenance};

use super::model::{MotionSpline, SplitClips};
use super::plan::MotionSplinePlan;
use crate::spline_transformer::{SequencePlan, SequenceTrainer};

/// Walks in a circle at half a metre per second, turning at 0.3 rad/s; two joints swing.
pub(super) fn walk(name: &str, frames: usize, fps: f64) -> MotionClip {
    let time = |frame: usize| frame as f64 / fps;
    let heading = |t: f64| 0.4 + 0.3 * t;
    let place = |t: f64| {
        let (radius, angle) = (0.5 / 0.3, heading(t));
        Vec3::new(radius * angle.sin(), -radius * angle.cos(), 0.6 + 0.02 * (6.0 * t).sin())
    };
    let turn = |t: f64| {
        Quat::from_axis_angle(&Vec3::z_axis(), heading(t))
            * Quat::from_scaled_axis(Vec3::new(0.05 * (3.0 * t).sin(), 0.1, 0.0))
    };
    MotionClip {
        name: name.into(),
        fps,
        joint_names: vec!["left".into(), "right".into()],
        root_position: (0..frames).map(|f| place(time(f))).collect(),
        root_orientation: (0..frames).map(|f| turn(time(f))).collect(),
        joints: (0..frames).flat_map(|f| [(3.0 * time(f)).sin(), -(3.0 * time(f)).sin()]).collect(),
        contacts: Some(Contacts { names: vec!["foot".into()], flags: (0..frames).map(|f| f % 3 == 0).collect() }),
        cyclic: false,
        provenance: Provenance::default(),
    }
}

/// Returns a network that was never trained: what must hold for any network holds for it.
pub(super) fn model() -> MotionSpline {
    model_of(walk("walk", 300, 50.0))
}

/// Returns the same with one training clip.
pub(super) fn model_of(clip: MotionClip) -> MotionSpline {
    let training = SequencePlan { latent: 5, layers: 1, heads: 2, width: 8, ..SequencePlan::default() };
    let plan = MotionSplinePlan {
        robot: "nobody".into(),
        clips: Vec::new(),
        mirror: false,
        validation: Vec::new(),
        test: Vec::new(),
        frame_rate: 25.0,
        frames: 50,
        training,
    };
    let clips = SplitClips { training: vec![clip], ..SplitClips::default() };
    let (data, space) = MotionSpline::data(&plan, &clips).unwrap();
    let trainer = SequenceTrainer::new(plan.training.clone(), data).unwrap();
    MotionSpline::new(plan, space, &trainer).unwrap()
}
