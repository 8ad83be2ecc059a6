//! The test bench of a servo against its authors' equations (`fixtures/make_bench.py`).

use std::collections::BTreeMap;

use lifelike_robot::actuator::{DcMotor, ExtendedFriction};
use lifelike_sim::bench::{BenchCommands, PendulumBench};

#[derive(serde::Deserialize)]
struct Fixture {
    mass: f64,
    arm: f64,
    kp: f64,
    supply: f64,
    step: f64,
    goal: Vec<f64>,
    on: Vec<bool>,
    models: Vec<Model>,
}

#[derive(serde::Deserialize)]
struct Model {
    model: String,
    parameters: BTreeMap<String, serde_json::Value>,
    position: Vec<f64>,
}

#[test]
fn all_six_friction_models_turn_the_arm_as_their_authors_say() {
    let fixture: Fixture = serde_json::from_str(include_str!("../fixtures/bench.json")).unwrap();
    for Model { model, parameters, position } in &fixture.models {
        let number = |name: &str| parameters.get(name).and_then(serde_json::Value::as_f64).unwrap_or(0.0);
        let one = |name: &str| [number(name); 2];
        let (load, rest) = match model.as_str() {
            "m5" | "m6" => (
                [number("load_friction_motor"), number("load_friction_external")],
                [number("load_friction_motor_stribeck"), number("load_friction_external_stribeck")],
            ),
            _ => (one("load_friction_base"), one("load_friction_stribeck")),
        };
        let bench = PendulumBench {
            mass: fixture.mass,
            arm_mass: 0.0,
            arm: fixture.arm,
            goal_speed: None,
            armature: number("armature"),
            offset: number("q_offset"),
            motor: DcMotor {
                proportional: fixture.kp * 4096.0 / std::f64::consts::TAU / (256.0 * 885.0),
                integral: 0.0,
                derivative: 0.0,
                duty_max: 1.0,
                supply: fixture.supply,
                supply_resistance: 0.0,
                resistance: number("R"),
                torque_constant: number("kt"),
                current_max: f64::INFINITY,
            },
            friction: ExtendedFriction {
                base: number("friction_base"),
                stribeck: number("friction_stribeck"),
                stribeck_velocity: number("dtheta_stribeck"),
                stribeck_exponent: number("alpha"),
                load,
                load_stribeck: rest,
                load_quadratic: [number("load_friction_motor_quad"), number("load_friction_external_quad")],
                viscous: number("friction_viscous"),
            },
            delay: 0.0,
        };
        let commands = BenchCommands { step: fixture.step, goal: &fixture.goal, enabled: &fixture.on };
        let motion = bench.run(commands, 0.1, -0.2);
        for (i, (expected, got)) in position.iter().zip(motion.position.iter().step_by(20)).enumerate() {
            assert!((expected - got).abs() < 1e-9, "{model}, step {}: {got} for {expected}", 20 * i);
        }
        // The six are not one.
        assert!(motion.position.iter().any(|q| q.abs() > 0.3));
    }
}

#[test]
fn commands_come_later_by_the_delay() {
    let bench = |delay: f64, goal_speed: Option<f64>| PendulumBench {
        mass: 0.2,
        arm_mass: 0.0,
        arm: 0.1,
        goal_speed,
        armature: 1e-3,
        offset: 0.0,
        motor: DcMotor {
            proportional: 2.0,
            integral: 0.0,
            derivative: 0.0,
            duty_max: 1.0,
            supply: 7.4,
            supply_resistance: 0.0,
            resistance: 4.0,
            torque_constant: 0.35,
            current_max: f64::INFINITY,
        },
        friction: ExtendedFriction { base: 0.01, ..ExtendedFriction::default() },
        delay,
    };
    let goal: Vec<f64> = (0..200).map(|i| if i < 20 { 0.0 } else { 0.5 }).collect();
    let enabled = vec![true; 200];
    let commands = BenchCommands { step: 0.005, goal: &goal, enabled: &enabled };
    let (now, later) = (bench(0.0, None).run(commands, 0.0, 0.0), bench(0.02, None).run(commands, 0.0, 0.0));
    // Four steps.
    assert!(now.position.iter().zip(&later.position[4..]).all(|(a, b)| (a - b).abs() < 1e-12));
    assert!(now.position[199] > 0.2);
    // A controller whose reference moves no faster than 1 rad/s gets the step as a ramp of half a second.
    let ramp: Vec<f64> = (0..200).map(|i| (0.005 * (f64::from(i) - 19.0)).clamp(0.0, 0.5)).collect();
    let limited = bench(0.0, Some(1.0)).run(commands, 0.0, 0.0);
    let ramped = bench(0.0, None).run(BenchCommands { goal: &ramp, ..commands }, 0.0, 0.0);
    assert!(limited.position.iter().zip(&ramped.position).all(|(a, b)| (a - b).abs() < 1e-12));
}
