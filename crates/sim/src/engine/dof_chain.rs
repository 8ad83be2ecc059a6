//! Sparsity of a constraint: the degrees of freedom between two bodies, and products of rows that have entries on them only.

use super::lanes::Lanes;

/// The dofs between two bodies, ancestors before descendants: those above both, the first body's own, the second's own.
/// They are kept as runs of neighbours, because a run is a slice.
#[derive(Debug, Clone, PartialEq)]
pub struct DofChain {
    pub dofs: Vec<usize>,
    runs: Vec<Run>,
    /// Number of dofs that move both bodies.
    pub shared: usize,
    /// Start of the second body's own dofs.
    pub fork: usize,
}

/// Neighbouring dofs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Run {
    pub first: usize,
    /// Index of its first in the list it is a part of.
    pub at: usize,
    pub len: usize,
}

/// A list of dofs as runs of neighbours.
pub fn runs(dofs: &[usize]) -> Vec<Run> {
    let mut runs: Vec<Run> = Vec::new();
    for (at, &dof) in dofs.iter().enumerate() {
        match runs.last_mut() {
            Some(run) if run.first + run.len == dof => run.len += 1,
            _ => runs.push(Run { first: dof, at, len: 1 }),
        }
    }
    runs
}

impl DofChain {
    /// The chain of one body, whose dofs are `chain`, against the world.
    pub fn of(chain: &[usize]) -> Self {
        Self::between(&[], chain)
    }

    /// The chain between two bodies, moved by the dofs `a` and `b`, root first.
    pub fn between(a: &[usize], b: &[usize]) -> Self {
        let shared = a.iter().zip(b).take_while(|(x, y)| x == y).count();
        let dofs: Vec<usize> = a.iter().chain(&b[shared..]).copied().collect();
        let runs = runs(&dofs);
        Self { dofs, runs, shared, fork: a.len() }
    }

    /// Number of dofs.
    pub fn len(&self) -> usize {
        self.dofs.len()
    }

    /// y · u of K rows.
    #[inline(always)]
    pub fn gather<V: Lanes, const K: usize>(&self, y: &[[V; K]], u: &[V]) -> [V; K] {
        // Two sums, because one would wait for its last product each time.
        let (mut even, mut odd) = ([V::zero(); K], [V::zero(); K]);
        for run in &self.runs {
            let (y, u) = (&y[run.at..run.at + run.len], &u[run.first..run.first + run.len]);
            let (pairs, last) = y.as_chunks::<2>();
            for (y, u) in pairs.iter().zip(u.as_chunks::<2>().0) {
                for k in 0..K {
                    even[k] = even[k].add_mul(y[0][k], u[0]);
                    odd[k] = odd[k].add_mul(y[1][k], u[1]);
                }
            }
            if let ([y], Some(u)) = (last, u.last()) {
                for k in 0..K {
                    even[k] = even[k].add_mul(y[k], *u);
                }
            }
        }
        for k in 0..K {
            even[k] += odd[k];
        }
        even
    }

    /// u ← u + y f: forces on K rows.
    #[inline(always)]
    pub fn spread<V: Lanes, const K: usize>(&self, y: &[[V; K]], force: &[V; K], u: &mut [V]) {
        for run in &self.runs {
            for (y, u) in y[run.at..run.at + run.len].iter().zip(&mut u[run.first..run.first + run.len]) {
                let mut sum = *u;
                for k in 0..K {
                    sum = sum.add_mul(y[k], force[k]);
                }
                *u = sum;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_and_forks_by_hand() {
        // Two legs below a root of three dofs: 0 1 2 | 3 4 | 5 6 7.
        let dof_chain = DofChain::between(&[0, 1, 2, 3, 4], &[0, 1, 2, 5, 6, 7]);
        assert_eq!(dof_chain.dofs, [0, 1, 2, 3, 4, 5, 6, 7]);
        assert_eq!((dof_chain.shared, dof_chain.fork, dof_chain.runs.len()), (3, 5, 1));
        let one = DofChain::of(&[0, 1, 2, 5, 6]);
        assert_eq!((one.shared, one.fork, one.runs.len()), (0, 0, 2));
        let mut u: Vec<f64> = (0..8).map(f64::from).collect();
        let y = [[1.0]; 5];
        assert_eq!(one.gather(&y, &u), [14.0]);
        one.spread(&y, &[2.0], &mut u);
        assert_eq!(u, [2.0, 3.0, 4.0, 3.0, 4.0, 7.0, 8.0, 7.0]);
    }
}
