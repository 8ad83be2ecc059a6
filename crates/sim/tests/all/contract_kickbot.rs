//! The robots of thesis chapter 2: what the thesis says of them (2.5), and that they stand in the engine.

use std::path::Path;
use std::sync::Arc;

use lifelike_character::kinematics::Kinematics;
use lifelike_robot::Robot;
use lifelike_sim::{Drive, Simulation, SimulationSpec};

fn robot(name: &str) -> Robot {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../robot/robots/{name}.xml"));
    Robot::load(file.to_str().unwrap()).unwrap()
}

#[test]
fn masses_joints_and_loops_are_the_thesis() {
    for (name, mass, loops) in [("kickbot", 3.08, 0), ("kickbot_foot", 3.08, 0), ("dancebot", 2.58, 1)] {
        let robot = robot(name);
        let total: f64 = robot.character.bodies.iter().map(|body| body.inertial.mass).sum();
        assert!((total - mass).abs() < 1e-9, "{name}: {total} kg");
        assert_eq!((robot.joints(), robot.character.equalities.len()), (12, loops), "{name}");
        assert!(robot.character.root_joint().is_none(), "{name} is fixed to the world");
        assert_eq!(robot.control_hz, 250.0, "{name}");
    }
}

/// Attached at the pelvis or at the foot it is one robot: the same angles bring its parts to the same places beside each other.
#[test]
fn kickbot_is_the_same_robot_wherever_it_is_attached() {
    let robots = [robot("kickbot"), robot("kickbot_foot")];
    let angle = |i: usize| 0.25 * (i as f64 * 1.7).sin();
    let names = &robots[0].layout.joints;
    let places = robots.each_ref().map(|robot| {
        let mut position = robot.character.reference_position();
        for joint in robot.character.scalar_joints() {
            position[joint.q_index] = angle(names.iter().position(|name| *name == joint.name).unwrap());
        }
        let mut kinematics = Kinematics::new(&robot.character);
        kinematics.update(&robot.character, &position);
        let body = |name: &str| robot.character.bodies.iter().position(|body| body.name == name).unwrap();
        let (foot, pelvis) = (body("right_foot"), body("pelvis"));
        ["left_foot", "trunk", "pelvis"].map(|name| {
            let between = kinematics.body_position[body(name)] - kinematics.body_position[foot];
            (kinematics.body_orientation[pelvis].inverse() * between, robot.character.bodies[body(name)].inertial.mass)
        })
    });
    for (a, b) in places[0].iter().zip(&places[1]) {
        assert!((a.0 - b.0).norm() < 1e-9 && a.1 == b.1, "{a:?} {b:?}");
    }
}

#[test]
fn they_hold_their_default_pose() {
    for name in ["kickbot", "kickbot_foot", "dancebot"] {
        let robot = Arc::new(robot(name));
        let mut simulation = SimulationSpec::new(1).build(robot.clone()).unwrap();
        let targets: Vec<f32> = robot.default_pose.iter().map(|q| *q as f32).collect();
        for _ in 0..500 {
            simulation.step(Drive::Targets(&targets)).unwrap();
        }
        let state = simulation.state();
        let off = state.joint_position.iter().zip(&targets).fold(0.0_f32, |most, (q, t)| most.max((q - t).abs()));
        // A servo without an integral hangs by load / kp: 0.85 N m / 21 N m/rad at the hip of one that stands on one foot.
        assert!(!state.diverged[0] && off < 0.06, "{name}: {off} rad");
        assert!(state.joint_velocity.iter().all(|v| v.abs() < 0.01), "{name} moves");
    }
}
