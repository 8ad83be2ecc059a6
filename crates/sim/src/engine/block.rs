//! The environments of a vector, stepped together: their state, and one physics step.

use std::sync::Arc;

use lifelike_character::JointKind;
use lifelike_robot::Robot;
use lifelike_robot::actuator::{ActuatorParameters, ExtendedFriction};

use super::command::Command;
use super::constraints::{ITERATIONS, Solver};
use super::lanes::{Lanes, Scalar};
use super::model_parameters::ModelParameters;
use super::outputs::Outputs;
use super::profiler::{Profiler, Stage};
use super::rigid_body::RigidBodyDynamics;
use super::solver_context::{Forces, InvWeight, SolverContext};
use super::spatial::{Spatial, accumulate, along, cross, dot6};
use super::tree::{Driven, Tree};
use crate::error::SimError;
use crate::terrain::Terrain;

/// Velocity (m/s, rad/s) beyond which an environment has diverged.
const VELOCITY_LIMIT: f64 = 1e3;

/// Constants of the robot that all blocks share.
#[derive(Debug)]
pub struct Model<V: Lanes> {
    pub tree: Tree<V::Scalar>,
    /// The same in double precision: inverse weights are made with it.
    pub exact: Tree<f64>,
    /// Uneven ground in place of the level one.
    pub terrain: Option<Arc<Terrain>>,
    /// One actuator per scalar joint.
    pub actuators: Vec<ActuatorParameters<V>>,
    /// Friction under load, by the index of its actuator.
    pub frictions: Vec<(usize, ExtendedFriction<V>)>,
    /// The model's own constants, of all environments and in double precision.
    pub nominal: ModelParameters<V>,
    pub exact_nominal: ModelParameters<f64>,
    /// Visits of all constraint rows per physics step.
    pub iterations: usize,
}

impl<V: Lanes> Model<V> {
    pub fn new(robot: &Robot) -> Result<Self, SimError> {
        let actuators = robot.actuators.parameters.iter().map(|own| own.map(V::splat_f64));
        let actuators: Vec<_> = actuators.collect();
        let own = robot.actuators.parameters.iter().enumerate();
        let frictions = own.filter_map(|(i, own)| Some((i, own.extended_friction?.map(V::splat_f64))));
        let frictions: Vec<_> = frictions.collect();
        let (tree, exact) = (Tree::new(robot)?, Tree::new(robot)?);
        let nominal = ModelParameters::nominal(&tree, &actuators);
        // Inverse weights need no gains.
        let exact_nominal = ModelParameters::nominal(&exact, &[]);
        Ok(Self { tree, exact, terrain: None, actuators, frictions, nominal, exact_nominal, iterations: ITERATIONS })
    }
}

/// The state and the parameters of the environments of a vector.
#[derive(Debug, Clone)]
pub struct Block<V: Lanes> {
    pub q: Vec<V>,
    pub v: Vec<V>,
    pub forces: Forces<V>,
    /// Largest dry friction of each dof in this step.
    pub frictionloss: Vec<V>,
    pub parameters: ModelParameters<V>,
    pub invweight: InvWeight<V>,
    /// Torque and force at the centre of mass of each body, world axes; none where nobody pushes.
    pub pushes: Vec<Option<Spatial<V>>>,
    pub diverged: Vec<bool>,
    /// Joint commands of this step.
    pub command: Command<V>,
    /// Torque of each actuator at the last substep, and the mean of its square over the substeps.
    pub torque: Vec<V>,
    pub torque_squared: Vec<V>,
}

/// Scratch memory of one thread.
#[derive(Debug, Clone)]
pub struct Workspace<V: Lanes> {
    pub dynamics: RigidBodyDynamics<V>,
    pub outputs: Outputs<V>,
    solver: Solver<V>,
    u: Vec<V>,
    /// Damping times the time step: what taking it implicitly adds to the mass matrix.
    added: Vec<V>,
    before: Before<V>,
}

/// State at the beginning of a step, for environments that diverge in it.
#[derive(Debug, Clone)]
struct Before<V: Lanes> {
    q: Vec<V>,
    v: Vec<V>,
    forces: Forces<V>,
}

impl<V: Lanes> Workspace<V> {
    pub fn new(tree: &Tree<V::Scalar>) -> Self {
        let zero = V::zero();
        Self {
            dynamics: RigidBodyDynamics::new(tree),
            outputs: Outputs::default(),
            solver: Solver::new(tree),
            u: vec![zero; tree.nv],
            added: vec![zero; tree.nv],
            before: Before { q: vec![zero; tree.nq], v: vec![zero; tree.nv], forces: Forces::new(tree) },
        }
    }

    /// Acceleration of every dof without constraints, and the mass matrix and bias forces on the way: for tests.
    pub fn unconstrained(&mut self, model: &Model<V>, block: &Block<V>, applied: &[V]) -> Vec<V> {
        let tree = &model.tree;
        self.dynamics.kinematics(tree, &block.q);
        self.dynamics.bias(tree, &block.parameters, &block.v);
        self.dynamics.mass_matrix(tree, &block.parameters);
        let mut a: Vec<_> = applied.iter().zip(&self.dynamics.bias).map(|(t, b)| *t - *b).collect();
        let RigidBodyDynamics { factors, mass, .. } = &mut self.dynamics;
        factors.factorise(tree, mass, &[]);
        factors.half_solve(tree, &mut a);
        factors.finish_solve(tree, &mut a);
        a
    }
}

impl<V: Lanes> Workspace<V> {
    /// Returns the wrenches on each body of the contacts that [`Block::accelerate`] recorded, about the root's position.
    #[inline(always)]
    pub fn contact_forces(&mut self, tree: &Tree<V::Scalar>, forces: &Forces<V>) -> Vec<Spatial<V>> {
        let zero = V::zero();
        let mut out = vec![[zero; 6]; tree.bodies.len()];
        let recorded = self.solver.contacts.recorded.take().unwrap_or_default();
        for (frame, contact) in recorded.iter().zip(&self.solver.contacts.list) {
            let total = contact.total(&forces.contact[contact.slot]);
            let mut force = [zero; 3];
            for k in 0..3 {
                force = along(&force, &frame.axes[k], total[k]);
            }
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

impl<V: Lanes> Block<V> {
    /// All environments in the reference position with the model's own masses.
    pub fn new(model: &Model<V>, invweight: &InvWeight<f64>) -> Self {
        let (tree, zero) = (&model.tree, V::zero());
        let broadcast = |values: &[f64]| values.iter().map(|x| V::splat_f64(*x)).collect();
        Self {
            q: vec![zero; tree.nq],
            v: vec![zero; tree.nv],
            forces: Forces::new(tree),
            frictionloss: tree.dofs.iter().map(|dof| V::splat(dof.frictionloss)).collect(),
            parameters: model.nominal.clone(),
            invweight: InvWeight {
                body: broadcast(&invweight.body),
                turn: broadcast(&invweight.turn),
                dof: broadcast(&invweight.dof),
            },
            pushes: vec![None; tree.bodies.len()],
            diverged: vec![false; V::LANES],
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
            + self.frictionloss.len()
            + self.parameters.len()
            + self.invweight.body.len()
            + self.invweight.turn.len()
            + self.invweight.dof.len()
            + self.command.values.len()
            + self.torque.len()
            + self.torque_squared.len();
        lanes * size_of::<V>() + size_of_val(self.pushes.as_slice()) + self.forces.live.len() + size_of::<Self>()
    }

    /// Makes one policy step. An environment that diverges, or did before, stays as it was and leaves its neighbours alone.
    pub fn step(&mut self, model: &Model<V>, workspace: &mut Workspace<V>, profiler: &mut dyn Profiler) {
        workspace.before.q.copy_from_slice(&self.q);
        workspace.before.v.copy_from_slice(&self.v);
        workspace.before.forces.copy_from(&self.forces);
        self.torque_squared.fill(V::zero());
        for _ in 0..model.tree.substeps {
            self.substep(model, workspace, profiler);
        }
        let share = V::splat_f64(1.0 / model.tree.substeps as f64);
        V::vectorize(
            #[inline(always)]
            || {
                for x in &mut self.torque_squared {
                    *x = *x * share;
                }
            },
        );
        self.quarantine(&mut workspace.before);
        workspace.dynamics.kinematics(&model.tree, &self.q);
    }

    fn quarantine(&mut self, before: &mut Before<V>) {
        let unsound = self.unsound();
        for lane in 0..V::LANES {
            if unsound.lane(lane) == Scalar::new(0.0) && !self.diverged[lane] {
                continue;
            }
            self.diverged[lane] = true;
            let restore = |now: &mut V, then: &V| now.set_lane(lane, then.lane(lane));
            self.q.iter_mut().zip(&before.q).for_each(|(a, b)| restore(a, b));
            self.v.iter_mut().zip(&before.v).for_each(|(a, b)| restore(a, b));
            self.forces.numbers_mut().zip(before.forces.numbers_mut()).for_each(|(a, b)| restore(a, b));
            for x in self.torque.iter_mut().chain(&mut self.torque_squared) {
                x.set_lane(lane, Scalar::new(0.0));
            }
        }
    }

    /// Zero in the lanes whose numbers are finite and whose velocities are not absurd.
    fn unsound(&self) -> V {
        V::vectorize(
            #[inline(always)]
            || {
                let (zero, one) = (V::zero(), V::splat_f64(1.0));
                let (mut finite, mut fastest) = (zero, zero);
                // A limit on the torque would turn a target that is not a number into a torque that is one.
                for numbers in [&self.q, &self.v, &self.command.values] {
                    for x in numbers {
                        // Infinity times zero is not a number, and stays in the sum.
                        finite = finite.add_mul(*x, zero);
                    }
                }
                for v in &self.v {
                    fastest = fastest.max(v.abs());
                }
                fastest.select_gt(V::splat_f64(VELOCITY_LIMIT), one, finite)
            },
        )
    }

    /// Actuators, dynamics and constraints: leaves the acceleration in the solver's coordinates (`workspace.u`), and what
    /// damping adds to the inertia.
    fn forward(&mut self, model: &Model<V>, workspace: &mut Workspace<V>, profiler: &mut dyn Profiler) {
        let tree = &model.tree;
        workspace.dynamics.kinematics(tree, &self.q);
        profiler.end_stage(Stage::Kinematics);
        workspace.dynamics.bias(tree, &self.parameters, &self.v);
        profiler.end_stage(Stage::Bias);
        workspace.dynamics.mass_matrix(tree, &self.parameters);
        profiler.end_stage(Stage::MassMatrix);
        self.apply_forces(model, workspace);
        self.bound_dry_friction(model);
        profiler.end_stage(Stage::Forces);
        let Workspace { dynamics, solver, u, .. } = workspace;
        dynamics.factors.factorise(tree, &dynamics.mass, &[]);
        dynamics.factors.half_solve(tree, u);
        profiler.end_stage(Stage::Factors);
        let context = SolverContext {
            tree,
            terrain: model.terrain.as_deref(),
            dynamics,
            invweight: &self.invweight,
            friction: self.parameters.friction,
            foot_friction: &self.parameters.feet,
            frictionloss: &self.frictionloss,
            q: &self.q,
            v: &self.v,
            iterations: model.iterations,
        };
        solver.solve(&context, &mut self.forces, u, profiler);
    }

    /// Leaves what acts on each dof besides constraints in `workspace.u`, and what damping adds to its inertia.
    fn apply_forces(&mut self, model: &Model<V>, workspace: &mut Workspace<V>) {
        V::vectorize(
            #[inline(always)]
            || {
                let (tree, command) = (&model.tree, &self.command);
                let Workspace { dynamics, u, added: damping, .. } = workspace;
                let h = V::splat_f64(tree.timestep);
                damping.copy_from_slice(&self.parameters.damping);
                for (u, bias) in u.iter_mut().zip(&dynamics.bias) {
                    *u = -*bias;
                }
                for (i, (joint, actuator)) in tree.driven.iter().zip(&model.actuators).enumerate() {
                    let (position, velocity) = (self.q[joint.q], self.v[joint.v]);
                    let applied = if command.targets {
                        let gains = self.parameters.gains[i];
                        let friction = actuator.friction_damping(velocity);
                        damping[joint.v] += friction;
                        let motor = actuator.motor_torque_with(gains, command.values[i], position, velocity);
                        let motor = self.parameters.strength[i] * motor;
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
                    damping[d] = damping[d] * h;
                }
                for spring in &tree.springs {
                    let stretch = self.q[spring.q] - V::splat(spring.reference);
                    u[spring.v] = u[spring.v].sub_mul(V::splat(spring.stiffness), stretch);
                }
                for (body, push) in self.pushes.iter().enumerate() {
                    if let (Some(push), Some(last)) = (push, tree.bodies[body].last_dof) {
                        let about_root = dynamics.about_origin(push, body);
                        for d in &tree.dofs[last].chain {
                            u[*d] += dot6(&dynamics.motion[*d], &about_root);
                        }
                    }
                }
            },
        );
    }

    /// One physics step: semi-implicit Euler with damping taken implicitly (MuJoCo's `Euler`: constraint forces see M, the
    /// velocities M + h D).
    fn substep(&mut self, model: &Model<V>, workspace: &mut Workspace<V>, profiler: &mut dyn Profiler) {
        self.forward(model, workspace, profiler);
        let (tree, h) = (&model.tree, V::splat_f64(model.tree.timestep));
        let Workspace { dynamics, u, added, .. } = workspace;
        dynamics.factors.half_multiply(tree, u);
        self.note_outside_torques(tree, u);
        dynamics.factors.factorise(tree, &dynamics.mass, added);
        dynamics.factors.half_solve(tree, u);
        dynamics.factors.finish_solve(tree, u);
        profiler.end_stage(Stage::Factors);
        self.move_along(tree, u, h);
        profiler.end_stage(Stage::Integration);
    }

    /// Sets the largest dry friction of joints whose actuators have friction under load. It depends on the motor's torque, and on
    /// that from outside in the step before.
    fn bound_dry_friction(&mut self, model: &Model<V>) {
        V::vectorize(
            #[inline(always)]
            || {
                for (i, friction) in &model.frictions {
                    let Driven { v: d, .. } = model.tree.driven[*i];
                    let velocity = self.v[d];
                    let mut held = V::splat(model.tree.dofs[d].frictionloss);
                    if self.command.targets {
                        let motor = self.torque[*i].add_mul(model.actuators[*i].friction_damping(velocity), velocity);
                        held += friction.limit(motor, self.forces.outside[*i], velocity);
                    }
                    self.frictionloss[d] = held;
                }
            },
        );
    }

    /// Keeps the torque on each actuator from outside for its friction in the next step, given the sum of all forces on each dof:
    /// all but the actuator's own torque, the joint's damping and its dry friction.
    fn note_outside_torques(&mut self, tree: &Tree<V::Scalar>, total: &[V]) {
        let Self { forces, parameters, torque, v, .. } = self;
        V::vectorize(
            #[inline(always)]
            || {
                for (outside, (joint, torque)) in forces.outside.iter_mut().zip(tree.driven.iter().zip(torque)) {
                    let d = joint.v;
                    *outside = (total[d] - *torque - forces.friction[d]).add_mul(parameters.damping[d], v[d]);
                }
            },
        );
    }

    /// Acceleration of every dof in the present state, damping not taken implicitly.
    pub fn accelerate(&mut self, model: &Model<V>, workspace: &mut Workspace<V>) -> Vec<V> {
        workspace.solver.contacts.recorded = Some(Vec::new());
        self.forward(model, workspace, &mut ());
        workspace.dynamics.factors.finish_solve(&model.tree, &mut workspace.u);
        workspace.u.clone()
    }

    /// Integrates accelerations.
    fn move_along(&mut self, tree: &Tree<V::Scalar>, acceleration: &[V], h: V) {
        V::vectorize(
            #[inline(always)]
            || {
                for (v, a) in self.v.iter_mut().zip(acceleration) {
                    *v = v.add_mul(h, *a);
                }
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
            },
        );
    }

    /// A quaternion turned with an angular velocity in its own frame for a time.
    #[inline(always)]
    fn turn(&mut self, q: usize, v: usize, h: V) {
        let (x, y, z) = (self.v[v], self.v[v + 1], self.v[v + 2]);
        let speed = (x * x).add_mul(y, y).add_mul(z, z).sqrt().max(V::splat_f64(1e-12));
        let (s, c) = (speed * h * V::splat_f64(0.5)).sin_cos();
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
