//! The factorization M = Lᵀ D L on the tree's own sparsity (Featherstone 2008, 6.5), which is also MuJoCo's.
//!
//! A dof's row has an entry for every dof above it, root first, and so begins with the indices of all its ancestors'
//! rows: entry j of the row of any descendant stands for the same dof as entry j of one's own. The shares that
//! descendants take from a row are therefore summed from slices, several entries at a time in registers. Each entry is
//! written once.

use super::dof_chain::DofChain;
use super::lanes::Lanes;
use super::tree::Tree;

/// M = Lᵀ D L.
#[derive(Debug, Clone)]
pub struct Factors<V: Lanes> {
    /// L below its diagonal of ones, rows of `Dof::chain`; the last entry of a row is D.
    pub rows: Vec<V>,
    /// D L, likewise.
    scaled: Vec<V>,
    /// 1 / D.
    pub inverse: Vec<V>,
    /// D^(-1/2).
    pub inverse_root: Vec<V>,
}

impl<V: Lanes> Factors<V> {
    pub fn new(tree: &Tree<V::Scalar>) -> Self {
        let zero = V::zero();
        let (entries, dofs) = (vec![zero; tree.entries], vec![zero; tree.nv]);
        Self { rows: entries.clone(), scaled: entries, inverse: dofs.clone(), inverse_root: dofs }
    }

    /// Factorises a matrix that has something added to its diagonal, where `diagonal` is not empty.
    pub fn factorise(&mut self, tree: &Tree<V::Scalar>, matrix: &[V], diagonal: &[V]) {
        V::vectorize(
            #[inline(always)]
            || {
                for (d, dof) in tree.dofs.iter().enumerate().rev() {
                    let n = dof.chain.len();
                    let mut j = 0;
                    while j + 4 <= n {
                        self.eliminate::<4>(tree, d, j, matrix);
                        j += 4;
                    }
                    if j + 2 <= n {
                        self.eliminate::<2>(tree, d, j, matrix);
                        j += 2;
                    }
                    if j < n {
                        self.eliminate::<1>(tree, d, j, matrix);
                    }
                    let own = &mut self.scaled[dof.row..dof.row + n];
                    if let Some(added) = diagonal.get(d) {
                        own[n - 1] += *added;
                    }
                    let inverse = own[n - 1].recip();
                    self.inverse[d] = inverse;
                    self.inverse_root[d] = inverse.sqrt();
                    let row = &mut self.rows[dof.row..dof.row + n];
                    for (l, x) in row[..n - 1].iter_mut().zip(&own[..n - 1]) {
                        *l = *x * inverse;
                    }
                    row[n - 1] = own[n - 1];
                }
            },
        );
    }

    /// Entries `j..j + K` of a dof's row of D L: the matrix' own, less what every descendant takes.
    #[inline(always)]
    fn eliminate<const K: usize>(&mut self, tree: &Tree<V::Scalar>, d: usize, j: usize, matrix: &[V]) {
        let dof = &tree.dofs[d];
        let mut sum = [V::zero(); K];
        sum.copy_from_slice(&matrix[dof.row + j..dof.row + j + K]);
        for &below in &dof.descendants {
            let share = self.rows[below + dof.chain.len() - 1];
            for (sum, x) in sum.iter_mut().zip(&self.scaled[below + j..below + j + K]) {
                *sum = sum.sub_mul(share, *x);
            }
        }
        self.scaled[dof.row + j..dof.row + j + K].copy_from_slice(&sum);
    }

    /// x ← D^(-1/2) L^(-T) x.
    pub fn half_solve(&self, tree: &Tree<V::Scalar>, x: &mut [V]) {
        V::vectorize(
            #[inline(always)]
            || {
                for (d, dof) in tree.dofs.iter().enumerate().rev() {
                    let value = x[d];
                    for (at, run) in ancestors(dof) {
                        for (x, l) in x[run].iter_mut().zip(&self.rows[at..]) {
                            *x = x.sub_mul(*l, value);
                        }
                    }
                    x[d] = value * self.inverse_root[d];
                }
            },
        );
    }

    /// y ← D^(-1/2) L^(-T) y for K rows at once, `y[i]` belonging to `dof_chain.dofs[i]`.
    #[inline(always)]
    pub fn half_solve_rows<const K: usize>(&self, tree: &Tree<V::Scalar>, dof_chain: &DofChain, y: &mut [[V; K]]) {
        for n in (0..dof_chain.dofs.len()).rev() {
            let d = dof_chain.dofs[n];
            let row = &self.rows[tree.dofs[d].row..];
            let (above, own) = y.split_at_mut(n);
            let value = own[0];
            if n < dof_chain.fork {
                take(above, &row[..n], &value);
            } else {
                take(&mut above[..dof_chain.shared], &row[..dof_chain.shared], &value);
                take(
                    &mut above[dof_chain.fork..],
                    &row[dof_chain.shared..dof_chain.shared + n - dof_chain.fork],
                    &value,
                );
            }
            for k in 0..K {
                own[0][k] = value[k] * self.inverse_root[d];
            }
        }
    }

    /// x ← L^(-1) D^(-1/2) x: the other half.
    pub fn finish_solve(&self, tree: &Tree<V::Scalar>, x: &mut [V]) {
        V::vectorize(
            #[inline(always)]
            || {
                for (d, dof) in tree.dofs.iter().enumerate() {
                    let mut value = x[d] * self.inverse_root[d];
                    for (at, run) in ancestors(dof) {
                        for (x, l) in x[run].iter().zip(&self.rows[at..]) {
                            value = value.sub_mul(*l, *x);
                        }
                    }
                    x[d] = value;
                }
            },
        );
    }

    /// x ← Lᵀ D^(1/2) x: undoes [`Self::half_solve`].
    pub fn half_multiply(&self, tree: &Tree<V::Scalar>, x: &mut [V]) {
        V::vectorize(
            #[inline(always)]
            || {
                for (d, dof) in tree.dofs.iter().enumerate() {
                    // D^(1/2) = D · D^(-1/2).
                    let value = x[d] * self.rows[dof.row + dof.chain.len() - 1] * self.inverse_root[d];
                    x[d] = value;
                    for (at, run) in ancestors(dof) {
                        for (x, l) in x[run].iter_mut().zip(&self.rows[at..]) {
                            *x = x.add_mul(*l, value);
                        }
                    }
                }
            },
        );
    }
}

/// above ← above − l value.
#[inline(always)]
fn take<V: Lanes, const K: usize>(above: &mut [[V; K]], l: &[V], value: &[V; K]) {
    for (x, l) in above.iter_mut().zip(l) {
        for k in 0..K {
            x[k] = x[k].sub_mul(*l, value[k]);
        }
    }
}

/// The dofs above one, as runs of neighbours, each with the index of its first entry in the row.
#[inline(always)]
fn ancestors<T>(dof: &super::tree::Dof<T>) -> impl Iterator<Item = (usize, std::ops::Range<usize>)> + '_ {
    dof.ancestors.iter().map(|run| (dof.row + run.at, run.first..run.first + run.len))
}
