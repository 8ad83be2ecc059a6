//! Memory for passes through frozen networks.

/// Buffers between the layers of a network, kept from pass to pass.
#[derive(Debug, Clone, Default)]
pub struct Workspace {
    buffers: [Vec<f32>; 4],
    /// Rows of a product one at a time, which allocates nothing, instead of all at once, which is faster.
    by_row: bool,
}

impl Workspace {
    /// For one robot in real time: no pass allocates once the first is made.
    pub fn live() -> Self {
        Self { by_row: true, ..Self::default() }
    }

    /// For many rows at a time, with the products of the training framework: equal to its numbers bit for bit where a
    /// network consists of products, biases and ELUs.
    pub fn batched() -> Self {
        Self::default()
    }

    /// Multiplies rows `[N, K]` by a weight `[K, M]`.
    pub(super) fn product(by_row: bool, rows: &[f32], weight: &[f32], sizes: [usize; 3], out: &mut [f32]) {
        if by_row {
            lifelike_dense::product_by_row(rows, weight, sizes, out);
        } else {
            lifelike_dense::product(rows, weight, sizes, out);
        }
    }

    /// The buffers with at least this many numbers each, and whether products go row by row.
    pub(super) fn parts(&mut self, numbers: usize) -> (&mut [Vec<f32>; 4], bool) {
        for buffer in &mut self.buffers {
            if buffer.len() < numbers {
                buffer.resize(numbers, 0.0);
            }
        }
        (&mut self.buffers, self.by_row)
    }
}
