//! A robot and a simulation small enough for tests.
//!
//! A floating base has two joints, each a critically damped follower of its target. The base falls when the joints are
//! far from its initial reference.

#![allow(clippy::unwrap_used)] // its robot is known to be sound

use std::sync::Arc;

use crate::{
    BatchState, ConstraintWrenches, Drive, EnvironmentParameters, IntegrationState, SimError, Simulation, Terrain,
};
use lifelike_character::{Body, Character, Inertial, Joint, JointKind, Quat, Vec3};
use lifelike_robot::{Profile, Robot};

fn body(name: &str, parent: usize, joints: std::ops::Range<usize>, mass: f64) -> Body {
    Body {
        name: name.into(),
        parent,
        position: if parent == 0 { Vec3::zeros() } else { Vec3::new(0.0, 0.0, 0.2) },
        orientation: Quat::identity(),
        inertial: Inertial {
            mass,
            com: Vec3::zeros(),
            orientation: Quat::identity(),
            diagonal: Vec3::new(0.1, 0.1, 0.1),
        },
        joints,
        gravcomp: 0.0,
    }
}

fn joint(name: &str, body: usize, kind: JointKind, q_index: usize, v_index: usize) -> Joint {
    Joint {
        name: name.into(),
        body,
        kind,
        position: Vec3::zeros(),
        axis: Vec3::y(),
        range: (kind == JointKind::Hinge).then_some((-2.0, 2.0)),
        q_index,
        v_index,
        reference: 0.0,
        armature: 0.01,
        damping: 0.0,
        frictionloss: 0.0,
        stiffness: 0.0,
        spring_reference: 0.0,
        actuator_force_range: Some((-10.0, 10.0)),
        velocity_limit: None,
        coupling: None,
    }
}

/// Pelvis, thigh, shank.
pub fn robot() -> Arc<Robot> {
    let character = Character {
        name: "post".into(),
        bodies: vec![
            body("world", 0, 0..0, 0.0),
            Body { position: Vec3::new(0.0, 0.0, 0.5), ..body("pelvis", 0, 0..1, 1.0) },
            body("left_thigh", 1, 1..2, 0.5),
            body("left_shank", 2, 2..3, 0.5),
        ],
        joints: vec![
            joint("root", 1, JointKind::Free, 0, 0),
            joint("hip", 2, JointKind::Hinge, 7, 6),
            joint("knee", 3, JointKind::Hinge, 8, 7),
        ],
        nq: 9,
        nv: 8,
        gravity: Vec3::new(0.0, 0.0, -9.81),
        timestep: 0.005,
        ..Character::default()
    };
    let profile = Profile { end_effectors: vec!["left_shank".into()], ..Profile::default() };
    Arc::new(Robot::from_character(character, profile).unwrap())
}

/// The followers.
pub struct Followers {
    robot: Arc<Robot>,
    state: BatchState,
    pushes: Vec<[f32; 3]>,
    parameters: Vec<EnvironmentParameters>,
    /// Environment that diverges when it reaches this many steps.
    pub diverge: Option<(usize, u64)>,
    /// The ground that heights are measured from; the base flies.
    pub terrain: Option<Arc<Terrain>>,
    steps: Vec<u64>,
}

impl Followers {
    /// Returns `n` environments of [`robot`].
    pub fn new(n: usize) -> Self {
        let robot = robot();
        let (joints, bodies) = (robot.joints(), robot.character.bodies.len());
        let places = robot.effectors.len() + robot.key_bodies.len();
        let state = BatchState {
            root_position: vec![0.0; 3 * n],
            root_orientation: [1.0, 0.0, 0.0, 0.0].repeat(n),
            linear_velocity_w: vec![0.0; 3 * n],
            angular_velocity_w: vec![0.0; 3 * n],
            joint_position: vec![0.0; joints * n],
            joint_velocity: vec![0.0; joints * n],
            site_position: vec![0.0; 3 * places * n],
            body_position: vec![0.0; 3 * bodies * n],
            body_orientation: [1.0, 0.0, 0.0, 0.0].repeat(bodies * n),
            torque_squared: vec![0.0; joints * n],
            torque: vec![0.0; joints * n],
            foot_force: vec![0.0; robot.anatomy.soles.len() * n],
            constraint_force: vec![0.0; joints * n],
            diverged: vec![false; n],
        };
        let parameters = vec![EnvironmentParameters::default(); n];
        Self { robot, state, pushes: vec![[0.0; 3]; n], parameters, diverge: None, terrain: None, steps: vec![0; n] }
    }

    fn outputs(&mut self) {
        let s = &mut self.state;
        let joints = self.robot.joints();
        for i in 0..self.steps.len() {
            let (sin, cos) = s.joint_position[i * joints].sin_cos();
            let root: Vec<f32> = s.root_position[3 * i..3 * i + 3].to_vec();
            // One place: the end of a 0.2 m link that the first joint turns about y.
            s.site_position[3 * i..3 * i + 3].copy_from_slice(&[
                root[0] + 0.2 * sin,
                root[1],
                root[2] + 0.2 + 0.2 * cos,
            ]);
        }
    }
}

impl Simulation for Followers {
    fn engine(&self) -> &'static str {
        "followers"
    }
    fn robot(&self) -> &Arc<Robot> {
        &self.robot
    }
    fn len(&self) -> usize {
        self.steps.len()
    }
    fn terrain(&self) -> Option<&Arc<Terrain>> {
        self.terrain.as_ref()
    }
    fn state(&self) -> &BatchState {
        &self.state
    }
    fn reset(&mut self, ids: &[usize], positions: &[f64], velocities: &[f64]) -> Result<(), SimError> {
        for ((&i, q), v) in ids.iter().zip(positions.chunks_exact(9)).zip(velocities.chunks_exact(8)) {
            for k in 0..3 {
                self.state.root_position[3 * i + k] = q[k] as f32;
                self.state.linear_velocity_w[3 * i + k] = v[k] as f32;
            }
            for k in 0..4 {
                self.state.root_orientation[4 * i + k] = q[3 + k] as f32;
            }
            for k in 0..2 {
                self.state.joint_position[2 * i + k] = q[7 + k] as f32;
                self.state.joint_velocity[2 * i + k] = v[6 + k] as f32;
            }
            self.steps[i] = 0;
            self.state.diverged[i] = false;
        }
        self.outputs();
        Ok(())
    }
    fn set_parameters(&mut self, id: usize, parameters: EnvironmentParameters) -> Result<(), SimError> {
        self.parameters[id] = parameters;
        Ok(())
    }
    fn push(&mut self, id: usize, _: usize, force_w: [f32; 3], _: [f32; 3]) -> Result<(), SimError> {
        self.pushes[id] = force_w;
        Ok(())
    }
    fn clear_pushes(&mut self, id: usize) {
        self.pushes[id] = [0.0; 3];
    }
    fn step(&mut self, drive: Drive<'_>) -> Result<(), SimError> {
        let Drive::Targets(targets) = drive else { return Ok(()) };
        for i in 0..self.steps.len() {
            self.steps[i] += 1;
            self.state.diverged[i] = self.diverge == Some((i, self.steps[i]));
            let friction = self.parameters[i].ground_friction.unwrap_or(1.0);
            for k in 0..2 {
                let at = 2 * i + k;
                let pull = 200.0 * (targets[at] - self.state.joint_position[at]) - 28.0 * self.state.joint_velocity[at];
                self.state.joint_velocity[at] += 0.02 * pull * friction;
                self.state.joint_position[at] += 0.02 * self.state.joint_velocity[at];
                self.state.torque_squared[at] = pull * pull;
            }
            for k in 0..3 {
                let at = 3 * i + k;
                self.state.linear_velocity_w[at] += 0.001 * self.pushes[i][k];
                self.state.root_position[at] += 0.02 * self.state.linear_velocity_w[at];
            }
        }
        self.outputs();
        Ok(())
    }
    fn constraint_wrenches(&mut self, _: Drive<'_>) -> Result<ConstraintWrenches, SimError> {
        Ok(ConstraintWrenches::zeros(self.len(), self.robot.character.bodies.len(), self.robot.joints()))
    }
    fn save(&self) -> IntegrationState {
        let s = &self.state;
        let mut values = Vec::new();
        for i in 0..self.steps.len() {
            let columns: [(&[f32], usize); 7] = [
                (&s.root_position, 3),
                (&s.root_orientation, 4),
                (&s.linear_velocity_w, 3),
                (&s.joint_position, 2),
                (&s.joint_velocity, 2),
                (self.pushes.as_flattened(), 3),
                (&s.angular_velocity_w, 3),
            ];
            for (column, width) in columns {
                values.extend(column[i * width..(i + 1) * width].iter().map(|x| f64::from(*x)));
            }
            values.push(self.steps[i] as f64);
        }
        IntegrationState { engine: "followers".into(), width: 21, values, parameters: self.parameters.clone() }
    }
    fn restore(&mut self, saved: &IntegrationState) -> Result<(), SimError> {
        for (i, row) in saved.values.chunks_exact(21).enumerate() {
            let mut rest = row.iter().map(|x| *x as f32);
            let mut take = |to: &mut [f32]| to.iter_mut().for_each(|x| *x = rest.next().unwrap());
            take(&mut self.state.root_position[3 * i..3 * i + 3]);
            take(&mut self.state.root_orientation[4 * i..4 * i + 4]);
            take(&mut self.state.linear_velocity_w[3 * i..3 * i + 3]);
            take(&mut self.state.joint_position[2 * i..2 * i + 2]);
            take(&mut self.state.joint_velocity[2 * i..2 * i + 2]);
            take(&mut self.pushes[i]);
            take(&mut self.state.angular_velocity_w[3 * i..3 * i + 3]);
            self.steps[i] = row[20] as u64;
        }
        self.parameters = saved.parameters.clone();
        self.outputs();
        Ok(())
    }
}
