//! The matrix product.

use gemm_common::Parallelism;

/// Multiplications from which on a product is worth several threads: the number of the training framework's CPU backend.
const PARALLEL: usize = 192 * 192 * 192;

/// Writes the product of rows and a weight.
///
/// # Shapes
/// `rows: [N, K]`, `weight: [K, M]`, `out: [N, M]`; `sizes` is `[N, K, M]`.
///
/// One row allocates nothing; more rows are packed into memory of the kernel's own.
///
/// # Panics
/// A slice is shorter or longer than `sizes` says.
pub fn product(rows: &[f32], weight: &[f32], sizes: [usize; 3], out: &mut [f32]) {
    let [n, k, m] = sizes;
    assert_eq!((rows.len(), weight.len(), out.len()), (n * k, k * m, n * m), "sizes {sizes:?}");
    let many = n.saturating_mul(k).saturating_mul(m) >= PARALLEL;
    let threads = if many { Parallelism::Rayon(0) } else { Parallelism::None };
    let kernel = gemm_f32::gemm::f32::get_gemm_fn();
    let (x, w, y) = (rows.as_ptr(), weight.as_ptr(), out.as_mut_ptr());
    let [steps_k, steps_m] = [k as isize, m as isize];
    // SAFETY: the three slices are as long as the sizes say (asserted above), `out` is borrowed for writing alone, and
    // all strides are those of dense row-major matrices.
    unsafe {
        if m > 1 {
            // Columns first: the kernel likes its result column-major, and a row-major product is a transposed one.
            kernel(m, n, k, y, steps_m, 1, false, w, steps_m, 1, x, steps_k, 1, 0.0, 1.0, false, false, false, threads);
        } else {
            kernel(n, m, k, y, 1, steps_m, false, x, 1, steps_k, w, 1, steps_m, 0.0, 1.0, false, false, false, threads);
        }
    }
}

/// Does the same a row at a time: slower for many rows, and without any allocation.
///
/// # Panics
/// As [`product`].
pub fn product_by_row(rows: &[f32], weight: &[f32], [n, k, m]: [usize; 3], out: &mut [f32]) {
    assert_eq!((rows.len(), out.len()), (n * k, n * m));
    if k == 0 || m == 0 {
        return out.fill(0.0);
    }
    for (row, out) in rows.chunks_exact(k).zip(out.chunks_exact_mut(m)) {
        product(row, weight, [1, k, m], out);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn numbers(count: usize, step: usize) -> Vec<f32> {
        (0..count).map(|i| ((i * step) % 23) as f32 * 0.13 - 1.4).collect()
    }

    #[test]
    fn it_is_the_sum_of_products() {
        for sizes in [[1, 7, 5], [3, 40, 20], [4, 6, 1], [1, 300, 1], [2, 1, 2], [3, 0, 2]] {
            let [n, k, m] = sizes;
            let (x, w) = (numbers(n * k, 7), numbers(k * m, 11));
            let (mut together, mut by_row) = (vec![f32::NAN; n * m], vec![f32::NAN; n * m]);
            product(&x, &w, sizes, &mut together);
            product_by_row(&x, &w, sizes, &mut by_row);
            for i in 0..n {
                for j in 0..m {
                    let exact: f64 = (0..k).map(|l| f64::from(x[i * k + l]) * f64::from(w[l * m + j])).sum();
                    for got in [together[i * m + j], by_row[i * m + j]] {
                        assert!((f64::from(got) - exact).abs() < 1e-4, "{sizes:?}: {got}, not {exact}");
                    }
                }
            }
        }
    }
}
