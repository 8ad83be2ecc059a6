//! States in which a robot lies or falls: where getting up begins.

use std::f64::consts::PI;

use lifelike_character::anatomy::lowest;
use lifelike_character::rotation::{from_wxyz, to_wxyz};
use lifelike_character::{Character, JointKind, Kinematics};
use rand::Rng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// Height of the lowest point above the ground (m), from which it drops.
const DROP: f64 = 0.02;
/// Range of a joint without limits (rad).
const UNLIMITED: f64 = PI;

/// Writes a state at rest whose lowest point is just above `ground` (m). It lies between the state in `q` (`depth` 0) and one that is
/// turned anyhow, with joints anywhere in their ranges (`depth` 1).
pub fn lay_down(character: &Character, ground: f64, depth: f64, rng: &mut ChaCha8Rng, q: &mut [f64], v: &mut [f64]) {
    v.fill(0.0);
    for joint in character.joints.iter().filter(|joint| joint.is_scalar()) {
        let (low, high) = joint.range.unwrap_or((-UNLIMITED, UNLIMITED));
        let angle = &mut q[joint.q_index];
        *angle += depth * (rng.random_range(low..=high) - *angle);
    }
    character.follow(q, v);
    let Some(root) = character.joints.iter().find(|joint| joint.kind == JointKind::Free) else { return };
    // Four normal numbers are a turn of which none is more likely than another.
    let turn: [f64; 4] = std::array::from_fn(|_| StandardNormal.sample(rng));
    let quaternion = root.q_index + 3..root.q_index + 7;
    let upright = from_wxyz(std::array::from_fn(|i| q[quaternion.start + i])).unwrap_or_default();
    let anyhow = from_wxyz(turn).unwrap_or_default();
    q[quaternion].copy_from_slice(&to_wxyz(&upright.try_slerp(&anyhow, depth, 1e-9).unwrap_or(anyhow)));
    let mut kinematics = Kinematics::new(character);
    kinematics.update(character, q);
    let solid = character.geoms.iter().filter(|geom| geom.body != 0 && (geom.contype | geom.conaffinity) != 0);
    let low = solid.flat_map(|geom| lowest(geom, &kinematics)).map(|point| point.z).reduce(f64::min);
    q[root.q_index + 2] += ground + DROP - low.unwrap_or(0.0);
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use lifelike_character::Vec3;

    use super::*;

    #[test]
    fn a_robot_lies_just_above_the_ground_turned_anyhow() {
        let file = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../robots/lima.xml");
        let lima = Character::from_mjcf(&std::fs::read_to_string(file).unwrap(), "lima.xml", None).unwrap();
        let mut upright = 0;
        for index in 0..200 {
            let mut rng = lifelike_checkpoint::rng::stream(1, "test", index, 0);
            let (mut q, mut v) = (lima.reference_position(), vec![1.0; lima.nv]);
            lay_down(&lima, 0.5, 1.0, &mut rng, &mut q, &mut v);
            let mut kinematics = Kinematics::new(&lima);
            kinematics.update(&lima, &q);
            let solid = lima.geoms.iter().filter(|geom| geom.body != 0 && (geom.contype | geom.conaffinity) != 0);
            let low = solid.flat_map(|geom| lowest(geom, &kinematics)).map(|p| p.z).fold(f64::INFINITY, f64::min);
            assert!((low - 0.5 - DROP).abs() < 1e-9, "{low}");
            assert!(v.iter().all(|v| *v == 0.0));
            let up = kinematics.body_orientation[lima.root_body()] * Vec3::z();
            upright += usize::from(up.z > 0.9);
            for joint in lima.scalar_joints() {
                let (least, most) = joint.range.unwrap();
                assert!((least..=most).contains(&q[joint.q_index]));
            }
        }
        assert!(upright < 30, "{upright} of 200 stand");
    }

    #[test]
    fn the_depth_goes_from_the_given_state_to_lying() {
        let file = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../robots/lima.xml");
        let lima = Character::from_mjcf(&std::fs::read_to_string(file).unwrap(), "lima.xml", None).unwrap();
        let joints = |depth: f64| {
            let mut rng = lifelike_checkpoint::rng::stream(1, "test", 0, 0);
            let (mut q, mut v) = (lima.reference_position(), vec![1.0; lima.nv]);
            lay_down(&lima, 0.0, depth, &mut rng, &mut q, &mut v);
            q
        };
        let (given, half, lying) = (lima.reference_position(), joints(0.5), joints(1.0));
        let far = |q: &[f64]| q[7..].iter().zip(&given[7..]).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt();
        assert!(far(&joints(0.0)) < 1e-12 && (far(&half) - 0.5 * far(&lying)).abs() < 1e-9);
        assert!((joints(0.0)[3] - 1.0).abs() < 1e-12, "{:?}", &joints(0.0)[3..7]);
    }
}
