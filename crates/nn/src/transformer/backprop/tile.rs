//! Matrix products small enough for the cache, inside of one thread: what attention of one head needs.

use super::elementary::fma;

/// Columns of a panel.
pub(in crate::transformer) const LANES: usize = 16;

/// Returns the next multiple of a panel's width.
pub(in crate::transformer) fn padded(n: usize) -> usize {
    n.next_multiple_of(LANES)
}

/// Lays a `[k, n]` matrix out in panels of [`LANES`] columns, each row by row, zeros beyond the last column.
/// `at(row, column)` gives the numbers.
#[inline(always)]
pub(in crate::transformer) fn pack(panels: &mut Vec<[f32; LANES]>, k: usize, n: usize, at: impl Fn(usize, usize) -> f32) {
    panels.clear();
    for first in (0..n).step_by(LANES) {
        for row in 0..k {
            let mut lanes = [0.0; LANES];
            for (lane, x) in lanes.iter_mut().enumerate().take(n - first) {
                *x = at(row, first + lane);
            }
            panels.push(lanes);
        }
    }
}

/// The left factor: number (row, i) stands at `row · stride + i`, or if `transposed` at `i · stride + row`.
#[derive(Clone, Copy)]
pub(in crate::transformer) struct Left<'a> {
    pub(in crate::transformer) numbers: &'a [f32],
    pub(in crate::transformer) stride: usize,
    pub(in crate::transformer) transposed: bool,
}

/// out = left · panels; `out` is `[rows, padded(n)]`, row-major.
#[inline(always)]
pub(in crate::transformer) fn product(out: &mut [f32], rows: usize, left: Left<'_>, panels: &[[f32; LANES]], k: usize) {
    let width = panels.len() / k.max(1) * LANES;
    for (p, panel) in panels.chunks_exact(k.max(1)).enumerate() {
        let mut row = 0;
        while row + 6 <= rows {
            tile::<6>(out, width, row, p * LANES, left, panel);
            row += 6;
        }
        while row + 2 <= rows {
            tile::<2>(out, width, row, p * LANES, left, panel);
            row += 2;
        }
        if row < rows {
            tile::<1>(out, width, row, p * LANES, left, panel);
        }
    }
}

/// R rows of one panel's columns, summed in registers.
#[inline(always)]
fn tile<const R: usize>(
    out: &mut [f32],
    width: usize,
    row: usize,
    column: usize,
    left: Left<'_>,
    panel: &[[f32; LANES]],
) {
    let mut sums = [[0.0_f32; LANES]; R];
    if left.transposed {
        for (i, lanes) in panel.iter().enumerate() {
            if let Some(x) = left.numbers[i * left.stride + row..].first_chunk::<R>() {
                add(&mut sums, x, lanes);
            }
        }
    } else {
        let rows: [&[f32]; R] = std::array::from_fn(|r| &left.numbers[(row + r) * left.stride..][..panel.len()]);
        for (i, lanes) in panel.iter().enumerate() {
            add(&mut sums, &std::array::from_fn(|r| rows[r][i]), lanes);
        }
    }
    for (r, sums) in sums.iter().enumerate() {
        out[(row + r) * width + column..][..LANES].copy_from_slice(sums);
    }
}

/// sums ← sums + x lanes.
#[inline(always)]
fn add<const R: usize>(sums: &mut [[f32; LANES]; R], x: &[f32; R], lanes: &[f32; LANES]) {
    for (sums, x) in sums.iter_mut().zip(x) {
        for (sum, y) in sums.iter_mut().zip(lanes) {
            *sum = fma(*x, *y, *sum);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn products_are_those_of_three_loops() {
        for (m, k, n) in [(1, 1, 1), (6, 5, 16), (13, 7, 33), (9, 20, 5), (27, 3, 64)] {
            let a: Vec<f32> = (0..m * k).map(|i| ((i * 37) % 19) as f32 - 9.0).collect();
            let b: Vec<f32> = (0..k * n).map(|i| ((i * 11) % 23) as f32 - 11.0).collect();
            let mut panels = Vec::new();
            pack(&mut panels, k, n, |row, column| b[row * n + column]);
            let turned: Vec<f32> = (0..k * m).map(|i| a[i % m * k + i / m]).collect();
            for (numbers, stride, transposed) in [(&a, k, false), (&turned, m, true)] {
                let mut out = vec![f32::NAN; m * padded(n)];
                product(&mut out, m, Left { numbers, stride, transposed }, &panels, k);
                for i in 0..m {
                    for j in 0..n {
                        // Whole numbers: no rounding.
                        let expected: f32 = (0..k).map(|l| a[i * k + l] * b[l * n + j]).sum();
                        assert_eq!(out[i * padded(n) + j], expected, "{m} {k} {n}, {transposed}, ({i}, {j})");
                    }
                }
            }
        }
    }
}
