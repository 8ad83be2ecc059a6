//! Forward kinematics and Jacobians.

use std::ops::AddAssign;

use nalgebra::DMatrix;

use crate::model::{Character, JointKind};
use crate::rotation::{Mat3, Quat, Vec3, from_wxyz};

/// Poses of all bodies at one generalised position. A reusable workspace: make it once, update it often.
#[derive(Debug, Clone)]
pub struct Kinematics {
    /// Position of each body frame (m, world).
    pub body_position: Vec<Vec3>,
    /// Orientation of each body frame.
    pub body_orientation: Vec<Quat>,
    /// Anchor of each joint (m, world).
    pub joint_anchor: Vec<Vec3>,
    /// Axis of each joint (unit, world).
    pub joint_axis: Vec<Vec3>,
    /// Column of the Jacobian that each joint moves with, and its share of that motion: of a joint that follows another its
    /// leader's. `None` for one that is held.
    leads: Vec<Option<(usize, f64)>>,
}

impl Kinematics {
    /// Returns a workspace for this character, at its reference position.
    pub fn new(character: &Character) -> Self {
        let mut kinematics = Self {
            body_position: vec![Vec3::zeros(); character.bodies.len()],
            body_orientation: vec![Quat::identity(); character.bodies.len()],
            joint_anchor: vec![Vec3::zeros(); character.joints.len()],
            joint_axis: vec![Vec3::z(); character.joints.len()],
            leads: character.joints.iter().map(|joint| Some((joint.v_index, 1.0))).collect(),
        };
        kinematics.update(character, &character.reference_position());
        kinematics
    }

    /// Moves every body to the generalised position `q` (length `nq`, MuJoCo's layout; quaternions are normalised here,
    /// as MuJoCo does). Joints that follow others are where their leaders put them, whatever `q` says of them.
    pub fn update(&mut self, character: &Character, q: &[f64]) {
        debug_assert_eq!(q.len(), character.nq);
        for (i, body) in character.bodies.iter().enumerate().skip(1) {
            let mut position = self.body_position[body.parent] + self.body_orientation[body.parent] * body.position;
            let mut orientation = self.body_orientation[body.parent] * body.orientation;
            for j in body.joints.clone() {
                let joint = &character.joints[j];
                let at = joint.q_index;
                if joint.kind == JointKind::Free {
                    position = Vec3::new(q[at], q[at + 1], q[at + 2]);
                    orientation =
                        from_wxyz([q[at + 3], q[at + 4], q[at + 5], q[at + 6]]).unwrap_or_else(Quat::identity);
                    self.joint_anchor[j] = position;
                    self.joint_axis[j] = Vec3::z();
                    continue;
                }
                let anchor = position + orientation * joint.position;
                let axis = orientation * joint.axis;
                self.joint_anchor[j] = anchor;
                self.joint_axis[j] = axis;
                let moved = match joint.coupling {
                    None => q[at] - joint.reference,
                    Some(_) => {
                        let (place, leader, slope) = character.led(joint, q);
                        self.leads[j] = leader.map(|leader| (leader.v_index, slope));
                        place - joint.reference
                    }
                };
                match joint.kind {
                    JointKind::Slide => position += axis * moved,
                    JointKind::Hinge => {
                        let turn = Quat::from_scaled_axis(joint.axis * moved);
                        orientation *= turn;
                        // Rotating about an off-centre anchor moves the body frame.
                        position = anchor - orientation * joint.position;
                    }
                    JointKind::Ball => {
                        orientation *=
                            from_wxyz([q[at], q[at + 1], q[at + 2], q[at + 3]]).unwrap_or_else(Quat::identity);
                        position = anchor - orientation * joint.position;
                    }
                    JointKind::Free => {}
                }
            }
            self.body_position[i] = position;
            self.body_orientation[i] = orientation;
        }
    }

    /// Returns the world position of a point given in a body's frame (m).
    pub fn point(&self, body: usize, local: &Vec3) -> Vec3 {
        self.body_position[body] + self.body_orientation[body] * local
    }

    /// Returns the 6 x nv Jacobian of a world point rigidly attached to `body`: rows 0-2 linear, rows 3-5 angular, both
    /// in the world frame. Columns follow MuJoCo's velocities (free joint: linear world, angular body frame); what a joint that
    /// follows another moves is in its leader's column.
    pub fn jacobian(&self, character: &Character, body: usize, point_w: &Vec3) -> DMatrix<f64> {
        let mut jacobian = DMatrix::zeros(6, character.nv);
        self.for_each_column(character, body, point_w, |column, linear, angular| {
            let mut own = jacobian.column_mut(column);
            own.fixed_rows_mut::<3>(0).add_assign(&linear);
            own.fixed_rows_mut::<3>(3).add_assign(&angular);
        });
        jacobian
    }

    /// Returns the inertia that each velocity's actuator feels (kg m², or kg of a slide): the inverse of the diagonal of the inverse
    /// mass matrix, so that it counts what gives way on both sides of the joint. Joints that follow others are free in it, as in
    /// MuJoCo's. `None` where the mass matrix is singular.
    pub fn effective_inertias(&self, character: &Character) -> Option<Vec<f64>> {
        let factor = self.mass_matrix(character).cholesky()?;
        Some(factor.inverse().diagonal().iter().map(|inverse| 1.0 / inverse).collect())
    }

    /// Returns the mass matrix with armature, `[nv, nv]`.
    fn mass_matrix(&self, character: &Character) -> DMatrix<f64> {
        let mut mass = DMatrix::<f64>::zeros(character.nv, character.nv);
        let mut free = self.clone();
        free.leads = character.joints.iter().map(|joint| Some((joint.v_index, 1.0))).collect();
        for (i, body) in character.bodies.iter().enumerate().skip(1) {
            let inertial = &body.inertial;
            let jacobian = free.jacobian(character, i, &self.point(i, &inertial.com));
            let axes = (self.body_orientation[i] * inertial.orientation).to_rotation_matrix().into_inner();
            let inertia = axes * Mat3::from_diagonal(&inertial.diagonal) * axes.transpose();
            let (linear, angular) = (jacobian.rows(0, 3), jacobian.rows(3, 3));
            mass += inertial.mass * linear.transpose() * linear;
            mass += angular.transpose() * inertia * angular;
        }
        for joint in &character.joints {
            for dof in joint.v_index..joint.v_index + joint.kind.nv() {
                mass[(dof, dof)] += joint.armature;
            }
        }
        mass
    }

    /// Visits the non-zero columns of [`Self::jacobian`], without allocating: `visit(column, linear, angular)`. A column with
    /// several joints is visited for each, and their motions add up.
    pub fn for_each_column(
        &self,
        character: &Character,
        body: usize,
        point_w: &Vec3,
        mut visit: impl FnMut(usize, Vec3, Vec3),
    ) {
        let mut at = body;
        while at != 0 {
            for j in character.bodies[at].joints.clone() {
                let joint = &character.joints[j];
                let Some((column, share)) = self.leads[j] else { continue };
                let arm = point_w - self.joint_anchor[j];
                let axis = self.joint_axis[j] * share;
                match joint.kind {
                    JointKind::Hinge => visit(column, axis.cross(&arm), axis),
                    JointKind::Slide => visit(column, axis, Vec3::zeros()),
                    JointKind::Ball | JointKind::Free => {
                        let mut first = column;
                        if joint.kind == JointKind::Free {
                            for axis in 0..3 {
                                visit(column + axis, Vec3::ith(axis, 1.0), Vec3::zeros());
                            }
                            first += 3;
                        }
                        for axis in 0..3 {
                            let turn = self.body_orientation[at] * Vec3::ith(axis, 1.0);
                            visit(first + axis, turn.cross(&arm), turn);
                        }
                    }
                }
            }
            at = character.bodies[at].parent;
        }
    }
}
