//! Contacts: our engine against MuJoCo.
use std::sync::Arc;

use crate::world::{
    all, from_text, near_standing, random_state, random_targets, rms, robots, self_touching, sliding_box, toy,
};
use lifelike_robot::Robot;
use lifelike_sim::{BatchState, Drive, LifelikeSimulation, MujocoSimulation, Simulation, Terrain};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// How far the vertical force on the feet is off MuJoCo's two physics steps after a random state near the ground, as a
/// share of it: of each state that touches, sorted.
fn off_in_contact(robot: &Robot, iterations: Option<usize>) -> Vec<f64> {
    let mut robot = robot.clone();
    (robot.control_hz, robot.substeps) = (robot.control_hz * robot.substeps as f64, 1);
    let (robot, n) = (Arc::new(robot), 1000);
    let mut oracle = MujocoSimulation::new(robot.clone(), n, 2).unwrap();
    let mut ours = LifelikeSimulation::new(robot.clone(), n, 1).unwrap();
    if let Some(iterations) = iterations {
        ours = ours.with_iterations(iterations);
    }
    let (mut positions, velocities) = near_standing(&robot, n, 11);
    positions.iter_mut().skip(2).step_by(robot.character.nq).for_each(|z| *z -= 0.008);
    let targets = random_targets(&robot, n, 12);
    for simulation in [&mut oracle as &mut dyn Simulation, &mut ours] {
        simulation.reset(&all(n), &positions, &velocities).unwrap();
        // The second step has a warm start.
        (0..2).for_each(|_| simulation.step(Drive::Targets(&targets)).unwrap());
    }
    let (theirs, ours) = (&oracle.state().foot_force, &ours.state().foot_force);
    let weight = robot.character.mass() * robot.character.gravity.norm();
    let feet = theirs.len() / n;
    let sum = |forces: &[f32]| forces.iter().map(|x| f64::from(*x)).sum::<f64>();
    let pairs = theirs.chunks(feet).zip(ours.chunks(feet)).map(|(theirs, ours)| (sum(theirs), sum(ours)));
    let touching = pairs.filter(|(theirs, _)| *theirs > 0.05 * weight);
    let mut off: Vec<f64> = touching.map(|(theirs, ours)| (theirs - ours).abs() / theirs).collect();
    off.sort_by(f64::total_cmp);
    off
}

/// Gate 3: the impulse of one physics step in states that touch the ground: on average, in 99 of 100 states, at worst.
///
/// Limits are twice what was measured when they were set, but for one: G1 stands on 28 points, the ends of seven capsules
/// under each foot, and twelve iterations do not share a load out there. In its worst state 69% of a small force is missing
/// (in 99 of 100 less than 5.5%); all of it missing, which is 1, would be another failure than that. With converged forces
/// nothing is left but single precision, for every robot: it is the iterations and not the model.
#[test]
fn one_step_of_contact_is_mujocos() {
    // The reference position of dm_control's humanoid is half a metre up in the air.
    for (name, robot) in robots().into_iter().filter(|(name, _)| *name != "dm humanoid") {
        let as_shipped = match name {
            "lima" => [6e-4, 7e-3, 0.03],
            "humanoid" => [2.2e-3, 0.03, 0.05],
            _ => [0.018, 0.11, 1.0],
        };
        for (iterations, limits) in [(None, as_shipped), (Some(400), [5e-5, 8e-4, 2e-3])] {
            let off = off_in_contact(&robot, iterations);
            let mean = off.iter().sum::<f64>() / off.len() as f64;
            let most = |share: f64| off[((off.len() - 1) as f64 * share) as usize];
            let got = [mean, most(0.99), most(1.0)];
            println!(
                "{name}, {}: vertical force in {} touching states off by {:.4}% on average, \
                 {:.2}% in 99 of 100, {:.2}% at worst",
                iterations.map_or("as shipped".into(), |n| format!("{n} iterations")),
                off.len(),
                100.0 * got[0],
                100.0 * got[1],
                100.0 * got[2]
            );
            assert!(off.len() > 100, "{name}: {}", off.len());
            assert!(
                got.iter().zip(limits).all(|(got, limit)| *got < limit),
                "{name} {iterations:?}: {got:?} {limits:?}"
            );
        }
    }
}

fn slide(simulation: &mut dyn Simulation, seconds: f64) -> f64 {
    let robot = simulation.robot().clone();
    let steps = (seconds * robot.control_hz) as usize;
    let targets = vec![0.0; robot.joints()];
    (0..steps).for_each(|_| simulation.step(Drive::Targets(&targets)).unwrap());
    f64::from(simulation.state().root_position[0])
}

#[test]
fn boxes_stick_and_slip_on_slopes_as_they_should() {
    // Soft contacts creep: what sticks moves a little. Measured after the box has come to rest on its springs.
    let friction = 0.5_f64;
    let way = |slope: f64| {
        let mut ours = LifelikeSimulation::new(sliding_box(friction, slope), 1, 1).unwrap();
        let mut oracle = MujocoSimulation::new(sliding_box(friction, slope), 1, 1).unwrap();
        let settled = (slide(&mut ours, 1.5), slide(&mut oracle, 1.5));
        (slide(&mut ours, 1.0) - settled.0, slide(&mut oracle, 1.0) - settled.1)
    };
    // With a hundred iterations only single precision is left between the two.
    let creep = |iterations: usize| {
        let robot = sliding_box(friction, (0.98 * friction).atan());
        slide(&mut LifelikeSimulation::new(robot, 1, 1).unwrap().with_iterations(iterations), 1.0)
    };
    let converged =
        slide(&mut MujocoSimulation::new(sliding_box(friction, (0.98 * friction).atan()), 1, 1).unwrap(), 1.0);
    println!(
        "0.98, first second: {:.6} m with 12 iterations, {:.6} with 100, MuJoCo {converged:.6}",
        creep(12),
        creep(100)
    );
    assert!((creep(100) / converged - 1.0).abs() < 1e-3);
    for factor in [0.9, 0.98, 1.02, 1.1] {
        let (ours, mujoco) = way((factor * friction).atan());
        println!("{factor} of the friction angle: {ours:.4} m in a second, MuJoCo {mujoco:.4} m");
        assert_eq!(ours > 0.05, factor > 1.0, "{factor}: {ours}");
        assert_eq!(mujoco > 0.05, factor > 1.0, "{factor}: {mujoco}");
    }
}

/// Margins: a force acts before surfaces meet, from the sum of both margins on; gaps change nothing.
#[test]
fn margins_hold_a_box_above_the_ground_as_in_mujoco() {
    let robot = sliding_box(0.8, 0.0);
    let text =
        robot.character.mjcf.clone().unwrap().replace("type=\"box\"", "type=\"box\" margin=\"0.004\" gap=\"0.01\"");
    let text = text.replace("type=\"plane\"", "type=\"plane\" margin=\"0.003\"");
    let robot = from_text(&text);
    let mut ours = LifelikeSimulation::new(robot.clone(), 1, 1).unwrap();
    let mut oracle = MujocoSimulation::new(robot, 1, 1).unwrap();
    slide(&mut ours, 2.0);
    slide(&mut oracle, 2.0);
    let (a, b) = (ours.state().root_position[2] - 0.05, oracle.state().root_position[2] - 0.05);
    println!("with margins of 4 and 3 mm a box hovers at {a:.5} m, in MuJoCo at {b:.5} m");
    assert!(b > 0.005 && (a - b).abs() < 1e-5, "{a} {b}");
}

/// At rest the spring of the contacts carries the weight: the same depth is the same force.
#[test]
fn a_box_at_rest_sinks_as_deep_as_in_mujoco() {
    let robot = sliding_box(0.8, 0.0);
    let mut ours = LifelikeSimulation::new(robot.clone(), 1, 1).unwrap();
    let mut oracle = MujocoSimulation::new(robot, 1, 1).unwrap();
    slide(&mut ours, 2.0);
    slide(&mut oracle, 2.0);
    let (a, b) = (ours.state().root_position[2], oracle.state().root_position[2]);
    let (penetration, theirs) = (0.05 - f64::from(a), 0.05 - f64::from(b));
    println!("a box of 2 kg sinks {penetration:.2e} m, in MuJoCo {theirs:.2e} m");
    assert!(penetration > 0.0 && (penetration / theirs - 1.0).abs() < 0.01, "{penetration} {theirs}");
}

/// How far joint velocities are apart after two physics steps from random states, as a share of what touching itself
/// changes in them: of each state in which it changes anything, sorted.
fn apart_by_touching(robot: &Arc<Robot>, apart: &Arc<Robot>) -> Vec<f64> {
    let n = 1000;
    let one_step = |robot: &Arc<Robot>| {
        let mut robot = Robot::clone(robot);
        (robot.control_hz, robot.substeps) = (robot.control_hz * robot.substeps as f64, 1);
        Arc::new(robot)
    };
    let mut rng = ChaCha8Rng::seed_from_u64(51);
    let (mut positions, mut velocities) = (Vec::new(), Vec::new());
    for _ in 0..n {
        let (q, v) = random_state(robot, &mut rng, 50.0);
        positions.extend(q);
        velocities.extend(v.iter().map(|x| 0.1 * x));
    }
    let end = |simulation: &mut dyn Simulation| {
        simulation.reset(&all(n), &positions, &velocities).unwrap();
        let torques = vec![0.0; n * robot.joints()];
        (0..2).for_each(|_| simulation.step(Drive::Torques(&torques)).unwrap());
        simulation.state().clone()
    };
    let free = end(&mut MujocoSimulation::new(one_step(apart), n, 2).unwrap());
    let theirs = end(&mut MujocoSimulation::new(one_step(robot), n, 2).unwrap());
    let ours = end(&mut LifelikeSimulation::in_double_precision(one_step(robot), n, 2).unwrap().with_iterations(100));
    let joints = robot.joints();
    let mut shares = Vec::new();
    for e in 0..n {
        // What overlaps deeply is thrown apart faster than can be followed.
        if theirs.diverged[e] {
            continue;
        }
        let row = |x: &BatchState| x.joint_velocity[e * joints..(e + 1) * joints].to_vec();
        let effect = rms(&row(&theirs), &row(&free));
        if effect > 1e-3 {
            shares.push(rms(&row(&theirs), &row(&ours)) / effect);
        } else {
            assert!(rms(&row(&theirs), &row(&ours)) < 1e-3, "ours touches where MuJoCo does not: state {e}");
        }
    }
    shares.sort_by(f64::total_cmp);
    shares
}

#[test]
fn parts_that_touch_push_each_other_as_in_mujoco() {
    let (ball, capsule, cuboid) =
        (r#"type="sphere" size="0.14""#, r#"type="capsule" size="0.1 0.12""#, r#"type="box" size="0.2 0.15 0.1""#);
    let small = |shape: &str| {
        shape.replace("0.2 0.15 0.1", "0.08 0.06 0.05").replace("0.1 0.12", "0.04 0.08").replace("0.14", "0.05")
    };
    // Boxes may be held at other points than MuJoCo's (`boxes`), so only a share of the states is the same there.
    for (trunk, hand, compared) in [
        (ball, ball, 1.0),
        (ball, capsule, 1.0),
        (capsule, capsule, 1.0),
        (cuboid, ball, 1.0),
        (cuboid, capsule, 0.6),
        (cuboid, cuboid, 0.7),
    ] {
        let hand = small(hand);
        let apart = self_touching(&format!("{trunk} contype=\"0\" conaffinity=\"0\""), &hand);
        let shares = apart_by_touching(&self_touching(trunk, &hand), &apart);
        let equal = shares.iter().filter(|share| **share < 1e-4).count() as f64 / shares.len() as f64;
        println!("{trunk} and {hand}: the same in {:.0}% of {} states", 100.0 * equal, shares.len());
        assert!(shares.len() > 50 && equal >= compared, "{trunk} {hand}: {equal}");
    }
}

/// A ball with a small arm above a plane that is turned by `quaternion`.
fn ball(quaternion: &str) -> Arc<Robot> {
    let plane = format!(r#"friction="0.7" quat="{quaternion}""#);
    toy("0 0 -9.81", &plane, "0 0 0.5", r#"type="sphere" size="0.1""#)
}

/// Balls put on a terrain, some time later: roots, and where they started.
fn roll(simulation: &mut dyn Simulation, terrain: &Terrain) -> (Vec<f32>, Vec<f32>) {
    let (robot, n) = (simulation.robot().clone(), simulation.len());
    let mut rng = ChaCha8Rng::seed_from_u64(61);
    let mut positions = Vec::new();
    for _ in 0..n {
        let mut q = robot.default_position();
        (q[0], q[1]) = (rng.random_range(-2.0..2.0), rng.random_range(-2.0..2.0));
        let (above, normal) = terrain.clearance([q[0], q[1], 0.0]);
        q[2] = (0.1 - above) / normal[2];
        positions.extend(q);
    }
    simulation.reset(&all(n), &positions, &vec![0.0; n * robot.character.nv]).unwrap();
    let start = simulation.state().root_position.clone();
    (0..25).for_each(|_| simulation.step(Drive::Targets(&vec![0.0; n])).unwrap());
    (simulation.state().root_position.clone(), start)
}

/// A terrain that is one slope is a plane that is turned. (MuJoCo's own height field is not its plane: it makes a contact
/// with every prism that it cuts the field into.)
#[test]
fn a_slope_is_a_turned_plane() {
    let (n, angle) = (50, 0.15_f64);
    let terrain = Terrain::from_fn(8.0, 0.1, |x, _| -angle.tan() * x).unwrap();
    let turned = ball(&format!("{} 0 {} 0", (0.5 * angle).cos(), (0.5 * angle).sin()));
    let (theirs, start) = roll(&mut MujocoSimulation::new(turned, n, 1).unwrap(), &terrain);
    let ours = LifelikeSimulation::new(ball("1 0 0 0"), n, 1).unwrap();
    let (ours, _) = roll(&mut ours.with_terrain(Arc::new(terrain.clone())), &terrain);
    let (way, off) = (rms(&theirs, &start), rms(&theirs, &ours));
    let mut field = MujocoSimulation::on(Some(&terrain), ball("1 0 0 0"), n, 1).unwrap();
    let other = rms(&theirs, &roll(&mut field, &terrain).0);
    println!(
        "balls roll {way:.3} m down a plane; ours end {off:.1e} m beside, those on MuJoCo's height field {other:.1e} m"
    );
    assert!(way > 0.05 && off < 1e-3 * way, "{way} {off}");
}

/// On hills the two height fields are not the same model, but nothing falls through and balls roll the same way.
#[test]
fn hills_carry_about_as_in_mujoco() {
    let (n, terrain) = (100, Terrain::hills(8.0, 0.1, 0.3, 4.0, 5).unwrap());
    let mut field = MujocoSimulation::on(Some(&terrain), ball("1 0 0 0"), n, 1).unwrap();
    let (theirs, start) = roll(&mut field, &terrain);
    let ours = LifelikeSimulation::new(ball("1 0 0 0"), n, 1).unwrap();
    let (ours, _) = roll(&mut ours.with_terrain(Arc::new(terrain.clone())), &terrain);
    let (way, off) = (rms(&theirs, &start), rms(&theirs, &ours));
    println!("balls roll {way:.3} m on hills; ours end {off:.1e} m beside MuJoCo's");
    let sunk = |roots: &[f32]| {
        let depth = |p: &[f32]| 0.1 - terrain.clearance([p[0], p[1], p[2]].map(f64::from)).0;
        roots.chunks(3).map(depth).fold(0.0, f64::max)
    };
    let (own, their) = (sunk(&ours), sunk(&theirs));
    println!("deepest: ours {own:.1e} m, MuJoCo's {their:.1e} m");
    assert!(off < 0.15 * way && own < 2e-3, "{way} {off} {own}");
}
