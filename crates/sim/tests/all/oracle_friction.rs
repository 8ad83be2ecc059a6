//! Friction under load (`model = "bam"`): our engine and MuJoCo against BAM's own controller, and against hand arithmetic.

use std::sync::Arc;

use lifelike_character::Character;
use lifelike_robot::actuator::ExtendedFriction;
use lifelike_robot::{Profile, Robot};
use lifelike_sim::{Drive, LifelikeSimulation, MujocoSimulation, Simulation};

const ARM: &str = include_str!("../fixtures/arm.xml");

#[derive(serde::Deserialize)]
struct Fixture {
    /// Of each policy step, for each joint.
    targets: Vec<[f32; 2]>,
    /// Every how many steps angles are kept.
    kept: usize,
    runs: Vec<Run>,
}

#[derive(serde::Deserialize)]
struct Run {
    /// BAM's file, and how the servo is used.
    parameters: toml::Table,
    angles: Vec<[f64; 2]>,
}

fn arm(parameters: &toml::Table) -> Arc<Robot> {
    let mut group = toml::Table::new();
    group.insert("joints".into(), toml::Value::Array(vec!["*".into()]));
    group.insert("model".into(), "bam".into());
    group.insert("parameters".into(), parameters.clone().into());
    let actuators = toml::Table::from_iter([("servo".to_string(), toml::Value::Table(group))]);
    let mut profile = toml::Table::from_iter([("actuator".to_string(), toml::Value::Table(actuators))]);
    profile.insert("control_hz".into(), 100.into());
    profile.insert("physics_hz".into(), 500.into());
    robot(ARM, &toml::to_string(&profile).unwrap())
}

fn robot(mjcf: &str, profile: &str) -> Arc<Robot> {
    let character = Character::from_mjcf(mjcf, "arm.xml", None).unwrap();
    let profile = Profile::from_toml(profile, "arm.toml".as_ref()).unwrap();
    Arc::new(Robot::from_character(character, profile).unwrap())
}

/// The largest distance from BAM's angles (rad).
fn farthest(mut simulation: impl Simulation, fixture: &Fixture, run: &Run) -> f64 {
    simulation.reset(&[0], &[0.0; 2], &[0.0; 2]).unwrap();
    let mut worst = 0.0_f64;
    for (step, targets) in fixture.targets.iter().enumerate() {
        simulation.step(Drive::Targets(targets)).unwrap();
        if step % fixture.kept == fixture.kept - 1 {
            let angles = &simulation.state().joint_position;
            for (got, expected) in angles.iter().zip(run.angles[step / fixture.kept]) {
                worst = worst.max((f64::from(*got) - expected).abs());
            }
        }
    }
    worst
}

#[test]
fn every_model_of_bam_moves_an_arm_as_bams_own_controller_does() {
    let fixture: Fixture = serde_json::from_str(include_str!("../fixtures/bam.json")).unwrap();
    for run in &fixture.runs {
        let robot = arm(&run.parameters);
        let mujoco = farthest(MujocoSimulation::new(robot.clone(), 1, 1).unwrap(), &fixture, run);
        let double = LifelikeSimulation::in_double_precision(robot.clone(), 1, 1).unwrap();
        let double = farthest(double.with_iterations(200), &fixture, run);
        let single = farthest(LifelikeSimulation::new(robot.clone(), 1, 1).unwrap(), &fixture, run);
        let name = &run.parameters["model"];
        println!("{name}: {mujoco:.1e} rad in MuJoCo, {double:.1e} and {single:.1e} in our engine, f64 and f32");
        assert!(mujoco < 1e-6 && double < 1e-6 && single < 1e-5, "{name}: {mujoco} {double} {single}");
    }
    // M1 and M6 differ by what friction depends on: the test can see it.
    let (first, last) = (&fixture.runs[0], &fixture.runs[5]);
    let apart = first.angles.iter().zip(&last.angles).map(|(a, b)| (a[0] - b[0]).abs()).fold(0.0, f64::max);
    assert!(apart > 0.05, "{apart}");
}

/// A weight of 1 N m on a level arm and a motor at its limit: it goes up where τ - 1 > 0.1 + 0.3 τ + 0.2, that is from
/// τ = 1.857 on, and down where 1 - τ > 0.1 + 0.3 τ + 0.2, that is up to τ = 0.538. Between these it creeps, as MuJoCo's dry friction
/// does: by R τ / b, at most 0.015 rad in the 0.2 s.
#[test]
fn a_load_is_held_lifted_and_dropped_where_the_friction_says() {
    let level = r#"<mujoco><option timestep="0.002"/><worldbody><body name="arm"><joint name="joint" axis="0 1 0"/>
        <inertial pos="0.1 0 0" mass="1.0193679918450560" diaginertia="0.001 0.001 0.001"/></body></worldbody></mujoco>"#;
    let friction = ExtendedFriction { base: 0.1, load: [0.3, 0.2], ..ExtendedFriction::default() };
    for (torque, expected) in [(0.50, "down"), (0.57, "held"), (1.0, "held"), (1.82, "held"), (1.90, "up")] {
        let profile = format!(
            "control_hz = 100\nphysics_hz = 500\n[actuator.a]\njoints = [\"*\"]\n[actuator.a.parameters]\nkp = 1000.0\nkd = 0.0\n\
             friction_velocity = 1.0\nstatic_friction = 0.0\nviscous_friction = 0.0\ntorque_max = {torque}\n\
             full_torque_velocity = 100.0\nvelocity_max = 200.0\n[actuator.a.parameters.extended_friction]\n{}",
            toml::to_string(&friction).unwrap()
        );
        let robot = robot(level, &profile);
        let engines: [Box<dyn Simulation>; 2] = [
            Box::new(LifelikeSimulation::new(robot.clone(), 1, 1).unwrap()),
            Box::new(MujocoSimulation::new(robot.clone(), 1, 1).unwrap()),
        ];
        for mut simulation in engines {
            simulation.reset(&[0], &[0.0], &[0.0]).unwrap();
            // Down is positive about y.
            (0..20).for_each(|_| simulation.step(Drive::Targets(&[-1.0])).unwrap());
            let angle = simulation.state().joint_position[0];
            let got = if angle.abs() < 0.02 {
                "held"
            } else if angle > 0.0 {
                "down"
            } else {
                "up"
            };
            assert_eq!(got, expected, "{} at {torque} N m: {angle} rad", simulation.engine());
        }
    }
}

#[test]
fn a_saved_state_goes_on_bit_for_bit_and_torques_have_no_friction() {
    let fixture: Fixture = serde_json::from_str(include_str!("../fixtures/bam.json")).unwrap();
    let robot = arm(&fixture.runs[5].parameters);
    let engines: [Box<dyn Simulation>; 2] = [
        Box::new(LifelikeSimulation::new(robot.clone(), 1, 1).unwrap()),
        Box::new(MujocoSimulation::new(robot.clone(), 1, 1).unwrap()),
    ];
    for mut simulation in engines {
        simulation.reset(&[0], &[0.0; 2], &[0.0; 2]).unwrap();
        fixture.targets[..40].iter().for_each(|targets| simulation.step(Drive::Targets(targets)).unwrap());
        let saved = simulation.save();
        let mut end = |reset: bool| {
            if reset {
                simulation.reset(&[0], &[0.5; 2], &[3.0; 2]).unwrap();
                simulation.step(Drive::Targets(&[1.0; 2])).unwrap();
            }
            simulation.restore(&saved).unwrap();
            fixture.targets[40..80].iter().for_each(|targets| simulation.step(Drive::Targets(targets)).unwrap());
            simulation.state().clone()
        };
        assert_eq!(end(false), end(true));
        // At rest without a torque the arm falls, however dry its servos are.
        simulation.reset(&[0], &[0.0; 2], &[0.0; 2]).unwrap();
        (0..20).for_each(|_| simulation.step(Drive::Torques(&[0.0; 2])).unwrap());
        assert!(simulation.state().joint_position[0] > 0.1, "{}", simulation.engine());
    }
}
