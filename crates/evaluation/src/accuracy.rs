//! Distances of joints, end effectors and bodies from the reference.

use lifelike_character::Vec3;
use lifelike_character::rotation::heading;

use super::rollout::{Rollout, Snapshot};

/// Mean absolute error of the joint positions over frames and joints (deg): the first number of thesis Table 4.3. NaN
/// where no frame counts.
pub fn joint_error(rollout: &Rollout) -> f64 {
    mean(rollout.pairs().flat_map(|(r, s)| r.joints.iter().zip(&s.joints).map(|(a, b)| (a - b).abs()))).to_degrees()
}

/// Mean absolute error of each joint over frames (deg). The mean over joints hides two ankles that never move.
pub fn joint_errors(rollout: &Rollout) -> Vec<f64> {
    let of = |joint: usize| mean(rollout.pairs().map(|(r, s)| (r.joints[joint] - s.joints[joint]).abs()));
    (0..rollout.names.joints.len()).map(|joint| of(joint).to_degrees()).collect()
}

/// Returns the share of frames and feet in which a foot stands where the reference's does and does not where it does
/// not: the steps of the reference are taken. NaN where no frame counts or there are no feet.
pub fn contact_agreement(rollout: &Rollout) -> f64 {
    let feet = rollout.names.feet.len();
    mean(rollout.counted().flat_map(|frame| frame * feet..(frame + 1) * feet).map(|i| {
        let in_contact = rollout.foot_force[i] > CONTACT_SHARE;
        if in_contact == rollout.planned_contact[i] { 1.0 } else { 0.0 }
    }))
}

/// A foot stands when it carries more than this share of the weight.
pub(super) const CONTACT_SHARE: f32 = 0.02;

/// Mean distance of the end effectors over frames and effectors (m), each relative to its own root in its own heading
/// frame: the second number of thesis Table 4.3. (The thesis does not say whether it averages distances or coordinates;
/// distances are the larger.)
pub fn effector_error(rollout: &Rollout) -> f64 {
    mean(rollout.pairs().flat_map(|(r, s)| effector_distances(r, s)))
}

/// Distance of each end effector, each relative to its own root in its own heading frame (m).
pub(super) fn effector_distances(r: &Snapshot, s: &Snapshot) -> Vec<f64> {
    let (to_r, to_s) = (heading(&r.root_orientation).inverse(), heading(&s.root_orientation).inverse());
    let pairs = r.effectors.iter().zip(&s.effectors);
    pairs.map(|(a, b)| (to_r * (a - r.root_position) - to_s * (b - s.root_position)).norm()).collect()
}

/// Mean distance of the bodies (m, world) in each frame that counts. Success in the sense of PHC (Luo et al. 2023) means
/// that it never exceeds [`PHC_LIMIT`].
pub fn body_errors(rollout: &Rollout) -> Vec<f64> {
    rollout
        .pairs()
        .map(|(r, s)| mean(r.bodies.iter().zip(&s.bodies).skip(1).map(|(a, b)| (a.0 - b.0).norm())))
        .collect()
}

/// Mean distance of the bodies in each frame that counts, each from its own root (m): PHC's MPJPE, blind to drift. Directions stay
/// those of the world.
pub fn root_relative_body_errors(rollout: &Rollout) -> Vec<f64> {
    let of = |(r, s): (&Snapshot, &Snapshot)| {
        let pairs = r.bodies.iter().zip(&s.bodies).skip(1);
        mean(pairs.map(|(a, b)| ((a.0 - r.root_position) - (b.0 - s.root_position)).norm()))
    };
    rollout.pairs().map(of).collect()
}

/// The mean body error beyond which a clip counts as not followed (m).
pub const PHC_LIMIT: f64 = 0.5;

/// Distance of each body (the world left out) from the reference (m) when both stand on the same spot and face the same
/// way: what is wrong with the posture, whatever the drift. Heights are those above each one's ground.
pub fn posture_errors(reference: &Snapshot, simulated: &Snapshot) -> Vec<f64> {
    let local = |s: &Snapshot| {
        let spot = Vec3::new(s.root_position.x, s.root_position.y, s.ground);
        let turn = heading(&s.root_orientation).inverse();
        s.bodies.iter().skip(1).map(|b| turn * (b.0 - spot)).collect::<Vec<_>>()
    };
    local(reference).iter().zip(local(simulated)).map(|(a, b)| (a - b).norm()).collect()
}

/// The mean; NaN of nothing.
pub(super) fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, n) = values.fold((0.0, 0_u64), |(sum, n), v| (sum + v, n + 1));
    if n == 0 { f64::NAN } else { sum / n as f64 }
}

#[cfg(test)]
mod tests {
    use super::super::rollout::example::{rollout, snapshot};
    use super::*;

    #[test]
    fn joints_by_hand() {
        // Errors of 0.1 t at t = 0.1, 0.2, 0.3 (the start does not count): mean 0.02 rad.
        let r = rollout(4, |_| snapshot(Vec3::z(), 0.0, 1.0), |t| snapshot(Vec3::z(), 0.0, 1.0 - 0.1 * t));
        assert!((joint_error(&r) - 0.02 * 180.0 / std::f64::consts::PI).abs() < 1e-12);
        assert!(
            joint_error(&rollout(1, |_| snapshot(Vec3::z(), 0.0, 0.0), |_| snapshot(Vec3::z(), 0.0, 0.0))).is_nan()
        );
    }

    #[test]
    fn a_foot_that_stays_down_in_one_of_two_steps_agrees_by_half() {
        let still = |_| snapshot(Vec3::z(), 0.0, 0.0);
        let mut r = rollout(5, still, still);
        // The first frame does not count. Asked: down, up, down, up. Done: down, down, down, up by a hair.
        r.planned_contact = vec![false, true, false, true, false];
        r.foot_force = vec![0.0, 1.0, 0.5, 0.9, 0.01];
        assert!((contact_agreement(&r) - 0.75).abs() < 1e-12);
        assert!(
            (joint_errors(&rollout(2, still, |_| snapshot(Vec3::z(), 0.0, 0.1)))[0] - 0.1_f64.to_degrees()).abs()
                < 1e-9
        );
    }

    #[test]
    fn effectors_do_not_care_where_the_root_is_and_bodies_do() {
        let reference = |_| snapshot(Vec3::z(), 0.0, 0.0);
        // Two metres aside and a quarter turn: the hand is where it should be, seen from the root.
        let turned = rollout(3, reference, |_| snapshot(Vec3::new(0.0, 2.0, 1.0), std::f64::consts::FRAC_PI_2, 0.0));
        assert!(effector_error(&turned) < 1e-12);
        assert!(posture_errors(&turned.reference[1], &turned.simulated[1]).iter().all(|e| *e < 1e-12));
        // Pelvis: 2 m. Hand: from (1, 0) to (0, 3): sqrt(10) m.
        let expected = (2.0 + 10.0_f64.sqrt()) / 2.0;
        assert!(body_errors(&turned).iter().all(|e| (e - expected).abs() < 1e-12));
        assert_eq!(body_errors(&turned).len(), 2);
        // Both roots in one place: the hand is a quarter turn off at one metre.
        let apart = 2.0_f64.sqrt() / 2.0;
        assert!(root_relative_body_errors(&turned).iter().all(|e| (e - apart).abs() < 1e-12));
    }

    #[test]
    fn a_hand_off_by_three_and_four_is_off_by_five() {
        let reference = |_| snapshot(Vec3::z(), 0.0, 0.0);
        let off = rollout(2, reference, |_| {
            let mut s = snapshot(Vec3::z(), 0.0, 0.0);
            s.effectors[0] += Vec3::new(0.03, 0.0, 0.04);
            s
        });
        assert!((effector_error(&off) - 0.05).abs() < 1e-12);
    }

    #[test]
    fn a_sunken_root_is_a_wrong_posture() {
        let errors = posture_errors(&snapshot(Vec3::z(), 0.3, 0.0), &snapshot(0.8 * Vec3::z(), -1.0, 0.0));
        assert!(errors.iter().all(|e| (e - 0.2).abs() < 1e-12), "{errors:?}");
    }
}
