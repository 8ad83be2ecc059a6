//! A trained augmentation: it closes a gap that it was trained on, its file gives the same numbers, and inside of a simulation it
//! corrects what it corrects in that simulation's trace.

use std::sync::Arc;

use lifelike_augmentation::model::SatSizes;
use lifelike_augmentation::training::{AugmentationPlan, AugmentationTrainer, FeedbackShares};
use lifelike_augmentation::{ActuatorCorrection, Augmentation, Feedback, gap};
use lifelike_robot::Robot;
use lifelike_sim::augmented::Augmented;
use lifelike_sim::trace::{Columns, Recorder, Trace};
use lifelike_sim::{Drive, Simulation, SimulationSpec};

const STEPS: usize = 150;

/// Targets of a robot that swings all its joints a little.
fn targets(robot: &Robot, step: usize) -> Vec<f32> {
    let swing = |(j, q): (usize, &f64)| (q + 0.15 * (step as f64 * (0.07 + 0.01 * j as f64)).sin()) as f32;
    robot.default_pose.iter().enumerate().map(swing).collect()
}

/// A trace of lima whose "measured" joints sag under their load and lag behind: what a network can learn.
fn trace(robot: &Arc<Robot>) -> Trace {
    let mut simulation = SimulationSpec::new(1).build(robot.clone()).unwrap();
    let mut recorder = Recorder::new(&simulation, 0);
    for step in 0..STEPS {
        recorder.step(&mut simulation, &targets(robot, step)).unwrap();
    }
    let mut trace = recorder.trace("swing", "servo");
    for block in &mut trace.blocks {
        let load: Vec<f32> = block.force.column("load").unwrap().collect();
        let velocity: Vec<f32> = block.simulated.column("velocity").unwrap().collect();
        let position = block.simulated.column("position").unwrap();
        let measured: Vec<f64> =
            position.zip(load.iter().zip(&velocity)).map(|(q, (f, v))| f64::from(q + 0.004 * f - 0.01 * v)).collect();
        block.measured = Columns::new(&[("position", &measured)]);
        block.selection = block.by_name();
    }
    trace
}

fn trained(trace: &Trace) -> Augmentation {
    let model = SatSizes { width: 8, heads: 2, embedding: 4, history: 16, ..SatSizes::default() };
    let plan = AugmentationPlan { model, stretch: 60, batch: 16, iterations: 150, noise: 0.0, ..Default::default() };
    let mut trainer = AugmentationTrainer::new(&plan, std::slice::from_ref(trace), &[]).unwrap();
    for _ in 0..plan.iterations {
        trainer.iterate();
    }
    trainer.augmentation()
}

#[test]
fn it_closes_a_gap_and_does_the_same_in_a_running_simulation() {
    let robot = Arc::new(Robot::load("lima").unwrap());
    let trace = trace(&robot);
    let augmentation = trained(&trace);
    let error = |trace: &Trace| gap::summary(&gap::gaps(trace))[0].mae[0];
    let (before, corrected) = (error(&trace), augmentation.corrected(&trace, Feedback::None).unwrap());
    assert!(error(&corrected) < 0.4 * before, "{} of {before}", error(&corrected));

    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("servo.augmentation.safetensors");
    augmentation.save(&file).unwrap();
    let augmentation = Augmentation::load(&file).unwrap();
    assert_eq!(augmentation.corrected(&trace, Feedback::None).unwrap(), corrected, "the file is the augmentation");

    // Two environments at once, the second pushed around: each is corrected by its own history.
    let correction = ActuatorCorrection::new(augmentation, &robot, &[], Feedback::None).unwrap();
    let simulation = SimulationSpec::new(2).build(robot.clone()).unwrap();
    let mut augmented = Augmented::new(simulation, Box::new(correction)).unwrap();
    augmented.push(1, 1, [30.0, 0.0, 0.0], [0.0; 3]).unwrap();
    let mut worst = 0.0_f32;
    for step in 0..STEPS {
        augmented.step(Drive::Targets(&targets(&robot, step).repeat(2))).unwrap();
        for (j, block) in corrected.blocks.iter().enumerate() {
            let expected = block.simulated.values[3 * step];
            worst = worst.max((augmented.state().joint_position[j] - expected).abs());
        }
    }
    assert!(worst < 1e-4, "{worst} rad from the trace's correction");
    assert!(augmented.state().joint_position[0] != augmented.state().joint_position[robot.joints()]);
}

#[test]
fn robots_it_does_not_fit_are_refused() {
    let robot = Arc::new(Robot::load("lima").unwrap());
    let mut trace = trace(&robot);
    let augmentation = trained(&trace);
    let refused = |augmentation: &Augmentation, joints: &[String], feedback: Feedback| {
        ActuatorCorrection::new(augmentation.clone(), &robot, joints, feedback).err().unwrap().to_string()
    };
    assert!(refused(&augmentation, &["elbow".into()], Feedback::None).contains("got 'elbow'"));
    assert!(refused(&augmentation, &[], Feedback::Measured).contains("got measurements"));
    trace.rate = 200.0;
    let plan = AugmentationPlan { stretch: 60, iterations: 1, ..Default::default() };
    let other = AugmentationTrainer::new(&plan, &[trace], &[]).unwrap().augmentation();
    assert!(refused(&other, &[], Feedback::None).contains("50 Hz, got 200 Hz"));
}

/// In the thesis' form the network learns in its own closed loop, and closes the gap with what it predicts and with what is measured.
#[test]
fn the_thesis_form_closes_a_gap_in_its_own_loop() {
    let robot = Arc::new(Robot::load("lima").unwrap());
    let trace = trace(&robot);
    let model = SatSizes { width: 8, heads: 2, embedding: 4, history: 16, carry: false, ..SatSizes::default() };
    let feedback = FeedbackShares::THESIS;
    let hysteresis = Vec::new();
    let plan = AugmentationPlan {
        stretch: 60,
        iterations: 200,
        noise: 0.0,
        model,
        feedback,
        hysteresis,
        ..Default::default()
    };
    let mut trainer =
        AugmentationTrainer::new(&plan, std::slice::from_ref(&trace), std::slice::from_ref(&trace)).unwrap();
    for _ in 0..plan.iterations {
        trainer.iterate();
    }
    let validated = trainer.validate_once().unwrap()[0];
    let augmentation = trainer.augmentation();
    let error = |trace: &Trace| gap::summary(&gap::gaps(trace))[0].mae[0];
    let before = error(&trace);
    for feedback in [Feedback::Predicted, Feedback::Measured] {
        let after = error(&augmentation.corrected(&trace, feedback).unwrap());
        assert!(after < 0.5 * before, "{feedback:?}: {after} of {before}");
    }
    // What validation says is the error of the closed loop, in units of the error's scale.
    let own = error(&augmentation.corrected(&trace, Feedback::Predicted).unwrap());
    let scale = f64::from(augmentation.header().scales.error[0]);
    assert!((own - validated * scale).abs() < 1e-4 * before, "{own} and {}", validated * scale);
}

/// Ten minutes of its own predictions: whatever a network says of itself, corrections stay below the stated guard.
#[test]
fn ten_minutes_of_its_own_predictions_stay_bounded() {
    let robot = Arc::new(Robot::load("lima").unwrap());
    let trace = trace(&robot);
    let augmentation = trained(&trace);
    let header = augmentation.header();
    let most = 1.5 * header.limit[0] * header.scales.error[0];
    let correction = ActuatorCorrection::new(augmentation, &robot, &[], Feedback::Predicted).unwrap();
    let simulation = SimulationSpec::new(1).build(robot.clone()).unwrap();
    let mut augmented = Augmented::new(simulation, Box::new(correction)).unwrap();
    let mut largest = [0.0_f32; 2];
    let steps = 10 * 60 * robot.control_hz as usize;
    for step in 0..steps {
        augmented.step(Drive::Targets(&targets(&robot, step))).unwrap();
        // It falls at some time, and goes on from the ground.
        let off = augmented.state().joint_position.iter().zip(&augmented.simulation().state().joint_position);
        let off = off.fold(0.0_f32, |most, (a, b)| most.max((a - b).abs()));
        let half = usize::from(step >= steps / 2);
        largest[half] = largest[half].max(off);
        assert!(off <= most * 1.001, "{off} of {most} rad at step {step}");
    }
    assert!(largest[1] > 0.0, "it still corrects");
}
