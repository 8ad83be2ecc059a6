//! Work on parts of an array, shared among the cores.

use lifelike_simd::vectorize;
use rayon::prelude::*;

/// Less than this many numbers are not worth a thread.
pub(super) const WORTHWHILE: usize = 1 << 15;

/// Calls `job(first, part)` for parts of `out` that begin at multiples of `unit`: `first` is the number of the part's first
/// unit. Which thread takes which part must not matter to `job`, so results do not depend on the number of threads.
///
/// `job` is compiled for the vector instructions of the machine: it must be `#[inline(always)]`, with all loops in it.
pub(super) fn each_part(out: &mut [f32], unit: usize, job: impl Fn(usize, &mut [f32]) + Sync) {
    let units = out.len() / unit.max(1);
    let threads = if out.len() < WORTHWHILE { 1 } else { rayon::current_num_threads() };
    let share = units.div_ceil(threads).max(1);
    if share >= units {
        return vectorize(
            #[inline(always)]
            || job(0, out),
        );
    }
    out.par_chunks_mut(share * unit).enumerate().for_each(|(i, part)| {
        vectorize(
            #[inline(always)]
            || job(i * share, part),
        );
    });
}
