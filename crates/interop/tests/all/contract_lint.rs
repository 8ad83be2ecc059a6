//! The lint of layouts: it finds every mistake that is made between stacks, and nothing in a right layout.
use crate::shuffles;
use lifelike_robot::ControllerFile;

/// The G1's joints level after level, without the model: depths of its bodies below the pelvis.
fn breadth_first(joints: &[String]) -> Vec<usize> {
    let depth = |name: &str| {
        let place_in = |limb: &[&str], above: usize| limb.iter().position(|end| name.contains(end)).map(|i| i + above);
        let leg = ["hip_pitch", "hip_roll", "hip_yaw", "knee", "ankle_pitch", "ankle_roll"];
        let arm =
            ["shoulder_pitch", "shoulder_roll", "shoulder_yaw", "elbow", "wrist_roll", "wrist_pitch", "wrist_yaw"];
        let waist = ["waist_yaw", "waist_roll", "waist_pitch"];
        place_in(&waist, 0).or_else(|| place_in(&leg, 0)).or_else(|| place_in(&arm, 3)).unwrap()
    };
    let mut order: Vec<usize> = (0..joints.len()).collect();
    order.sort_by_key(|joint| depth(&joints[*joint]));
    order
}

#[test]
fn twelve_mistakes_about_a_g1_policy_are_found_and_its_own_layout_is_right() {
    let path =
        std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../lifelike/assets/g1-deploy.controller.safetensors");
    let file = ControllerFile::read(&path).unwrap();
    let order = breadth_first(&file.header().observation.joints);
    let found = shuffles::found(&file, &order, file.header().action.scale() as f32);
    assert_eq!(found.len(), 13);
    for (mistake, contradictions) in found.iter().skip(1) {
        assert!(!contradictions.is_empty(), "not found: {mistake}");
    }
    let own: Vec<String> = found[0].1.iter().map(ToString::to_string).collect();
    assert!(own.is_empty(), "{own:?}");
}
