//! Peak rates of one core of this machine, with the vector instructions of this process.

use std::hint::black_box;
use std::time::Instant;

use lifelike_simd::prelude::*;
use lifelike_simd::{InstructionSet, Simd, Task};

/// Independent sums: enough to keep both multipliers of a core busy while each waits for its last result.
const SUMS: usize = 10;
/// Numbers of an array that fits into the second-level cache but not into the first.
const ARRAY: usize = 1 << 16;

/// Best of some tries, in things per second.
#[inline(always)]
fn best(things: f64, mut work: impl FnMut()) -> f64 {
    let mut shortest = f64::INFINITY;
    for _ in 0..20 {
        let start = Instant::now();
        work();
        shortest = start.elapsed().as_secs_f64().min(shortest);
    }
    things / shortest
}

/// Floating-point operations per second of one core: multiply-adds that wait for nothing.
pub fn peak_operations() -> f64 {
    InstructionSet::chosen().run(Operations)
}

/// Bytes per second that one core reads from its second-level cache.
pub fn cache_bytes() -> f64 {
    InstructionSet::chosen().run(CacheBytes)
}

struct Operations;

impl Task for Operations {
    type Output = f64;
    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> f64 {
        const ROUNDS: usize = 200_000;
        let operations = ROUNDS * SUMS * <S::f32s as SimdBase<S>>::LEN * 2;
        best(
            operations as f64,
            #[inline(always)]
            || {
                let (factor, one) = (S::f32s::splat(simd, black_box(0.999)), S::f32s::splat(simd, black_box(1.0)));
                let mut sums = [one; SUMS];
                for _ in 0..ROUNDS {
                    for sum in &mut sums {
                        *sum = sum.mul_add(factor, factor);
                    }
                }
                black_box(sums);
            },
        )
    }
}

struct CacheBytes;

impl Task for CacheBytes {
    type Output = f64;
    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> f64 {
        const ROUNDS: usize = 50;
        let array = black_box(vec![1.0_f32; ARRAY]);
        let width = <S::f32s as SimdBase<S>>::LEN;
        best(
            (ROUNDS * size_of_val(array.as_slice())) as f64,
            #[inline(always)]
            || {
                let mut sums = [S::f32s::splat(simd, 0.0); 8];
                for _ in 0..ROUNDS {
                    for part in array.chunks_exact(8 * width) {
                        for (sum, x) in sums.iter_mut().zip(part.chunks_exact(width)) {
                            *sum += S::f32s::from_slice(simd, x);
                        }
                    }
                    black_box(&mut sums);
                }
            },
        )
    }
}
