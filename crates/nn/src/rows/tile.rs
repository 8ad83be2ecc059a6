//! Matrix products small enough for the cache, inside of one thread: what attention of one head and a block of rows need.

use lifelike_simd::{InstructionSet, Simd, Task, prelude::*};

/// Columns of a panel.
pub(crate) const LANES: usize = 16;

/// One number of each of as many rows as a panel has columns.
pub(crate) type Lanes = [f32; LANES];

/// Returns the next multiple of a panel's width.
pub(crate) fn padded(n: usize) -> usize {
    n.next_multiple_of(LANES)
}

/// A matrix among numbers: (row, i) stands at `row · stride + i`, or if `transposed` at `i · stride + row`.
#[derive(Clone, Copy)]
pub(crate) struct View<'a> {
    pub(crate) numbers: &'a [f32],
    pub(crate) stride: usize,
    pub(crate) transposed: bool,
}

impl<'a> View<'a> {
    /// A row begins every `stride` numbers.
    pub(crate) fn rows(numbers: &'a [f32], stride: usize) -> Self {
        Self { numbers, stride, transposed: false }
    }

    /// A column begins every `stride` numbers.
    pub(crate) fn columns(numbers: &'a [f32], stride: usize) -> Self {
        Self { numbers, stride, transposed: true }
    }
}

/// Lays a `[k, n]` matrix times a number out in panels of [`LANES`] columns, each row by row, zeros beyond the last column.
#[inline(always)]
pub(crate) fn pack(panels: &mut Vec<Lanes>, k: usize, n: usize, matrix: View<'_>, scale: f32) {
    // All of it is overwritten.
    panels.resize(k * padded(n) / LANES, [0.0; LANES]);
    let View { numbers, stride, transposed } = matrix;
    for (panel, first) in panels.chunks_exact_mut(k.max(1)).zip((0..n).step_by(LANES)) {
        let columns = LANES.min(n - first);
        if transposed {
            for lane in 0..columns {
                let column = &numbers[(first + lane) * stride..][..k];
                panel.iter_mut().zip(column).for_each(|(lanes, x)| lanes[lane] = scale * x);
            }
            for lane in columns..LANES {
                panel.iter_mut().for_each(|lanes| lanes[lane] = 0.0);
            }
        } else {
            for (row, lanes) in panel.iter_mut().enumerate() {
                let row = &numbers[row * stride + first..][..columns];
                // Most panels are full or, of a head's columns, half full: lengths that are known.
                match (row.as_array::<LANES>(), row.as_array::<{ LANES / 2 }>()) {
                    (Some(row), _) => *lanes = row.map(|x| scale * x),
                    (_, Some(row)) => {
                        *lanes = [0.0; LANES];
                        lanes.iter_mut().zip(row).for_each(|(lane, x)| *lane = scale * x);
                    }
                    _ => {
                        *lanes = [0.0; LANES];
                        lanes.iter_mut().zip(row).for_each(|(lane, x)| *lane = scale * x);
                    }
                }
            }
        }
    }
}

/// out = left · panels; `out` is `[rows, padded(n)]`, row-major.
///
/// Each number is summed over k from the first to the last with fused multiply-adds, with every instruction set alike.
pub(crate) fn product(out: &mut [f32], rows: usize, left: View<'_>, panels: &[[f32; LANES]], k: usize) {
    InstructionSet::chosen().run(Product { out, rows, left, panels, k });
}

struct Product<'a> {
    out: &'a mut [f32],
    rows: usize,
    left: View<'a>,
    panels: &'a [[f32; LANES]],
    k: usize,
}

impl Task for Product<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(mut self, simd: S) {
        let panels = self.panels.len() / self.k.max(1);
        // As many sums at a time as registers hold beside a row of the panel.
        match S::f32s::LEN {
            // Two panels: else every multiplication would wait for a number of the left factor.
            16 => {
                self.panels::<S, 12, 1, 2>(simd, 0);
                let even = panels / 2 * 2;
                self.panels::<S, 12, 1, 1>(simd, even);
            }
            8 => self.panels::<S, 6, 2, 1>(simd, 0),
            // NEON holds them in its 32 registers.
            _ => self.panels::<S, 6, 4, 1>(simd, 0),
        }
    }
}

impl Product<'_> {
    /// The panels from `first` on, as far as they are `P` together: `R` rows at a time, then two, then one; a row of a panel is `V` vectors.
    #[inline(always)]
    fn panels<S: Simd, const R: usize, const V: usize, const P: usize>(&mut self, simd: S, first: usize) {
        let k = self.k.max(1);
        for (p, panels) in self.panels[first * k..].chunks_exact(P * k).enumerate() {
            let p = first + p * P;
            let mut row = 0;
            while row + R <= self.rows {
                self.tile::<S, R, V, P>(simd, row, p, panels);
                row += R;
            }
            while row + 2 <= self.rows {
                self.tile::<S, 2, V, P>(simd, row, p, panels);
                row += 2;
            }
            if row < self.rows {
                self.tile::<S, 1, V, P>(simd, row, p, panels);
            }
        }
    }

    /// `R` rows of `P` panels' columns, the first of them number `p`, summed in registers.
    #[inline(always)]
    fn tile<S: Simd, const R: usize, const V: usize, const P: usize>(
        &mut self,
        simd: S,
        row: usize,
        p: usize,
        panels: &[Lanes],
    ) {
        let (left, width) = (self.left, self.panels.len() / self.k.max(1) * LANES);
        let mut sums = [[[S::f32s::splat(simd, 0.0); V]; P]; R];
        let mut side_by_side: [&[Lanes]; P] = [&[]; P];
        for (panel, own) in side_by_side.iter_mut().zip(panels.chunks_exact(self.k.max(1))) {
            *panel = own;
        }
        let panels = side_by_side;
        if left.transposed {
            for i in 0..self.k {
                let y = vectors::<S, V, P>(simd, &panels.map(|panel| &panel[i]));
                if let Some(x) = left.numbers[i * left.stride + row..].first_chunk::<R>() {
                    for (sums, x) in sums.iter_mut().zip(x) {
                        add(S::f32s::splat(simd, *x), &y, sums);
                    }
                }
            }
        } else {
            // Plain loops: a closure that is not inlined here would be a call for every multiplication.
            let mut rows: [&[f32]; R] = [&[]; R];
            for (r, numbers) in rows.iter_mut().enumerate() {
                *numbers = &left.numbers[(row + r) * left.stride..][..self.k];
            }
            for i in 0..self.k {
                let y = vectors::<S, V, P>(simd, &panels.map(|panel| &panel[i]));
                for (sums, row) in sums.iter_mut().zip(&rows) {
                    add(S::f32s::splat(simd, row[i]), &y, sums);
                }
            }
        }
        for (r, sums) in sums.iter().enumerate() {
            let out = &mut self.out[(row + r) * width + p * LANES..][..P * LANES];
            for (out, sum) in out.chunks_exact_mut(S::f32s::LEN).zip(sums.as_flattened()) {
                sum.store_slice(out);
            }
        }
    }
}

/// Returns a row of each panel.
#[inline(always)]
fn vectors<S: Simd, const V: usize, const P: usize>(simd: S, lanes: &[&Lanes; P]) -> [[S::f32s; V]; P] {
    let mut y = [[S::f32s::splat(simd, 0.0); V]; P];
    for (y, lanes) in y.iter_mut().zip(lanes) {
        for (y, lanes) in y.iter_mut().zip(lanes.chunks_exact(S::f32s::LEN)) {
            *y = S::f32s::from_slice(simd, lanes);
        }
    }
    y
}

/// sums ← sums + x y, of one row of the left factor.
///
/// Row by row: each number of the left factor is needed once and its register free again. Vector by vector all of them would be
/// held beside the sums, for which AVX2's 16 registers do not suffice.
#[inline(always)]
fn add<F: SimdFloat<S>, S: Simd, const V: usize, const P: usize>(x: F, y: &[[F; V]; P], sums: &mut [[F; V]; P]) {
    for (sums, y) in sums.iter_mut().zip(y) {
        for (sum, y) in sums.iter_mut().zip(y) {
            *sum = x.mul_add_precise(*y, *sum);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn panels_hold_a_matrix_times_a_number_however_it_stands() {
        for (k, n) in [(1, 1), (5, 16), (7, 33), (3, 50)] {
            let at = |row: usize, column: usize| (row * 100 + column) as f32;
            // Rows and columns begin further apart than they are long.
            let (mut rows, mut columns) = (vec![f32::NAN; k * (n + 3)], vec![f32::NAN; n * (k + 2)]);
            for row in 0..k {
                for column in 0..n {
                    rows[row * (n + 3) + column] = at(row, column);
                    columns[column * (k + 2) + row] = at(row, column);
                }
            }
            for matrix in [View::rows(&rows, n + 3), View::columns(&columns, k + 2)] {
                let mut panels = vec![[f32::NAN; LANES]; 2];
                pack(&mut panels, k, n, matrix, 0.5);
                assert_eq!(panels.len(), k * padded(n) / LANES);
                for (i, lanes) in panels.iter().enumerate() {
                    for (lane, x) in lanes.iter().enumerate() {
                        let (row, column) = (i % k, i / k * LANES + lane);
                        let expected = if column < n { 0.5 * at(row, column) } else { 0.0 };
                        assert_eq!(*x, expected, "{k} {n}, {}, ({row}, {column})", matrix.transposed);
                    }
                }
            }
        }
    }

    #[test]
    fn products_are_those_of_three_loops() {
        for (m, k, n) in [(1, 1, 1), (6, 5, 16), (13, 7, 33), (9, 20, 5), (27, 3, 64)] {
            let a: Vec<f32> = (0..m * k).map(|i| ((i * 37) % 19) as f32 - 9.0).collect();
            let b: Vec<f32> = (0..k * n).map(|i| ((i * 11) % 23) as f32 - 11.0).collect();
            let mut panels = Vec::new();
            pack(&mut panels, k, n, View::rows(&b, n), 1.0);
            let turned: Vec<f32> = (0..k * m).map(|i| a[i % m * k + i / m]).collect();
            for left in [View::rows(&a, k), View::columns(&turned, m)] {
                let mut out = vec![f32::NAN; m * padded(n)];
                product(&mut out, m, left, &panels, k);
                for set in InstructionSet::available() {
                    let mut again = vec![f32::NAN; m * padded(n)];
                    set.run(Product { out: &mut again, rows: m, left, panels: &panels, k });
                    assert_eq!(again, out, "{set}");
                }
                for i in 0..m {
                    for j in 0..n {
                        // Whole numbers: no rounding.
                        let expected: f32 = (0..k).map(|l| a[i * k + l] * b[l * n + j]).sum();
                        assert_eq!(out[i * padded(n) + j], expected, "{m} {k} {n}, {}, ({i}, {j})", left.transposed);
                    }
                }
            }
        }
    }
}
