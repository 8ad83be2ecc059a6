//! Rows of numbers in the order in which the kernels read them.
//!
//! Forty-eight rows are a panel: for each channel (input, hidden unit, output) its number in all of these rows, one
//! after another. A vector holds one channel of several rows. Products, biases and ELUs of a layer read the output of
//! the layer before without transposing it. Channels are padded with zeros to a multiple of [`GROUP`].

use std::ops::{Deref, DerefMut};

/// Rows of a panel: three vectors of 512 bits, six of 256, twelve of 128.
pub const ROWS: usize = 48;
/// Channels come in groups of this many: the height of the kernels' tiles.
pub(crate) const GROUP: usize = 6;

/// One channel of the rows of a panel. It begins where a cache line does: a vector that crosses two lines is read twice.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C, align(64))]
pub struct Channel([f32; ROWS]);

impl Channel {
    /// All numbers zero.
    pub const ZERO: Self = Self([0.0; ROWS]);
}

impl Deref for Channel {
    type Target = [f32; ROWS];
    #[inline(always)]
    fn deref(&self) -> &[f32; ROWS] {
        &self.0
    }
}

impl DerefMut for Channel {
    #[inline(always)]
    fn deref_mut(&mut self) -> &mut [f32; ROWS] {
        &mut self.0
    }
}

/// Returns the channels with those that fill up the last group.
pub(crate) fn padded(channels: usize) -> usize {
    channels.next_multiple_of(GROUP)
}

/// Writes rows into a panel; rows that are not there are zeros.
///
/// # Shapes
/// `rows`: at most [`ROWS`] times `[channels.len()]`.
///
/// # Panics
/// There are more rows, or one is shorter.
pub fn pack<'a>(rows: impl IntoIterator<Item = &'a [f32]>, channels: &mut [Channel]) {
    let mut table: [&[f32]; ROWS] = [&[]; ROWS];
    let mut count = 0;
    for row in rows {
        table[count] = &row[..channels.len()];
        count += 1;
    }
    // Squares of a few cache lines: neither side's lines are left before they are used up.
    for (square, channels) in channels.chunks_mut(16).enumerate() {
        for (r, row) in table[..count].iter().enumerate() {
            for (channel, x) in channels.iter_mut().zip(&row[16 * square..]) {
                channel[r] = *x;
            }
        }
        for channel in channels {
            channel[count..].fill(0.0);
        }
    }
}

/// Reads rows back, `[rows, channels.len()]`.
///
/// # Panics
/// `rows` holds more than [`ROWS`] rows, or no whole number of them.
pub fn unpack(channels: &[Channel], rows: &mut [f32]) {
    assert!(rows.len().is_multiple_of(channels.len().max(1)), "rows of a panel");
    for (r, row) in rows.chunks_exact_mut(channels.len().max(1)).enumerate() {
        row.iter_mut().zip(channels).for_each(|(x, channel)| *x = channel[r]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_come_back_and_missing_ones_are_zeros() {
        let rows: Vec<f32> = (0..5 * 37).map(|i| i as f32).collect();
        let mut panel = vec![Channel([f32::NAN; ROWS]); 37];
        pack(rows.chunks_exact(37), &mut panel);
        assert_eq!((panel[0][0], panel[36][4], panel[17][2]), (0.0, 184.0, 91.0));
        assert!(panel.iter().all(|channel| channel[5..] == [0.0; ROWS - 5]));
        let mut back = vec![0.0; rows.len()];
        unpack(&panel, &mut back);
        assert_eq!(back, rows);
    }
}
