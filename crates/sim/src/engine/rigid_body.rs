//! Unconstrained dynamics on lanes: kinematics, composite inertias, bias forces, the mass matrix and its factors.
//!
//! Everything is about the root's position, axes of the world: f32 keeps its digits however far the robot walks. Of a robot
//! that is fixed to the world it is about the world's origin, and "the root's position" means that.
//! Algorithms: composite rigid bodies and recursive Newton-Euler (Featherstone 2008, ch. 5 and 6).

use lifelike_character::JointKind;

use super::factors::Factors;
use super::lanes::Lanes;
use super::model_parameters::ModelParameters;
use super::spatial::{
    Inertia, Mat3, Spatial, Vec3, accumulate, add, along, column, cross, cross_force, cross_motion, dot, dot6,
    momentum, product, product_constant, quaternion_matrix, rotate, rotate_constant, sub, turn, turned_about, vec3,
    velocity_at,
};
use super::tree::{Root, Tree, TreeBody, TreeJoint};

/// Scratch memory of kinematics and dynamics, for one vector of environments.
#[derive(Debug, Clone)]
pub struct RigidBodyDynamics<V: Lanes> {
    /// The root's position (m, world).
    pub origin: Vec3<V>,
    /// Rotation of each body.
    pub rotation: Vec<Mat3<V>>,
    /// Position of each body frame, from the root's position.
    pub position: Vec<Vec3<V>>,
    /// Centre of mass of each body, likewise; known after [`Self::bias`].
    pub com: Vec<Vec3<V>>,
    /// Motion of each dof per unit of its velocity.
    pub motion: Vec<Spatial<V>>,
    /// Velocity of each body.
    pub velocity: Vec<Spatial<V>>,
    inertia: Vec<Inertia<V>>,
    /// Its acceleration by velocities and gravity alone.
    pub acceleration: Vec<Spatial<V>>,
    force: Vec<Spatial<V>>,
    /// Mass matrix, rows of `Dof::chain`.
    pub mass: Vec<V>,
    /// Bias force of each dof: Coriolis, centrifugal, gravity.
    pub bias: Vec<V>,
    /// Mass matrix as it is factorised.
    pub factors: Factors<V>,
}

impl<V: Lanes> RigidBodyDynamics<V> {
    pub fn new(tree: &Tree<V::Scalar>) -> Self {
        let zero = V::zero();
        let bodies = tree.bodies.len();
        let mut rotation = vec![[zero; 9]; bodies];
        for i in 0..3 {
            rotation[0][4 * i] = V::splat_f64(1.0);
        }
        Self {
            origin: [zero; 3],
            rotation,
            position: vec![[zero; 3]; bodies],
            com: vec![[zero; 3]; bodies],
            motion: vec![[zero; 6]; tree.nv],
            velocity: vec![[zero; 6]; bodies],
            inertia: vec![[zero; 10]; bodies],
            acceleration: vec![[zero; 6]; bodies],
            force: vec![[zero; 6]; bodies],
            mass: vec![zero; tree.entries],
            bias: vec![zero; tree.nv],
            factors: Factors::new(tree),
        }
    }

    /// Computes poses of bodies and axes of dofs.
    pub fn kinematics(&mut self, tree: &Tree<V::Scalar>, q: &[V]) {
        V::vectorize(
            #[inline(always)]
            || {
                let zero = V::zero();
                // The world, seen from the root.
                if let Root::Free { q: at, .. } = tree.root {
                    self.origin = [q[at], q[at + 1], q[at + 2]];
                    self.position[0] = self.origin.map(|x| -x);
                }
                for (b, body) in tree.bodies.iter().enumerate().skip(1) {
                    let parent = self.rotation[body.parent];
                    let mut position = add(&self.position[body.parent], &rotate_constant(&parent, &body.position));
                    let mut rotation = match &body.rotation {
                        Some(own) => product_constant(&parent, own),
                        None => parent,
                    };
                    for joint in &tree.joints[body.joints.clone()] {
                        match joint.kind {
                            JointKind::Free => {
                                position = [zero; 3];
                                rotation = quaternion_matrix(&q[joint.q + 3..joint.q + 7]);
                                for k in 0..3 {
                                    let mut along = [zero; 6];
                                    along[3 + k] = V::splat_f64(1.0);
                                    self.motion[joint.v + k] = along;
                                    self.motion[joint.v + 3 + k] =
                                        [rotation[k], rotation[3 + k], rotation[6 + k], zero, zero, zero];
                                }
                            }
                            JointKind::Ball => {
                                let anchor = match &joint.anchor {
                                    Some(arm) => add(&position, &rotate_constant(&rotation, arm)),
                                    None => position,
                                };
                                rotation = product(&rotation, &quaternion_matrix(&q[joint.q..joint.q + 4]));
                                position = match &joint.anchor {
                                    Some(arm) => sub(&anchor, &rotate_constant(&rotation, arm)),
                                    None => anchor,
                                };
                                for k in 0..3 {
                                    let axis = column(&rotation, k);
                                    let moment = cross(&anchor, &axis);
                                    self.motion[joint.v + k] =
                                        [axis[0], axis[1], axis[2], moment[0], moment[1], moment[2]];
                                }
                            }
                            JointKind::Hinge => {
                                let anchor = match &joint.anchor {
                                    Some(arm) => add(&position, &rotate_constant(&rotation, arm)),
                                    None => position,
                                };
                                let angle = q[joint.q] - V::splat(joint.reference);
                                let axis;
                                (axis, rotation) = hinge(&rotation, joint, angle);
                                position = match &joint.anchor {
                                    Some(arm) => sub(&anchor, &rotate_constant(&rotation, arm)),
                                    None => anchor,
                                };
                                let moment = cross(&anchor, &axis);
                                self.motion[joint.v] = [axis[0], axis[1], axis[2], moment[0], moment[1], moment[2]];
                            }
                            JointKind::Slide => {
                                let axis = rotate_constant(&rotation, &joint.axis);
                                position = along(&position, &axis, q[joint.q] - V::splat(joint.reference));
                                self.motion[joint.v] = [zero, zero, zero, axis[0], axis[1], axis[2]];
                            }
                        }
                    }
                    self.rotation[b] = rotation;
                    self.position[b] = position;
                }
            },
        );
    }

    /// Inertias, velocities and bias forces.
    pub fn bias(&mut self, tree: &Tree<V::Scalar>, parameters: &ModelParameters<V>, v: &[V]) {
        V::vectorize(
            #[inline(always)]
            || {
                let zero = V::zero();
                self.velocity[0] = [zero; 6];
                // Gravity as the ground accelerating upwards.
                let up = &parameters.gravity;
                self.acceleration[0] = [zero, zero, zero, -up[0], -up[1], -up[2]];
                for (b, body) in tree.bodies.iter().enumerate().skip(1) {
                    let mut velocity = self.velocity[body.parent];
                    let mut acceleration = self.acceleration[body.parent];
                    for joint in &tree.joints[body.joints.clone()] {
                        let mut own = [zero; 6];
                        for k in joint.v..joint.v + joint.kind.nv() {
                            let s = &self.motion[k];
                            for i in 0..6 {
                                own[i] = own[i].add_mul(s[i], v[k]);
                            }
                        }
                        let change = if joint.kind == JointKind::Free {
                            // The root's velocity is of a point that moves along: its spatial acceleration is -ω × v.
                            let (w, l) = ([own[0], own[1], own[2]], [own[3], own[4], own[5]]);
                            let x = cross(&l, &w);
                            [zero, zero, zero, x[0], x[1], x[2]]
                        } else {
                            cross_motion(&velocity, &own)
                        };
                        accumulate(&mut velocity, &own);
                        accumulate(&mut acceleration, &change);
                    }
                    self.velocity[b] = velocity;
                    self.acceleration[b] = acceleration;
                    self.com[b] = add(&self.position[b], &rotate(&self.rotation[b], &parameters.com[b]));
                    let inertia = self.spatial_inertia(b, body, parameters);
                    let mut force = momentum(&inertia, &acceleration);
                    accumulate(&mut force, &cross_force(&velocity, &momentum(&inertia, &velocity)));
                    self.inertia[b] = inertia;
                    self.force[b] = force;
                }
                for d in 0..tree.nv {
                    self.bias[d] = zero;
                }
                for (b, body) in tree.bodies.iter().enumerate().skip(1).rev() {
                    let force = self.force[b];
                    for joint in &tree.joints[body.joints.clone()] {
                        for k in joint.v..joint.v + joint.kind.nv() {
                            self.bias[k] = dot6(&self.motion[k], &force);
                        }
                    }
                    if body.parent != 0 {
                        accumulate(&mut self.force[body.parent], &force);
                        let inertia = self.inertia[b];
                        accumulate(&mut self.inertia[body.parent], &inertia);
                    }
                }
            },
        );
    }

    /// Inertia of a body, about the root's position.
    #[inline(always)]
    pub fn spatial_inertia(&self, b: usize, body: &TreeBody<V::Scalar>, parameters: &ModelParameters<V>) -> Inertia<V> {
        let r = &self.rotation[b];
        let [xx, yy, zz, xy, xz, yz] = body.inertia;
        let t = product_constant(r, &[xx, xy, xz, xy, yy, yz, xz, yz, zz]);
        let (t, r) = ([vec3(&t, 0), vec3(&t, 1), vec3(&t, 2)], [vec3(r, 0), vec3(r, 1), vec3(r, 2)]);
        let (c, m) = (self.com[b], parameters.mass[b] * V::splat(body.mass));
        let scale = parameters.mass[b] * parameters.inertia[b];
        let h = [m * c[0], m * c[1], m * c[2]];
        [
            m,
            h[0],
            h[1],
            h[2],
            (scale * dot(&t[0], &r[0])).add_mul(h[1], c[1]).add_mul(h[2], c[2]),
            (scale * dot(&t[1], &r[1])).add_mul(h[0], c[0]).add_mul(h[2], c[2]),
            (scale * dot(&t[2], &r[2])).add_mul(h[0], c[0]).add_mul(h[1], c[1]),
            (scale * dot(&t[0], &r[1])).sub_mul(h[0], c[1]),
            (scale * dot(&t[0], &r[2])).sub_mul(h[0], c[2]),
            (scale * dot(&t[1], &r[2])).sub_mul(h[1], c[2]),
        ]
    }

    /// The mass matrix, from the composite inertias that [`Self::bias`] left.
    pub fn mass_matrix(&mut self, tree: &Tree<V::Scalar>, parameters: &ModelParameters<V>) {
        V::vectorize(
            #[inline(always)]
            || {
                for (d, dof) in tree.dofs.iter().enumerate() {
                    let force = momentum(&self.inertia[dof.body], &self.motion[d]);
                    let n = dof.chain.len();
                    for (slot, j) in self.mass[dof.row..dof.row + n].iter_mut().zip(&dof.chain) {
                        *slot = dot6(&self.motion[*j], &force);
                    }
                    self.mass[dof.row + n - 1] += parameters.armature[d];
                }
            },
        );
    }

    /// A torque and a force at the centre of mass of a body, about the root's position.
    #[inline(always)]
    pub fn about_origin(&self, push: &Spatial<V>, body: usize) -> Spatial<V> {
        let force = [push[3], push[4], push[5]];
        let torque = add(&[push[0], push[1], push[2]], &cross(&self.com[body], &force));
        [torque[0], torque[1], torque[2], force[0], force[1], force[2]]
    }

    /// The column of dof `d` of a point's Jacobian: how fast the point (from the root's position) moves.
    #[inline(always)]
    pub fn point_velocity(&self, d: usize, point: &Vec3<V>) -> Vec3<V> {
        velocity_at(&self.motion[d], point)
    }
}

/// Axis of a hinge, and the rotation behind it.
#[inline(always)]
fn hinge<V: Lanes>(rotation: &Mat3<V>, joint: &TreeJoint<V::Scalar>, angle: V) -> (Vec3<V>, Mat3<V>) {
    let (s, c) = angle.sin_cos();
    let (s, direction) = if joint.backwards { (-s, V::splat_f64(-1.0)) } else { (s, V::splat_f64(1.0)) };
    let (axis, rotation) = match joint.coordinate {
        Some(0) => (column(rotation, 0), turned_about::<V, 0>(rotation, s, c)),
        Some(1) => (column(rotation, 1), turned_about::<V, 1>(rotation, s, c)),
        Some(_) => (column(rotation, 2), turned_about::<V, 2>(rotation, s, c)),
        None => (rotate_constant(rotation, &joint.axis), product(rotation, &turn(&joint.axis, s, c))),
    };
    ([axis[0] * direction, axis[1] * direction, axis[2] * direction], rotation)
}
