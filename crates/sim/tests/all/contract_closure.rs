//! Closed loops and robots that are fixed to the world, without an oracle.
use crate::world;
use std::sync::Arc;

use crate::world::all;
use lifelike_character::{Character, Kinematics};
use lifelike_robot::Robot;
use lifelike_sim::{BatchState, Drive, EnvironmentParameters, IntegrationState, LifelikeSimulation, Simulation};
use lifelike_simd::InstructionSet;
use world::closed::{four_bar, gap, standing_on_a_weld_and_a_foot, standing_on_its_foot, standing_on_welds, waves};

fn mechanisms() -> Vec<(&'static str, Arc<Robot>)> {
    vec![
        ("four-bar", four_bar("")),
        ("flying four-bar", four_bar("<freejoint/>")),
        ("on its foot", standing_on_its_foot("frictionloss=\"0.1\"")),
        ("on welds", standing_on_welds()),
        ("on a weld and a foot", standing_on_a_weld_and_a_foot()),
    ]
}

fn drive(simulation: &mut dyn Simulation, environments: &[usize], t: usize) {
    let (targets, values) = waves(&simulation.robot().clone(), environments, t);
    simulation.step(if targets { Drive::Targets(&values) } else { Drive::Torques(&values) }).unwrap();
}

/// A constraint gives way to a demand a (m/s²) on its acceleration by about a (1 - i) / (i² k): with MuJoCo's defaults
/// (k = 2770 1/s², i = 0.95 beyond a millimetre) 3 mm at 150 m/s², which a crank of 0.1 m at 39 rad/s asks for. MuJoCo's loops
/// open as far (`oracle_closure.rs`), and so do they turn: feet are light, and the softest of their welds holds a leg to 5
/// degrees.
#[test]
fn loops_stay_closed() {
    for (name, robot) in mechanisms() {
        let n = 20;
        let mut simulation = LifelikeSimulation::new(robot.clone(), n, 1).unwrap();
        let mut kinematics = Kinematics::new(&robot.character);
        let mut worst = [0.0_f64; 2];
        let mut fastest = 0.0_f32;
        for t in 0..400 {
            drive(&mut simulation, &all(n), t);
            let saved = simulation.save();
            // One of the welds asks for another place than it begins in, and has time to get there.
            for row in saved.values.chunks(saved.width).filter(|_| t > 50) {
                let now = gap(&robot, &mut kinematics, &row[..robot.character.nq]);
                worst = [worst[0].max(now[0]), worst[1].max(now[1])];
            }
            fastest = simulation.state().joint_velocity.iter().fold(fastest, |a, v| a.max(v.abs()));
        }
        println!(
            "{name}: joints up to {fastest:.1} rad/s, loops open to {:.2} mm, {:.4} rad",
            1e3 * worst[0],
            worst[1]
        );
        assert!(simulation.state().diverged.iter().all(|d| !d), "{name}");
        assert!(worst[0] < 3e-3 && worst[1] < 0.09 && fastest > 0.5, "{name}: {worst:?}");
    }
}

fn run(
    robot: &Arc<Robot>,
    set: InstructionSet,
    environments: &[usize],
    threads: usize,
) -> (BatchState, IntegrationState) {
    let n = environments.len();
    let mut simulation = LifelikeSimulation::with_instructions(set, robot.clone(), n, threads).unwrap();
    for (id, e) in environments.iter().enumerate().filter(|(_, e)| *e % 3 == 1) {
        let mass_scale = vec![0.8 + 0.01 * *e as f32; robot.character.bodies.len()];
        simulation.set_parameters(id, EnvironmentParameters { mass_scale, ..Default::default() }).unwrap();
    }
    (0..30).for_each(|t| drive(&mut simulation, environments, t));
    (simulation.state().clone(), simulation.save())
}

#[test]
fn instructions_threads_and_neighbours_change_no_bit() {
    let environments: Vec<usize> = (0..19).collect();
    let permuted: Vec<usize> = (0..19).map(|i| (i * 7 + 3) % 19).collect();
    for (name, robot) in mechanisms() {
        let expected = run(&robot, InstructionSet::Portable, &environments, 2);
        for set in InstructionSet::available() {
            assert!(run(&robot, set, &environments, 1) == expected, "{name}: {set}");
            let (_, other) = run(&robot, set, &permuted, 3);
            let row =
                |state: &IntegrationState, id: usize| state.values[id * state.width..(id + 1) * state.width].to_vec();
            for (place, e) in permuted.iter().enumerate() {
                assert_eq!(row(&expected.1, *e), row(&other, place), "{name}, {set}: environment {e} in place {place}");
            }
        }
    }
}

#[test]
fn a_saved_state_continues_bit_for_bit() {
    for (name, robot) in mechanisms() {
        let mut simulation = LifelikeSimulation::new(robot.clone(), 3, 1).unwrap();
        (0..20).for_each(|t| drive(&mut simulation, &all(3), t));
        let saved = simulation.save();
        (20..30).for_each(|t| drive(&mut simulation, &all(3), t));
        let expected = simulation.save();
        simulation.restore(&saved).unwrap();
        (20..30).for_each(|t| drive(&mut simulation, &all(3), t));
        assert!(simulation.save() == expected, "{name}");
    }
}

/// A floating base bears nothing: what holds a robot that stands on welds acts on its feet, and must not be found in its root.
#[test]
fn the_joint_of_a_floating_base_has_no_force() {
    for robot in [standing_on_welds(), standing_on_a_weld_and_a_foot(), four_bar("<freejoint/>")] {
        let mut simulation = LifelikeSimulation::new(robot.clone(), 1, 1).unwrap();
        (0..20).for_each(|t| drive(&mut simulation, &[0], t));
        let torques = vec![0.5; robot.joints()];
        let wrenches = simulation.constraint_wrenches(Drive::Torques(&torques)).unwrap();
        let root = &wrenches.joint[6 * robot.character.root_body()..][..6];
        let largest = wrenches.constraint.iter().fold(0.0_f32, |a, x| a.max(x.abs()));
        println!("{}: {root:.5?} of {largest:.1}", robot.name);
        assert!(root.iter().all(|x| x.abs() < 1e-4 * largest.max(10.0)), "{root:?}");
    }
}

#[test]
fn an_inactive_constraint_is_none() {
    let robot = four_bar("");
    let text = robot.character.mjcf.clone().unwrap();
    let with = |text: &str| {
        let mut robot = Robot::clone(&robot);
        robot.character = Character::from_mjcf(text, "four-bar", None).unwrap().into();
        let mut simulation = LifelikeSimulation::new(Arc::new(robot), 2, 1).unwrap();
        (0..50).for_each(|t| drive(&mut simulation, &all(2), t));
        simulation.save().values
    };
    let start = text.find("<equality>").unwrap();
    let end = text.find("</equality>").unwrap() + "</equality>".len();
    let none = with(&(text[..start].to_string() + &text[end..]));
    assert_eq!(with(&text.replace("name=\"pin\"", "name=\"pin\" active=\"false\"")), none);
    assert_ne!(with(&text)[..3], none[..3]);
}

/// A robot without a free joint: its root is where the model puts it, at rest, and everything else moves.
#[test]
fn a_fixed_root_stays_where_it_is() {
    let text = r#"<mujoco><compiler angle="radian"/><worldbody><geom type="plane" size="5 5 1"/>
      <body name="pelvis" pos="1 2 0.9" quat="0.8 0 0 0.6"><geom type="box" size="0.1 0.1 0.1"/>
        <body name="thigh" pos="0 0.1 -0.1"><joint name="hip" axis="0 1 0" range="-2 2" armature="0.01"/><geom type="capsule" fromto="0 0 0 0 0 -0.4" size="0.04"/>
          <body name="shank" pos="0 0 -0.4"><joint name="knee" axis="0 1 0" range="0 2" armature="0.01"/><geom type="capsule" fromto="0 0 0 0 0 -0.43" size="0.03"/>
    </body></body></body></worldbody></mujoco>"#;
    let robot = world::from_text(text);
    let mut simulation = LifelikeSimulation::new(robot.clone(), 3, 1).unwrap();
    let root = |state: &BatchState| {
        (
            state.root_position[3..6].to_vec(),
            state.root_orientation[4..8].to_vec(),
            state.linear_velocity_w[3..6].to_vec(),
        )
    };
    let expected = (vec![1.0, 2.0, 0.9], vec![0.8, 0.0, 0.0, 0.6], vec![0.0; 3]);
    assert_eq!(root(simulation.state()), expected);
    simulation.reset(&[1], &[0.5, 1.0], &[1.0, 0.0]).unwrap();
    simulation.push(1, 3, [3.0, 0.0, 0.0], [0.0; 3]).unwrap();
    assert!(simulation.reset(&[1], &[f64::NAN, 1.0], &[1.0, 0.0]).is_err());
    for _ in 0..100 {
        simulation.step(Drive::Targets(&[0.1; 6])).unwrap();
    }
    let state = simulation.state();
    assert_eq!((root(state), state.diverged[1]), (expected, false));
    assert!(state.joint_position[2] != state.joint_position[0] && state.joint_velocity[2].abs() < 1.0);
    let mut kinematics = Kinematics::new(&robot.character);
    kinematics.update(&robot.character, &[state.joint_position[2].into(), state.joint_position[3].into()]);
    for b in 0..4 {
        for k in 0..3 {
            let off = f64::from(state.body_position[3 * (4 + b) + k]) - kinematics.body_position[b][k];
            assert!(off.abs() < 1e-6, "body {b}: {off}");
        }
    }
    // Straight down the leg reaches 6 cm below the ground: the ground holds its foot there, whatever the root's height.
    simulation.reset(&[0], &[0.0, 0.0], &[0.0, 0.0]).unwrap();
    simulation.clear_pushes(0);
    for _ in 0..100 {
        simulation.step(Drive::Targets(&[0.0; 6])).unwrap();
    }
    let wrenches = simulation.constraint_wrenches(Drive::Targets(&[0.0; 6])).unwrap();
    assert!(wrenches.contact[6 * 3 + 5] > 1.0, "{:?}", &wrenches.contact[18..24]);
    let weight = (robot.character.mass() * 9.81) as f32;
    let held = wrenches.joint[6 + 5] + wrenches.contact[6 * 3 + 5];
    assert!((held - weight).abs() < 1e-2 * weight, "{held} {weight}");
}
