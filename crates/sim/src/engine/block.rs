//! W environments that are stepped together: their state, and one physics step.

use std::sync::Arc;

use lifelike_character::JointKind;
use lifelike_robot::Robot;
use lifelike_robot::actuator::ActuatorParameters;

use super::command::Command;
use super::constraints::{ITERATIONS, Solver};
use super::lane::{Lane, Scalar};
use super::model_parameters::ModelParameters;
use super::profiler::{Profiler, Stage};
use super::rigid_body::RigidBodyDynamics;
use super::solver_context::{Forces, InvWeight, SolverContext};
use super::spatial::{Spatial, accumulate, along, cross, dot6};
use super::tree::Tree;
use crate::error::SimError;
use crate::terrain::Terrain;

/// Velocity (m/s, rad/s) beyond which an environment has diverged.
const VELOCITY_LIMIT: f64 = 1e3;

/// Constants of the robot that all blocks share.
#[derive(Debug)]
pub struct Model<T: Scalar, const W: usize> {
    pub tree: Tree<T>,
    /// The same in double precision: inverse weights are made with it.
    pub exact: Tree<f64>,
    /// Uneven ground in place of the level one.
    pub terrain: Option<Arc<Terrain>>,
    /// One actuator per scalar joint.
    pub actuators: Vec<ActuatorParameters<Lane<T, W>>>,
    /// The model's own constants, of all environments and in double precision.
    pub nominal: ModelParameters<T, W>,
    pub exact_nominal: ModelParameters<f64, 1>,
    /// Visits of all constraint rows per physics step.
    pub iterations: usize,
}

impl<T: Scalar, const W: usize> Model<T, W> {
    pub fn new(robot: &Robot) -> Result<Self, SimError> {
        let actuators = robot.actuators.parameters.iter().map(|p| ActuatorParameters {
            kp: Lane::splat_f64(p.kp),
            kd: Lane::splat_f64(p.kd),
            friction_velocity: Lane::splat_f64(p.friction_velocity),
            static_friction: Lane::splat_f64(p.static_friction),
            viscous_friction: Lane::splat_f64(p.viscous_friction),
            torque_max: Lane::splat_f64(p.torque_max),
            full_torque_velocity: Lane::splat_f64(p.full_torque_velocity),
            velocity_max: Lane::splat_f64(p.velocity_max),
        });
        let actuators: Vec<_> = actuators.collect();
        let (tree, exact) = (Tree::new(robot)?, Tree::new(robot)?);
        let nominal = ModelParameters::nominal(&tree, &actuators);
        // Inverse weights need no gains.
        let exact_nominal = ModelParameters::nominal(&exact, &[]);
        Ok(Self { tree, exact, terrain: None, actuators, nominal, exact_nominal, iterations: ITERATIONS })
    }
}

/// The state and the parameters of W environments.
#[derive(Debug, Clone)]
pub struct Block<T: Scalar, const W: usize> {
    pub q: Vec<Lane<T, W>>,
    pub v: Vec<Lane<T, W>>,
    pub forces: Forces<T, W>,
    pub parameters: ModelParameters<T, W>,
    pub invweight: InvWeight<T, W>,
    /// Torque and force at the centre of mass of each body, world axes; none where nobody pushes.
    pub pushes: Vec<Option<Spatial<T, W>>>,
    pub diverged: [bool; W],
    /// Joint commands of this step.
    pub command: Command<T, W>,
    /// Torque of each actuator at the last substep, and the mean of its square over the substeps.
    pub torque: Vec<Lane<T, W>>,
    pub torque_squared: Vec<Lane<T, W>>,
}

/// Scratch memory of one thread.
#[derive(Debug, Clone)]
pub struct Workspace<T: Scalar, const W: usize> {
    pub dynamics: RigidBodyDynamics<T, W>,
    solver: Solver<T, W>,
    u: Vec<Lane<T, W>>,
    damping: Vec<Lane<T, W>>,
    before: Before<T, W>,
}

/// State at the beginning of a step, for environments that diverge in it.
#[derive(Debug, Clone)]
struct Before<T: Scalar, const W: usize> {
    q: Vec<Lane<T, W>>,
    v: Vec<Lane<T, W>>,
    forces: Forces<T, W>,
}

impl<T: Scalar, const W: usize> Workspace<T, W> {
    pub fn new(tree: &Tree<T>) -> Self {
        let zero = Lane::zero();
        Self {
            dynamics: RigidBodyDynamics::new(tree),
            solver: Solver::new(tree),
            u: vec![zero; tree.nv],
            damping: vec![zero; tree.nv],
            before: Before { q: vec![zero; tree.nq], v: vec![zero; tree.nv], forces: Forces::new(tree) },
        }
    }

    /// Acceleration of every dof without constraints, and the mass matrix and bias forces on the way: for tests.
    pub fn unconstrained(
        &mut self,
        model: &Model<T, W>,
        block: &Block<T, W>,
        applied: &[Lane<T, W>],
    ) -> Vec<Lane<T, W>> {
        let tree = &model.tree;
        self.dynamics.kinematics(tree, &block.q);
        self.dynamics.bias(tree, &block.parameters, &block.v);
        self.dynamics.mass_matrix(tree, &block.parameters);
        let mut a: Vec<_> = applied.iter().zip(&self.dynamics.bias).map(|(t, b)| *t - *b).collect();
        let RigidBodyDynamics { factors, mass, .. } = &mut self.dynamics;
        factors.factorise(tree, mass, |_| Lane::zero());
        factors.half_solve(tree, &mut a);
        factors.finish_solve(tree, &mut a);
        a
    }
}

impl<T: Scalar, const W: usize> Workspace<T, W> {
    /// Returns the wrenches on each body of the contacts that [`Block::accelerate`] recorded, about the root's position.
    pub fn contact_forces(&mut self, tree: &Tree<T>, forces: &Forces<T, W>) -> Vec<Spatial<T, W>> {
        let zero = Lane::zero();
        let mut out = vec![[zero; 6]; tree.bodies.len()];
        let recorded = self.solver.contacts.recorded.take().unwrap_or_default();
        for (frame, contact) in recorded.iter().zip(&self.solver.contacts.list) {
            let total = contact.total(&forces.contact[contact.slot]);
            let force = (0..3).fold([zero; 3], |sum, k| along(&sum, &frame.axes[k], total[k]));
            let torque = cross(&frame.point, &force);
            let wrench = [torque[0], torque[1], torque[2], force[0], force[1], force[2]];
            let [a, b] = frame.bodies;
            accumulate(&mut out[b], &wrench);
            accumulate(&mut out[a], &wrench.map(|x| -x));
        }
        out[0] = [zero; 6];
        out
    }
}

impl<T: Scalar, const W: usize> Block<T, W> {
    /// All environments in the reference position with the model's own masses.
    pub fn new(model: &Model<T, W>, invweight: &InvWeight<f64, 1>) -> Self {
        let (tree, zero) = (&model.tree, Lane::zero());
        let broadcast = |values: &[Lane<f64, 1>]| values.iter().map(|x| Lane::splat_f64(x.0[0])).collect();
        Self {
            q: vec![zero; tree.nq],
            v: vec![zero; tree.nv],
            forces: Forces::new(tree),
            parameters: model.nominal.clone(),
            invweight: InvWeight { body: broadcast(&invweight.body), dof: broadcast(&invweight.dof) },
            pushes: vec![None; tree.bodies.len()],
            diverged: [false; W],
            command: Command::none(tree.driven.len()),
            torque: vec![zero; tree.driven.len()],
            torque_squared: vec![zero; tree.driven.len()],
        }
    }

    /// Returns its memory (bytes).
    pub fn bytes(&self) -> usize {
        let lanes = self.q.len()
            + self.v.len()
            + self.forces.len()
            + self.parameters.len()
            + self.invweight.body.len()
            + self.invweight.dof.len()
            + self.command.values.len()
            + self.torque.len()
            + self.torque_squared.len();
        lanes * size_of::<Lane<T, W>>()
            + size_of_val(self.pushes.as_slice())
            + self.forces.live.len()
            + size_of::<Self>()
    }

    /// Makes one policy step. An environment that diverges, or did before, stays as it was and leaves its neighbours alone.
    pub fn step(&mut self, model: &Model<T, W>, workspace: &mut Workspace<T, W>, profiler: &mut impl Profiler) {
        workspace.before.q.clone_from(&self.q);
        workspace.before.v.clone_from(&self.v);
        workspace.before.forces.clone_from(&self.forces);
        let zero = Lane::zero();
        self.torque_squared.iter_mut().for_each(|x| *x = zero);
        for _ in 0..model.tree.substeps {
            self.substep(model, workspace, profiler);
        }
        let share = Lane::splat_f64(1.0 / model.tree.substeps as f64);
        self.torque_squared.iter_mut().for_each(|x| *x = *x * share);
        self.quarantine(&mut workspace.before);
        workspace.dynamics.kinematics(&model.tree, &self.q);
    }

    fn quarantine(&mut self, before: &mut Before<T, W>) {
        let limit = T::new(VELOCITY_LIMIT);
        for lane in 0..W {
            // A limit on the torque would turn a target that is not a number into a torque that is one.
            let sound = self.q.iter().chain(&self.command.values).all(|x| x.0[lane].to_f64().is_finite())
                && self.v.iter().all(|x| x.0[lane] <= limit && -x.0[lane] <= limit);
            if sound && !self.diverged[lane] {
                continue;
            }
            self.diverged[lane] = true;
            let restore = |now: &mut Lane<T, W>, then: &Lane<T, W>| now.0[lane] = then.0[lane];
            self.q.iter_mut().zip(&before.q).for_each(|(a, b)| restore(a, b));
            self.v.iter_mut().zip(&before.v).for_each(|(a, b)| restore(a, b));
            self.forces.numbers_mut().zip(before.forces.numbers_mut()).for_each(|(a, b)| restore(a, b));
            for x in self.torque.iter_mut().chain(&mut self.torque_squared) {
                x.0[lane] = T::default();
            }
        }
    }

    /// Actuators, dynamics and constraints: leaves the acceleration in the solver's coordinates (`workspace.u`), and every dof's
    /// damping.
    #[inline(always)]
    fn forward(&mut self, model: &Model<T, W>, workspace: &mut Workspace<T, W>, profiler: &mut impl Profiler) {
        let (tree, command) = (&model.tree, &self.command);
        let Workspace { dynamics, solver, u, damping, .. } = workspace;
        dynamics.kinematics(tree, &self.q);
        profiler.end_stage(Stage::Kinematics);
        dynamics.bias(tree, &self.parameters, &self.v);
        profiler.end_stage(Stage::Bias);
        dynamics.mass_matrix(tree, &self.parameters);
        profiler.end_stage(Stage::MassMatrix);
        damping.copy_from_slice(&self.parameters.damping);
        for (u, bias) in u.iter_mut().zip(&dynamics.bias) {
            *u = -*bias;
        }
        for (i, (joint, actuator)) in tree.driven.iter().zip(&model.actuators).enumerate() {
            let (position, velocity) = (self.q[joint.q], self.v[joint.v]);
            let applied = if command.targets {
                let [kp, kd] = self.parameters.gains[i];
                let actuator = ActuatorParameters { kp, kd, ..*actuator };
                let friction = actuator.friction_damping(velocity);
                damping[joint.v] += friction;
                let motor = self.parameters.strength[i] * actuator.motor_torque(command.values[i], position, velocity);
                self.torque[i] = motor.sub_mul(friction, velocity);
                motor
            } else {
                self.torque[i] = command.values[i];
                command.values[i]
            };
            u[joint.v] += applied;
            self.torque_squared[i] = self.torque_squared[i].add_mul(self.torque[i], self.torque[i]);
        }
        for d in 0..tree.nv {
            u[d] = u[d].sub_mul(damping[d], self.v[d]);
        }
        for spring in &tree.springs {
            let stretch = self.q[spring.q] - Lane::splat(spring.reference);
            u[spring.v] = u[spring.v].sub_mul(Lane::splat(spring.stiffness), stretch);
        }
        for (body, push) in self.pushes.iter().enumerate() {
            if let (Some(push), Some(last)) = (push, tree.bodies[body].last_dof) {
                let about_root = dynamics.about_origin(push, body);
                for d in &tree.dofs[last].chain {
                    u[*d] += dot6(&dynamics.motion[*d], &about_root);
                }
            }
        }
        profiler.end_stage(Stage::Forces);
        dynamics.factors.factorise(tree, &dynamics.mass, |_| Lane::zero());
        dynamics.factors.half_solve(tree, u);
        profiler.end_stage(Stage::Factors);
        let context = SolverContext {
            tree,
            terrain: model.terrain.as_deref(),
            dynamics,
            invweight: &self.invweight,
            friction: self.parameters.friction,
            foot_friction: &self.parameters.feet,
            q: &self.q,
            v: &self.v,
            iterations: model.iterations,
        };
        solver.solve(&context, &mut self.forces, u, profiler);
    }

    /// One physics step: semi-implicit Euler with damping taken implicitly (MuJoCo's `Euler`: constraint forces see M, the
    /// velocities M + h D).
    fn substep(&mut self, model: &Model<T, W>, workspace: &mut Workspace<T, W>, profiler: &mut impl Profiler) {
        self.forward(model, workspace, profiler);
        let (tree, h) = (&model.tree, Lane::splat_f64(model.tree.timestep));
        let Workspace { dynamics, u, damping, .. } = workspace;
        dynamics.factors.half_multiply(tree, u);
        dynamics.factors.factorise(tree, &dynamics.mass, |d| h * damping[d]);
        dynamics.factors.half_solve(tree, u);
        dynamics.factors.finish_solve(tree, u);
        profiler.end_stage(Stage::Factors);
        for d in 0..tree.nv {
            self.v[d] = self.v[d].add_mul(h, u[d]);
        }
        self.move_along(tree, h);
        profiler.end_stage(Stage::Integration);
    }

    /// Acceleration of every dof in the present state, damping not taken implicitly.
    pub fn accelerate(&mut self, model: &Model<T, W>, workspace: &mut Workspace<T, W>) -> Vec<Lane<T, W>> {
        workspace.solver.contacts.recorded = Some(Vec::new());
        self.forward(model, workspace, &mut ());
        workspace.dynamics.factors.finish_solve(&model.tree, &mut workspace.u);
        workspace.u.clone()
    }

    fn move_along(&mut self, tree: &Tree<T>, h: Lane<T, W>) {
        for joint in &tree.joints {
            let (q, v) = (joint.q, joint.v);
            match joint.kind {
                JointKind::Hinge | JointKind::Slide => self.q[q] = self.q[q].add_mul(h, self.v[v]),
                JointKind::Free => {
                    for k in 0..3 {
                        self.q[q + k] = self.q[q + k].add_mul(h, self.v[v + k]);
                    }
                    self.turn(q + 3, v + 3, h);
                }
                JointKind::Ball => self.turn(q, v, h),
            }
        }
    }

    /// A quaternion turned with an angular velocity in its own frame for a time.
    fn turn(&mut self, q: usize, v: usize, h: Lane<T, W>) {
        let (x, y, z) = (self.v[v], self.v[v + 1], self.v[v + 2]);
        let speed = (x * x).add_mul(y, y).add_mul(z, z).sqrt().max(Lane::splat_f64(1e-12));
        let (s, c) = (speed * h * Lane::splat_f64(0.5)).sin_cos();
        let share = s / speed;
        let (x, y, z) = (x * share, y * share, z * share);
        let [w0, x0, y0, z0] = [self.q[q], self.q[q + 1], self.q[q + 2], self.q[q + 3]];
        let new = [
            (w0 * c).sub_mul(x0, x).sub_mul(y0, y).sub_mul(z0, z),
            (x0 * c).add_mul(w0, x).add_mul(y0, z).sub_mul(z0, y),
            (y0 * c).add_mul(w0, y).add_mul(z0, x).sub_mul(x0, z),
            (z0 * c).add_mul(w0, z).add_mul(x0, y).sub_mul(y0, x),
        ];
        let square = (new[0] * new[0]).add_mul(new[1], new[1]).add_mul(new[2], new[2]).add_mul(new[3], new[3]);
        let inverse = square.sqrt().recip();
        for (k, x) in new.into_iter().enumerate() {
            self.q[q + k] = x * inverse;
        }
    }
}
