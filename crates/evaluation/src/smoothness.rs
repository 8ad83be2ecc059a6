//! Smoothness of a motion.

use super::rollout::Snapshot;

/// Mean absolute jerk of the joints (rad/s³): the third difference of the positions times the cube of the rate, over
/// joints and frames. NaN for fewer than four frames.
pub fn jerk(frames: &[Snapshot], fps: f64) -> f64 {
    let cube = fps * fps * fps;
    super::accuracy::mean(frames.windows(4).flat_map(|w| {
        let joints = w[0].joints.len();
        (0..joints).map(move |j| {
            let q = |k: usize| w[k].joints[j];
            ((q(3) - 3.0 * q(2) + 3.0 * q(1) - q(0)) * cube).abs()
        })
    }))
}

#[cfg(test)]
mod tests {
    use lifelike_character::Vec3;

    use super::super::rollout::example::{rollout, snapshot};
    use super::*;

    #[test]
    fn a_cubic_has_its_third_derivative_and_a_parabola_none() {
        let of = |f: fn(f64) -> f64| {
            let at = move |t| snapshot(Vec3::z(), 0.0, f(t));
            jerk(&rollout(8, at, at).simulated, 10.0)
        };
        assert!((of(|t| 0.5 * t * t * t - t) - 3.0).abs() < 1e-9);
        assert!(of(|t| 4.0 * t * t + t) < 1e-9);
    }

    #[test]
    fn three_frames_have_none() {
        let still = |_| snapshot(Vec3::z(), 0.0, 0.0);
        assert!(jerk(&rollout(3, still, still).simulated, 10.0).is_nan());
    }
}
