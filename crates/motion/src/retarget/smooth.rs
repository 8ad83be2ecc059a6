//! Zero-phase smoothing and speed limiting of whole trajectories.

use lifelike_character::rotation::{from_wxyz, to_wxyz};
use lifelike_character::{Quat, Vec3};

use super::rig::Rig;

/// Returns a Gaussian window of this standard deviation (frames), normalised; centre in the middle.
fn gaussian(sigma: f64) -> Vec<f64> {
    let radius = (3.0 * sigma).ceil() as i64;
    let raw: Vec<f64> = (-radius..=radius).map(|i| (-0.5 * (i as f64 / sigma).powi(2)).exp()).collect();
    let sum: f64 = raw.iter().sum();
    raw.into_iter().map(|w| w / sum).collect()
}

/// Smooths a signal; beyond its ends it is taken to continue as its point reflection, so slopes survive.
pub(crate) fn smooth(signal: &[f64], sigma: f64) -> Vec<f64> {
    if sigma < 0.05 || signal.len() < 3 {
        return signal.to_vec();
    }
    let window = gaussian(sigma);
    let (radius, last) = ((window.len() / 2) as i64, signal.len() as i64 - 1);
    let at = |t: i64| {
        if t < 0 {
            2.0 * signal[0] - signal[(-t).min(last) as usize]
        } else if t > last {
            2.0 * signal[last as usize] - signal[(2 * last - t).max(0) as usize]
        } else {
            signal[t as usize]
        }
    };
    (0..=last).map(|t| window.iter().enumerate().map(|(i, w)| w * at(t + i as i64 - radius)).sum()).collect()
}

/// Limits the speed (per frame) without delay: the mean of limiting forwards and backwards, which keeps the limit.
pub(crate) fn limit_speed(signal: &mut [f64], largest_step: f64) {
    let follow = |signal: &mut dyn Iterator<Item = f64>| -> Vec<f64> {
        let mut held: Option<f64> = None;
        signal
            .map(|x| {
                let next = held.map_or(x, |h| x.clamp(h - largest_step, h + largest_step));
                held = Some(next);
                next
            })
            .collect()
    };
    let forward = follow(&mut signal.iter().copied());
    let backward = follow(&mut signal.iter().rev().copied());
    for ((x, f), b) in signal.iter_mut().zip(forward).zip(backward.iter().rev()) {
        *x = 0.5 * (f + b);
    }
}

/// Smooths every coordinate of a trajectory of generalised positions.
pub(crate) fn smooth_poses(rig: &Rig, poses: &mut [Vec<f64>], sigma: f64) {
    let at = rig.root.q_index;
    continuous(poses, at + 3);
    let mut coordinates: Vec<usize> = (at..at + 7).collect();
    coordinates.extend(rig.axes.iter().map(|a| a.q));
    for c in coordinates {
        let column: Vec<f64> = poses.iter().map(|p| p[c]).collect();
        for (pose, value) in poses.iter_mut().zip(smooth(&column, sigma)) {
            pose[c] = value;
        }
    }
    for pose in poses.iter_mut() {
        let turn = orientation(pose, at);
        pose[at + 3..at + 7].copy_from_slice(&to_wxyz(&turn));
    }
}

/// Smooths how `poses` differ from `base`, leaving `base` itself as sharp as it is.
pub(crate) fn smooth_change(rig: &Rig, base: &[Vec<f64>], poses: &mut [Vec<f64>], sigma: f64) {
    let at = rig.root.q_index;
    let mut coordinates: Vec<usize> = (at..at + 3).collect();
    coordinates.extend(rig.axes.iter().map(|a| a.q));
    for c in coordinates {
        let change: Vec<f64> = poses.iter().zip(base).map(|(p, b)| p[c] - b[c]).collect();
        for ((pose, b), value) in poses.iter_mut().zip(base).zip(smooth(&change, sigma)) {
            pose[c] = b[c] + value;
        }
    }
    let turns: Vec<Vec3> = poses
        .iter()
        .zip(base)
        .map(|(p, b)| (orientation(b, at).inverse() * orientation(p, at)).scaled_axis())
        .collect();
    let smoothed: Vec<Vec<f64>> =
        (0..3).map(|i| smooth(&turns.iter().map(|t| t[i]).collect::<Vec<_>>(), sigma)).collect();
    for (t, (pose, b)) in poses.iter_mut().zip(base).enumerate() {
        let turn = Quat::from_scaled_axis(Vec3::new(smoothed[0][t], smoothed[1][t], smoothed[2][t]));
        pose[at + 3..at + 7].copy_from_slice(&to_wxyz(&(orientation(b, at) * turn)));
    }
}

/// Returns the orientation of the root in a generalised position.
pub(crate) fn orientation(pose: &[f64], root: usize) -> Quat {
    from_wxyz([pose[root + 3], pose[root + 4], pose[root + 5], pose[root + 6]]).unwrap_or_else(Quat::identity)
}

/// Returns the same with its sign kept: components as they stand, which [`continuous`] made continuous.
pub(crate) fn signed_orientation(pose: &[f64], root: usize) -> Quat {
    Quat::new_normalize(nalgebra::Quaternion::new(pose[root + 3], pose[root + 4], pose[root + 5], pose[root + 6]))
}

/// Flips the signs of quaternions so that neighbours are near each other.
pub(crate) fn continuous(poses: &mut [Vec<f64>], at: usize) {
    for t in 1..poses.len() {
        let dot: f64 = (0..4).map(|i| poses[t - 1][at + i] * poses[t][at + i]).sum();
        if dot < 0.0 {
            poses[t][at..at + 4].iter_mut().for_each(|x| *x = -*x);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn smoothing_keeps_lines_to_their_ends() {
        let line: Vec<f64> = (0..30).map(|i| 0.3 + 0.1 * f64::from(i)).collect();
        for (a, b) in smooth(&line, 2.0).iter().zip(&line) {
            assert!((a - b).abs() < 1e-12);
        }
    }

    #[test]
    fn a_jump_becomes_a_ramp_around_its_middle() {
        let mut signal = vec![0.0; 21];
        signal[11..].fill(1.0);
        limit_speed(&mut signal, 0.1);
        assert!(signal.windows(2).all(|w| (w[1] - w[0]).abs() <= 0.1 + 1e-12));
        // Forwards it would reach the middle at frame 15, backwards at frame 6: no delay on the mean.
        let early: f64 = signal[..11].iter().sum();
        let late: f64 = signal[11..].iter().map(|x| 1.0 - x).sum();
        assert!((early - late).abs() < 0.2, "{early} {late}");
    }
}
