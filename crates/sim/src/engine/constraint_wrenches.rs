//! Constraint wrenches of a block: forces in joints and on bodies, as chapter 2 of the thesis needs them.

use super::block::{Block, Model, Workspace};
use super::lanes::{Lanes, Scalar};
use super::model_parameters::ModelParameters;
use super::rigid_body::RigidBodyDynamics;
use super::spatial::{Spatial, accumulate, cross, cross_force, dot6, momentum, sub};
use super::tree::Tree;
use crate::constraint_wrenches::WrenchRows;

/// The wrenches of [`crate::ConstraintWrenches`], about the root's position, one entry per body.
pub struct BodyWrenches<V: Lanes> {
    joint: Vec<Spatial<V>>,
    constraint: Vec<Spatial<V>>,
    contact: Vec<Spatial<V>>,
}

impl<V: Lanes> BodyWrenches<V> {
    /// The wrenches of a block in its present state, under its command.
    pub fn of(model: &Model<V>, block: &mut Block<V>, workspace: &mut Workspace<V>) -> Self {
        V::vectorize(
            #[inline(always)]
            || Self::compute(model, block, workspace),
        )
    }

    #[inline(always)]
    fn compute(model: &Model<V>, block: &mut Block<V>, workspace: &mut Workspace<V>) -> Self {
        let acceleration = block.accelerate(model, workspace);
        let contact = workspace.contact_forces(&model.tree, &block.forces);
        let mut external = contact.clone();
        for (body, push) in block.pushes.iter().enumerate() {
            if let Some(push) = push {
                accumulate(&mut external[body], &workspace.dynamics.about_origin(push, body));
            }
        }
        let constraint = workspace.dynamics.constraint_forces(&model.tree, &block.parameters, &acceleration, &external);
        // What closes loops acts on its bodies as joints do, but not through a joint of the tree.
        let mut closure = vec![[V::zero(); 6]; constraint.len()];
        model.tree.closures.wrenches(&workspace.dynamics, &block.forces.closure, &mut closure);
        let mut joint = constraint.clone();
        for (own, closure) in joint.iter_mut().zip(&closure) {
            for k in 0..6 {
                own[k] -= closure[k];
            }
        }
        for (b, body) in model.tree.bodies.iter().enumerate().skip(1).rev() {
            let own = joint[b];
            accumulate(&mut joint[body.parent], &own);
        }
        joint[0] = [V::zero(); 6];
        Self { joint, constraint, contact }
    }

    /// Writes the rows of one environment, unless its state or its drive is not finite.
    pub fn write(&self, model: &Model<V>, dynamics: &RigidBodyDynamics<V>, lane: usize, out: &mut WrenchRows<'_>) {
        if !self.joint.iter().flatten().all(|x| x.lane(lane).to_f64().is_finite()) {
            return;
        }
        let bodies = self.joint.len();
        let row = |wrench: &Spatial<V>, about: &[V; 3], out: &mut [f32]| {
            let force = [wrench[3], wrench[4], wrench[5]];
            let torque = sub(&[wrench[0], wrench[1], wrench[2]], &cross(about, &force));
            for (slot, x) in out.iter_mut().zip(torque.iter().chain(&force)) {
                *slot = x.lane(lane).to_f64() as f32;
            }
        };
        for b in 1..bodies {
            let at = 6 * (lane * bodies + b);
            row(&self.joint[b], &dynamics.position[b], &mut out.joint[at..at + 6]);
            row(&self.constraint[b], &dynamics.com[b], &mut out.constraint[at..at + 6]);
            row(&self.contact[b], &dynamics.com[b], &mut out.contact[at..at + 6]);
        }
        let tree = &model.tree;
        let loads = &mut out.joint_load[lane * tree.driven.len()..];
        for (slot, joint) in loads.iter_mut().zip(&tree.driven) {
            let load = dot6(&dynamics.motion[joint.v], &self.joint[tree.dofs[joint.v].body]);
            *slot = load.lane(lane).to_f64() as f32;
        }
    }
}

impl<V: Lanes> RigidBodyDynamics<V> {
    /// Returns the wrench that must act on each body besides gravity and `external` for it to accelerate so (Newton and Euler), about the
    /// root's position. Needs [`Self::bias`] of the same state.
    #[inline(always)]
    fn constraint_forces(
        &self,
        tree: &Tree<V::Scalar>,
        parameters: &ModelParameters<V>,
        acceleration: &[V],
        external: &[Spatial<V>],
    ) -> Vec<Spatial<V>> {
        // What the joints' accelerations add to the accelerations that velocities and gravity cause.
        let mut added = vec![[V::zero(); 6]; tree.bodies.len()];
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
