//! Learning in several processes at once: each has environments of its own, and all take the same gradient steps.
//!
//! Shared quantities are summed over the processes: gradients, the moments of observations and advantages, the
//! divergence that controls the learning rate, and stop requests. All other data stays local. The transport is the
//! program's: MPI, which clusters already run.

/// Sums over processes. Every process must call the same methods in the same order.
pub trait Collective: Send + Sync {
    /// Number of processes.
    fn size(&self) -> usize;

    /// Which of them this is, from 0.
    fn rank(&self) -> usize;

    /// Replaces each number by its sum over all processes.
    fn sum(&self, values: &mut [f32]);

    /// The same in double precision.
    fn sum_wide(&self, values: &mut [f64]);

    /// Ends all processes: one that cannot go on would leave the others waiting for it for ever.
    fn abort(&self) {}

    /// Returns each process's number, in their order.
    fn gather(&self, here: f64) -> Vec<f64> {
        let mut all = vec![0.0; self.size()];
        all[self.rank()] = here;
        self.sum_wide(&mut all);
        all
    }

    /// Returns true where any process says so.
    fn any(&self, here: bool) -> bool {
        let mut votes = [f64::from(u8::from(here))];
        self.sum_wide(&mut votes);
        votes[0] > 0.0
    }

    /// Mean over the processes of a number.
    fn mean(&self, here: f64) -> f64 {
        let mut sum = [here];
        self.sum_wide(&mut sum);
        sum[0] / self.size() as f64
    }
}

/// One process.
#[derive(Debug, Clone, Copy, Default)]
pub struct Alone;

impl Collective for Alone {
    fn size(&self) -> usize {
        1
    }
    fn rank(&self) -> usize {
        0
    }
    fn sum(&self, _: &mut [f32]) {}
    fn sum_wide(&self, _: &mut [f64]) {}
}

/// Threads of one process in the place of processes.
pub mod threads {
    use std::sync::{Arc, Barrier, Mutex};

    use super::Collective;

    /// One of them.
    #[derive(Debug)]
    pub struct Member {
        rank: usize,
        barrier: Arc<Barrier>,
        slots: Arc<Mutex<Vec<Vec<f64>>>>,
    }

    /// Returns the members of one group.
    pub fn group(size: usize) -> Vec<Member> {
        let (barrier, slots) = (Arc::new(Barrier::new(size)), Arc::new(Mutex::new(vec![Vec::new(); size])));
        (0..size).map(|rank| Member { rank, barrier: barrier.clone(), slots: slots.clone() }).collect()
    }

    impl Collective for Member {
        fn size(&self) -> usize {
            self.slots.lock().map_or(0, |slots| slots.len())
        }
        fn rank(&self) -> usize {
            self.rank
        }
        fn sum(&self, values: &mut [f32]) {
            let mut wide: Vec<f64> = values.iter().map(|x| f64::from(*x)).collect();
            self.sum_wide(&mut wide);
            values.iter_mut().zip(wide).for_each(|(x, w)| *x = w as f32);
        }
        fn sum_wide(&self, values: &mut [f64]) {
            if let Ok(mut slots) = self.slots.lock() {
                slots[self.rank] = values.to_vec();
            }
            self.barrier.wait();
            if let Ok(slots) = self.slots.lock() {
                for (i, value) in values.iter_mut().enumerate() {
                    *value = slots.iter().map(|slot| slot[i]).sum();
                }
            }
            self.barrier.wait();
        }
    }
}
