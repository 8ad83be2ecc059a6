//! Constraints: joint limits, dry friction, contacts, closed loops, joints that follow others. MuJoCo's convex model, solved by projected
//! Gauss-Seidel.
//!
//! Each constraint row r has a Jacobian J_r, a reference acceleration a*_r = -b v_r - k i d_r (violation d_r, impedance i)
//! and a regularization R_r = (1 - i) / i · Â_r. Forces minimise ½ fᵀ(A + R)f + fᵀ(J a₀ - a*), A = J M⁻¹ Jᵀ, within their
//! bounds (MuJoCo documentation, "Computation"). A contact with friction is a pyramid of four edges J_n ± μ J_t whose
//! forces are not negative.
//!
//! In the coordinates u = D^(1/2) L a (M = Lᵀ D L) the matrix is Y Yᵀ with rows y_r = D^(-1/2) L^(-T) J_rᵀ that have
//! entries on one chain of the tree only. So a row is visited by one scalar product and one update of u, and A is never
//! formed. [`ITERATIONS`] visits of all rows per step, each contact solved [`INNER`](super::contact::INNER) times within itself, started from the
//! forces of the step before: fixed, so that every environment does the same. `tests/all/oracle_contact.rs` says how far
//! that is from MuJoCo's converged forces, and that a hundred iterations arrive there.

use super::collision::Detector;
use super::contact::Contacts;
use super::dof_chain::DofChain;
use super::lanes::Lanes;
use super::profiler::{Profiler, Stage};
use super::row_block::RowBlock;
use super::solver_context::{Forces, SolverContext};
use super::surface::regularization;
use super::tree::Tree;

/// Visits of all rows per physics step, where nobody says otherwise.
pub const ITERATIONS: usize = 12;

/// One bounded row on the chain of a dof.
#[derive(Debug, Clone)]
struct Row<V: Lanes> {
    /// Index into `Forces::friction` or `Forces::limit`.
    slot: usize,
    dof: usize,
    y: usize,
    offset: V,
    softness: V,
    inverse: V,
    low: V,
    high: V,
}

/// The rows of one step.
#[derive(Debug, Clone)]
pub struct Solver<V: Lanes> {
    frictions: Vec<Row<V>>,
    limits: Vec<Row<V>>,
    /// The y of frictions and limits.
    singles: Vec<[V; 1]>,
    detector: Detector<V>,
    pub contacts: Contacts<V>,
    closures: RowBlock<V, 3>,
    couplings: RowBlock<V, 1>,
}

impl<V: Lanes> Solver<V> {
    pub fn new(tree: &Tree<V::Scalar>) -> Self {
        Self {
            frictions: Vec::new(),
            limits: Vec::new(),
            singles: Vec::new(),
            detector: Detector::new(tree),
            contacts: Contacts::new(tree.dof_chains.len()),
            closures: RowBlock::new(&tree.closures.triples),
            couplings: RowBlock::new(&tree.couplings.rows),
        }
    }

    /// Finds the forces, and adds what they do to `u`, which comes with what everything else does.
    pub fn solve(
        &mut self,
        context: &SolverContext<'_, V>,
        forces: &mut Forces<V>,
        u: &mut [V],
        profiler: &mut dyn Profiler,
    ) {
        self.singles.clear();
        self.add_frictions(context);
        self.add_limits(context, forces);
        self.detector.find(context, forces, &mut self.contacts);
        self.closures.prepare(context);
        context.tree.couplings.prepare(context, &mut self.couplings);
        self.start(context.tree, forces, u);
        profiler.end_stage(Stage::Rows);
        V::vectorize(
            #[inline(always)]
            || {
                for _ in 0..context.iterations {
                    self.visit_all(context.tree, forces, u);
                }
            },
        );
        profiler.end_stage(Stage::Iterations);
    }

    /// Visits every row once; what closes loops comes last, so that a loop is closed whatever else has not settled.
    #[inline(always)]
    fn visit_all(&mut self, tree: &Tree<V::Scalar>, forces: &mut Forces<V>, u: &mut [V]) {
        let dof_chains = &tree.dof_chains;
        for row in &self.frictions {
            row.visit(&dof_chains[row.dof], &self.singles, &mut forces.friction[row.slot], u);
        }
        for row in &self.limits {
            row.visit(&dof_chains[row.dof], &self.singles, &mut forces.limit[row.slot], u);
        }
        for contact in &self.contacts.list {
            contact.visit(&dof_chains[contact.dof_chain], &self.contacts.y, &mut forces.contact[contact.slot], u);
        }
        self.couplings.visit(&tree.couplings.rows, dof_chains, &mut forces.coupling, u);
        self.closures.visit(&tree.closures.triples, dof_chains, &mut forces.closure, u);
    }

    /// The forces of the step before.
    fn start(&self, tree: &Tree<V::Scalar>, forces: &Forces<V>, u: &mut [V]) {
        V::vectorize(
            #[inline(always)]
            || {
                let dof_chains = &tree.dof_chains;
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
                self.couplings.spread(&tree.couplings.rows, dof_chains, &forces.coupling, u);
                self.closures.spread(&tree.closures.triples, dof_chains, &forces.closure, u);
            },
        );
    }

    fn add_frictions(&mut self, s: &SolverContext<'_, V>) {
        V::vectorize(
            #[inline(always)]
            || {
                self.frictions.clear();
                let softness = &s.tree.joint_softness;
                for d in (0..s.tree.nv).filter(|d| s.tree.dofs[*d].dry) {
                    let regular = regularization(softness.impedance(V::zero()), s.invweight.dof[d]);
                    let (y, own) = self.push_unit(s, d, V::splat_f64(1.0));
                    self.frictions.push(Row {
                        slot: d,
                        dof: d,
                        y,
                        offset: s.v[d] * V::splat(softness.damping),
                        softness: regular,
                        inverse: (own + regular).recip(),
                        low: -s.frictionloss[d],
                        high: s.frictionloss[d],
                    });
                }
            },
        );
    }

    fn add_limits(&mut self, s: &SolverContext<'_, V>, forces: &mut Forces<V>) {
        V::vectorize(
            #[inline(always)]
            || {
                self.limits.clear();
                let softness = &s.tree.joint_softness;
                let (zero, one) = (V::zero(), V::splat_f64(1.0));
                for (slot, limit) in s.tree.limits.iter().enumerate() {
                    let q = s.q[limit.q];
                    let (below, over) = (V::splat(limit.low) - q, q - V::splat(limit.high));
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
                    let pull = V::splat(softness.stiffness) * impedance * beyond;
                    self.limits.push(Row {
                        slot,
                        dof: limit.dof,
                        y,
                        offset: (side * s.v[limit.dof] * V::splat(softness.damping)) - pull,
                        softness: regular,
                        inverse: (own + regular).recip(),
                        low: zero,
                        high: beyond.select_gt(zero, V::splat_f64(1e30), zero),
                    });
                }
            },
        );
    }

    /// The row of one dof: where its y is, and y·y.
    #[inline(always)]
    fn push_unit(&mut self, s: &SolverContext<'_, V>, d: usize, entry: V) -> (usize, V) {
        let dof_chain = &s.tree.dof_chains[d];
        let at = self.singles.len();
        self.singles.resize(at + dof_chain.len() - 1, [V::zero()]);
        self.singles.push([entry]);
        let y = &mut self.singles[at..];
        s.dynamics.factors.half_solve_rows(s.tree, dof_chain, y);
        let mut own = V::zero();
        for [x] in y.iter() {
            own = own.add_mul(*x, *x);
        }
        (at, own)
    }
}

impl<V: Lanes> Row<V> {
    #[inline(always)]
    fn visit(&self, dof_chain: &DofChain, y: &[[V; 1]], force: &mut V, u: &mut [V]) {
        let y = &y[self.y..self.y + dof_chain.len()];
        let [acceleration] = dof_chain.gather(y, u);
        let residual = (acceleration + self.offset).add_mul(self.softness, *force);
        let new = force.sub_mul(residual, self.inverse).max(self.low).min(self.high);
        dof_chain.spread(y, &[new - *force], u);
        *force = new;
    }
}
