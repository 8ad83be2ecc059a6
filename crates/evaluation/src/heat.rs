//! Heat of the motors: squared torque, which is what warms a winding, beside what the motor bears for any time.

use super::accuracy::mean;
use super::rollout::Rollout;

/// Returns, for each joint, the mean over the frames that count of the squared actuator torque over the squared continuous torque.
/// 1 is the continuous rating; a joint above it gets too hot if the motion goes on. NaN where no frame counts.
pub fn joint_heat(rollout: &Rollout) -> Vec<f64> {
    let joints = rollout.names.joints.len();
    let of = |joint: usize| mean(rollout.counted().map(|frame| f64::from(rollout.heat[frame * joints + joint])));
    (0..joints).map(of).collect()
}

/// Returns the mean and the largest of the joints' heat; NaN where there is none.
pub fn mean_and_worst(heat: &[f64]) -> (f64, f64) {
    let known = || heat.iter().copied().filter(|h| h.is_finite());
    (mean(known()), known().fold(f64::NAN, f64::max))
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use lifelike_character::Vec3;

    use super::super::rollout::Names;
    use super::super::rollout::example::{rollout, snapshot};
    use super::*;

    #[test]
    fn heat_is_the_mean_square_over_what_is_borne() {
        let still = |_| snapshot(Vec3::z(), 0.0, 0.0);
        let mut r = rollout(3, still, still);
        r.names = Arc::new(Names { joints: vec!["hip".into(), "knee".into()], ..Names::default() });
        // The start does not count. Hip: half the continuous torque, then twice as much: (0.25 + 4) / 2; the knee rests.
        r.heat = vec![9.0, 9.0, 0.25, 0.0, 4.0, 0.0];
        assert_eq!(joint_heat(&r), [2.125, 0.0]);
        assert_eq!(mean_and_worst(&joint_heat(&r)), (1.0625, 2.125));
        let (mean, worst) = mean_and_worst(&[f64::NAN]);
        assert!(mean.is_nan() && worst.is_nan());
    }
}
