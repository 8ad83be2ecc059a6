//! Calmer: without what is faster than a cutoff, and without delay.

use lifelike_character::{Anatomy, Character, Quat, Vec3};

use super::joints::{column, columns, set_column};
use super::path::continuous;
use super::restyle::settle;
use super::story::{provenance, unfit};
use crate::clip::MotionClip;
use crate::error::MotionError;
use crate::retarget::{RetargetOptions, smooth as zero_phase};

/// The widest window (s, standard deviation): wider than any gesture.
const WIDEST: f64 = 60.0;

/// Returns the clip with some joints smoothed by a zero-phase Gaussian low pass that lets half of the power through at
/// `cutoff` (Hz). When `joints` are all of the clip's, the root is smoothed with them. If root or legs change, the
/// soles that stood are put back on the ground.
///
/// # Errors
/// [`MotionError::Unfit`] for a cutoff that is not positive, or joints that are not there; [`MotionError::Mismatch`]
/// for a clip of another character.
pub fn smooth(
    clip: &MotionClip,
    character: &Character,
    anatomy: &Anatomy,
    joints: &[String],
    cutoff: f64,
    options: &RetargetOptions,
) -> Result<MotionClip, MotionError> {
    clip.check()?;
    let columns = columns(clip, joints)?;
    let mut out = clip.clone();
    for &at in &columns {
        let smoothed = low_pass(clip, &column(clip, at), cutoff)?;
        set_column(&mut out, at, &smoothed);
    }
    if (0..clip.joint_names.len()).all(|at| columns.contains(&at)) {
        smooth_root(&mut out, clip, cutoff)?;
    }
    let done = format!("'{}' with {} smoothed at {cutoff} Hz", clip.name, joints.join(", "));
    out.provenance = provenance(&[clip], done, clip.provenance.captions.clone());
    settle(clip, out, character, anatomy, options)
}

/// Returns the whole clip, root and all joints, without what is faster than `cutoff` (Hz), its soles where that takes them: for motion out of
/// physics, whose soles roll and slide as they do.
///
/// # Errors
/// [`MotionError::Unfit`] for a cutoff that is not positive, or a clip that is not consistent.
pub fn low_passed(clip: &MotionClip, cutoff: f64) -> Result<MotionClip, MotionError> {
    clip.check()?;
    let mut out = clip.clone();
    for at in 0..clip.joint_names.len() {
        set_column(&mut out, at, &low_pass(clip, &column(clip, at), cutoff)?);
    }
    smooth_root(&mut out, clip, cutoff)?;
    continuous(&mut out.root_orientation);
    Ok(out)
}

fn smooth_root(out: &mut MotionClip, clip: &MotionClip, cutoff: f64) -> Result<(), MotionError> {
    let mut turns = clip.root_orientation.clone();
    continuous(&mut turns);
    let place = |axis: usize| low_pass(clip, &clip.root_position.iter().map(|p| p[axis]).collect::<Vec<_>>(), cutoff);
    let turn = |axis: usize| low_pass(clip, &turns.iter().map(|q| q.coords[axis]).collect::<Vec<_>>(), cutoff);
    let ([x, y, z], [i, j, k, w]) = ([place(0)?, place(1)?, place(2)?], [turn(0)?, turn(1)?, turn(2)?, turn(3)?]);
    for t in 0..clip.len() {
        out.root_position[t] = Vec3::new(x[t], y[t], z[t]);
        out.root_orientation[t] = Quat::new_normalize(nalgebra::Quaternion::new(w[t], i[t], j[t], k[t]));
    }
    Ok(())
}

/// Returns a signal at the clip's rate without what is faster than `cutoff` (Hz).
pub(super) fn low_pass(clip: &MotionClip, signal: &[f64], cutoff: f64) -> Result<Vec<f64>, MotionError> {
    // A Gaussian of standard deviation s has the gain exp(-(2 pi f s)^2 / 2), which is 1/sqrt(2) at f = sqrt(ln 2) / (2 pi s).
    let sigma = std::f64::consts::LN_2.sqrt() / (std::f64::consts::TAU * cutoff);
    if !(sigma > 0.0 && sigma < WIDEST) {
        let message = format!(
            "expected a cutoff above {:.4} Hz, got {cutoff}",
            std::f64::consts::LN_2.sqrt() / (std::f64::consts::TAU * WIDEST)
        );
        return Err(unfit(clip, message));
    }
    Ok(zero_phase::smooth(signal, sigma * clip.fps))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::fixtures::clip;

    #[test]
    fn half_of_the_power_is_left_at_the_cutoff_and_nothing_is_late() {
        let c = clip(401, |_| [0.0, 0.0]);
        let wave = |i: usize| (std::f64::consts::TAU * 2.0 * i as f64 / 50.0).sin();
        let signal: Vec<f64> = (0..401).map(wave).collect();
        let out = low_pass(&c, &signal, 2.0).unwrap();
        for i in 100..300 {
            assert!((out[i] - wave(i) * std::f64::consts::FRAC_1_SQRT_2).abs() < 5e-3, "{i}: {} {}", out[i], wave(i));
        }
        for cutoff in [0.0, -1.0, f64::NAN, 1e-6] {
            assert!(low_pass(&c, &signal, cutoff).is_err(), "{cutoff}");
        }
    }
}
