//! Memory for passes through frozen networks.

use lifelike_dense::Between;

/// Buffers between the layers of a network, kept from pass to pass.
#[derive(Debug, Clone, Default)]
pub struct Workspace {
    buffers: [Vec<f32>; 4],
    between: Between,
    /// Everything on the caller's thread, which allocates nothing, instead of on all threads.
    live: bool,
}

impl Workspace {
    /// For one robot in real time: no pass allocates once the first is made.
    pub fn live() -> Self {
        Self { live: true, ..Self::default() }
    }

    /// For many rows at a time, on all threads. The numbers are the same.
    pub fn batched() -> Self {
        Self::default()
    }

    pub(super) fn is_live(&self) -> bool {
        self.live
    }

    pub(super) fn between(&mut self) -> &mut Between {
        &mut self.between
    }

    /// Multiplies rows `[N, K]` by a weight `[K, M]`.
    pub(super) fn product(live: bool, rows: &[f32], weight: &[f32], sizes: [usize; 3], out: &mut [f32]) {
        if live {
            lifelike_dense::product_on_this_thread(rows, weight, sizes, out);
        } else {
            lifelike_dense::product(rows, weight, sizes, out);
        }
    }

    /// The buffers with at least this many numbers each, and whether products stay on this thread.
    pub(super) fn parts(&mut self, numbers: usize) -> (&mut [Vec<f32>; 4], bool) {
        for buffer in &mut self.buffers {
            if buffer.len() < numbers {
                buffer.resize(numbers, 0.0);
            }
        }
        (&mut self.buffers, self.live)
    }
}
