//! Constraint wrenches: both engines against MuJoCo called by hand.
use std::sync::Arc;

use crate::world::{all, exactly_solved, near_standing, self_touching};
use lifelike_character::Vec3;
use lifelike_sim::mujoco::native::{DSBL_ACTUATION, Data, Model};
use lifelike_sim::{ConstraintWrenches, Drive, LifelikeSimulation, MujocoSimulation, Simulation};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Torque and force about another point.
fn moved(torque: Vec3, force: Vec3, from: Vec3, to: Vec3) -> [f64; 6] {
    let torque = torque + (from - to).cross(&force);
    [torque.x, torque.y, torque.z, force.x, force.y, force.z]
}

#[test]
fn forces_on_bodies_are_mujocos() {
    let n = 20;
    let ball = |size: &str| format!(r#"type="sphere" size="{size}""#);
    for (name, robot) in [
        ("lima", Arc::new(exactly_solved("lima"))),
        ("humanoid", Arc::new(exactly_solved("humanoid"))),
        ("one that touches itself", self_touching(&ball("0.2"), &ball("0.15"))),
    ] {
        let (positions, velocities) = near_standing(&robot, n, 71);
        let mut ours = LifelikeSimulation::in_double_precision(robot.clone(), n, 1).unwrap().with_iterations(1000);
        ours.reset(&all(n), &positions, &velocities).unwrap();
        let bodies = robot.character.bodies.len();
        let pushed = |id: usize| 1 + id % (bodies - 1);
        let mut rng = ChaCha8Rng::seed_from_u64(72);
        let torques: Vec<f32> = (0..n * robot.joints()).map(|_| rng.random_range(-2.0..2.0)).collect();
        for id in 0..n {
            ours.push(id, pushed(id), [5.0, -3.0, 8.0], [0.2, 0.1, -0.3]).unwrap();
        }
        (0..5).for_each(|_| ours.step(Drive::Torques(&torques)).unwrap());
        let before = ours.save();
        let forces = ours.constraint_wrenches(Drive::Torques(&torques)).unwrap();
        assert_eq!(ours.save(), before, "asking changes nothing");
        // MuJoCo behind the same trait, in the same states.
        let mut theirs = MujocoSimulation::new(robot.clone(), n, 1).unwrap();
        for (id, row) in before.values.chunks(before.width).enumerate() {
            let (nq, nv) = (robot.character.nq, robot.character.nv);
            theirs.reset(&[id], &row[..nq], &row[nq..nq + nv]).unwrap();
            theirs.push(id, pushed(id), [5.0, -3.0, 8.0], [0.2, 0.1, -0.3]).unwrap();
        }
        let of_trait = theirs.constraint_wrenches(Drive::Torques(&torques)).unwrap();

        let mut model = Model::from_xml_string(robot.character.mjcf.as_deref().unwrap()).unwrap();
        let mut edited = model.edit();
        *edited.opt_timestep_mut() = robot.timestep();
        *edited.opt_disableflags_mut() |= DSBL_ACTUATION;
        let mut data = Data::new(model).unwrap();
        let (nq, nv) = (robot.character.nq, robot.character.nv);
        let (mut worst, mut largest, mut touching, mut loads) = ([0.0_f64; 3], [0.0_f64; 3], 0, 0.0_f64);
        for (e, row) in before.values.chunks(before.width).enumerate() {
            data.qpos_mut().copy_from_slice(&row[..nq]);
            data.qvel_mut().copy_from_slice(&row[nq..nq + nv]);
            data.qfrc_applied_mut().fill(0.0);
            for (i, joint) in robot.character.scalar_joints().enumerate() {
                data.qfrc_applied_mut()[joint.v_index] = f64::from(torques[e * robot.joints() + i]);
            }
            data.xfrc_applied_mut().iter_mut().for_each(|push| push.fill(0.0));
            data.xfrc_applied_mut()[pushed(e)].copy_from_slice(&[5.0, -3.0, 8.0, 0.2, 0.1, -0.3]);
            data.forward();
            data.rne_post_constraint();
            touching += usize::from(!data.contact().is_empty());
            let side = |f: &ConstraintWrenches, i: usize| f64::from(f.joint_load[e * robot.joints() + i]);
            for (i, joint) in robot.character.scalar_joints().enumerate() {
                // In the air the actuator's side of a joint is all that acts on it, less what its rotor takes.
                let v = joint.v_index;
                let load = if data.contact().is_empty() {
                    data.qfrc_applied()[v] + data.qfrc_passive()[v] + data.qfrc_constraint()[v]
                        - data.model().dof_armature()[v] * data.qacc()[v]
                } else {
                    data.cdof()[v].iter().zip(&data.cfrc_int()[joint.body]).map(|(s, f)| s * f).sum()
                };
                loads = loads.max((side(&forces, i) - load).abs()).max((side(&of_trait, i) - load).abs());
            }
            let middle = Vec3::from(data.subtree_com()[1]);
            let wrench = |x: &[f64; 6]| (Vec3::new(x[0], x[1], x[2]), Vec3::new(x[3], x[4], x[5]));
            for b in 1..bodies {
                let (origin, com) = (Vec3::from(data.xpos()[b]), Vec3::from(data.xipos()[b]));
                let (torque, force) = wrench(&data.cfrc_int()[b]);
                let joint = moved(torque, force, middle, origin);
                // All joints of a body: the one above less those below.
                let (mut torque, mut force) = (torque, force);
                for child in (1..bodies).filter(|c| robot.character.bodies[*c].parent == b) {
                    let (t, f) = wrench(&data.cfrc_int()[child]);
                    (torque, force) = (torque - t, force - f);
                }
                let constraint = moved(torque, force, middle, com);
                let (torque, force) = wrench(&data.cfrc_ext()[b]);
                let mut contact = moved(torque, force, middle, com);
                if b == pushed(e) {
                    for (x, push) in contact.iter_mut().zip([0.2, 0.1, -0.3, 5.0, -3.0, 8.0]) {
                        *x -= push;
                    }
                }
                let at = 6 * (e * bodies + b);
                for engine in [&forces, &of_trait] {
                    let own = [&engine.joint, &engine.constraint, &engine.contact].map(|x| &x[at..at + 6]);
                    for (k, (own, their)) in own.into_iter().zip([joint, constraint, contact]).enumerate() {
                        for (a, b) in own.iter().zip(their) {
                            worst[k] = worst[k].max((f64::from(*a) - b).abs());
                            largest[k] = largest[k].max(b.abs());
                        }
                    }
                }
            }
        }
        println!(
            "{name}: joints, bodies, contacts: {worst:.5?} N off, of up to {largest:.1?}; {touching} of {n} touching; \
             loads {loads:.5} N m off"
        );
        assert!(touching > n / 2 && loads < 1e-4 * largest[0], "{name}: {loads}");
        for k in 0..3 {
            assert!(worst[k] < 1e-4 * largest[k], "{name} {k}: {worst:?} of {largest:?}");
        }
    }
}
