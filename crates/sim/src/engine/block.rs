//! W environments that are stepped together: their state, and one physics step.

use std::sync::Arc;

use lifelike_character::JointKind;
use lifelike_robot::Robot;
use lifelike_robot::actuator::{ActuatorParameters, Number};

use super::clock::{Clock, Stage};
use super::constraints::{SWEEPS, Solver};
use super::dynamics::Workspace;
use super::lane::{Lane, Scalar};
use super::setting::{Forces, InverseWeights, Setting};
use super::spatial::{Spatial, accumulate, along, cross, dot6};
use super::tree::Tree;
use super::variation::Variation;
use crate::error::SimError;
use crate::terrain::Terrain;

/// An environment with a velocity beyond this (m/s, rad/s) is lost.
const VELOCITY_LIMIT: f64 = 1e3;

/// What is the same for all blocks.
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
    pub own: Variation<T, W>,
    pub exact_own: Variation<f64, 1>,
    /// Visits of all constraint rows per physics step.
    pub sweeps: usize,
}

impl<T: Scalar, const W: usize> Model<T, W> {
    pub fn new(robot: &Robot) -> Result<Self, SimError> {
        let actuators = robot.actuators.parameters.iter().map(|p| ActuatorParameters {
            kp: Lane::of(p.kp),
            kd: Lane::of(p.kd),
            friction_velocity: Lane::of(p.friction_velocity),
            static_friction: Lane::of(p.static_friction),
            viscous_friction: Lane::of(p.viscous_friction),
            torque_max: Lane::of(p.torque_max),
            full_torque_velocity: Lane::of(p.full_torque_velocity),
            velocity_max: Lane::of(p.velocity_max),
        });
        let actuators: Vec<_> = actuators.collect();
        let (tree, exact) = (Tree::new(robot)?, Tree::new(robot)?);
        let own = Variation::none(&tree, &actuators);
        // Inverse weights need no gains.
        let exact_own = Variation::none(&exact, &[]);
        Ok(Self { tree, exact, terrain: None, actuators, own, exact_own, sweeps: SWEEPS })
    }
}

/// The state and the parameters of W environments.
#[derive(Debug, Clone)]
pub struct Block<T: Scalar, const W: usize> {
    pub q: Vec<Lane<T, W>>,
    pub v: Vec<Lane<T, W>>,
    pub forces: Forces<T, W>,
    pub variation: Variation<T, W>,
    pub weights: InverseWeights<T, W>,
    /// Torque and force at the centre of mass of each body, world axes; none where nobody pushes.
    pub pushes: Vec<Option<Spatial<T, W>>>,
    pub diverged: [bool; W],
    /// Targets (rad) or torques (N m) of this step, one per scalar joint.
    pub command: Vec<Lane<T, W>>,
    /// Torque of each actuator at the last substep, and the mean of its square over the substeps.
    pub torque: Vec<Lane<T, W>>,
    pub torque_squared: Vec<Lane<T, W>>,
}

/// What a thread calculates with.
#[derive(Debug, Clone)]
pub struct Desk<T: Scalar, const W: usize> {
    pub work: Workspace<T, W>,
    solver: Solver<T, W>,
    u: Vec<Lane<T, W>>,
    damping: Vec<Lane<T, W>>,
    before: Before<T, W>,
}

/// A state to go back to.
#[derive(Debug, Clone)]
struct Before<T: Scalar, const W: usize> {
    q: Vec<Lane<T, W>>,
    v: Vec<Lane<T, W>>,
    forces: Forces<T, W>,
}

impl<T: Scalar, const W: usize> Desk<T, W> {
    pub fn new(tree: &Tree<T>) -> Self {
        let zero = Lane::zero();
        Self {
            work: Workspace::new(tree),
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
        self.work.kinematics(tree, &block.q);
        self.work.bias(tree, &block.variation, &block.v);
        self.work.mass_matrix(tree, &block.variation);
        let mut a: Vec<_> = applied.iter().zip(&self.work.bias).map(|(t, b)| *t - *b).collect();
        let Workspace { factors, mass, .. } = &mut self.work;
        factors.factorise(tree, mass, |_| Lane::zero());
        factors.half_solve(tree, &mut a);
        factors.finish_solve(tree, &mut a);
        a
    }
}

impl<T: Scalar, const W: usize> Desk<T, W> {
    /// What the contacts that [`Block::accelerate`] kept exert on each body, about the root's position.
    pub fn contact_forces(&mut self, tree: &Tree<T>, forces: &Forces<T, W>) -> Vec<Spatial<T, W>> {
        let zero = Lane::zero();
        let mut out = vec![[zero; 6]; tree.bodies.len()];
        let kept = self.solver.contacts.kept.take().unwrap_or_default();
        for (place, contact) in kept.iter().zip(&self.solver.contacts.list) {
            let total = contact.total(&forces.contact[contact.slot]);
            let force = (0..3).fold([zero; 3], |sum, k| along(&sum, &place.frame[k], total[k]));
            let torque = cross(&place.point, &force);
            let wrench = [torque[0], torque[1], torque[2], force[0], force[1], force[2]];
            let [a, b] = place.bodies;
            accumulate(&mut out[b], &wrench);
            accumulate(&mut out[a], &wrench.map(|x| -x));
        }
        out[0] = [zero; 6];
        out
    }
}

impl<T: Scalar, const W: usize> Block<T, W> {
    /// All environments in the reference position with the model's own masses.
    pub fn new(model: &Model<T, W>, weights: &InverseWeights<f64, 1>) -> Self {
        let (tree, zero) = (&model.tree, Lane::zero());
        let spread = |values: &[Lane<f64, 1>]| values.iter().map(|x| Lane::of(x.0[0])).collect();
        Self {
            q: vec![zero; tree.nq],
            v: vec![zero; tree.nv],
            forces: Forces::new(tree),
            variation: model.own.clone(),
            weights: InverseWeights { body: spread(&weights.body), dof: spread(&weights.dof) },
            pushes: vec![None; tree.bodies.len()],
            diverged: [false; W],
            command: vec![zero; tree.driven.len()],
            torque: vec![zero; tree.driven.len()],
            torque_squared: vec![zero; tree.driven.len()],
        }
    }

    /// Memory that it takes (bytes).
    pub fn bytes(&self) -> usize {
        let lanes = self.q.len()
            + self.v.len()
            + self.forces.len()
            + self.variation.len()
            + self.weights.body.len()
            + self.weights.dof.len()
            + self.command.len()
            + self.torque.len()
            + self.torque_squared.len();
        lanes * size_of::<Lane<T, W>>()
            + size_of_val(self.pushes.as_slice())
            + self.forces.live.len()
            + size_of::<Self>()
    }

    /// One policy step. What diverges, or did before, stays as it was; its neighbours do not notice.
    pub fn step(&mut self, model: &Model<T, W>, desk: &mut Desk<T, W>, targets: bool, clock: &mut impl Clock) {
        desk.before.q.clone_from(&self.q);
        desk.before.v.clone_from(&self.v);
        desk.before.forces.clone_from(&self.forces);
        let zero = Lane::zero();
        self.torque_squared.iter_mut().for_each(|x| *x = zero);
        for _ in 0..model.tree.substeps {
            self.substep(model, desk, targets, clock);
        }
        let share = Lane::of(1.0 / model.tree.substeps as f64);
        self.torque_squared.iter_mut().for_each(|x| *x = *x * share);
        self.quarantine(&mut desk.before);
        desk.work.kinematics(&model.tree, &self.q);
    }

    fn quarantine(&mut self, before: &mut Before<T, W>) {
        let limit = T::new(VELOCITY_LIMIT);
        for lane in 0..W {
            // A limit on the torque would turn a target that is not a number into a torque that is one.
            let sound = self.q.iter().chain(&self.command).all(|x| x.0[lane].wide().is_finite())
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

    /// Actuators, dynamics and constraints: leaves the acceleration in the solver's coordinates (`desk.u`), and every dof's
    /// damping.
    #[inline(always)]
    fn forward(&mut self, model: &Model<T, W>, desk: &mut Desk<T, W>, targets: bool, clock: &mut impl Clock) {
        let tree = &model.tree;
        let Desk { work, solver, u, damping, .. } = desk;
        work.kinematics(tree, &self.q);
        clock.lap(Stage::Kinematics);
        work.bias(tree, &self.variation, &self.v);
        clock.lap(Stage::Bias);
        work.mass_matrix(tree, &self.variation);
        clock.lap(Stage::MassMatrix);
        damping.copy_from_slice(&self.variation.damping);
        for (u, bias) in u.iter_mut().zip(&work.bias) {
            *u = -*bias;
        }
        for (i, (joint, actuator)) in tree.driven.iter().zip(&model.actuators).enumerate() {
            let (position, velocity) = (self.q[joint.q], self.v[joint.v]);
            let applied = if targets {
                let [kp, kd] = self.variation.gains[i];
                let actuator = ActuatorParameters { kp, kd, ..*actuator };
                let friction = actuator.friction_damping(velocity);
                damping[joint.v] += friction;
                let motor = self.variation.strength[i] * actuator.motor_torque(self.command[i], position, velocity);
                self.torque[i] = motor.minus(friction, velocity);
                motor
            } else {
                self.torque[i] = self.command[i];
                self.command[i]
            };
            u[joint.v] += applied;
            self.torque_squared[i] = self.torque_squared[i].plus(self.torque[i], self.torque[i]);
        }
        for d in 0..tree.nv {
            u[d] = u[d].minus(damping[d], self.v[d]);
        }
        for spring in &tree.springs {
            let stretch = self.q[spring.q] - Lane::all(spring.reference);
            u[spring.v] = u[spring.v].minus(Lane::all(spring.stiffness), stretch);
        }
        for (body, push) in self.pushes.iter().enumerate() {
            if let (Some(push), Some(last)) = (push, tree.bodies[body].last_dof) {
                let about_root = work.about_origin(push, body);
                for d in &tree.dofs[last].chain {
                    u[*d] += dot6(&work.motion[*d], &about_root);
                }
            }
        }
        clock.lap(Stage::Forces);
        work.factors.factorise(tree, &work.mass, |_| Lane::zero());
        work.factors.half_solve(tree, u);
        clock.lap(Stage::Factors);
        let setting = Setting {
            tree,
            terrain: model.terrain.as_deref(),
            work,
            weights: &self.weights,
            friction: self.variation.friction,
            foot_friction: &self.variation.feet,
            q: &self.q,
            v: &self.v,
            sweeps: model.sweeps,
        };
        solver.solve(&setting, &mut self.forces, u, clock);
    }

    /// One physics step: semi-implicit Euler with damping taken implicitly (MuJoCo's `Euler`: constraint forces see M, the
    /// velocities M + h D).
    fn substep(&mut self, model: &Model<T, W>, desk: &mut Desk<T, W>, targets: bool, clock: &mut impl Clock) {
        self.forward(model, desk, targets, clock);
        let (tree, h) = (&model.tree, Lane::of(model.tree.timestep));
        let Desk { work, u, damping, .. } = desk;
        work.factors.half_multiply(tree, u);
        work.factors.factorise(tree, &work.mass, |d| h * damping[d]);
        work.factors.half_solve(tree, u);
        work.factors.finish_solve(tree, u);
        clock.lap(Stage::Factors);
        for d in 0..tree.nv {
            self.v[d] = self.v[d].plus(h, u[d]);
        }
        self.move_along(tree, h);
        clock.lap(Stage::Integration);
    }

    /// Acceleration of every dof in the present state, damping not taken implicitly.
    pub fn accelerate(&mut self, model: &Model<T, W>, desk: &mut Desk<T, W>, targets: bool) -> Vec<Lane<T, W>> {
        desk.solver.contacts.kept = Some(Vec::new());
        self.forward(model, desk, targets, &mut ());
        desk.work.factors.finish_solve(&model.tree, &mut desk.u);
        desk.u.clone()
    }

    fn move_along(&mut self, tree: &Tree<T>, h: Lane<T, W>) {
        for joint in &tree.joints {
            let (q, v) = (joint.q, joint.v);
            match joint.kind {
                JointKind::Hinge | JointKind::Slide => self.q[q] = self.q[q].plus(h, self.v[v]),
                JointKind::Free => {
                    for k in 0..3 {
                        self.q[q + k] = self.q[q + k].plus(h, self.v[v + k]);
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
        let speed = (x * x).plus(y, y).plus(z, z).sqrt().most(Lane::of(1e-12));
        let (s, c) = (speed * h * Lane::of(0.5)).sin_cos();
        let share = s / speed;
        let (x, y, z) = (x * share, y * share, z * share);
        let [w0, x0, y0, z0] = [self.q[q], self.q[q + 1], self.q[q + 2], self.q[q + 3]];
        let new = [
            (w0 * c).minus(x0, x).minus(y0, y).minus(z0, z),
            (x0 * c).plus(w0, x).plus(y0, z).minus(z0, y),
            (y0 * c).plus(w0, y).plus(z0, x).minus(x0, z),
            (z0 * c).plus(w0, z).plus(x0, y).minus(y0, x),
        ];
        let square = (new[0] * new[0]).plus(new[1], new[1]).plus(new[2], new[2]).plus(new[3], new[3]);
        let inverse = square.sqrt().recip();
        for (k, x) in new.into_iter().enumerate() {
            self.q[q + k] = x * inverse;
        }
    }
}
