//! A correction of bodies in their parents' frames: turn the whole scene, and it turns with it.

use std::sync::Arc;

use lifelike_augmentation::model::{Frame, SatSizes};
use lifelike_augmentation::references::random::{self, RandomSpec};
use lifelike_augmentation::replay::{Measuring, on_twin};
use lifelike_augmentation::training::{AugmentationPlan, AugmentationTrainer};
use lifelike_augmentation::{Augmentation, Feedback};
use lifelike_character::rotation::{from_wxyz, to_wxyz};
use lifelike_character::{Quat, Vec3};
use lifelike_robot::Robot;
use lifelike_sim::trace::{BlockTrace, Columns, Trace};
use lifelike_sim::twin::TwinSpec;

const OUTPUTS: [&str; 3] = ["position_x", "position_y", "position_z"];

/// A second of KickBot, simulated and on its twin.
fn trace() -> Trace {
    let file = format!("{}/../robot/robots/kickbot.xml", env!("CARGO_MANIFEST_DIR"));
    let robot = Arc::new(Robot::load(&file).unwrap());
    let references = random::draw(&robot, &RandomSpec { seed: 3, runs: 1, seconds: 1.0, ..RandomSpec::default() });
    let all = on_twin(&references.unwrap(), &robot, &robot, &TwinSpec::default(), &Measuring::default()).unwrap();
    all.into_iter().next().unwrap()
}

/// An augmentation with the weights that it begins with: they know nothing, and turn all the same.
fn augmentation(trace: &Trace, frame: Frame) -> Augmentation {
    let model = SatSizes { width: 8, heads: 2, embedding: 2, history: 16, ..SatSizes::default() };
    let outputs = OUTPUTS.map(String::from).to_vec();
    let plan = AugmentationPlan { class: "body".into(), outputs, frame, model, stretch: 32, ..Default::default() };
    AugmentationTrainer::new(&plan, std::slice::from_ref(trace), &[]).unwrap().augmentation()
}

fn vector(row: &[f32]) -> Vec3 {
    Vec3::new(row[0].into(), row[1].into(), row[2].into())
}

/// Columns of a scene that was turned, then moved: vectors are three columns in a row, places the first.
fn turned(columns: &Columns, turn: &Quat, by: &Vec3) -> Columns {
    let mut out = columns.clone();
    for row in out.values.chunks_exact_mut(columns.names.len().max(1)) {
        for (i, three) in row.chunks_exact_mut(3).enumerate() {
            let moved = if columns.names[3 * i] == "position_x" { *by } else { Vec3::zeros() };
            let new = turn * vector(three) + moved;
            three.iter_mut().zip(new.iter()).for_each(|(x, y)| *x = *y as f32);
        }
    }
    out
}

fn turned_block(block: &BlockTrace, turn: &Quat, by: &Vec3) -> BlockTrace {
    let mut frame = block.frame.clone();
    for row in frame.values.chunks_exact_mut(7) {
        let place = turn * vector(row) + by;
        row[..3].iter_mut().zip(place.iter()).for_each(|(x, y)| *x = *y as f32);
        let pose = turn * from_wxyz([row[3], row[4], row[5], row[6]].map(f64::from)).unwrap();
        row[3..].copy_from_slice(&to_wxyz(&pose).map(|x| x as f32));
    }
    let of = |columns: &Columns| turned(columns, turn, by);
    let (simulated, force, measured) = (of(&block.simulated), of(&block.force), of(&block.measured));
    BlockTrace { simulated, force, measured, frame, ..block.clone() }
}

/// The largest difference between the turned correction and the correction of the turned scene, by the largest correction.
fn off(augmentation: &Augmentation, trace: &Trace, feedback: Feedback) -> f64 {
    let (turn, by) = (Quat::from_scaled_axis(Vec3::new(0.4, -1.1, 2.0)), Vec3::new(0.3, -0.5, 0.2));
    let (mut worst, mut largest) = (0.0_f64, 0.0_f64);
    for block in trace.blocks.iter().filter(|block| block.class == "body") {
        let here = augmentation.errors(block, feedback).unwrap();
        let there = augmentation.errors(&turned_block(block, &turn, &by), feedback).unwrap();
        for (here, there) in here.chunks_exact(3).zip(there.chunks_exact(3)) {
            let expected = turn * vector(here);
            worst = worst.max((vector(there) - expected).norm());
            largest = largest.max(expected.norm());
        }
    }
    worst / largest
}

#[test]
fn corrections_turn_with_the_scene() {
    let trace = trace();
    let local = augmentation(&trace, Frame::Parent);
    for feedback in [Feedback::None, Feedback::Measured, Feedback::Predicted] {
        let off = off(&local, &trace, feedback);
        assert!(off < 2e-3, "{feedback:?}: {off} of the largest correction");
    }
    let world = off(&augmentation(&trace, Frame::World), &trace, Feedback::None);
    assert!(world > 0.1, "in the world's axes it does not: {world}");
}

#[test]
fn single_coordinates_cannot_be_turned() {
    let trace = trace();
    let plan = AugmentationPlan { class: "body".into(), outputs: vec!["position_x".into()], ..Default::default() };
    let text = AugmentationTrainer::new(&plan, std::slice::from_ref(&trace), &[]).err().unwrap().to_string();
    assert!(text.contains("x, y and z of each vector"), "{text}");
}
