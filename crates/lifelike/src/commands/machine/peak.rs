//! Peak rates of one core of this machine, with the vectors of one instruction set.

use std::hint::black_box;
use std::time::Instant;

use lifelike_simd::prelude::*;
use lifelike_simd::{InstructionSet, Simd, Task};

/// Independent sums: enough to keep both multipliers of a core busy while each waits for its last result.
const SUMS: usize = 10;
/// Numbers of an array that fits into the second-level cache but not into the first: 256 KiB.
const ARRAY: usize = 65_536;

/// Returns the best of some tries, in things per second; `work` says how many it did.
fn best(mut work: impl FnMut() -> usize) -> f64 {
    let rates = (0..20).map(|_| {
        let start = Instant::now();
        let things = work() as f64;
        things / start.elapsed().as_secs_f64()
    });
    rates.fold(0.0, f64::max)
}

/// Multiply-adds that wait for nothing, rounded once as physics needs them. The starts differ, so that none can be left out.
struct MultiplyAdds {
    rounds: usize,
    factor: f32,
    starts: [f32; SUMS],
}

impl Task for MultiplyAdds {
    type Output = usize;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> usize {
        let factor = S::f32s::splat(simd, self.factor);
        let mut sums = self.starts.map(|start| S::f32s::splat(simd, start));
        for _ in 0..self.rounds {
            for sum in &mut sums {
                *sum = factor.mul_add_precise(*sum, factor);
            }
        }
        for sum in sums {
            black_box(sum.as_slice()[0]);
        }
        self.rounds * SUMS * S::f32s::LEN * 2
    }
}

/// Returns floating-point operations per second of one core, in single precision.
pub fn operations(set: InstructionSet) -> f64 {
    // Where a multiply-add takes several instructions, a tenth takes as long.
    let rounds = if set == InstructionSet::Portable { 20_000 } else { 200_000 };
    let starts = std::array::from_fn(|i| i as f32);
    best(|| set.run(MultiplyAdds { rounds, factor: black_box(0.999), starts: black_box(starts) }))
}

/// Reads an array again and again.
struct Read<'a>(&'a [f32]);

impl Task for Read<'_> {
    type Output = usize;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> usize {
        const ROUNDS: usize = 50;
        let mut sums = [S::f32s::splat(simd, 0.0); 8];
        for _ in 0..ROUNDS {
            for part in black_box(self.0).chunks_exact(8 * S::f32s::LEN) {
                for (sum, x) in sums.iter_mut().zip(part.chunks_exact(S::f32s::LEN)) {
                    *sum += S::f32s::from_slice(simd, x);
                }
            }
        }
        for sum in sums {
            black_box(sum.as_slice()[0]);
        }
        ROUNDS * size_of_val(self.0)
    }
}

/// Returns bytes per second that one core reads from its second-level cache.
pub fn cache_bytes(set: InstructionSet) -> f64 {
    let array = vec![1.0; ARRAY];
    best(|| set.run(Read(&array)))
}
