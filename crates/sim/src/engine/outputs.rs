//! Outputs of the environments, read from the lanes.

use super::block::{Block, Model, Workspace};
use super::lanes::{Lanes, Scalar};
use crate::rows::Rows;

fn narrow<T: Scalar>(value: T) -> f32 {
    value.to_f64() as f32
}

/// Writes poses and velocities; the workspace's kinematics are those of the block.
pub fn write_state<V: Lanes>(
    model: &Model<V>,
    block: &Block<V>,
    workspace: &Workspace<V>,
    lane: usize,
    out: &mut Rows<'_>,
) {
    let tree = &model.tree;
    let (root, velocity) = (tree.root_q, tree.root_v);
    let of = |x: &V| narrow(x.lane(lane));
    let put = |out: &mut [f32], values: &[V]| {
        for (slot, x) in out.iter_mut().zip(values) {
            *slot = of(x);
        }
    };
    put(out.root_position, &block.q[root..root + 3]);
    put(out.root_orientation, &block.q[root + 3..root + 7]);
    put(out.linear_velocity_w, &block.v[velocity..velocity + 3]);
    let dynamics = &workspace.dynamics;
    let at = |k: usize| block.q[root + k].lane(lane);
    let body = model.tree.root_body;
    let spin: [V::Scalar; 3] = std::array::from_fn(|k| block.v[velocity + 3 + k].lane(lane));
    for (k, slot) in out.angular_velocity_w.iter_mut().enumerate() {
        let r = &dynamics.rotation[body];
        *slot = narrow(
            r[3 * k].lane(lane) * spin[0] + r[3 * k + 1].lane(lane) * spin[1] + r[3 * k + 2].lane(lane) * spin[2],
        );
    }
    for (i, joint) in tree.driven.iter().enumerate() {
        out.joint_position[i] = of(&block.q[joint.q]);
        out.joint_velocity[i] = of(&block.v[joint.v]);
    }
    for (slot, (body, point)) in out.site_position.chunks_exact_mut(3).zip(&tree.sites) {
        let (r, p) = (&dynamics.rotation[*body], &dynamics.position[*body]);
        for k in 0..3 {
            let turned = (0..3).map(|i| r[3 * k + i].lane(lane).to_f64() * point[i].to_f64()).sum::<f64>();
            slot[k] = (at(k).to_f64() + p[k].lane(lane).to_f64() + turned) as f32;
        }
    }
    for body in 1..tree.bodies.len() {
        let p = &dynamics.position[body];
        for k in 0..3 {
            out.body_position[3 * body + k] = narrow(at(k) + p[k].lane(lane));
        }
        let r = dynamics.rotation[body].map(|x| x.lane(lane).to_f64());
        let rotation = nalgebra::Matrix3::from_row_slice(&r);
        let q = nalgebra::UnitQuaternion::from_rotation_matrix(&nalgebra::Rotation3::from_matrix_unchecked(rotation));
        let q = [q.w, q.i, q.j, q.k].map(|x| x as f32);
        out.body_orientation[4 * body..4 * body + 4].copy_from_slice(&q);
    }
    out.body_position[..3].fill(0.0);
    out.body_orientation[..4].copy_from_slice(&[1.0, 0.0, 0.0, 0.0]);
}

/// Writes torques and forces of the last substep; squared torques as the mean over all.
pub fn write_forces<V: Lanes>(model: &Model<V>, block: &Block<V>, lane: usize, out: &mut Rows<'_>) {
    let of = |x: &V| narrow(x.lane(lane));
    for (i, (torque, squared)) in block.torque.iter().zip(&block.torque_squared).enumerate() {
        out.torque[i] = of(torque);
        out.torque_squared[i] = of(squared);
    }
    out.foot_force.fill(0.0);
    let points = model.tree.ground_shapes.iter().flat_map(|s| s.points.iter().map(move |_| s.foot));
    for (foot, edges) in points.zip(&block.forces.contact) {
        if let Some(foot) = foot {
            out.foot_force[foot] += edges.iter().map(of).sum::<f32>();
        }
    }
    for (i, joint) in model.tree.driven.iter().enumerate() {
        out.constraint_force[i] = of(&block.forces.friction[joint.v]);
    }
    for (limit, (force, side)) in model.tree.limits.iter().zip(block.forces.limit.iter().zip(&block.forces.side)) {
        out.constraint_force[limit.scalar] += of(force) * of(side);
    }
}
