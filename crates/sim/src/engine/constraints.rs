//! Constraints: joint limits, dry friction, contacts. MuJoCo's convex model, solved by projected Gauss-Seidel.
//!
//! Each constraint row r has a Jacobian J_r, a reference acceleration a*_r = -b v_r - k i d_r (violation d_r, impedance i)
//! and a regularization R_r = (1 - i) / i · Â_r. Forces minimise ½ fᵀ(A + R)f + fᵀ(J a₀ - a*), A = J M⁻¹ Jᵀ, within their
//! bounds (MuJoCo documentation, "Computation"). A contact with friction is a pyramid of four edges J_n ± μ J_t whose
//! forces are not negative.
//!
//! In the coordinates u = D^(1/2) L a (M = Lᵀ D L) the matrix is Y Yᵀ with rows y_r = D^(-1/2) L^(-T) J_rᵀ that have
//! entries on one chain of the tree only. So a row is visited by one scalar product and one update of u, and A is never
//! formed. [`ITERATIONS`] visits of all rows per step, each contact solved [`INNER`](super::contact::INNER) times within itself, started from the
//! forces of the step before: fixed, so that every environment does the same. `tests/oracle_contact.rs` says how far
//! that is from MuJoCo's converged forces, and that a hundred iterations arrive there.

use super::collision::Detector;
use super::contact::Contacts;
use super::dof_chain::DofChain;
use super::lane::{Lane, Scalar};
use super::profiler::{Profiler, Stage};
use super::solver_context::{Forces, SolverContext};
use super::surface::regularization;
use super::tree::Tree;

/// Visits of all rows per physics step, where nobody says otherwise.
pub const ITERATIONS: usize = 12;

/// One bounded row on the chain of a dof.
#[derive(Debug, Clone)]
struct Row<T: Scalar, const W: usize> {
    /// Index into `Forces::friction` or `Forces::limit`.
    slot: usize,
    dof: usize,
    y: usize,
    offset: Lane<T, W>,
    softness: Lane<T, W>,
    inverse: Lane<T, W>,
    low: Lane<T, W>,
    high: Lane<T, W>,
}

/// The rows of one step.
#[derive(Debug, Clone)]
pub struct Solver<T: Scalar, const W: usize> {
    frictions: Vec<Row<T, W>>,
    limits: Vec<Row<T, W>>,
    /// The y of frictions and limits.
    singles: Vec<[Lane<T, W>; 1]>,
    detector: Detector<T, W>,
    pub contacts: Contacts<T, W>,
}

impl<T: Scalar, const W: usize> Solver<T, W> {
    pub fn new(tree: &Tree<T>) -> Self {
        Self {
            frictions: Vec::new(),
            limits: Vec::new(),
            singles: Vec::new(),
            detector: Detector::new(tree),
            contacts: Contacts::new(),
        }
    }

    /// Finds the forces, and adds what they do to `u`, which comes with what everything else does.
    #[inline(always)]
    pub fn solve(
        &mut self,
        context: &SolverContext<'_, T, W>,
        forces: &mut Forces<T, W>,
        u: &mut [Lane<T, W>],
        profiler: &mut impl Profiler,
    ) {
        self.singles.clear();
        self.add_frictions(context);
        self.add_limits(context, forces);
        self.detector.find(context, forces, &mut self.contacts);
        let dof_chains = &context.tree.dof_chains;
        self.start(dof_chains, forces, u);
        profiler.end_stage(Stage::Rows);
        for _ in 0..context.iterations {
            for row in &self.frictions {
                row.visit(&dof_chains[row.dof], &self.singles, &mut forces.friction[row.slot], u);
            }
            for row in &self.limits {
                row.visit(&dof_chains[row.dof], &self.singles, &mut forces.limit[row.slot], u);
            }
            for contact in &self.contacts.list {
                contact.visit(&dof_chains[contact.dof_chain], &self.contacts.y, &mut forces.contact[contact.slot], u);
            }
        }
        profiler.end_stage(Stage::Iterations);
    }

    /// The forces of the step before.
    #[inline(always)]
    fn start(&self, dof_chains: &[DofChain], forces: &Forces<T, W>, u: &mut [Lane<T, W>]) {
        for (rows, values) in [(&self.frictions, &forces.friction), (&self.limits, &forces.limit)] {
            for row in rows {
                let dof_chain = &dof_chains[row.dof];
                dof_chain.spread(&self.singles[row.y..row.y + dof_chain.len()], &[values[row.slot]], u);
            }
        }
        for contact in &self.contacts.list {
            let dof_chain = &dof_chains[contact.dof_chain];
            let total = contact.total(&forces.contact[contact.slot]);
            dof_chain.spread(&self.contacts.y[contact.y..contact.y + dof_chain.len()], &total, u);
        }
    }

    #[inline(always)]
    fn add_frictions(&mut self, s: &SolverContext<'_, T, W>) {
        self.frictions.clear();
        let softness = &s.tree.joint_softness;
        for (d, dof) in s.tree.dofs.iter().enumerate().filter(|(_, dof)| dof.frictionloss > T::default()) {
            let regular = regularization(softness.impedance(Lane::zero()), s.invweight.dof[d]);
            let (y, own) = self.push_unit(s, d, Lane::splat_f64(1.0));
            self.frictions.push(Row {
                slot: d,
                dof: d,
                y,
                offset: s.v[d] * Lane::splat(softness.damping),
                softness: regular,
                inverse: (own + regular).recip(),
                low: -Lane::splat(dof.frictionloss),
                high: Lane::splat(dof.frictionloss),
            });
        }
    }

    #[inline(always)]
    fn add_limits(&mut self, s: &SolverContext<'_, T, W>, forces: &mut Forces<T, W>) {
        self.limits.clear();
        let softness = &s.tree.joint_softness;
        let (zero, one) = (Lane::zero(), Lane::splat_f64(1.0));
        for (slot, limit) in s.tree.limits.iter().enumerate() {
            let q = s.q[limit.q];
            let (below, over) = (Lane::splat(limit.low) - q, q - Lane::splat(limit.high));
            let beyond = below.max(over);
            if !beyond.any_positive() {
                forces.limit[slot] = zero;
                continue;
            }
            let side = below.select_gt(over, one, -one);
            // The force of the step before counts on its own side only.
            let same = (side * forces.side[slot]).select_gt(zero, forces.limit[slot], zero);
            forces.limit[slot] = beyond.select_gt(zero, same, zero);
            forces.side[slot] = beyond.select_gt(zero, side, forces.side[slot]);
            let impedance = softness.impedance(beyond);
            let regular = regularization(impedance, s.invweight.dof[limit.dof]);
            let (y, own) = self.push_unit(s, limit.dof, side);
            let pull = Lane::splat(softness.stiffness) * impedance * beyond;
            self.limits.push(Row {
                slot,
                dof: limit.dof,
                y,
                offset: (side * s.v[limit.dof] * Lane::splat(softness.damping)) - pull,
                softness: regular,
                inverse: (own + regular).recip(),
                low: zero,
                high: beyond.select_gt(zero, Lane::splat_f64(1e30), zero),
            });
        }
    }

    /// The row of one dof: where its y is, and y·y.
    #[inline(always)]
    fn push_unit(&mut self, s: &SolverContext<'_, T, W>, d: usize, entry: Lane<T, W>) -> (usize, Lane<T, W>) {
        let dof_chain = &s.tree.dof_chains[d];
        let at = self.singles.len();
        self.singles.resize(at + dof_chain.len() - 1, [Lane::zero()]);
        self.singles.push([entry]);
        let y = &mut self.singles[at..];
        s.dynamics.factors.half_solve_rows(s.tree, dof_chain, y);
        let own = y.iter().fold(Lane::zero(), |sum: Lane<T, W>, [x]| sum.add_mul(*x, *x));
        (at, own)
    }
}

impl<T: Scalar, const W: usize> Row<T, W> {
    #[inline(always)]
    fn visit(&self, dof_chain: &DofChain, y: &[[Lane<T, W>; 1]], force: &mut Lane<T, W>, u: &mut [Lane<T, W>]) {
        let y = &y[self.y..self.y + dof_chain.len()];
        let [acceleration] = dof_chain.gather(y, u);
        let residual = (acceleration + self.offset).add_mul(self.softness, *force);
        let new = force.sub_mul(residual, self.inverse).max(self.low).min(self.high);
        dof_chain.spread(y, &[new - *force], u);
        *force = new;
    }
}
