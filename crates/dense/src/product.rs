//! Products of rows with a weight as it lies in a file: for few rows, and for networks that are used once.

use lifelike_simd::vectors::f32x4;
use lifelike_simd::{InstructionSet, Simd, Task, prelude::*};
use rayon::prelude::*;

use crate::elu::{elu, elu_of_vector};

/// Multiplications from which on several threads share a product: what starting them costs is then small beside it.
const PARALLEL: usize = 1 << 20;
/// Rows that a thread takes at a time.
const SHARE: usize = 32;

/// Writes the product of rows and a weight.
///
/// Each number is summed over K from the first to the last with fused multiply-adds. The result therefore does not
/// depend on instruction set, number of rows or threads. Without threads nothing is allocated.
///
/// # Shapes
/// `rows: [N, K]`, `weight: [K, M]`, `out: [N, M]`; `sizes` is `[N, K, M]`.
///
/// # Panics
/// A slice is shorter or longer than `sizes` says.
pub fn product(rows: &[f32], weight: &[f32], sizes: [usize; 3], out: &mut [f32]) {
    let [n, k, m] = sizes;
    assert_eq!((rows.len(), weight.len(), out.len()), (n * k, k * m, n * m), "sizes {sizes:?}");
    let set = InstructionSet::chosen();
    let many = n.saturating_mul(k).saturating_mul(m) >= PARALLEL && n > SHARE;
    if many {
        out.par_chunks_mut(SHARE * m).zip(rows.par_chunks(SHARE * k)).for_each(|(out, rows)| {
            set.run(RowsOfLayer { rows, weight, bias: &[], hidden: false, outputs: m, out });
        });
    } else {
        set.run(RowsOfLayer { rows, weight, bias: &[], hidden: false, outputs: m, out });
    }
}

/// Does the same on this thread alone, without any allocation.
///
/// # Panics
/// As [`product`].
pub fn product_on_this_thread(rows: &[f32], weight: &[f32], sizes: [usize; 3], out: &mut [f32]) {
    let [n, k, m] = sizes;
    assert_eq!((rows.len(), weight.len(), out.len()), (n * k, k * m, n * m), "sizes {sizes:?}");
    InstructionSet::chosen().run(RowsOfLayer { rows, weight, bias: &[], hidden: false, outputs: m, out });
}

/// A layer of rows: product, bias where there is one, ELU where it is hidden.
pub(crate) struct RowsOfLayer<'a> {
    pub rows: &'a [f32],
    pub weight: &'a [f32],
    pub bias: &'a [f32],
    pub hidden: bool,
    pub outputs: usize,
    pub out: &'a mut [f32],
}

impl Task for RowsOfLayer<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(mut self, simd: S) {
        let m = self.outputs;
        if m == 0 {
            return;
        }
        let (n, k) = (self.out.len() / m, self.weight.len() / m);
        let mut row = 0;
        while row < n {
            if n - row >= 4 {
                let rows: [&[f32]; 4] = std::array::from_fn(|r| &self.rows[(row + r) * k..][..k]);
                self.block::<S, 4, 3>(simd, rows, row);
                row += 4;
            } else {
                self.block::<S, 1, 8>(simd, [&self.rows[row * k..][..k]], row);
                row += 1;
            }
        }
    }
}

impl RowsOfLayer<'_> {
    /// All outputs of `R` rows, `V` vectors at a time, then one, then the last one again from where it still fits.
    #[inline(always)]
    fn block<S: Simd, const R: usize, const V: usize>(&mut self, simd: S, rows: [&[f32]; R], first: usize) {
        let (m, len) = (self.outputs, S::f32s::LEN);
        if m < len {
            return self.narrow(simd, rows, first);
        }
        let mut column = 0;
        while column < m {
            if m - column >= V * len {
                let sums = sums::<S, S::f32s, R, V>(simd, rows, self.weight, m, column);
                self.finish(simd, sums, first, column);
                column += V * len;
            } else {
                let from = column.min(m - len);
                let sums = sums::<S, S::f32s, R, 1>(simd, rows, self.weight, m, from);
                self.finish(simd, sums, first, from);
                column += len;
            }
        }
    }

    #[inline(always)]
    fn finish<S: Simd, const R: usize, const V: usize>(
        &mut self,
        simd: S,
        sums: [[S::f32s; V]; R],
        first: usize,
        column: usize,
    ) {
        let len = S::f32s::LEN;
        for r in 0..R {
            for v in 0..V {
                let (place, mut y) = (column + v * len, sums[r][v]);
                if !self.bias.is_empty() {
                    y += S::f32s::from_slice(simd, &self.bias[place..][..len]);
                }
                if self.hidden {
                    y = elu_of_vector(simd, y);
                }
                y.store_slice(&mut self.out[(first + r) * self.outputs + place..][..len]);
            }
        }
    }

    /// Fewer outputs than a vector holds: four at a time, or one.
    #[inline(always)]
    fn narrow<S: Simd, const R: usize>(&mut self, simd: S, rows: [&[f32]; R], first: usize) {
        let m = self.outputs;
        let mut column = 0;
        while column < m {
            let (from, count) = if m >= 4 { (column.min(m - 4), 4) } else { (column, 1) };
            let sums: [[f32x4<S>; 1]; R] = if count == 4 {
                sums::<S, f32x4<S>, R, 1>(simd, rows, self.weight, m, from)
            } else {
                let mut sums = [[f32x4::splat(simd, 0.0)]; R];
                for (l, w) in self.weight.get(from..).unwrap_or(&[]).chunks(m).enumerate() {
                    for r in 0..R {
                        sums[r][0] =
                            f32x4::splat(simd, rows[r][l]).mul_add_precise(f32x4::splat(simd, w[0]), sums[r][0]);
                    }
                }
                sums
            };
            for (r, [sums]) in sums.into_iter().enumerate() {
                for (j, sum) in sums.to_array().into_iter().enumerate().take(count) {
                    let y = self.bias.get(from + j).map_or(sum, |bias| sum + bias);
                    self.out[(first + r) * m + from + j] = if self.hidden { elu(y) } else { y };
                }
            }
            column += count;
        }
    }
}

#[inline(always)]
fn sums<S: Simd, F: SimdFloat<S, Element = f32>, const R: usize, const V: usize>(
    simd: S,
    rows: [&[f32]; R],
    weight: &[f32],
    m: usize,
    column: usize,
) -> [[F; V]; R] {
    let mut sums = [[F::splat(simd, 0.0); V]; R];
    let Some(weight) = weight.get(column..) else { return sums };
    for (l, w) in weight.chunks(m).enumerate() {
        let w = &w[..V * F::LEN];
        for v in 0..V {
            let w = F::from_slice(simd, &w[v * F::LEN..][..F::LEN]);
            for r in 0..R {
                sums[r][v] = F::splat(simd, rows[r][l]).mul_add_precise(w, sums[r][v]);
            }
        }
    }
    sums
}

#[cfg(test)]
mod tests {
    use super::*;

    fn numbers(count: usize, step: usize) -> Vec<f32> {
        (0..count).map(|i| ((i * step) % 23) as f32 * 0.13 - 1.4).collect()
    }

    #[test]
    fn it_is_the_sum_of_products_from_the_first_to_the_last() {
        for sizes in [[1, 7, 5], [3, 40, 20], [4, 6, 1], [1, 300, 1], [2, 1, 2], [3, 0, 2], [70, 160, 135], [9, 33, 23]]
        {
            let [n, k, m] = sizes;
            let (x, w) = (numbers(n * k, 7), numbers(k * m, 11));
            let mut expected = vec![0.0_f32; n * m];
            for i in 0..n {
                for j in 0..m {
                    expected[i * m + j] = (0..k).fold(0.0, |sum, l| x[i * k + l].mul_add(w[l * m + j], sum));
                }
            }
            let mut got = vec![f32::NAN; n * m];
            product(&x, &w, sizes, &mut got);
            assert_eq!(got, expected, "{sizes:?}");
            got.fill(f32::NAN);
            product_on_this_thread(&x, &w, sizes, &mut got);
            assert_eq!(got, expected, "{sizes:?}");
            for set in InstructionSet::available() {
                got.fill(f32::NAN);
                set.run(RowsOfLayer { rows: &x, weight: &w, bias: &[], hidden: false, outputs: m, out: &mut got });
                assert_eq!(got, expected, "{sizes:?} {set}");
            }
        }
    }
}
