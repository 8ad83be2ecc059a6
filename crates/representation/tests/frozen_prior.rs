//! The frozen encoder of a motion prior gives the trained one's codes.
#![allow(clippy::unwrap_used)]

use std::path::Path;

use lifelike_checkpoint::Checkpoint;
use lifelike_motion::features::frames_of;
use lifelike_representation::MotionPrior;
use lifelike_robot::controller::PriorEncoder;
use lifelike_robot::reference::standing_clip;
use lifelike_robot::{LatentEncoder, Robot};

#[test]
fn codes_are_those_of_the_trained_prior() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets/lima.prior.safetensors");
    let robot = Robot::load("lima").unwrap();
    let mut clip = standing_clip(&robot, 6.0);
    for (i, q) in clip.joints.iter_mut().enumerate() {
        *q += 0.2 * ((i / robot.joints()) as f64 * 0.1 + (i % robot.joints()) as f64).sin();
    }
    let frames = frames_of(&clip, &robot.character, &robot.effectors).unwrap();
    let expected = MotionPrior::load(&path).unwrap().encode_clip(&frames).unwrap();
    let frozen = PriorEncoder::from_prior(&Checkpoint::load(&path).unwrap()).unwrap();
    let got = frozen.encode(&clip, &frames, robot.control_hz).unwrap();
    assert_eq!(got.len(), expected.len());
    let scale = expected.iter().fold(0.0_f32, |most, z| most.max(z.abs()));
    assert!(scale > 0.1, "codes say something");
    let worst = got.iter().zip(&expected).map(|(g, e)| (g - e).abs()).fold(0.0, f32::max);
    assert!(worst <= 2e-6 * scale, "off by {worst}, codes are up to {scale}");
}
