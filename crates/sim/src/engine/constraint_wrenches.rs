//! What holds bodies together: forces in joints and on bodies, as chapter 2 of the thesis needs them.

use super::block::{Block, Model, Workspace};
use super::lane::{Lane, Scalar};
use super::model_parameters::ModelParameters;
use super::rigid_body::RigidBodyDynamics;
use super::spatial::{Spatial, accumulate, cross, cross_force, momentum, sub};
use super::tree::Tree;

/// Forces on every body of every environment, `[N, B, 6]`: torque (N m), then force (N), axes of the world. Row 0 of each
/// environment, the world, is zero.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct BodyForces {
    /// What each parent exerts on its child through the joints between them: constraint, motor, friction and limit
    /// together. About the origin of the child's frame.
    pub joint: Vec<f32>,
    /// What all joints of a body exert on it together: f_C of thesis eq. 2.1. About its centre of mass.
    pub constraint: Vec<f32>,
    /// What the ground and other parts of the robot exert where they touch. About its centre of mass.
    pub contact: Vec<f32>,
}

/// The three fields of [`BodyForces`], about the root's position, one entry per body.
pub struct BodyWrenches<T: Scalar, const W: usize> {
    joint: Vec<Spatial<T, W>>,
    constraint: Vec<Spatial<T, W>>,
    contact: Vec<Spatial<T, W>>,
}

impl<T: Scalar, const W: usize> BodyWrenches<T, W> {
    /// Those of a block in its present state, under its command.
    pub fn of(model: &Model<T, W>, block: &mut Block<T, W>, workspace: &mut Workspace<T, W>, targets: bool) -> Self {
        let acceleration = block.accelerate(model, workspace, targets);
        let contact = workspace.contact_forces(&model.tree, &block.forces);
        let mut external = contact.clone();
        for (body, push) in block.pushes.iter().enumerate() {
            if let Some(push) = push {
                accumulate(&mut external[body], &workspace.dynamics.about_origin(push, body));
            }
        }
        let constraint = workspace.dynamics.constraint_forces(&model.tree, &block.parameters, &acceleration, &external);
        let mut joint = constraint.clone();
        for (b, body) in model.tree.bodies.iter().enumerate().skip(1).rev() {
            let own = joint[b];
            accumulate(&mut joint[body.parent], &own);
        }
        joint[0] = [Lane::zero(); 6];
        Self { joint, constraint, contact }
    }

    /// Appends the rows of one environment: zeros where it has diverged.
    pub fn write(&self, dynamics: &RigidBodyDynamics<T, W>, diverged: bool, lane: usize, out: &mut BodyForces) {
        let row = |wrench: &Spatial<T, W>, from: &[Lane<T, W>; 3], out: &mut Vec<f32>| {
            let force = [wrench[3], wrench[4], wrench[5]];
            let torque = sub(&[wrench[0], wrench[1], wrench[2]], &cross(from, &force));
            out.extend(torque.iter().chain(&force).map(|x| x.0[lane].to_f64() as f32));
        };
        for b in 0..self.joint.len() {
            if b == 0 || diverged {
                [&mut out.joint, &mut out.constraint, &mut out.contact].into_iter().for_each(|x| x.extend([0.0; 6]));
                continue;
            }
            row(&self.joint[b], &dynamics.position[b], &mut out.joint);
            row(&self.constraint[b], &dynamics.com[b], &mut out.constraint);
            row(&self.contact[b], &dynamics.com[b], &mut out.contact);
        }
    }
}

impl<T: Scalar, const W: usize> RigidBodyDynamics<T, W> {
    /// What must act on each body besides gravity and `external` for it to accelerate so (Newton and Euler), about the
    /// root's position. Needs [`Self::bias`] of the same state.
    fn constraint_forces(
        &self,
        tree: &Tree<T>,
        parameters: &ModelParameters<T, W>,
        acceleration: &[Lane<T, W>],
        external: &[Spatial<T, W>],
    ) -> Vec<Spatial<T, W>> {
        // What the joints' accelerations add to the accelerations that velocities and gravity cause.
        let mut added = vec![[Lane::zero(); 6]; tree.bodies.len()];
        let mut forces = added.clone();
        for (b, body) in tree.bodies.iter().enumerate().skip(1) {
            added[b] = added[body.parent];
            for joint in &tree.joints[body.joints.clone()] {
                for d in joint.v..joint.v + joint.kind.nv() {
                    for k in 0..6 {
                        added[b][k] = added[b][k].add_mul(self.motion[d][k], acceleration[d]);
                    }
                }
            }
            let mut whole = self.acceleration[b];
            accumulate(&mut whole, &added[b]);
            let inertia = self.spatial_inertia(b, body, parameters);
            let velocity = &self.velocity[b];
            forces[b] = momentum(&inertia, &whole);
            accumulate(&mut forces[b], &cross_force(velocity, &momentum(&inertia, velocity)));
            for k in 0..6 {
                forces[b][k] -= external[b][k];
            }
        }
        forces
    }
}
