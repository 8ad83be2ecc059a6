//! Rows of the equality constraints in one step, and their forces.
//!
//! The length of a constraint's whole violation gives all its rows one impedance, and their reference acceleration has what
//! velocities alone do to their rates (-J' v), as MuJoCo 3.17's: a loop that runs round fast stays closed.
//!
//! The forces have no bounds. So all of them are ONE block of a Gauss-Seidel sweep, and a visit solves it exactly, by
//! A + R = L D Lᵀ: rows that share a light link would take hundreds of visits, one after the other, to agree. Where nothing
//! touches, and no joint rubs or is at its limit, the first visit is the solution.

use super::closure::{Closure, Closures, Frames, Motion, angular};
use super::dof_chain::DofChain;
use super::lanes::Lanes;
use super::solver_context::SolverContext;
use super::spatial::{Vec3, dot, sub, velocity_at};
use super::surface::regularization;

/// The rows of one step.
#[derive(Debug, Clone)]
pub struct ClosureRows<V: Lanes> {
    y: Vec<[V; 3]>,
    /// Minus the reference acceleration of each row.
    offset: Vec<V>,
    /// Regularization of each row.
    softness: Vec<V>,
    /// Row after row of L up to its diagonal, where 1 / D is in place of the one.
    factor: Vec<V>,
    /// Room for what a visit changes.
    change: Vec<V>,
}

impl<V: Lanes> ClosureRows<V> {
    pub fn new(closures: &Closures<V::Scalar>) -> Self {
        let (zero, n) = (V::zero(), closures.rows());
        Self {
            y: vec![[zero; 3]; closures.entries],
            offset: vec![zero; n],
            softness: vec![zero; n],
            factor: vec![zero; n * (n + 1) / 2],
            change: vec![zero; n],
        }
    }

    /// Sets up all rows in the state of a step.
    pub fn prepare(&mut self, s: &SolverContext<'_, V>) {
        if s.tree.closures.list.is_empty() {
            return;
        }
        V::vectorize(
            #[inline(always)]
            || {
                let mut triple = 0;
                for closure in &s.tree.closures.list {
                    self.add(s, closure, triple);
                    triple += if closure.weld.is_some() { 2 } else { 1 };
                }
                self.multiply(&s.tree.closures);
                self.factorise();
            },
        );
    }

    /// The rows of one constraint, whose first triple is given.
    #[inline(always)]
    fn add(&mut self, s: &SolverContext<'_, V>, closure: &Closure<V::Scalar>, triple: usize) {
        let zero = V::zero();
        let Frames { points, turn } = closure.frames(s.dynamics);
        let (softness, dof_chain) = (&closure.softness, &s.tree.dof_chains[closure.dof_chain]);
        let [a, b] = closure.bodies;
        let apart = sub(&points[0], &points[1]);
        let mut square = dot(&apart, &apart);
        if let Some(turn) = &turn {
            let turned = turn.violation();
            square += dot(&turned, &turned);
        }
        let impedance = softness.impedance(square.sqrt());
        let (pull, damping) = (V::splat(softness.stiffness) * impedance, V::splat(softness.damping));
        let mut begin = |first: usize, violation: &Vec3<V>, velocity: &Vec3<V>, drift: &Vec3<V>, weight: V| {
            let softness = regularization(impedance, weight);
            for k in 0..3 {
                self.offset[first + k] = drift[k].add_mul(damping, velocity[k]).add_mul(pull, violation[k]);
                self.softness[first + k] = softness;
            }
        };
        let [first, second] = [a, b].map(|body| Motion::of(s.dynamics, body));
        let velocity = sub(&velocity_at(&first.velocity, &points[0]), &velocity_at(&second.velocity, &points[1]));
        let drift = sub(&first.drift(&points[0]), &second.drift(&points[1]));
        begin(3 * triple, &apart, &velocity, &drift, s.invweight.body[a] + s.invweight.body[b]);
        if let Some(turn) = &turn {
            let angular = sub(&angular(&first.velocity), &angular(&second.velocity));
            let weight = s.invweight.turn[a] + s.invweight.turn[b];
            begin(3 * triple + 3, &turn.violation(), &turn.rate(&angular), &turn.drift(&first, &second), weight);
        }

        let at = s.tree.closures.triples[triple].y;
        let y = &mut self.y[at..at + dof_chain.len()];
        for (n, (y, d)) in y.iter_mut().zip(&dof_chain.dofs).enumerate() {
            let motion = &s.dynamics.motion[*d];
            // A dof above both bodies moves the anchors alike only where they are one point.
            *y = if n < dof_chain.fork { velocity_at(motion, &points[0]) } else { [zero; 3] };
            if n < dof_chain.shared || n >= dof_chain.fork {
                *y = sub(y, &velocity_at(motion, &points[1]));
            }
        }
        s.dynamics.factors.half_solve_rows(s.tree, dof_chain, y);
        if let Some(turn) = &turn {
            let at = s.tree.closures.triples[triple + 1].y;
            let y = &mut self.y[at..at + dof_chain.len()];
            for (n, (y, d)) in y.iter_mut().zip(&dof_chain.dofs).enumerate() {
                let motion = &s.dynamics.motion[*d];
                let rate = turn.rate(&angular(motion));
                *y = match n {
                    _ if n < dof_chain.shared => [zero; 3],
                    _ if n < dof_chain.fork => rate,
                    _ => rate.map(|x| -x),
                };
            }
            s.dynamics.factors.half_solve_rows(s.tree, dof_chain, y);
        }
    }

    /// A + R, into the place of its factors.
    #[inline(always)]
    fn multiply(&mut self, closures: &Closures<V::Scalar>) {
        for (p, triple) in closures.triples.iter().enumerate() {
            for (q, shared) in triple.shared.iter().enumerate() {
                let mut product = [[V::zero(); 3]; 3];
                for [i, j] in shared {
                    let (own, other) = (&self.y[triple.y + i], &self.y[closures.triples[q].y + j]);
                    for a in 0..3 {
                        for b in 0..3 {
                            product[a][b] = product[a][b].add_mul(own[a], other[b]);
                        }
                    }
                }
                for a in 0..3 {
                    let row = 3 * p + a;
                    for b in 0..if p == q { a + 1 } else { 3 } {
                        self.factor[start(row) + 3 * q + b] = product[a][b];
                    }
                    if p == q {
                        self.factor[start(row) + row] += self.softness[row];
                    }
                }
            }
        }
    }

    /// A + R = L D Lᵀ.
    #[inline(always)]
    fn factorise(&mut self) {
        for i in 0..self.offset.len() {
            let (done, own) = self.factor.split_at_mut(start(i));
            for j in 0..i {
                let mut sum = own[j];
                for (x, l) in own[..j].iter().zip(&done[start(j)..]) {
                    sum = sum.sub_mul(*x, *l);
                }
                own[j] = sum;
            }
            let mut pivot = own[i];
            for j in 0..i {
                let l = own[j] * done[start(j) + j];
                pivot = pivot.sub_mul(own[j], l);
                own[j] = l;
            }
            // A has no negative directions, so what is left of a row is its regularization at least, but for rounding: rows
            // that say the same (hinges of a plane linkage hold it in its plane already) cancel.
            own[i] = pivot.max(self.softness[i]).recip();
        }
    }

    /// The forces of the step before.
    #[inline(always)]
    pub fn start(&self, closures: &Closures<V::Scalar>, dof_chains: &[DofChain], forces: &[V], u: &mut [V]) {
        for (triple, force) in closures.triples.iter().zip(forces.as_chunks::<3>().0) {
            let dof_chain = &dof_chains[triple.dof_chain];
            dof_chain.spread(&self.y[triple.y..triple.y + dof_chain.len()], force, u);
        }
    }

    /// Brings all forces to where every row is as it should be.
    #[inline(always)]
    pub fn visit(&mut self, closures: &Closures<V::Scalar>, dof_chains: &[DofChain], forces: &mut [V], u: &mut [V]) {
        if !forces.is_empty() {
            self.solve(closures, dof_chains, forces, u);
        }
    }

    /// Not a part of the sweep's own loop, which most robots run without it.
    #[inline(never)]
    fn solve(&mut self, closures: &Closures<V::Scalar>, dof_chains: &[DofChain], forces: &mut [V], u: &mut [V]) {
        V::vectorize(
            #[inline(always)]
            || {
                for (t, triple) in closures.triples.iter().enumerate() {
                    let dof_chain = &dof_chains[triple.dof_chain];
                    let acceleration = dof_chain.gather(&self.y[triple.y..triple.y + dof_chain.len()], u);
                    for k in 0..3 {
                        let row = 3 * t + k;
                        self.change[row] =
                            -(acceleration[k] + self.offset[row]).add_mul(self.softness[row], forces[row]);
                    }
                }
                let n = self.change.len();
                for i in 1..n {
                    let mut sum = self.change[i];
                    for (l, x) in self.factor[start(i)..start(i) + i].iter().zip(&self.change) {
                        sum = sum.sub_mul(*l, *x);
                    }
                    self.change[i] = sum;
                }
                for i in 0..n {
                    self.change[i] = self.change[i] * self.factor[start(i) + i];
                }
                for i in (1..n).rev() {
                    let (above, own) = self.change.split_at_mut(i);
                    for (x, l) in above.iter_mut().zip(&self.factor[start(i)..start(i) + i]) {
                        *x = x.sub_mul(*l, own[0]);
                    }
                }
                for (force, change) in forces.iter_mut().zip(&self.change) {
                    *force += *change;
                }
                self.start(closures, dof_chains, &self.change, u);
            },
        );
    }
}

/// Where a row of a lower triangle begins.
#[inline(always)]
fn start(row: usize) -> usize {
    row * (row + 1) / 2
}
