//! Inputs of the constraint solver, and the forces that it leaves for the next step.

use super::lanes::Lanes;
use super::rigid_body::RigidBodyDynamics;
use super::tree::Tree;
use crate::terrain::Terrain;

/// Inverse weights at the reference position (MuJoCo's `invweight0`), which scale the regularization.
#[derive(Debug, Clone)]
pub struct InvWeight<V: Lanes> {
    /// Inverse weight of each body's centre of mass, translation (1/kg).
    pub body: Vec<V>,
    /// Inverse weight of each body's rotation (1/(kg m²)), of those bodies whose orientation something holds.
    pub turn: Vec<V>,
    /// Inverse weight of each dof.
    pub dof: Vec<V>,
}

/// Forces of every possible row, kept from step to step.
#[derive(Debug, Clone)]
pub struct Forces<V: Lanes> {
    /// Dry friction of each dof.
    pub friction: Vec<V>,
    /// Each limit; positive pushes away from the limit.
    pub limit: Vec<V>,
    /// The side of each limit: 1 at the lower, -1 at the upper.
    pub side: Vec<V>,
    /// Edges of each possible contact's pyramid: the ground's points, then pairs of the robot's own parts.
    pub contact: Vec<[V; 4]>,
    /// True where any lane of a contact may have a force; elsewhere all are zero.
    pub live: Vec<bool>,
    /// Each row of what closes loops.
    pub closure: Vec<V>,
    /// Each joint that follows another.
    pub coupling: Vec<V>,
    /// Torque on each actuator from outside, which friction under load depends on; empty where no actuator has one.
    pub outside: Vec<V>,
}

impl<V: Lanes> Forces<V> {
    pub fn new(tree: &Tree<V::Scalar>) -> Self {
        let zero = V::zero();
        Self {
            friction: vec![zero; tree.nv],
            limit: vec![zero; tree.limits.len()],
            side: vec![zero; tree.limits.len()],
            contact: vec![[zero; 4]; tree.contacts],
            live: vec![true; tree.contacts],
            closure: vec![zero; tree.closures.triples.rows()],
            coupling: vec![zero; tree.couplings.list.len()],
            outside: vec![zero; tree.loaded],
        }
    }

    /// Takes over the numbers of others of the same robot.
    pub fn copy_from(&mut self, other: &Self) {
        self.friction.copy_from_slice(&other.friction);
        self.limit.copy_from_slice(&other.limit);
        self.side.copy_from_slice(&other.side);
        // Most pairs do not touch: their forces are zero here and there.
        for slot in 0..other.contact.len() {
            if self.live[slot] || other.live[slot] {
                self.contact[slot] = other.contact[slot];
            }
        }
        self.live.copy_from_slice(&other.live);
        self.closure.copy_from_slice(&other.closure);
        self.coupling.copy_from_slice(&other.coupling);
        self.outside.copy_from_slice(&other.outside);
    }

    /// Every number, in a fixed order: for saving, and for bringing one environment back.
    pub fn numbers_mut(&mut self) -> impl Iterator<Item = &mut V> {
        self.live.fill(true);
        let ends = self.friction.iter_mut().chain(&mut self.limit).chain(&mut self.side);
        let closed = self.closure.iter_mut().chain(&mut self.coupling).chain(&mut self.outside);
        ends.chain(self.contact.iter_mut().flatten()).chain(closed)
    }

    /// Returns their number.
    pub fn len(&self) -> usize {
        let joints = self.friction.len() + self.limit.len() + self.side.len() + self.coupling.len();
        let joints = joints + self.outside.len();
        joints + 4 * self.contact.len() + self.closure.len()
    }
}

impl<V: Lanes> Forces<V> {
    /// Forces of the step before stay where something still touches. Returns whether anything does.
    #[inline(always)]
    pub fn keep(&mut self, slot: usize, touching: V) -> bool {
        let any = touching.any_positive();
        if any || self.live[slot] {
            for edge in &mut self.contact[slot] {
                *edge = touching.select_gt(V::zero(), *edge, V::zero());
            }
        }
        self.live[slot] = any;
        any
    }

    /// Nothing touches.
    #[inline(always)]
    pub fn end(&mut self, slot: usize) {
        if self.live[slot] {
            self.contact[slot] = [V::zero(); 4];
            self.live[slot] = false;
        }
    }
}

/// Inputs of the constraint solver in one step.
pub struct SolverContext<'a, V: Lanes> {
    pub tree: &'a Tree<V::Scalar>,
    /// Uneven ground in place of the level one.
    pub terrain: Option<&'a Terrain>,
    pub dynamics: &'a RigidBodyDynamics<V>,
    pub invweight: &'a InvWeight<V>,
    /// Friction of all contacts; where it is below zero, their own.
    pub friction: V,
    /// Friction of each foot on the ground, likewise.
    pub foot_friction: &'a [V],
    /// Largest dry friction of each dof.
    pub frictionloss: &'a [V],
    pub q: &'a [V],
    pub v: &'a [V],
    /// Visits of all rows.
    pub iterations: usize,
}
