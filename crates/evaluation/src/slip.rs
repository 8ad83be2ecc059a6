//! Soles that slide while they carry weight.

use super::accuracy::{CONTACT_SHARE, mean};
use super::rollout::Rollout;

/// Mean speed over the ground (m/s) of the lowest corner of each sole. Frames count in which it carries weight and did
/// so in the frame before. NaN where no foot stands.
pub fn sole_slip(rollout: &Rollout) -> f64 {
    let feet = rollout.names.feet.len();
    let stands = |frame: usize, foot: usize| rollout.foot_force[frame * feet + foot] > CONTACT_SHARE;
    let frames = rollout.counted();
    mean(frames.flat_map(|frame| {
        let standing = (0..feet).filter(move |foot| stands(frame, *foot) && stands(frame - 1, *foot));
        standing.map(move |foot| f64::from(rollout.sole_speed[frame * feet + foot]))
    }))
}

#[cfg(test)]
mod tests {
    use lifelike_character::Vec3;

    use super::super::rollout::example::{rollout, snapshot};
    use super::*;

    #[test]
    fn only_a_foot_that_stood_before_slips() {
        let still = |_| snapshot(Vec3::z(), 0.0, 0.0);
        let mut r = rollout(5, still, still);
        r.foot_force = vec![0.0, 1.0, 1.0, 0.0, 1.0];
        r.sole_speed = vec![9.0, 9.0, 0.2, 9.0, 9.0];
        assert!((sole_slip(&r) - f64::from(0.2_f32)).abs() < 1e-12);
        r.foot_force = vec![0.0; 5];
        assert!(sole_slip(&r).is_nan());
    }
}
