//! Rows without bounds, K on each of several chains of dofs, whose forces are found together.
//!
//! Such rows are ONE block of a Gauss-Seidel sweep, and a visit solves it exactly, by A + R = L D Lᵀ: rows that share
//! a light link would take hundreds of visits, one after the other, to agree. If nothing touches, and no joint rubs or
//! is at its limit, the first visit is the solution.

use super::dof_chain::DofChain;
use super::lanes::Lanes;

/// K rows on one chain.
#[derive(Debug, Clone, PartialEq)]
pub struct Group {
    pub dof_chain: usize,
    /// Start of its y.
    pub y: usize,
    /// For each group up to this one the dofs that both know, as indices into the y of either.
    pub shared: Vec<Vec<[usize; 2]>>,
}

/// Groups of K rows.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Groups<const K: usize> {
    pub list: Vec<Group>,
    /// Entries of the y of all groups.
    entries: usize,
}

impl<const K: usize> Groups<K> {
    /// Adds a group on a chain.
    pub fn add(&mut self, dof_chain: usize, dof_chains: &[DofChain]) {
        let own = &dof_chains[dof_chain].dofs;
        let shared = |other: usize| {
            let other = &dof_chains[other].dofs;
            let both = own.iter().enumerate().filter_map(|(i, dof)| Some([i, other.iter().position(|d| d == dof)?]));
            both.collect()
        };
        let chains: Vec<usize> = self.list.iter().map(|group| group.dof_chain).chain([dof_chain]).collect();
        let shared = chains.into_iter().map(shared).collect();
        self.list.push(Group { dof_chain, y: self.entries, shared });
        self.entries += own.len();
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        K * self.list.len()
    }
}

/// The rows of one step.
#[derive(Debug, Clone)]
pub struct RowBlock<V: Lanes, const K: usize> {
    pub y: Vec<[V; K]>,
    /// Minus the reference acceleration of each row.
    pub offset: Vec<V>,
    /// Regularization of each row.
    pub softness: Vec<V>,
    /// Row after row of L up to its diagonal, where 1 / D is in place of the one.
    factor: Vec<V>,
    /// Room for what a visit changes.
    change: Vec<V>,
}

impl<V: Lanes, const K: usize> RowBlock<V, K> {
    pub fn new(groups: &Groups<K>) -> Self {
        let (zero, n) = (V::zero(), groups.rows());
        Self {
            y: vec![[zero; K]; groups.entries],
            offset: vec![zero; n],
            softness: vec![zero; n],
            factor: vec![zero; n * (n + 1) / 2],
            change: vec![zero; n],
        }
    }

    /// Factorises A + R of rows whose y, offset and softness are there.
    #[inline(always)]
    pub fn factorise(&mut self, groups: &Groups<K>) {
        self.multiply(groups);
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

    /// A + R, into the place of its factors.
    #[inline(always)]
    fn multiply(&mut self, groups: &Groups<K>) {
        for (p, group) in groups.list.iter().enumerate() {
            for (q, shared) in group.shared.iter().enumerate() {
                let mut product = [[V::zero(); K]; K];
                for [i, j] in shared {
                    let (own, other) = (&self.y[group.y + i], &self.y[groups.list[q].y + j]);
                    for a in 0..K {
                        for b in 0..K {
                            product[a][b] = product[a][b].add_mul(own[a], other[b]);
                        }
                    }
                }
                for a in 0..K {
                    let row = K * p + a;
                    for b in 0..if p == q { a + 1 } else { K } {
                        self.factor[start(row) + K * q + b] = product[a][b];
                    }
                    if p == q {
                        self.factor[start(row) + row] += self.softness[row];
                    }
                }
            }
        }
    }

    /// Adds to `u` what forces on all rows do.
    #[inline(always)]
    pub fn spread(&self, groups: &Groups<K>, dof_chains: &[DofChain], forces: &[V], u: &mut [V]) {
        for (group, force) in groups.list.iter().zip(forces.as_chunks::<K>().0) {
            let dof_chain = &dof_chains[group.dof_chain];
            dof_chain.spread(&self.y[group.y..group.y + dof_chain.len()], force, u);
        }
    }

    /// Brings all forces to where every row is as it should be.
    #[inline(always)]
    pub fn visit(&mut self, groups: &Groups<K>, dof_chains: &[DofChain], forces: &mut [V], u: &mut [V]) {
        if !forces.is_empty() {
            self.solve(groups, dof_chains, forces, u);
        }
    }

    /// Not a part of the sweep's own loop, which most robots run without it.
    #[inline(never)]
    fn solve(&mut self, groups: &Groups<K>, dof_chains: &[DofChain], forces: &mut [V], u: &mut [V]) {
        V::vectorize(
            #[inline(always)]
            || {
                for (g, group) in groups.list.iter().enumerate() {
                    let dof_chain = &dof_chains[group.dof_chain];
                    let acceleration = dof_chain.gather(&self.y[group.y..group.y + dof_chain.len()], u);
                    for k in 0..K {
                        let row = K * g + k;
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
                self.spread(groups, dof_chains, &self.change, u);
            },
        );
    }
}

/// Start of a row of a lower triangle.
#[inline(always)]
fn start(row: usize) -> usize {
    row * (row + 1) / 2
}
