//! The frozen encoder of a motion prior gives the trained one's codes.
use std::path::Path;

use crate::swings::{clips, layout};
use lifelike_checkpoint::Checkpoint;
use lifelike_motion::features::frames_of;
use lifelike_motion::{MotionClip, Provenance};
use lifelike_representation::MotionPrior;
use lifelike_representation::prior::pca::{PcaPlan, PcaTrainer};
use lifelike_representation::prior::vae::{VaePlan, VaeTrainer};
use lifelike_representation::prior::{PriorData, PriorTraining};
use lifelike_robot::controller::PriorEncoder;
use lifelike_robot::reference::standing_clip;
use lifelike_robot::{LatentEncoder, Robot};
use lifelike_train::TrainingTask;

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
    // Both passes add up in single precision, each in an order of its own. Such a pass of this prior is off by 3.1e-6 of
    // the codes' scale from one in double precision (PyTorch, float64): two may differ by twice that,
    // and are held to less.
    assert!(worst <= 4e-6 * scale, "off by {worst}, codes are up to {scale}");
}

/// Of every kind that a controller can carry, after it is saved and read.
#[test]
fn a_linear_path_and_components_alone_give_their_codes_too() {
    let sizes = VaePlan { channels: 16, blocks: 1, latent: 8, batch: 16, learning_rate: 0.01, ..VaePlan::default() };
    let learned = |linear_path: bool| {
        let plan = VaePlan { linear_path, ..sizes.clone() };
        let mut trainer = VaeTrainer::new(plan, layout(), clips(), Vec::new()).unwrap();
        for _ in 0..20 {
            trainer.step().unwrap();
        }
        trainer.prior()
    };
    let data = PriorData { layout: layout(), training: clips(), held_out: Vec::new() };
    let mut components = PcaTrainer::new(PcaPlan { latent: 8, ..PcaPlan::default() }, data).unwrap();
    components.step().unwrap();
    let frames = &clips()[3].frames;
    let clip = MotionClip {
        name: "swing".into(),
        fps: 50.0,
        joint_names: Vec::new(),
        root_position: Vec::new(),
        root_orientation: Vec::new(),
        joints: Vec::new(),
        contacts: None,
        cyclic: false,
        provenance: Provenance::default(),
    };
    let folder = tempfile::tempdir().unwrap();
    for prior in [learned(false), learned(true), components.prior().unwrap()] {
        let path = folder.path().join("prior");
        prior.save(&path).unwrap();
        let frozen = PriorEncoder::from_prior(&Checkpoint::load(&path).unwrap()).unwrap();
        let (expected, got) = (prior.encode_clip(frames).unwrap(), frozen.encode(&clip, frames, 50.0).unwrap());
        let scale = expected.iter().fold(0.0_f32, |most, z| most.max(z.abs()));
        let worst = got.iter().zip(&expected).map(|(g, e)| (g - e).abs()).fold(0.0, f32::max);
        assert!(scale > 0.1 && worst <= 1e-5 * scale, "off by {worst}, codes are up to {scale}");
    }
}
