//! Joints that follow others, in our engine and in kinematics, against MuJoCo (`fixtures/make_couplings.py`).

use std::sync::Arc;

use lifelike_character::{Character, Kinematics};
use lifelike_robot::{Profile, Robot};
use lifelike_sim::{Drive, LifelikeSimulation, Simulation};

#[derive(serde::Deserialize)]
struct Fixture {
    states: Vec<State>,
}

#[derive(serde::Deserialize)]
struct State {
    q: Vec<f64>,
    v: Vec<f64>,
    torques: Vec<f32>,
    /// Velocities after each step.
    after: Vec<Vec<f64>>,
    end: Vec<f64>,
}

const TEXT: &str = include_str!("../fixtures/couplings.xml");

fn hand() -> Arc<Robot> {
    let character = Character::from_mjcf(TEXT, "couplings.xml", None).unwrap();
    let profile = "control_hz = 200\nphysics_hz = 200\n[actuator.all]\njoints = [\"*\"]\narmature = 0.002\n\
                   parameters = { kp = 0.0, kd = 0.0, friction_velocity = 1.0, static_friction = 0.0, viscous_friction = 0.0, \
                   torque_max = 10.0, full_torque_velocity = 100.0, velocity_max = 100.0 }\n";
    let profile: Profile = toml::from_str(profile).unwrap();
    Arc::new(Robot::from_character(character, profile).unwrap())
}

/// The first step is compared as accelerations; later ones as velocities, on which errors add up.
#[test]
fn rollouts_are_mujocos() {
    let Fixture { states } = serde_json::from_str(include_str!("../fixtures/couplings.json")).unwrap();
    let (robot, n) = (hand(), states.len());
    assert_eq!(robot.layout.joints, ["proximal", "thumb"]);
    let [q, v] =
        [|s: &State| s.q.clone(), |s: &State| s.v.clone()].map(|of| states.iter().flat_map(of).collect::<Vec<_>>());
    let torques: Vec<f32> = states.iter().flat_map(|s| s.torques.clone()).collect();
    let all: Vec<usize> = (0..n).collect();
    let run = |mut simulation: LifelikeSimulation| {
        simulation.reset(&all, &q, &v).unwrap();
        let (nq, nv, h) = (robot.character.nq, robot.character.nv, robot.timestep());
        let (mut first, mut worst, mut largest, mut place) = (0.0_f64, 0.0_f64, 0.0_f64, 0.0_f64);
        for step in 0..states[0].after.len() {
            simulation.step(Drive::Torques(&torques)).unwrap();
            let saved = simulation.save();
            for (e, state) in states.iter().enumerate() {
                let row = &saved.values[e * saved.width..];
                for d in 0..nv {
                    let off = (row[nq + d] - state.after[step][d]).abs();
                    worst = worst.max(off);
                    if step == 0 {
                        first = first.max(off / h);
                        largest = largest.max((state.after[0][d] - state.v[d]).abs() / h);
                    }
                }
                if step + 1 == state.after.len() {
                    place = (0..nq).fold(place, |most, i| most.max((row[i] - state.end[i]).abs()));
                }
            }
        }
        [first / largest, worst, place]
    };
    let double = run(LifelikeSimulation::in_double_precision(robot.clone(), n, 1).unwrap().with_iterations(200));
    let single = run(LifelikeSimulation::new(robot.clone(), n, 1).unwrap());
    let shown = |[first, velocity, place]: &[f64; 3]| format!("{first:.1e}, {velocity:.1e}, {place:.1e}");
    println!("first accelerations (share), velocities (rad/s), positions (rad):");
    println!("f64 {}, f32 {}", shown(&double), shown(&single));
    assert!(double[0] < 1e-9 && double[1] < 1e-6 && double[2] < 1e-7, "{double:?}");
    assert!(single[0] < 1e-3 && single[2] < 1e-3, "{single:?}");
}

/// Kinematics puts followers where their polynomials say: by hand, and as differences of positions.
#[test]
fn followers_are_where_their_leaders_put_them() {
    let robot = hand();
    let character = &robot.character;
    let joint = |name: &str| &character.joints[character.joint(name).unwrap()];
    let (mut q, mut v) = (character.reference_position(), vec![0.0; character.nv]);
    let moved = |q: &[f64], name: &str| q[joint(name).q_index] - joint(name).reference;
    q[joint("proximal").q_index] += 0.5;
    v[joint("proximal").v_index] = 2.0;
    character.follow(&mut q, &mut v);
    let x: f64 = 0.1 + 0.8 * 0.5 - 0.3 * 0.25 + 0.2 * 0.125 + 0.1 * 0.0625;
    assert!((moved(&q, "middle") - x).abs() < 1e-12);
    assert!((moved(&q, "distal") - (0.7 * x + 0.2 * x * x)).abs() < 1e-12);
    assert!((moved(&q, "latch") - 0.3).abs() < 1e-12 && (moved(&q, "rod") - 0.01).abs() < 1e-12);
    let slope = 0.8 - 0.6 * 0.5 + 0.6 * 0.25 + 0.4 * 0.125;
    assert!((v[joint("middle").v_index] - 2.0 * slope).abs() < 1e-12);

    let tip = character.body("distal").unwrap();
    let place = |angle: f64| {
        let mut q = character.reference_position();
        q[joint("proximal").q_index] += angle;
        let mut kinematics = Kinematics::new(character);
        kinematics.update(character, &q);
        (kinematics.point(tip, &[0.03, 0.0, 0.0].into()), kinematics)
    };
    let ((before, _), (here, kinematics), (after, _)) = (place(0.499), place(0.5), place(0.501));
    let jacobian = kinematics.jacobian(character, tip, &here);
    let column = jacobian.column(joint("proximal").v_index).into_owned();
    let difference = (after - before) / 0.002;
    assert!((column.fixed_rows::<3>(0) - difference).norm() < 1e-6, "{column} {difference}");
    assert_eq!(jacobian.column(joint("middle").v_index).norm(), 0.0);
}
