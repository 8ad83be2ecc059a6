//! Threads that share a queue of jobs, each with a workspace of its own.

use std::sync::{Mutex, PoisonError};

/// One workspace per thread: the thread that asks for work, and those of a pool beside it.
pub(crate) struct Workers<W> {
    /// None where the asking thread is all there is.
    pool: Option<rayon::ThreadPool>,
    workspaces: Vec<W>,
}

impl<W: Send> Workers<W> {
    /// So many threads (0: one per processor), each with a workspace that `make` returns.
    pub fn new(threads: usize, make: impl FnMut() -> Result<W, String>) -> Result<Self, String> {
        let threads = match threads {
            0 => std::thread::available_parallelism().map_or(1, std::num::NonZero::get),
            n => n,
        };
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads - 1).thread_name(|i| format!("physics-{i}"));
        let pool = (threads > 1).then(|| pool.build()).transpose().map_err(|e| e.to_string())?;
        let workspaces = std::iter::repeat_with(make).take(threads).collect::<Result<_, _>>()?;
        Ok(Self { pool, workspaces })
    }

    /// One workspace, for what is not worth a thread.
    pub fn first(&mut self) -> &mut W {
        &mut self.workspaces[0]
    }

    /// Does every job in some workspace. A thread takes the next job when it is done with one, so a job's result must not
    /// depend on what its workspace did before. The asking thread begins at once, while the others still wake up.
    pub fn run<J: Send>(&mut self, jobs: Vec<J>, work: impl Fn(&mut W, J) + Sync) {
        let helpers = jobs.len().saturating_sub(1);
        let queue = Mutex::new(jobs.into_iter());
        let work_off = |workspace: &mut W| {
            let next = || queue.lock().unwrap_or_else(PoisonError::into_inner).next();
            while let Some(job) = next() {
                work(workspace, job);
            }
        };
        let (own, others) = self.workspaces.split_at_mut(1);
        match &self.pool {
            Some(pool) if helpers > 0 => pool.in_place_scope(|scope| {
                for workspace in others.iter_mut().take(helpers) {
                    scope.spawn(|_| work_off(workspace));
                }
                work_off(&mut own[0]);
            }),
            _ => work_off(&mut own[0]),
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn every_job_is_done_once_whatever_the_number_of_threads() {
        for threads in [1, 3] {
            let mut workers = Workers::new(threads, || Ok(0_u32)).unwrap();
            let mut done = vec![0; 100];
            workers.run(done.iter_mut().collect(), |count, slot: &mut i32| {
                *slot += 1;
                *count += 1;
            });
            assert_eq!(done, [1; 100]);
            assert_eq!(workers.workspaces.iter().sum::<u32>(), 100);
        }
    }

    #[test]
    fn a_workspace_that_cannot_be_made_stops_the_whole() {
        assert_eq!(Workers::<()>::new(2, || Err("no memory".into())).err().unwrap(), "no memory");
    }
}
