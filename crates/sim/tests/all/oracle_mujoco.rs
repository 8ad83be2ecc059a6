//! The batch against MuJoCo itself, stepped by hand, and against arithmetic.
use std::sync::Arc;

use lifelike_character::Character;
use lifelike_robot::{Profile, Robot};
use lifelike_sim::mujoco::native::{DSBL_ACTUATION, Data, Model, OBJ_GEOM};
use lifelike_sim::{BatchState, Drive, EnvironmentParameters, MujocoSimulation, Simulation};

/// MuJoCo as a user of its C interface would set it up.
fn by_hand(robot: &Robot) -> Data {
    let mut model = Model::from_xml_string(robot.character.mjcf.as_deref().unwrap()).unwrap();
    let mut edited = model.edit();
    *edited.opt_timestep_mut() = 0.005;
    *edited.opt_disableflags_mut() |= DSBL_ACTUATION;
    let mut data = Data::new(model).unwrap();
    data.qpos_mut().copy_from_slice(&robot.default_position());
    data
}

/// One physics step with the law of eqs. 4.9-4.11; the joints are those behind the free one.
fn step_by_hand(data: &mut Data, robot: &Robot, targets: &[f32], damping: &[f64]) -> Vec<f64> {
    let mut torques = Vec::new();
    for (i, actuator) in robot.actuators.parameters.iter().enumerate() {
        let (q, v) = (data.qpos()[7 + i], data.qvel()[6 + i]);
        let motor = actuator.motor_torque(f64::from(targets[i]), q, v);
        data.qfrc_applied_mut()[6 + i] = motor;
        data.model_mut().dof_damping_mut()[6 + i] = damping[i] + actuator.friction_damping(v);
        torques.push(motor - actuator.friction_torque(v));
    }
    data.step();
    torques
}

fn own_damping(data: &Data) -> Vec<f64> {
    data.model().dof_damping()[6..].to_vec()
}

fn targets(robot: &Robot, t: usize) -> Vec<f32> {
    let wave = |i: usize| (0.4 * (t as f64 * 0.3 + i as f64).sin()) as f32;
    robot.default_pose.iter().enumerate().map(|(i, &q)| q as f32 + wave(i)).collect()
}

fn check_bitwise(state: &BatchState, e: usize, data: &Data, robot: &Robot) {
    let j = robot.joints();
    let narrow = |v: &[f64]| v.iter().map(|&x| x as f32).collect::<Vec<_>>();
    assert_eq!(state.root_position[3 * e..3 * e + 3], narrow(&data.qpos()[..3]));
    assert_eq!(state.root_orientation[4 * e..4 * e + 4], narrow(&data.qpos()[3..7]));
    assert_eq!(state.linear_velocity_w[3 * e..3 * e + 3], narrow(&data.qvel()[..3]));
    assert_eq!(state.joint_position[e * j..(e + 1) * j], narrow(&data.qpos()[7..]));
    assert_eq!(state.joint_velocity[e * j..(e + 1) * j], narrow(&data.qvel()[6..]));
}

#[test]
fn a_batch_of_many_is_mujoco_to_the_bit() {
    for name in ["lima", "humanoid"] {
        let robot = Arc::new(Robot::load(name).unwrap());
        let mut simulation = MujocoSimulation::new(robot.clone(), 5, 2).unwrap();
        let mut hand = by_hand(&robot);
        let damping = own_damping(&hand);
        for t in 0..60 {
            let mut all = Vec::new();
            (0..5).for_each(|e| all.extend(targets(&robot, if e == 3 { t } else { t + 100 * e })));
            simulation.step(Drive::Targets(&all)).unwrap();
            let mut squared = vec![0.0; robot.joints()];
            let mut last = Vec::new();
            for _ in 0..4 {
                last = step_by_hand(&mut hand, &robot, &targets(&robot, t), &damping);
                squared.iter_mut().zip(&last).for_each(|(s, l)| *s += l * l / 4.0);
            }
            let (state, j) = (simulation.state(), robot.joints());
            check_bitwise(state, 3, &hand, &robot);
            for i in 0..j {
                let (got, expected) = (f64::from(state.torque[3 * j + i]), last[i]);
                assert!((got - expected).abs() < 1e-5 * (1.0 + expected.abs()), "torque {i}: {got}, {expected}");
                let (got, expected) = (f64::from(state.torque_squared[3 * j + i]), squared[i]);
                assert!((got - expected).abs() < 1e-5 * (1.0 + expected), "squared torque {i}: {got}, {expected}");
            }
            // The free joint's vertical constraint force is all that the ground does; a foot's share is part of it.
            let ground: f64 = hand.qfrc_constraint()[2];
            let feet: f32 = state.foot_force[3 * 2..3 * 2 + 2].iter().sum();
            assert!(state.foot_force.iter().all(|&f| f >= 0.0));
            let only_feet = hand.contact().iter().all(|c| {
                let names = c.geom.map(|g| hand.model().id_to_name(OBJ_GEOM, g as usize));
                names.iter().any(|n| n.is_some_and(|n| n.contains("foot") || n.contains("toe") || n.contains("sole")))
            });
            if only_feet {
                assert!((f64::from(feet) - ground).abs() < 1e-3 * (1.0 + ground.abs()), "{name} {t}: {feet}, {ground}");
            }
            // Poses are those after the step.
            hand.kinematics();
            let bodies = robot.character.bodies.len();
            for body in 0..bodies {
                let at = 3 * (3 * bodies + body);
                let expected = hand.xpos()[body].map(|x| x as f32);
                assert_eq!(state.body_position[at..at + 3], expected, "body {body}");
            }
        }
    }
}

#[test]
fn parameters_are_those_of_a_model_changed_by_hand() {
    let robot = Arc::new(Robot::load("lima").unwrap());
    let bodies = robot.character.bodies.len();
    let mut simulation = MujocoSimulation::new(robot.clone(), 3, 1).unwrap();
    let mass_scale: Vec<f32> = (0..bodies).map(|b| 0.9 + 0.01 * b as f32).collect();
    let parameters = EnvironmentParameters {
        mass_scale: mass_scale.clone(),
        ground_friction: Some(0.35),
        ..EnvironmentParameters::default()
    };
    simulation.set_parameters(1, parameters).unwrap();
    simulation.push(1, 2, [3.0, -20.0, 1.0], [0.5, 0.0, 0.25]).unwrap();
    let mut plain = by_hand(&robot);
    let mut changed = by_hand(&robot);
    let damping = own_damping(&changed);
    let mut model = changed.model_mut();
    for (body, &scale) in mass_scale.iter().enumerate() {
        model.body_mass_mut()[body] *= f64::from(scale);
        model.body_inertia_mut()[body].iter_mut().for_each(|i| *i *= f64::from(scale));
    }
    model.geom_friction_mut().iter_mut().for_each(|f| f[0] = f64::from(0.35_f32));
    changed.set_const();
    changed.qpos_mut().copy_from_slice(&robot.default_position());
    changed.xfrc_applied_mut()[2] = [3.0, -20.0, 1.0, 0.5, 0.0, 0.25];
    for t in 0..40 {
        simulation.step(Drive::Targets(&targets(&robot, t).repeat(3))).unwrap();
        for _ in 0..4 {
            step_by_hand(&mut plain, &robot, &targets(&robot, t), &damping);
            step_by_hand(&mut changed, &robot, &targets(&robot, t), &damping);
        }
        check_bitwise(simulation.state(), 0, &plain, &robot);
        check_bitwise(simulation.state(), 1, &changed, &robot);
        check_bitwise(simulation.state(), 2, &plain, &robot);
    }
    // Back to normal: the default takes everything back.
    simulation.clear_pushes(1);
    simulation.set_parameters(1, EnvironmentParameters::default()).unwrap();
    let (position, velocity) = (robot.default_position(), vec![0.0; robot.character.nv]);
    simulation.reset(&[0, 1], &position.repeat(2), &velocity.repeat(2)).unwrap();
    simulation.step(Drive::Targets(&targets(&robot, 0).repeat(3))).unwrap();
    let state = simulation.state();
    assert_eq!(state.joint_velocity[..20], state.joint_velocity[20..40]);
}

#[test]
fn angular_velocity_is_in_the_world() {
    let robot = Arc::new(Robot::load("lima").unwrap());
    let mut simulation = MujocoSimulation::new(robot.clone(), 1, 1).unwrap();
    let mut position = robot.default_position();
    let half = std::f64::consts::FRAC_1_SQRT_2;
    position[3..7].copy_from_slice(&[half, 0.0, 0.0, half]); // a quarter turn to the left: the body's x is the world's y
    let mut velocity = vec![0.0; robot.character.nv];
    velocity[..6].copy_from_slice(&[1.0, 2.0, 3.0, 0.5, 0.0, -1.0]);
    simulation.reset(&[0], &position, &velocity).unwrap();
    let state = simulation.state();
    assert_eq!(state.linear_velocity_w, [1.0, 2.0, 3.0], "linear velocity is the world's already");
    for (got, expected) in state.angular_velocity_w.iter().zip([0.0, 0.5, -1.0]) {
        assert!((got - expected).abs() < 1e-6, "{:?}", state.angular_velocity_w);
    }
}

/// A heavy floating block with two light hinges, far above the ground, without gravity.
fn block(joint: &str, jacobian: &str, profile: &str) -> Arc<Robot> {
    let text = format!(
        r#"<mujoco model="block"><compiler angle="radian" autolimits="true"/>
        <option gravity="0 0 0" timestep="0.005" jacobian="{jacobian}"/>
        <worldbody><body name="block" pos="0 0 50"><freejoint name="root"/>
          <inertial pos="0 0 0" mass="1e7" diaginertia="1e7 1e7 1e7"/>
          <body name="one"><joint name="one" axis="0 1 0" {joint}/><inertial pos="0 0 0" mass="0.1" diaginertia="0.01 0.011 0.01"/></body>
          <body name="two"><joint name="two" axis="0 1 0" {joint}/><inertial pos="0 0 0" mass="0.1" diaginertia="0.01 0.011 0.01"/></body>
        </body></worldbody></mujoco>"#
    );
    let character = Character::from_mjcf(&text, "block.xml", None).unwrap();
    let profile = Profile::from_toml(profile, std::path::Path::new("block.toml")).unwrap();
    Arc::new(Robot::from_character(character, profile).unwrap())
}

fn actuators(kp: f64, static_friction: f64) -> String {
    format!(
        "[actuator.all]\njoints = [\"*\"]\n[actuator.all.parameters]\nkp = {kp}\nkd = 0\nfriction_velocity = 0.1\n\
         static_friction = {static_friction}\nviscous_friction = 0.023\ntorque_max = 34\nfull_torque_velocity = 7.4\n\
         velocity_max = 20\n"
    )
}

/// Velocities of the block's joints after each policy step, at a physics rate.
fn coast(physics_hz: f64, start: [f64; 2], steps: usize) -> (Vec<[f64; 2]>, Arc<Robot>) {
    // 0.45 / 0.1 · 0.005 / 0.011 = 2.05: at 200 Hz the explicit form would be unstable.
    let robot = block("", "auto", &format!("physics_hz = {physics_hz}\n{}", actuators(0.0, 0.45)));
    let mut simulation = MujocoSimulation::new(robot.clone(), 1, 1).unwrap();
    let mut velocity = vec![0.0; robot.character.nv];
    velocity[6..8].copy_from_slice(&start);
    simulation.reset(&[0], &robot.default_position(), &velocity).unwrap();
    let mut step = || {
        simulation.step(Drive::Targets(&[0.0, 0.0])).unwrap();
        [0, 1].map(|joint| f64::from(simulation.state().joint_velocity[joint]))
    };
    ((0..steps).map(|_| step()).collect(), robot)
}

#[test]
fn friction_is_integrated_to_first_order() {
    let (at_800, robot) = coast(800.0, [5.0, 3.0], 2);
    let (at_3200, _) = coast(3200.0, [5.0, 3.0], 2);
    let actuator = robot.actuators.parameters[0];
    for (joint, start) in [5.0, 3.0].into_iter().enumerate() {
        // 0.011 dv/dt = -friction(v) for 0.04 s, in steps of a microsecond.
        let exact = (0..40_000).fold(start, |v, _| v - 1e-6 / 0.011 * actuator.friction_torque(v));
        let error = |velocities: &[[f64; 2]]| velocities[1][joint] - exact;
        let ratio = error(&at_800) / error(&at_3200);
        assert!((3.5..4.5).contains(&ratio), "a quarter of the step, a quarter of the error: {ratio}");
    }
}

#[test]
fn friction_stops_a_light_joint_and_does_not_shake_it() {
    let (velocities, _) = coast(200.0, [5.0, -0.2], 25);
    let mut before = [5.0, -0.2];
    for now in velocities {
        for (joint, (now, before)) in now.into_iter().zip(before).enumerate() {
            // The joint turns the heavy block back by a billionth of its own speed.
            assert!(now * before >= 0.0 || now.abs() < 1e-6, "joint {joint} shakes: {before}, then {now}");
            assert!(now.abs() <= before.abs().max(1e-6), "joint {joint} speeds up: {before}, then {now}");
        }
        before = now;
    }
    assert!(before.iter().all(|v| v.abs() < 1e-3), "{before:?}");
}

#[test]
fn rotors_of_the_profile_are_those_of_the_text() {
    let speeds = |joint: &str, rotor: &str| {
        let profile = actuators(0.0, 0.0).replace("joints =", &format!("{rotor}\njoints ="));
        let robot = block(joint, "auto", &profile);
        let mut simulation = MujocoSimulation::new(robot.clone(), 1, 1).unwrap();
        simulation.reset(&[0], &robot.default_position(), &vec![0.0; robot.character.nv]).unwrap();
        simulation.step(Drive::Torques(&[0.3, -0.2])).unwrap();
        simulation.state().joint_velocity.clone()
    };
    let text = speeds(r#"armature="0.02""#, "");
    assert_eq!(speeds("", "armature = 0.02"), text);
    assert!(speeds("", "")[0] > 2.0 * text[0], "it weighs something");
}

#[test]
fn torques_are_applied_as_they_are() {
    let robot = block("", "auto", &actuators(0.0, 0.45));
    let mut simulation = MujocoSimulation::new(robot, 1, 1).unwrap();
    simulation.step(Drive::Torques(&[50.0, -0.1])).unwrap();
    // 4 steps of 0.005 s: v = torque · 0.02 / 0.011, without clamp or friction.
    for (got, torque) in simulation.state().joint_velocity.iter().zip([50.0, -0.1]) {
        let expected = torque * 0.02 / 0.011;
        assert!((f64::from(*got) - expected).abs() < 1e-5 * f64::abs(expected), "{got}, expected {expected}");
    }
    assert_eq!(simulation.state().torque, [50.0, -0.1]);
    assert!((simulation.state().torque_squared[0] - 2500.0).abs() < 1e-3);
}

#[test]
fn joint_constraint_forces_are_those_in_joint_space() {
    for jacobian in ["dense", "sparse"] {
        // Off the ground there are no other constraints, so MuJoCo's generalised constraint force is the oracle.
        let robot = block("range=\"-0.3 0.4\" frictionloss=\"0.05\"", jacobian, &actuators(20.0, 0.0));
        let mut simulation = MujocoSimulation::new(robot.clone(), 1, 1).unwrap();
        let mut hand = by_hand(&robot);
        let damping = own_damping(&hand);
        let (mut upper, mut lower) = (false, false);
        for t in 0..60 {
            let target = if t < 30 { [1.0, -1.0] } else { [-1.0, 1.0] };
            simulation.step(Drive::Targets(&target)).unwrap();
            (0..4).for_each(|_| drop(step_by_hand(&mut hand, &robot, &target, &damping)));
            for joint in 0..2 {
                let (got, expected) = (simulation.state().constraint_force[joint], hand.qfrc_constraint()[6 + joint]);
                let bound = 1e-5 * (1.0 + expected.abs());
                assert!((f64::from(got) - expected).abs() < bound, "{jacobian} {t} {joint}: {got}, {expected}");
                upper |= expected < -1.0;
                lower |= expected > 1.0;
            }
        }
        assert!(upper && lower, "both limits were hit");
    }
}

#[test]
fn a_model_without_a_floor_gets_one() {
    let text = r#"<mujoco model="brick"><compiler angle="radian" autolimits="true"/><worldbody>
        <body name="brick" pos="0 0 0.5"><freejoint name="root"/><geom type="box" size=".2 .2 .1" mass="5"/>
        <body name="lid" pos="0 0 .1"><joint name="lid" axis="0 0 1"/><geom type="box" size=".1 .1 .02" pos="0 0 .1" mass="1"/></body>
        </body></worldbody></mujoco>"#;
    let character = Character::from_mjcf(text, "brick.xml", None).unwrap();
    let robot = Arc::new(Robot::from_character(character, Profile::default()).unwrap());
    let mut simulation = MujocoSimulation::new(robot, 2, 1).unwrap();
    for _ in 0..100 {
        simulation.step(Drive::Targets(&[0.0, 0.0])).unwrap();
    }
    for height in simulation.state().root_position.chunks(3).map(|p| p[2]) {
        assert!((height - 0.1).abs() < 2e-3, "rests on its side of 0.1 m: {height}");
    }
}
