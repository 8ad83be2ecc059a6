//! The records of all environments that a correction looks back on.

use super::correction::{History, HistorySize};

/// Records of N environments, at most K of each.
#[derive(Debug, Clone)]
pub(super) struct Histories {
    size: HistorySize,
    /// Number of records of each environment, `[N]`.
    lengths: Vec<usize>,
    /// Records, the oldest first, `[N, K, width]`.
    records: Vec<f32>,
}

impl Histories {
    /// No records of so many environments.
    pub fn new(environments: usize, size: HistorySize) -> Self {
        Self { size, lengths: vec![0; environments], records: vec![0.0; environments * size.steps * size.width] }
    }

    /// Numbers of one environment in a saved state.
    pub fn saved_width(&self) -> usize {
        1 + self.size.steps * self.size.width
    }

    fn row(&self, id: usize) -> std::ops::Range<usize> {
        let width = self.size.steps * self.size.width;
        id * width..(id + 1) * width
    }

    /// The records of one environment.
    pub fn get(&self, id: usize) -> History<'_> {
        let records = &self.records[self.row(id)][..self.lengths[id] * self.size.width];
        History { records, width: self.size.width }
    }

    /// Adds a record; of K already there the oldest goes.
    pub fn push(&mut self, id: usize, record: &[f32]) {
        let (row, HistorySize { steps, width }) = (self.row(id), self.size);
        if steps == 0 {
            return;
        }
        let records = &mut self.records[row];
        if self.lengths[id] == steps {
            records.copy_within(width.., 0);
        } else {
            self.lengths[id] += 1;
        }
        let at = (self.lengths[id] - 1) * width;
        records[at..at + width].copy_from_slice(record);
    }

    /// Forgets an environment's records, down to the numbers: what is saved does not tell of a past that is over.
    pub fn clear(&mut self, id: usize) {
        let row = self.row(id);
        self.records[row].fill(0.0);
        self.lengths[id] = 0;
    }

    /// Appends an environment's numbers.
    pub fn save(&self, id: usize, values: &mut Vec<f64>) {
        values.push(self.lengths[id] as f64);
        values.extend(self.records[self.row(id)].iter().map(|x| f64::from(*x)));
    }

    /// Takes over an environment's saved numbers.
    pub fn load(&mut self, id: usize, values: &[f64]) {
        self.lengths[id] = (values[0].max(0.0) as usize).min(self.size.steps);
        let row = self.row(id);
        self.records[row].iter_mut().zip(&values[1..]).for_each(|(slot, x)| *slot = *x as f32);
    }
}
