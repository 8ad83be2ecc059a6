//! One thread's model and data. It steps any environment: all that an environment is, is in its row.

use std::sync::Arc;

use lifelike_robot::ActuatorParameters;
use mujoco_rs::mujoco_c::mjtConstraint;
use mujoco_rs::prelude::{MjData, MjModel};
use nalgebra::{Quaternion, UnitQuaternion, Vector3};

use super::model::Layout;
use crate::batch::EnvironmentParameters;
use crate::rows::Rows;

/// An environment with a velocity beyond this (m/s, rad/s) is lost.
const VELOCITY_LIMIT: f64 = 1e3;

/// What drives the joints of one environment.
#[derive(Debug, Clone, Copy)]
pub(super) enum Command<'a> {
    /// Targets of the actuator model (rad), `[J]`.
    Targets(&'a [f32]),
    /// Torques (N m), `[J]`.
    Torques(&'a [f32]),
}

/// The fields of a model that the parameters of an environment change, dependent ones included.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Tuning {
    body_mass: Vec<f64>,
    body_inertia: Vec<[f64; 3]>,
    body_subtreemass: Vec<f64>,
    body_invweight0: Vec<[f64; 2]>,
    dof_invweight0: Vec<f64>,
    dof_m0: Vec<f64>,
    tendon_invweight0: Vec<f64>,
    geom_friction: Vec<[f64; 3]>,
    mean_inertia: f64,
    mean_mass: f64,
    body_ipos: Vec<[f64; 3]>,
    dof_armature: Vec<f64>,
    gravity: [f64; 3],
    /// Damping of each scalar joint's dof, and its actuator's gains.
    damping: Vec<f64>,
    gains: Vec<[f64; 2]>,
    strength: Vec<f64>,
}

/// Friction of the ground where each foot brings its own: MuJoCo takes the larger of two, so the ground's gives way.
const YIELDING: f64 = 1e-5;

impl Tuning {
    fn of(model: &MjModel, layout: &Layout) -> Self {
        Self {
            body_ipos: model.body_ipos().to_vec(),
            dof_armature: model.dof_armature().to_vec(),
            gravity: model.opt().gravity,
            damping: layout.joints.iter().map(|j| j.damping).collect(),
            gains: layout.joints.iter().map(|j| [j.actuator.kp, j.actuator.kd]).collect(),
            strength: vec![1.0; layout.joints.len()],
            body_mass: model.body_mass().to_vec(),
            body_inertia: model.body_inertia().to_vec(),
            body_subtreemass: model.body_subtreemass().to_vec(),
            body_invweight0: model.body_invweight0().to_vec(),
            dof_invweight0: model.dof_invweight0().to_vec(),
            dof_m0: model.dof_m0().to_vec(),
            tendon_invweight0: model.tendon_invweight0().to_vec(),
            geom_friction: model.geom_friction().to_vec(),
            mean_inertia: model.stat().meaninertia,
            mean_mass: model.stat().meanmass,
        }
    }

    fn apply(&self, model: &mut MjModel) {
        model.body_mass_mut().copy_from_slice(&self.body_mass);
        model.body_inertia_mut().copy_from_slice(&self.body_inertia);
        model.body_subtreemass_mut().copy_from_slice(&self.body_subtreemass);
        model.body_invweight0_mut().copy_from_slice(&self.body_invweight0);
        model.dof_invweight0_mut().copy_from_slice(&self.dof_invweight0);
        model.dof_m0_mut().copy_from_slice(&self.dof_m0);
        model.tendon_invweight0_mut().copy_from_slice(&self.tendon_invweight0);
        model.geom_friction_mut().copy_from_slice(&self.geom_friction);
        model.stat_mut().meaninertia = self.mean_inertia;
        model.stat_mut().meanmass = self.mean_mass;
        model.body_ipos_mut().copy_from_slice(&self.body_ipos);
        model.dof_armature_mut().copy_from_slice(&self.dof_armature);
        model.opt_mut().gravity = self.gravity;
    }
}

/// A model and a data of its own.
pub(super) struct Worker {
    data: MjData<Box<MjModel>>,
    layout: Arc<Layout>,
    base: Tuning,
    /// Whether the model is tuned to some environment.
    tuned: bool,
    /// Damping, gains and strength now in force, `[J]`.
    damping: Vec<f64>,
    gains: Vec<[f64; 2]>,
    strength: Vec<f64>,
    /// Sum of the squared torques over the substeps, and the last torque, `[J]`.
    torque_squared: Vec<f64>,
    torque: Vec<f64>,
}

impl Worker {
    /// A worker with a copy of the model.
    pub fn new(model: &MjModel, layout: Arc<Layout>) -> Result<Self, String> {
        let model = model.clone();
        let joints = layout.joints.len();
        Ok(Self {
            base: Tuning::of(&model, &layout),
            damping: layout.joints.iter().map(|j| j.damping).collect(),
            gains: layout.joints.iter().map(|j| [j.actuator.kp, j.actuator.kd]).collect(),
            strength: vec![1.0; joints],
            data: MjData::try_new(Box::new(model)).map_err(|e| e.to_string())?,
            layout,
            tuned: false,
            torque_squared: vec![0.0; joints],
            torque: vec![0.0; joints],
        })
    }

    fn model_mut(&mut self) -> &mut MjModel {
        // SAFETY: the model is never replaced, and only numbers that MuJoCo lets change at run time are written: no
        // sizes, indices or addresses.
        unsafe { self.data.model_mut() }
    }

    /// What `parameters` change in the model; `None` for nothing.
    ///
    /// MuJoCo takes the larger friction of two geoms that touch, so a friction of the ground is set on all of them: the
    /// ground then has exactly this friction for every part of the robot, and so have the robot's parts for each other.
    pub fn tuning(&mut self, parameters: &EnvironmentParameters) -> Option<Tuning> {
        if *parameters
            == (EnvironmentParameters { joint_offset: parameters.joint_offset.clone(), ..Default::default() })
        {
            return None;
        }
        let base = self.base.clone();
        let layout = self.layout.clone();
        let factor = |scale: &[f32], i: usize| scale.get(i).map_or(1.0, |x| f64::from(*x));
        let p = parameters;
        let model = self.model_mut();
        base.apply(model);
        for body in 0..layout.bodies {
            let mass = factor(&p.mass_scale, body);
            model.body_mass_mut()[body] *= mass;
            let turning = mass * factor(&p.inertia_scale, body);
            model.body_inertia_mut()[body].iter_mut().for_each(|moment| *moment *= turning);
            for (slot, offset) in
                model.body_ipos_mut()[body].iter_mut().zip(p.com_offset.get(body).into_iter().flatten())
            {
                *slot += f64::from(*offset);
            }
        }
        for (i, joint) in layout.joints.iter().enumerate() {
            model.dof_armature_mut()[joint.v] *= factor(&p.armature_scale, i);
        }
        if let Some(gravity) = p.gravity {
            model.opt_mut().gravity = gravity.map(f64::from);
        }
        if let Some(friction) = p.ground_friction {
            model.geom_friction_mut().iter_mut().for_each(|geom| geom[0] = f64::from(friction));
        }
        if !p.foot_friction.is_empty() {
            // What else touches the ground still does so with the larger of the two.
            let ground = model.geom_friction().iter().zip(&layout.ground).filter(|(_, ground)| **ground);
            let ground = ground.map(|(friction, _)| friction[0]).fold(0.0, f64::max);
            for (geom, friction) in model.geom_friction_mut().iter_mut().enumerate() {
                match layout.foot_of_geom[geom] {
                    _ if layout.ground[geom] => friction[0] = YIELDING,
                    Some(foot) => friction[0] = f64::from(p.foot_friction[foot]),
                    None => friction[0] = friction[0].max(ground),
                }
            }
        }
        // Inverse weights at the reference pose follow from the masses; contacts and limits use them.
        for joint in 0..layout.joints.len() {
            self.set_damping(joint, 0.0);
        }
        self.data.set_const();
        let mut tuning = Tuning::of(self.data.model(), &layout);
        for i in 0..layout.joints.len() {
            tuning.damping[i] *= factor(&p.damping_scale, i);
            tuning.gains[i][0] *= factor(&p.kp_scale, i);
            tuning.gains[i][1] *= factor(&p.kd_scale, i);
            tuning.strength[i] = factor(&p.strength_scale, i);
        }
        base.apply(self.model_mut());
        self.tuned = false;
        Some(tuning)
    }

    /// One policy step of one environment: `row` and `out` are its own. An environment that diverges, or did before,
    /// keeps its row.
    pub fn step(&mut self, row: &mut [f64], tuning: Option<&Tuning>, command: Command<'_>, out: &mut Rows<'_>) {
        let layout = self.layout.clone();
        if row[layout.diverged] != 0.0 {
            return;
        }
        self.tune(tuning);
        self.load(row);
        if self.advance(command) {
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
        for forces in [&mut *out.torque_squared, out.torque, out.foot_force, out.constraint_force] {
            forces.fill(0.0);
        }
        out.diverged.fill(row[self.layout.diverged] != 0.0);
    }

    fn apply(&mut self, tuning: &Tuning) {
        tuning.apply(self.model_mut());
        self.damping.clone_from(&tuning.damping);
        self.gains.clone_from(&tuning.gains);
        self.strength.clone_from(&tuning.strength);
    }

    fn tune(&mut self, tuning: Option<&Tuning>) {
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

    fn load(&mut self, row: &[f64]) {
        let layout = &self.layout;
        let data = &mut self.data;
        data.set_time(row[0]);
        data.qpos_mut().copy_from_slice(&row[layout.positions..layout.velocities]);
        data.qvel_mut().copy_from_slice(&row[layout.velocities..layout.warm_start]);
        data.qacc_warmstart_mut().copy_from_slice(&row[layout.warm_start..layout.pushes]);
        let pushes = &row[layout.pushes..layout.diverged];
        for (slot, push) in data.xfrc_applied_mut().iter_mut().zip(pushes.chunks_exact(6)) {
            slot.copy_from_slice(push);
        }
    }

    fn store(&self, row: &mut [f64]) {
        let layout = &self.layout;
        row[0] = self.data.time();
        row[layout.positions..layout.velocities].copy_from_slice(self.data.qpos());
        row[layout.velocities..layout.warm_start].copy_from_slice(self.data.qvel());
        row[layout.warm_start..layout.pushes].copy_from_slice(self.data.qacc_warmstart());
    }

    fn set_damping(&mut self, joint: usize, friction: f64) {
        let (dof, own) = (self.layout.joints[joint].v, self.damping[joint]);
        self.model_mut().dof_damping_mut()[dof] = own + friction;
    }

    /// All substeps; false as soon as something is not finite or absurdly fast.
    fn advance(&mut self, command: Command<'_>) -> bool {
        let numbers = match command {
            Command::Targets(numbers) | Command::Torques(numbers) => numbers,
        };
        if !numbers.iter().all(|x| x.is_finite()) {
            return false;
        }
        let layout = self.layout.clone();
        self.torque_squared.fill(0.0);
        for _ in 0..layout.substeps {
            for (i, joint) in layout.joints.iter().enumerate() {
                let number = f64::from(numbers[i]);
                let (position, velocity) = (self.data.qpos()[joint.q], self.data.qvel()[joint.v]);
                let (applied, friction) = match command {
                    Command::Targets(_) => {
                        let [kp, kd] = self.gains[i];
                        let actuator = ActuatorParameters { kp, kd, ..joint.actuator };
                        let motor = self.strength[i] * actuator.motor_torque(number, position, velocity);
                        (motor, actuator.friction_damping(velocity))
                    }
                    Command::Torques(_) => (number, 0.0),
                };
                self.data.qfrc_applied_mut()[joint.v] = applied;
                self.set_damping(i, friction);
                let torque = applied - friction * velocity;
                self.torque[i] = torque;
                self.torque_squared[i] += torque * torque;
            }
            self.data.step();
            let sound = self.data.qpos().iter().all(|x| x.is_finite())
                && self.data.qvel().iter().all(|v| v.abs() <= VELOCITY_LIMIT)
                && self.data.qacc_warmstart().iter().all(|a| a.is_finite());
            if !sound {
                return false;
            }
        }
        true
    }

    fn write_state(&self, row: &[f64], out: &mut Rows<'_>) {
        let layout = &self.layout;
        let q = &row[layout.positions..layout.velocities];
        let v = &row[layout.velocities..layout.warm_start];
        let (rq, rv) = (&q[layout.root_q..], &v[layout.root_v..]);
        // MuJoCo's angular velocity of a free joint is in the body's frame.
        let root = UnitQuaternion::new_normalize(Quaternion::new(rq[3], rq[4], rq[5], rq[6]));
        let angular = root * Vector3::new(rv[3], rv[4], rv[5]);
        narrow(out.root_position, &rq[..3]);
        narrow(out.root_orientation, &rq[3..7]);
        narrow(out.linear_velocity_w, &rv[..3]);
        narrow(out.angular_velocity_w, angular.as_slice());
        for (i, joint) in layout.joints.iter().enumerate() {
            out.joint_position[i] = q[joint.q] as f32;
            out.joint_velocity[i] = v[joint.v] as f32;
        }
        let (xpos, xquat) = (self.data.xpos(), self.data.xquat());
        for (slot, &(body, point)) in out.place_position.chunks_exact_mut(3).zip(&layout.places) {
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
        // SAFETY: MuJoCo filled these arrays in the step that `advance` just made, and nothing has changed them since;
        // row addresses exist for a sparse Jacobian only and are not looked at otherwise.
        let (force, addresses) = unsafe { (data.efc_force(), if sparse { data.efc_j_rowadr() } else { &[] }) };
        let nv = self.layout.nv;
        for (i, (&kind, &id)) in data.efc_type().iter().zip(data.efc_id()).enumerate() {
            let id = id.max(0) as usize;
            match kind {
                mjtConstraint::mjCNSTR_FRICTION_DOF => {
                    if let Some(scalar) = self.layout.scalar_of_dof[id] {
                        out[scalar] += force[i] as f32;
                    }
                }
                mjtConstraint::mjCNSTR_LIMIT_JOINT => {
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
