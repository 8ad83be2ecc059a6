//! Peak rates of one core of this machine.

use std::hint::black_box;
use std::time::Instant;

use lifelike_sim::engine::lane::Lane;

type Vector = Lane<f32, 8>;

/// Independent sums: enough to keep both multipliers of a core busy while each waits for its last result.
const SUMS: usize = 10;
/// Vectors of an array that fits into the second-level cache but not into the first.
const ARRAY: usize = 8192;

/// Best of some tries, in things per second.
fn best(things: f64, mut work: impl FnMut()) -> f64 {
    let times = (0..20).map(|_| {
        let start = Instant::now();
        work();
        start.elapsed().as_secs_f64()
    });
    things / times.fold(f64::INFINITY, f64::min)
}

/// Floating-point operations per second of one core: multiply-adds of eight lanes that wait for nothing.
pub fn peak_operations() -> f64 {
    const ROUNDS: usize = 200_000;
    best((ROUNDS * SUMS * 8 * 2) as f64, || {
        let (factor, mut sums) = (black_box(Vector::splat(0.999)), black_box([Vector::splat(1.0); SUMS]));
        for _ in 0..ROUNDS {
            for sum in &mut sums {
                *sum = factor.add_mul(*sum, factor);
            }
        }
        black_box(sums);
    })
}

/// Bytes per second that one core reads from its second-level cache.
pub fn cache_bytes() -> f64 {
    const ROUNDS: usize = 50;
    let array = black_box(vec![Vector::splat(1.0); ARRAY]);
    best((ROUNDS * ARRAY * size_of::<Vector>()) as f64, || {
        let mut sums = [Vector::zero(); 8];
        for _ in 0..ROUNDS {
            for part in array.chunks_exact(8) {
                for (sum, x) in sums.iter_mut().zip(part) {
                    *sum += *x;
                }
            }
            black_box(&mut sums);
        }
    })
}
