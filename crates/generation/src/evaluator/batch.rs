//! Sequences of different lengths as one padded tensor with its mask.

use burn::tensor::{Device, Int, Tensor, TensorData};

use crate::text::pieces::PAD;

/// Padded sequences.
pub(super) struct Padded<T> {
    /// The sequences; padding is zero.
    pub values: T,
    /// Their lengths.
    pub lengths: Vec<usize>,
}

/// Pads rows to the longest, and that to a multiple of `step`.
///
/// # Shapes
/// Sequences `[n_i, width]` to `[B, T, width]`.
pub(super) fn rows(sequences: &[Vec<f32>], width: usize, step: usize, device: &Device) -> Padded<Tensor<3>> {
    let lengths: Vec<usize> = sequences.iter().map(|rows| rows.len() / width).collect();
    let longest = longest(&lengths).next_multiple_of(step);
    let mut values = vec![0.0; sequences.len() * longest * width];
    for (out, rows) in values.chunks_exact_mut(longest * width).zip(sequences) {
        out[..rows.len()].copy_from_slice(rows);
    }
    let values = Tensor::from_data(TensorData::new(values, [sequences.len(), longest, width]), device);
    Padded { values, lengths }
}

/// Pads ids to the longest, `[B * L]`.
pub(super) fn ids(sentences: &[Vec<u32>], device: &Device) -> Padded<Tensor<1, Int>> {
    let lengths: Vec<usize> = sentences.iter().map(Vec::len).collect();
    let longest = longest(&lengths);
    let mut values = vec![i64::from(PAD); sentences.len() * longest];
    for (out, ids) in values.chunks_exact_mut(longest).zip(sentences) {
        out.iter_mut().zip(ids).for_each(|(out, id)| *out = i64::from(*id));
    }
    let count = values.len();
    Padded { values: Tensor::from_data(TensorData::new(values, [count]), device), lengths }
}

/// Returns ones where a sequence is and zeros where padding is, `[T, B, 1]`.
pub(super) fn mask(lengths: &[usize], steps: usize, device: &Device) -> Tensor<3> {
    let ones = (0..steps).flat_map(|t| lengths.iter().map(move |length| if t < *length { 1.0_f32 } else { 0.0 }));
    Tensor::from_data(TensorData::new(ones.collect::<Vec<_>>(), [steps, lengths.len(), 1]), device)
}

fn longest(lengths: &[usize]) -> usize {
    lengths.iter().copied().max().unwrap_or(0).max(1)
}
