//! A body is held by the ground or it falls: heights of a motion in which neither is so, put right.

use crate::contacts::{free_fall, runs};
use crate::retarget::smooth::smooth;

/// Share of frames that may reach below the motion's level: the others lift it as a whole.
const LOWEST: f64 = 0.1;
/// Heights that differ from the level by less than this (m) stay: soles that roll are not to be pressed flat.
const SLACK: f64 = 0.005;
/// Above this height over the level (m) nothing stands.
const LEFT: f64 = 0.015;
/// Share of the frames above it in which a body falls freely, from which they are a jump or a run.
const FALLING: f64 = 0.3;
/// Standard deviation over which the shift is smoothed (s).
const SMOOTH: f64 = 0.05;

/// Returns the height to raise each frame's root by (m), so that its lower sole is on the ground to half a centimetre.
/// A body in flight is not raised. `soles` are heights of the lowest corner of all soles, `roots` heights of the root.
/// A flight keeps its shape: over it the shift goes linearly from where it left the ground to where it lands.
pub fn support_shift(soles: &[f64], roots: &[f64], fps: f64) -> Vec<f64> {
    let falling = free_fall(roots, fps);
    let mut sorted = soles.to_vec();
    sorted.sort_by(f64::total_cmp);
    let level = sorted.get((LOWEST * sorted.len() as f64) as usize).copied().filter(|z| z.is_finite()).unwrap_or(0.0);
    let left: Vec<bool> = soles.iter().map(|z| z - level > LEFT).collect();
    let mut shift: Vec<f64> = soles.iter().map(|z| -level - (z - level - (z - level).clamp(-SLACK, SLACK))).collect();
    for (start, stop) in runs(&left, true) {
        let freely = falling[start..stop].iter().filter(|falling| **falling).count() as f64;
        if freely < FALLING * (stop - start) as f64 {
            continue;
        }
        // What is in the air at an end of the clip goes as its other end does.
        let (before, after) = (start.checked_sub(1).map(|t| shift[t]), shift.get(stop).copied());
        let (from, to) = (before.or(after).unwrap_or(0.0), after.or(before).unwrap_or(0.0));
        let steps = (stop - start + 1) as f64;
        for (k, shift) in shift[start..stop].iter_mut().enumerate() {
            *shift = from + (to - from) * (k + 1) as f64 / steps;
        }
    }
    smooth(&shift, SMOOTH * fps)
}

#[cfg(test)]
mod tests {
    use super::*;

    const FPS: f64 = 50.0;

    #[test]
    fn what_floats_comes_down_and_what_flies_does_not() {
        // A second on the ground, a jump of 0.4 s, a second on the ground; then a second 3 cm above it.
        let jump = |t: f64| if (1.0..1.4).contains(&t) { 0.5 * 9.81 * (t - 1.0) * (1.4 - t) } else { 0.0 };
        let time = |i: usize| i as f64 / FPS;
        let soles: Vec<f64> = (0..170).map(|i| jump(time(i)) + if i >= 120 { 0.03 } else { 0.0 }).collect();
        let roots: Vec<f64> = soles.iter().map(|z| 0.4 + z).collect();
        let shift = support_shift(&soles, &roots, FPS);
        let after: Vec<f64> = soles.iter().zip(&shift).map(|(z, s)| z + s).collect();
        for (i, z) in after.iter().enumerate() {
            let far = (120_usize.abs_diff(i)) as f64 / FPS > 3.0 * SMOOTH;
            assert!(!far || (z - jump(time(i))).abs() < SLACK + 2e-3, "{z} at {}", time(i));
        }
        assert!(after.iter().fold(0.0_f64, |most, z| most.max(*z)) > 0.19);
        assert!(after[130..].iter().all(|z| z.abs() < SLACK + 2e-3));
    }

    #[test]
    fn a_slow_rise_is_no_jump() {
        // As high as a jump, in two seconds: nothing holds the body up there.
        let soles: Vec<f64> = (0..100).map(|i| 0.2 * (std::f64::consts::PI * f64::from(i) / 99.0).sin()).collect();
        let shift = support_shift(&soles, &soles, FPS);
        assert!(soles.iter().zip(&shift).all(|(z, s)| (z + s).abs() < SLACK + 2e-3));
        assert!(support_shift(&[], &[], FPS).is_empty());
    }
}
