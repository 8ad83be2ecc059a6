//! Joints that follow others (MuJoCo's `mjEQ_JOINT`): one row each, q_1 - p(q_2) = 0 of displacements from the reference.
//!
//! The row of dofs is 1 at the follower and -p'(q_2) at the leader.

use lifelike_character::Coupling;
use lifelike_robot::Robot;

use super::dof_chain::DofChain;
use super::lanes::{Lanes, Scalar};
use super::row_block::{Groups, RowBlock};
use super::solver_context::SolverContext;
use super::surface::{Softness, regularization};
use super::tree::Dof;

/// One joint that follows another.
#[derive(Debug, Clone, PartialEq)]
pub struct TreeCoupling<T> {
    follower: Side<T>,
    leader: Option<Side<T>>,
    polynomial: [T; 5],
    softness: Softness<T>,
}

/// A joint of a coupling.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Side<T> {
    q: usize,
    dof: usize,
    /// Index of its dof in the chain.
    at: usize,
    reference: T,
}

/// All couplings of a robot.
#[derive(Debug, Clone, PartialEq)]
pub struct Couplings<T> {
    pub list: Vec<TreeCoupling<T>>,
    pub rows: Groups<1>,
}

impl<T> Default for Couplings<T> {
    fn default() -> Self {
        Self { list: Vec::new(), rows: Groups::default() }
    }
}

impl<T: Scalar> Couplings<T> {
    /// Those of a robot; dof chains that are not there are added.
    pub fn new(robot: &Robot, dofs: &[Dof<T>], dof_chains: &mut Vec<DofChain>) -> Self {
        let mut couplings = Self::default();
        for Coupling { follower, leader, polynomial, solref, solimp } in &robot.character.couplings {
            let joint = |index: usize| &robot.character.joints[index];
            let chain = |index: usize| dofs[joint(index).v_index].chain.as_slice();
            let dof_chain = DofChain::between(chain(*follower), leader.map_or(&[], chain));
            let side = |index: usize| {
                let joint = joint(index);
                let at = dof_chain.dofs.iter().position(|dof| *dof == joint.v_index).unwrap_or_default();
                Side { q: joint.q_index, dof: joint.v_index, at, reference: T::new(joint.reference) }
            };
            couplings.list.push(TreeCoupling {
                follower: side(*follower),
                leader: leader.map(side),
                polynomial: polynomial.map(T::new),
                softness: Softness::new(*solref, *solimp, robot.timestep()),
            });
            let index = dof_chains.iter().position(|chain| *chain == dof_chain).unwrap_or_else(|| {
                dof_chains.push(dof_chain);
                dof_chains.len() - 1
            });
            couplings.rows.add(index, dof_chains);
        }
        couplings
    }

    /// Sets up all rows in the state of a step.
    pub fn prepare<V: Lanes<Scalar = T>>(&self, s: &SolverContext<'_, V>, block: &mut RowBlock<V, 1>) {
        if self.list.is_empty() {
            return;
        }
        V::vectorize(
            #[inline(always)]
            || {
                for (row, coupling) in self.list.iter().enumerate() {
                    self.add(s, block, row, coupling);
                }
                block.factorise(&self.rows);
            },
        );
    }

    #[inline(always)]
    fn add<V: Lanes<Scalar = T>>(
        &self,
        s: &SolverContext<'_, V>,
        block: &mut RowBlock<V, 1>,
        row: usize,
        coupling: &TreeCoupling<T>,
    ) {
        let TreeCoupling { follower, leader, polynomial, softness } = coupling;
        let group = &self.rows.list[row];
        let dof_chain = &s.tree.dof_chains[group.dof_chain];
        let y = &mut block.y[group.y..group.y + dof_chain.len()];
        y.fill([V::zero()]);
        let moved = |side: &Side<T>| s.q[side.q] - V::splat(side.reference);
        let mut violation = moved(follower) - V::splat(polynomial[0]);
        let mut velocity = s.v[follower.dof];
        let mut weight = s.invweight.dof[follower.dof];
        y[follower.at] = [V::splat_f64(1.0)];
        if let Some(leader) = leader {
            let x = moved(leader);
            let (mut value, mut slope) = (V::zero(), V::zero());
            for (k, coefficient) in polynomial.iter().enumerate().skip(1).rev() {
                value = V::splat(*coefficient).add_mul(value, x);
                slope = (V::splat(*coefficient) * V::splat_f64(k as f64)).add_mul(slope, x);
            }
            violation = violation.sub_mul(value, x);
            velocity = velocity.sub_mul(slope, s.v[leader.dof]);
            weight += s.invweight.dof[leader.dof];
            y[leader.at] = [-slope];
        }
        s.dynamics.factors.half_solve_rows(s.tree, dof_chain, y);
        let impedance = softness.impedance(violation);
        let pull = V::splat(softness.stiffness) * impedance;
        block.offset[row] = (V::splat(softness.damping) * velocity).add_mul(pull, violation);
        block.softness[row] = regularization(impedance, weight);
    }
}
