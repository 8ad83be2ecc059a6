//! A clip to rows.

use std::f64::consts::PI;

use lifelike_character::Vec3;
use lifelike_character::rotation::{Turn, heading_angle};
use lifelike_motion::resample::{locate, slerp};
use lifelike_motion::{MotionClip, MotionError};

use super::{FeatureMatrix, RepresentationSpec};
use crate::GenerationError;

impl FeatureMatrix {
    /// Returns the rows of a clip of any rate, its joints matched BY NAME.
    ///
    /// Root velocity and yaw rate of a row lead to the next row, so that sums bring the path back exactly. The last
    /// row repeats them. Joint velocities are the clip's difference over one row's time around it.
    ///
    /// # Errors
    /// [`MotionError::Unfit`] for an inconsistent clip, [`GenerationError::Input`] for other joints than the spec's.
    pub fn from_clip(clip: &MotionClip, spec: &RepresentationSpec) -> Result<Self, GenerationError> {
        clip.check()?;
        spec.check()?;
        let columns = columns(clip, spec)?;
        let step = 1.0 / spec.fps;
        let n = (clip.seconds() * spec.fps + 1e-6).floor() as usize + 1;
        let (mut rows, mut joints) = (vec![0.0_f32; n * spec.width()], [vec![], vec![], vec![]]);
        let roots: Vec<_> = (0..n).map(|i| root_at(clip, i as f64 * step)).collect();
        for (i, row) in rows.chunks_exact_mut(spec.width()).enumerate() {
            let (position, orientation) = &roots[i];
            row[RepresentationSpec::HEIGHT] = position.z as f32;
            // The last row has no next one.
            let (a, b) = (i.min(n.saturating_sub(2)), (i + 1).min(n - 1));
            let headings = [a, b].map(|i| heading_angle(&roots[i].1));
            let way = Turn::by(headings[0]).inverse().apply((roots[b].0 - roots[a].0) * spec.fps);
            row[RepresentationSpec::VELOCITY].copy_from_slice(&[way.x as f32, way.y as f32]);
            row[RepresentationSpec::YAW_RATE] = (shorter(headings[1] - headings[0]) * spec.fps) as f32;
            let up = orientation.inverse() * Vec3::z();
            row[RepresentationSpec::UP].copy_from_slice(&[up.x as f32, up.y as f32, up.z as f32]);
            let time = i as f64 * step;
            let around = [(time - step / 2.0).max(0.0), time, (time + step / 2.0).min(clip.seconds())];
            for (joints, time) in joints.iter_mut().zip(around) {
                joints_at(clip, &columns, time, joints);
            }
            let [before, here, after] = &joints;
            let rate = if around[2] > around[0] { 1.0 / (around[2] - around[0]) } else { 0.0 };
            row[spec.angles()].iter_mut().zip(here).for_each(|(out, q)| *out = *q as f32);
            let velocities = before.iter().zip(after).map(|(a, b)| ((b - a) * rate) as f32);
            row[spec.velocities()].iter_mut().zip(velocities).for_each(|(out, v)| *out = v);
        }
        Self::new(rows, spec.width())
    }
}

/// Returns the clip's column of every joint of the spec.
fn columns(clip: &MotionClip, spec: &RepresentationSpec) -> Result<Vec<usize>, GenerationError> {
    let lacks = |has: &[String], wanted: &[String]| -> Vec<String> {
        wanted.iter().filter(|name| !has.contains(name)).cloned().collect()
    };
    let missing = lacks(&clip.joint_names, &spec.joint_names);
    let unknown = lacks(&spec.joint_names, &clip.joint_names);
    if !missing.is_empty() || !unknown.is_empty() {
        let message = format!("joints missing in the clip: {missing:?}; unknown to the representation: {unknown:?}");
        return Err(MotionError::Unfit { clip: clip.name.clone(), message }.into());
    }
    Ok(spec.joint_names.iter().filter_map(|name| clip.joint_names.iter().position(|n| n == name)).collect())
}

fn root_at(clip: &MotionClip, time: f64) -> (Vec3, lifelike_character::Quat) {
    let (before, share) = locate(time * clip.fps, clip.len());
    let after = (before + 1).min(clip.len() - 1);
    let position = clip.root_position[before].lerp(&clip.root_position[after], share);
    (position, slerp(&clip.root_orientation[before], &clip.root_orientation[after], share))
}

fn joints_at(clip: &MotionClip, columns: &[usize], time: f64, out: &mut Vec<f64>) {
    let (before, share) = locate(time * clip.fps, clip.len());
    let (a, b) = (clip.joints_at(before), clip.joints_at((before + 1).min(clip.len() - 1)));
    out.clear();
    out.extend(columns.iter().map(|&c| a[c] + (b[c] - a[c]) * share));
}

/// Returns the angle in −π..π that is the same turn.
fn shorter(angle: f64) -> f64 {
    angle - 2.0 * PI * (angle / (2.0 * PI)).round()
}
