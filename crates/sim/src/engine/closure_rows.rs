//! Rows of the equality constraints in one step.
//!
//! The length of a constraint's whole violation gives all its rows one impedance. Their reference acceleration has
//! what velocities alone do to their rates (-J' v), as MuJoCo 3.17's: a loop that runs round fast stays closed.

use super::closure::{Closure, Frames, Motion, angular};
use super::lanes::Lanes;
use super::row_block::RowBlock;
use super::solver_context::SolverContext;
use super::spatial::{Vec3, dot, sub, velocity_at};
use super::surface::regularization;

impl<V: Lanes> RowBlock<V, 3> {
    /// Sets up all rows of the closures in the state of a step.
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
                self.factorise(&s.tree.closures.triples);
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

        let at = s.tree.closures.triples.list[triple].y;
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
            let at = s.tree.closures.triples.list[triple + 1].y;
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
}
