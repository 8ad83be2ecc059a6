//! Work on parts of an array, shared among the cores.

use std::thread;

/// Less than this many numbers are not worth a thread.
const WORTHWHILE: usize = 1 << 15;

/// Calls `job(first, part)` for parts of `out` that begin at multiples of `unit`: `first` is the number of the part's first
/// unit. Which thread takes which part must not matter to `job`, so results do not depend on the number of threads.
pub(super) fn each_part(out: &mut [f32], unit: usize, job: impl Fn(usize, &mut [f32]) + Sync) {
    let units = out.len() / unit.max(1);
    let threads = if out.len() < WORTHWHILE { 1 } else { thread::available_parallelism().map_or(1, usize::from) };
    let share = units.div_ceil(threads).max(1);
    if share >= units {
        return job(0, out);
    }
    let job = &job;
    thread::scope(|scope| {
        for (i, part) in out.chunks_mut(share * unit).enumerate() {
            scope.spawn(move || job(i * share, part));
        }
    });
}
