//! Closed loops: welds and ball joints of our engine against MuJoCo's.
use crate::world;
use std::sync::Arc;

use crate::world::closed::{
    four_bar, gap, standing_on_a_weld_and_a_foot, standing_on_its_foot, standing_on_welds, waves,
};
use lifelike_character::rotation::to_wxyz;
use lifelike_character::{Character, EqualityKind, Kinematics, Vec3};
use lifelike_robot::Robot;
use lifelike_sim::mujoco::native::{DSBL_ACTUATION, Data, Model};
use lifelike_sim::{Drive, LifelikeSimulation, MujocoSimulation, Simulation};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use world::{all, rms};

/// Dry friction, and limits that are reached: what shares the sweeps with the loops.
const RUBBING: &str = r#"frictionloss="0.3" range="-0.02 0.5""#;

fn mechanisms() -> Vec<(&'static str, Arc<Robot>)> {
    vec![
        ("four-bar", four_bar("")),
        ("flying four-bar", four_bar("<freejoint/>")),
        ("on its foot", standing_on_its_foot("")),
        ("on its foot, rubbing", standing_on_its_foot(RUBBING)),
        ("on welds", standing_on_welds()),
        ("on a weld and a foot", standing_on_a_weld_and_a_foot()),
    ]
}

/// Whether forces have bounds: then a fixed number of sweeps leaves something, and else nothing.
fn bounded(name: &str) -> bool {
    name.contains("rubbing") || name.ends_with("a foot")
}

fn mujoco(robot: &Robot) -> Data {
    let mut model = Model::from_xml_string(robot.character.mjcf.as_deref().unwrap()).unwrap();
    let mut edited = model.edit();
    *edited.opt_timestep_mut() = robot.timestep();
    *edited.opt_disableflags_mut() |= DSBL_ACTUATION;
    Data::new(model).unwrap()
}

/// Positions around the reference that leave the loops open by `off` (rad, and m of a floating base), and velocities.
fn states(robot: &Robot, n: usize, off: f64, speed: f64) -> (Vec<f64>, Vec<f64>) {
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let mut around = |at: &f64| at + off * rng.random_range(-1.0..1.0);
    let mut positions = Vec::new();
    for _ in 0..n {
        let mut q: Vec<f64> = robot.default_position().iter().map(&mut around).collect();
        if let Some(root) = robot.character.root_joint() {
            let own = &mut q[root.q_index + 3..root.q_index + 7];
            let norm = own.iter().map(|x| x * x).sum::<f64>().sqrt();
            own.iter_mut().for_each(|x| *x /= norm);
        }
        positions.extend(q);
    }
    let velocities = (0..n * robot.character.nv).map(|_| speed * rng.random_range(-1.0..1.0)).collect();
    (positions, velocities)
}

fn random_torques(robot: &Robot, n: usize) -> Vec<f32> {
    let mut rng = ChaCha8Rng::seed_from_u64(6);
    (0..n * robot.joints()).map(|_| rng.random_range(-3.0..3.0)).collect()
}

/// MuJoCo in the state of environment `e` under its torques.
fn put(data: &mut Data, robot: &Robot, e: usize, (q, v): &(Vec<f64>, Vec<f64>), torques: &[f32]) {
    let (nq, nv) = (robot.character.nq, robot.character.nv);
    data.qpos_mut().copy_from_slice(&q[e * nq..(e + 1) * nq]);
    data.qvel_mut().copy_from_slice(&v[e * nv..(e + 1) * nv]);
    data.qacc_warmstart_mut().fill(0.0);
    for (i, joint) in robot.character.scalar_joints().enumerate() {
        data.qfrc_applied_mut()[joint.v_index] = f64::from(torques[e * robot.joints() + i]);
    }
}

/// Frames that the reader found are those that MuJoCo's compiler finds.
#[test]
fn frames_are_mujocos() {
    let text = r#"<mujoco><worldbody>
      <body name="a" pos="0.1 0.2 0.3" euler="10 20 30"><joint axis="1 2 3" ref="20"/><geom size="0.1"/>
        <body name="b" pos="0 0.4 0.1" euler="-40 5 60"><joint type="ball"/><geom size="0.1"/></body></body>
      <body name="c" pos="1 0 1" quat="1 2 3 4"><freejoint/><geom size="0.1"/></body></worldbody>
      <default><equality solref="0.01 2"/><default class="soft"><equality solimp="0.5 0.6 0.1" active="false"/></default></default>
      <equality>
        <connect body1="b" body2="c" anchor="0.3 -0.1 0.2"/>
        <connect body1="b" anchor="0.3 -0.1 0.2" class="soft" solref="0.05"/>
        <weld body1="a" body2="c" anchor="0.1 0.2 0.3" torquescale="0.7"/>
        <weld body1="c"/>
        <weld body1="world" body2="b" anchor="0.1 0.2 0.3" relpose="1 2 3 1 -1 2 0.5"/>
        <weld body1="a" body2="b" relpose="1 2 3 0 0 0 0"/>
      </equality></mujoco>"#;
    let character = Character::from_mjcf(text, "frames", None).unwrap();
    let model = Model::from_xml_string(character.mjcf.as_deref().unwrap()).unwrap();
    assert_eq!(character.equalities.len(), model.neq() as usize);
    let near = |a: &[f64], b: &[f64]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-12);
    for (i, e) in character.equalities.iter().enumerate() {
        assert!(near(&e.solref, &model.eq_solref()[i]) && near(&e.solimp, &model.eq_solimp()[i]), "{e:?}");
        assert_eq!(e.active, model.eq_active0()[i], "{e:?}");
        let (data, [first, second]) = (model.eq_data()[i], &e.anchors);
        // The anchors of a weld stand in the other order.
        let (first, second) = if e.kind == EqualityKind::Connect { (first, second) } else { (second, first) };
        assert!(near(first.as_slice(), &data[..3]) && near(second.as_slice(), &data[3..6]), "{e:?} {data:?}");
        if let EqualityKind::Weld { torque_scale } = e.kind {
            let own = to_wxyz(&e.orientations[0]);
            let sign = own.iter().zip(&data[6..10]).map(|(a, b)| a * b).sum::<f64>().signum();
            assert!(near(&own.map(|x| sign * x), &data[6..10]) && torque_scale == data[10], "{e:?} {data:?}");
        }
    }
}

/// From states whose loops are open by centimetres and degrees: accelerations in one step.
#[test]
fn accelerations_are_mujocos() {
    for (name, robot) in mechanisms() {
        let (n, nq, nv, h) = (50, robot.character.nq, robot.character.nv, robot.timestep());
        let mut data = mujoco(&robot);
        let mut double = LifelikeSimulation::in_double_precision(robot.clone(), n, 1).unwrap().with_iterations(3000);
        let mut single = LifelikeSimulation::new(robot.clone(), n, 1).unwrap();
        let state = states(&robot, n, 0.05, 1.0);
        let torques = random_torques(&robot, n);
        let step = |simulation: &mut LifelikeSimulation| {
            simulation.reset(&all(n), &state.0, &state.1).unwrap();
            simulation.step(Drive::Torques(&torques)).unwrap();
            simulation.save()
        };
        let results = [step(&mut double), step(&mut single)];
        let (mut worst, mut largest, mut open) = ([0.0_f64; 2], 0.0_f64, [0.0_f64; 2]);
        let mut kinematics = Kinematics::new(&robot.character);
        for e in 0..n {
            let now = gap(&robot, &mut kinematics, &state.0[e * nq..(e + 1) * nq]);
            open = [open[0].max(now[0]), open[1].max(now[1])];
            put(&mut data, &robot, e, &state, &torques);
            data.step();
            for d in 0..nv {
                let expected = (data.qvel()[d] - state.1[e * nv + d]) / h;
                largest = largest.max(expected.abs());
                for (worst, got) in worst.iter_mut().zip(&results) {
                    let got = (got.values[e * got.width + nq + d] - state.1[e * nv + d]) / h;
                    *worst = worst.max((got - expected).abs());
                }
            }
        }
        let [exact, fast] = worst.map(|x| x / largest);
        println!(
            "{name}: loops open by {open:.3?}: accelerations of up to {largest:.0} are {exact:.1e} off in f64, converged, \
             {fast:.1e} in f32 with 12 visits"
        );
        // Rounding, where MuJoCo's Newton has converged to 1e-14 as well; contacts converge to what PGS leaves after 3000.
        assert!(exact < 1e-9, "{name}: {exact}");
        // Of a matrix whose condition is some hundreds single precision keeps five digits. Forces with bounds are begun with
        // none, and twelve visits do not find them all.
        assert!(fast < if bounded(name) { 0.1 } else { 5e-5 }, "{name}: {fast}");
    }
}

/// Two seconds released from rest with closed loops, and driven.
#[test]
fn two_seconds_are_mujocos() {
    for (name, robot) in mechanisms() {
        let n = 8;
        // What falls over and bounces is not to be compared after two seconds.
        let free = (!name.ends_with("a foot")).then_some(false);
        for driven in free.into_iter().chain([true]) {
            let (positions, velocities) = states(&robot, n, 0.0, 0.0);
            let mut kinematics = Kinematics::new(&robot.character);
            let mut course = |simulation: &mut dyn Simulation| {
                simulation.reset(&all(n), &positions, &velocities).unwrap();
                let (mut course, mut open) = (Vec::new(), [0.0_f64; 2]);
                for t in 0..400 {
                    let (targets, mut values) = waves(&robot, &all(n), t);
                    if !driven {
                        values.fill(0.0);
                    }
                    let drive = if targets && driven { Drive::Targets(&values) } else { Drive::Torques(&values) };
                    simulation.step(drive).unwrap();
                    course.extend_from_slice(&simulation.state().joint_position);
                    let saved = simulation.save();
                    let at = usize::from(simulation.engine() == "mujoco");
                    for row in saved.values.chunks(saved.width) {
                        let now = gap(&robot, &mut kinematics, &row[at..at + robot.character.nq]);
                        open = [open[0].max(now[0]), open[1].max(now[1])];
                    }
                }
                (course, open)
            };
            let double = || LifelikeSimulation::in_double_precision(robot.clone(), n, 1).unwrap();
            let (theirs, their_gap) = course(&mut MujocoSimulation::new(robot.clone(), n, 1).unwrap());
            let (exact, _) = course(&mut double().with_iterations(1000));
            let (plain, _) = course(&mut double());
            let (single, own_gap) = course(&mut LifelikeSimulation::new(robot.clone(), n, 1).unwrap());
            let far = theirs.iter().fold(0.0_f32, |a, x| a.max(x.abs()));
            let [exact, plain, single] = [&exact, &plain, &single].map(|x| rms(&theirs, x));
            println!(
                "{name}, {}: joints go as far as {far:.2} rad; RMS off MuJoCo {exact:.1e} rad in f64, converged, {plain:.1e} \
                 with 12 visits, {single:.1e} in f32; loops open to {own_gap:.5?}, MuJoCo's {their_gap:.5?}",
                if driven { "driven" } else { "released" }
            );
            // The same equations in double precision: the outputs are rounded to single precision, 4e-7 rad at 7 rad.
            assert!(exact < 1e-6, "{name}: {exact}");
            // Single precision rounds by 6e-8. What actuators hold forgets it, a linkage that swings keeps it. Legs that nothing
            // holds collapse and whip like double pendulums: double precision, which rounds by 1e-16, ends up to 1e-8 off,
            // so single precision cannot be held to anything.
            let rounding = match (driven, robot.joints()) {
                (true, _) => 3e-5,
                (false, 3) => 5e-4,
                (false, _) => f64::INFINITY,
            };
            let limit = if bounded(name) { 2e-3_f64.max(rounding) } else { rounding };
            assert!(single < limit && (bounded(name) || plain < 1e-6), "{name}: {plain} {single}");
            for k in 0..2 {
                assert!(own_gap[k] < 1.1 * their_gap[k] + 1e-5, "{name}: {own_gap:?} {their_gap:?}");
            }
        }
    }
}

/// Torque and force about another point.
fn moved(torque: Vec3, force: Vec3, from: Vec3, to: Vec3) -> [f64; 6] {
    let torque = torque + (from - to).cross(&force);
    [torque.x, torque.y, torque.z, force.x, force.y, force.z]
}

/// What closes loops is among the constraint forces of its bodies, and not in the joints of the tree: both engines against
/// MuJoCo called by hand.
#[test]
fn forces_on_bodies_are_mujocos() {
    for (name, robot) in mechanisms() {
        let (n, bodies) = (20, robot.character.bodies.len());
        let state = states(&robot, n, 0.05, 1.0);
        let torques = random_torques(&robot, n);
        let mut ours = LifelikeSimulation::in_double_precision(robot.clone(), n, 1).unwrap().with_iterations(3000);
        let mut theirs = MujocoSimulation::new(robot.clone(), n, 1).unwrap();
        let engines = [&mut ours as &mut dyn Simulation, &mut theirs].map(|simulation| {
            simulation.reset(&all(n), &state.0, &state.1).unwrap();
            simulation.constraint_wrenches(Drive::Torques(&torques)).unwrap()
        });
        let mut data = mujoco(&robot);
        let (mut worst, mut largest, mut loads) = ([0.0_f64; 2], [0.0_f64; 2], 0.0_f64);
        for e in 0..n {
            put(&mut data, &robot, e, &state, &torques);
            data.forward();
            data.rne_post_constraint();
            let wrench = |x: &[f64; 6]| (Vec3::new(x[0], x[1], x[2]), Vec3::new(x[3], x[4], x[5]));
            for b in 1..bodies {
                let root = data.model().body_rootid()[b] as usize;
                let (middle, com) = (Vec3::from(data.subtree_com()[root]), Vec3::from(data.xipos()[b]));
                let (torque, force) = wrench(&data.cfrc_int()[b]);
                let joint = moved(torque, force, middle, Vec3::from(data.xpos()[b]));
                // Joints and contacts of a body together: what closes loops is in MuJoCo's external forces.
                let (mut torque, mut force) = (torque, force);
                for child in (1..bodies).filter(|c| robot.character.bodies[*c].parent == b) {
                    let (t, f) = wrench(&data.cfrc_int()[child]);
                    (torque, force) = (torque - t, force - f);
                }
                let (t, f) = wrench(&data.cfrc_ext()[b]);
                let together = moved(torque + t, force + f, middle, com);
                let at = 6 * (e * bodies + b);
                for engine in &engines {
                    for k in 0..6 {
                        let sum = engine.constraint[at + k] + engine.contact[at + k];
                        for (i, (own, their)) in
                            [(engine.joint[at + k], joint[k]), (sum, together[k])].into_iter().enumerate()
                        {
                            worst[i] = worst[i].max((f64::from(own) - their).abs());
                            largest[i] = largest[i].max(their.abs());
                        }
                        if !name.ends_with("a foot") {
                            assert!(engine.contact[at + k].abs() < 1e-5, "{name}: nothing touches");
                        }
                    }
                }
            }
            // Along its axis a joint bears what its actuator, its damping and its rotor make of it, whatever closes the loop.
            for (i, joint) in robot.character.scalar_joints().enumerate().filter(|_| !name.contains("rubbing")) {
                let v = joint.v_index;
                let rotor = data.model().dof_armature()[v] * data.qacc()[v];
                let load = data.qfrc_applied()[v] + data.qfrc_passive()[v] - rotor;
                for engine in &engines {
                    loads = loads.max((f64::from(engine.joint_load[e * robot.joints() + i]) - load).abs());
                }
            }
        }
        println!("{name}: joints, all: {worst:.5?} N off, of up to {largest:.1?}; loads {loads:.1e} N m off");
        assert!((0..2).all(|k| worst[k] < 1e-5 * largest[k]) && loads < 1e-5 * largest[0], "{name}");
    }
}
