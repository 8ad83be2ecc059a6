//! One thread's model and data. It steps any environment: all that makes an environment is in its row.

use std::sync::Arc;

use lifelike_character::rotation::to_wxyz;
use nalgebra::{Quaternion, UnitQuaternion, Vector3};

use super::model::Layout;
use super::native::{CNSTR_FRICTION_DOF, CNSTR_LIMIT_JOINT, Data, Model};
use super::tuning::Tuning;
use crate::rows::Rows;
use crate::simulation::Drive;

/// Velocity (m/s, rad/s) beyond which an environment has diverged.
const VELOCITY_LIMIT: f64 = 1e3;

/// A model and a data of its own.
pub(super) struct Worker {
    pub data: Data,
    pub layout: Arc<Layout>,
    pub base: Tuning,
    /// True while the model is tuned to some environment.
    pub tuned: bool,
    /// Damping, gains and strength now in force, `[J]`.
    damping: Vec<f64>,
    gains: Vec<[f64; 2]>,
    strength: Vec<f64>,
    /// Sum of the squared torques over the substeps, and the last torque, `[J]`.
    torque_squared: Vec<f64>,
    torque: Vec<f64>,
    /// Torque on each actuator from outside in the step before (N m); empty where no actuator has friction under load.
    outside: Vec<f64>,
}

impl Worker {
    /// A worker with a copy of the model.
    pub fn new(model: &Model, layout: Arc<Layout>) -> Result<Self, String> {
        let joints = layout.joints.len();
        Ok(Self {
            base: Tuning::of(model, &layout),
            damping: layout.joints.iter().map(|j| j.damping).collect(),
            gains: layout.joints.iter().map(|j| [j.actuator.kp, j.actuator.kd]).collect(),
            strength: vec![1.0; joints],
            outside: vec![0.0; layout.width - layout.outside],
            data: Data::new(model.copy()?)?,
            layout,
            tuned: false,
            torque_squared: vec![0.0; joints],
            torque: vec![0.0; joints],
        })
    }

    /// Makes one policy step of one environment: `row` and `out` are its own. An environment that diverges, or did before,
    /// keeps its row.
    pub fn step(&mut self, row: &mut [f64], tuning: Option<&Tuning>, drive: Drive<'_>, out: &mut Rows<'_>) {
        let layout = self.layout.clone();
        if row[layout.diverged] != 0.0 {
            return;
        }
        self.tune(tuning);
        self.load(row);
        if self.advance(drive) {
            self.store(row);
            out.diverged.fill(false);
            self.write_forces(out);
            // Poses follow from the stored positions, so an observer of the row sees the same.
            self.data.kinematics();
            self.write_state(row, out);
        } else {
            // Whatever is in the data now must not reach the next environment.
            self.data.reset();
            row[layout.diverged] = 1.0;
            self.observe(row, out);
        }
    }

    /// Writes the outputs of an environment that does not step; torques and forces are zero.
    pub fn observe(&mut self, row: &[f64], out: &mut Rows<'_>) {
        self.load(row);
        self.data.kinematics();
        self.write_state(row, out);
        out.clear_forces();
        out.diverged.fill(row[self.layout.diverged] != 0.0);
    }

    fn apply(&mut self, tuning: &Tuning) {
        tuning.apply(self.data.model_mut());
        self.damping.clone_from(&tuning.damping);
        self.gains.clone_from(&tuning.gains);
        self.strength.clone_from(&tuning.strength);
    }

    pub fn tune(&mut self, tuning: Option<&Tuning>) {
        match tuning {
            Some(tuning) => self.apply(tuning),
            None if self.tuned => {
                let base = self.base.clone();
                self.apply(&base);
            }
            None => {}
        }
        self.tuned = tuning.is_some();
    }

    pub fn load(&mut self, row: &[f64]) {
        let layout = &self.layout;
        let data = &mut self.data;
        *data.time_mut() = row[0];
        data.qpos_mut().copy_from_slice(&row[layout.positions..layout.velocities]);
        data.qvel_mut().copy_from_slice(&row[layout.velocities..layout.warm_start]);
        data.qacc_warmstart_mut().copy_from_slice(&row[layout.warm_start..layout.pushes]);
        let pushes = &row[layout.pushes..layout.diverged];
        for (slot, push) in data.xfrc_applied_mut().iter_mut().zip(pushes.chunks_exact(6)) {
            slot.copy_from_slice(push);
        }
        self.outside.copy_from_slice(&row[layout.outside..]);
    }

    fn store(&self, row: &mut [f64]) {
        let layout = &self.layout;
        row[0] = self.data.time();
        row[layout.positions..layout.velocities].copy_from_slice(self.data.qpos());
        row[layout.velocities..layout.warm_start].copy_from_slice(self.data.qvel());
        row[layout.warm_start..layout.pushes].copy_from_slice(self.data.qacc_warmstart());
        row[layout.outside..].copy_from_slice(&self.outside);
    }

    pub fn set_damping(&mut self, joint: usize, friction: f64) {
        let (dof, own) = (self.layout.joints[joint].v, self.damping[joint]);
        self.data.model_mut().dof_damping_mut()[dof] = own + friction;
    }

    /// Makes all substeps; false as soon as something is not finite or absurdly fast.
    fn advance(&mut self, drive: Drive<'_>) -> bool {
        let numbers = drive.values();
        if !numbers.iter().all(|x| x.is_finite()) {
            return false;
        }
        let layout = self.layout.clone();
        self.torque_squared.fill(0.0);
        for _ in 0..layout.substeps {
            self.apply_drive(drive);
            for (sum, torque) in self.torque_squared.iter_mut().zip(&self.torque) {
                *sum += torque * torque;
            }
            let velocities = (!self.outside.is_empty()).then(|| self.data.qvel().to_vec());
            self.data.step();
            if let Some(velocities) = velocities {
                self.note_outside_torques(&velocities);
            }
            let sound = self.data.qpos().iter().all(|x| x.is_finite())
                && self.data.qvel().iter().all(|v| v.abs() <= VELOCITY_LIMIT)
                && self.data.qacc_warmstart().iter().all(|a| a.is_finite());
            if !sound {
                return false;
            }
        }
        true
    }

    /// Joint forces and damping of a drive in the present state of the data.
    pub fn apply_drive(&mut self, drive: Drive<'_>) {
        let layout = self.layout.clone();
        for (i, joint) in layout.joints.iter().enumerate() {
            let number = f64::from(drive.values()[i]);
            let (position, velocity) = (self.data.qpos()[joint.q], self.data.qvel()[joint.v]);
            let (applied, friction, held) = match drive {
                Drive::Targets(_) => {
                    let actuator = &joint.actuator;
                    let motor =
                        self.strength[i] * actuator.motor_torque_with(self.gains[i], number, position, velocity);
                    let held = actuator.extended_friction.map(|own| own.limit(motor, self.outside[i], velocity));
                    (motor, actuator.friction_damping(velocity), held)
                }
                Drive::Torques(_) => (number, 0.0, None),
            };
            if joint.actuator.extended_friction.is_some() {
                self.data.model_mut().dof_frictionloss_mut()[joint.v] = joint.frictionloss + held.unwrap_or(0.0);
            }
            self.data.qfrc_applied_mut()[joint.v] = applied;
            self.set_damping(i, friction);
            self.torque[i] = applied - friction * velocity;
        }
    }

    /// Keeps the torque on each actuator from outside: all forces of the step but the actuator's own torque, the joint's damping
    /// and its dry friction. `velocities` are those before the step.
    fn note_outside_torques(&mut self, velocities: &[f64]) {
        let layout = self.layout.clone();
        let mut dry = vec![0.0; layout.joints.len()];
        let force = self.data.efc_force();
        for (i, (&kind, &id)) in self.data.efc_type().iter().zip(self.data.efc_id()).enumerate() {
            if let (CNSTR_FRICTION_DOF, Some(scalar)) = (kind, layout.scalar_of_dof[id.max(0) as usize]) {
                dry[scalar] += force[i];
            }
        }
        for (i, joint) in layout.joints.iter().enumerate() {
            let total = self.data.qfrc_smooth()[joint.v] + self.data.qfrc_constraint()[joint.v];
            self.outside[i] = total - self.torque[i] + self.damping[i] * velocities[joint.v] - dry[i];
        }
    }

    fn write_state(&self, row: &[f64], out: &mut Rows<'_>) {
        let layout = &self.layout;
        let q = &row[layout.positions..layout.velocities];
        let v = &row[layout.velocities..layout.warm_start];
        if let Some((at, rate)) = layout.root {
            let (rq, rv) = (&q[at..], &v[rate..]);
            // MuJoCo's angular velocity of a free joint is in the body's frame.
            let root = UnitQuaternion::new_normalize(Quaternion::new(rq[3], rq[4], rq[5], rq[6]));
            let angular = root * Vector3::new(rv[3], rv[4], rv[5]);
            narrow(out.root_position, &rq[..3]);
            narrow(out.root_orientation, &rq[3..7]);
            narrow(out.linear_velocity_w, &rv[..3]);
            narrow(out.angular_velocity_w, angular.as_slice());
        } else {
            let (position, orientation) = &layout.fixed_base;
            narrow(out.root_position, position.as_slice());
            narrow(out.root_orientation, &to_wxyz(orientation));
            out.linear_velocity_w.fill(0.0);
            out.angular_velocity_w.fill(0.0);
        }
        for (i, joint) in layout.joints.iter().enumerate() {
            out.joint_position[i] = q[joint.q] as f32;
            out.joint_velocity[i] = v[joint.v] as f32;
        }
        let (xpos, xquat) = (self.data.xpos(), self.data.xquat());
        for (slot, &(body, point)) in out.site_position.chunks_exact_mut(3).zip(&layout.sites) {
            let [w, x, y, z] = xquat[body];
            let rotation = UnitQuaternion::new_unchecked(Quaternion::new(w, x, y, z));
            narrow(slot, (Vector3::from(xpos[body]) + rotation * point).as_slice());
        }
        for body in 0..layout.bodies {
            narrow(&mut out.body_position[3 * body..3 * body + 3], &xpos[body]);
            narrow(&mut out.body_orientation[4 * body..4 * body + 4], &xquat[body]);
        }
    }

    /// Torques and forces of the last substep; squared torques as the mean over all.
    fn write_forces(&self, out: &mut Rows<'_>) {
        let substeps = self.layout.substeps as f64;
        for (i, (&squared, &torque)) in self.torque_squared.iter().zip(&self.torque).enumerate() {
            out.torque_squared[i] = (squared / substeps) as f32;
            out.torque[i] = torque as f32;
        }
        self.write_foot_forces(out.foot_force);
        self.write_constraint_forces(out.constraint_force);
    }

    fn write_foot_forces(&self, out: &mut [f32]) {
        out.fill(0.0);
        for (i, contact) in self.data.contact().iter().enumerate() {
            let [a, b] = contact.geom;
            if a < 0 || b < 0 || contact.efc_address < 0 {
                continue;
            }
            let (a, b) = (a as usize, b as usize);
            let foot = match (self.layout.ground[a], self.layout.ground[b]) {
                (true, false) => self.layout.foot_of_geom[b],
                (false, true) => self.layout.foot_of_geom[a],
                _ => None,
            };
            if let Some(foot) = foot {
                out[foot] += self.data.contact_force(i)[0] as f32;
            }
        }
    }

    fn write_constraint_forces(&self, out: &mut [f32]) {
        out.fill(0.0);
        let data = &self.data;
        let sparse = data.model().is_sparse();
        // Row addresses exist for a sparse Jacobian only.
        let (force, addresses) = (data.efc_force(), data.efc_j_rowadr());
        let nv = self.layout.nv;
        for (i, (&kind, &id)) in data.efc_type().iter().zip(data.efc_id()).enumerate() {
            let id = id.max(0) as usize;
            match kind {
                CNSTR_FRICTION_DOF => {
                    if let Some(scalar) = self.layout.scalar_of_dof[id] {
                        out[scalar] += force[i] as f32;
                    }
                }
                CNSTR_LIMIT_JOINT => {
                    if let Some(scalar) = self.layout.scalar_of_joint[id] {
                        // The row has one entry: 1 at the lower limit, -1 at the upper.
                        let at = if sparse { addresses[i] as usize } else { i * nv + self.layout.joints[scalar].v };
                        out[scalar] += (data.efc_j()[at] * force[i]) as f32;
                    }
                }
                _ => {}
            }
        }
    }
}

fn narrow(out: &mut [f32], values: &[f64]) {
    for (slot, &value) in out.iter_mut().zip(values) {
        *slot = value as f32;
    }
}
