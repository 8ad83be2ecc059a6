//! Softmax of attention scores in the machine's widest vectors: with as many heads and tokens as ours it takes as long as the products.

use lifelike_simd::{InstructionSet, Simd, Task, prelude::*};

use crate::rows::elementary::exp_of_vector;
use crate::rows::tile::LANES;

/// Softmax of each row of scores + bias, in place; rows are whole panels of `width` numbers.
///
/// Sums are those of [`LANES`] lanes, with every instruction set alike.
pub(super) fn softmax(scores: &mut [f32], bias: &[f32], width: usize) {
    InstructionSet::chosen().run(Softmax { scores, bias, width });
}

/// Rows at a time.
const ROWS: usize = 4;

struct Softmax<'a> {
    scores: &'a mut [f32],
    bias: &'a [f32],
    width: usize,
}

impl Task for Softmax<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let together = ROWS * self.width;
        for (scores, bias) in self.scores.chunks_mut(together).zip(self.bias.chunks(together)) {
            match S::f32s::LEN {
                16 => rows::<S, 1>(simd, scores, bias, self.width),
                8 => rows::<S, 2>(simd, scores, bias, self.width),
                _ => rows::<S, 4>(simd, scores, bias, self.width),
            }
        }
    }
}

/// Up to [`ROWS`] rows, whose steps do not wait for each other; a panel is `V` vectors.
#[inline(always)]
fn rows<S: Simd, const V: usize>(simd: S, scores: &mut [f32], bias: &[f32], width: usize) {
    let length = S::f32s::LEN;
    let splat = |x: f32| S::f32s::splat(simd, x);
    let lanes = |vectors: [S::f32s; V]| {
        let mut lanes = [0.0; LANES];
        lanes.chunks_exact_mut(length).zip(vectors).for_each(|(lanes, vector)| vector.store_slice(lanes));
        lanes
    };
    let mut greatest = [0.0; ROWS];
    let rows = scores.chunks_exact_mut(width).zip(bias.chunks_exact(width));
    for ((scores, bias), greatest) in rows.zip(&mut greatest) {
        let mut most = [splat(f32::MIN); V];
        for (scores, bias) in scores.chunks_exact_mut(LANES).zip(bias.chunks_exact(LANES)) {
            let vectors = scores.chunks_exact_mut(length).zip(bias.chunks_exact(length));
            for ((scores, bias), most) in vectors.zip(&mut most) {
                let score = S::f32s::from_slice(simd, scores) + S::f32s::from_slice(simd, bias);
                score.store_slice(scores);
                *most = score.simd_gt(*most).select(score, *most);
            }
        }
        *greatest = reduced(lanes(most), |x, y| if x > y { x } else { y });
    }
    let mut shares = [0.0; ROWS];
    for ((scores, greatest), share) in scores.chunks_exact_mut(width).zip(greatest).zip(&mut shares) {
        let mut sums = [splat(0.0); V];
        for scores in scores.chunks_exact_mut(LANES) {
            for (scores, sum) in scores.chunks_exact_mut(length).zip(&mut sums) {
                let weight = exp_of_vector(simd, S::f32s::from_slice(simd, scores) - splat(greatest));
                weight.store_slice(scores);
                *sum += weight;
            }
        }
        *share = 1.0 / reduced(lanes(sums), |x, y| x + y);
    }
    for (scores, share) in scores.chunks_exact_mut(width).zip(shares) {
        for scores in scores.chunks_exact_mut(length) {
            (S::f32s::from_slice(simd, scores) * splat(share)).store_slice(scores);
        }
    }
}

/// Half with half until one is left: one after the other they would wait for each other longer than the rest of a row takes.
#[inline(always)]
fn reduced(mut lanes: [f32; LANES], with: impl Fn(f32, f32) -> f32) -> f32 {
    let mut half = LANES / 2;
    while half > 0 {
        let (low, high) = lanes.split_at_mut(half);
        low.iter_mut().zip(high).for_each(|(low, high)| *low = with(*low, *high));
        half /= 2;
    }
    lanes[0]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_are_those_of_double_precision_with_every_instruction_set() {
        let width = 3 * LANES;
        let number = |i: usize| ((i * 37) % 101) as f32 * 0.17 - 8.0;
        let scores: Vec<f32> = (0..2 * width).map(number).collect();
        // The last three of a row leave no weight.
        let bias: Vec<f32> =
            (0..2 * width).map(|i| if i % width < width - 3 { number(i * i) } else { -1e30 }).collect();
        let mut got = scores.clone();
        softmax(&mut got, &bias, width);
        for set in InstructionSet::available() {
            let mut again = scores.clone();
            set.run(Softmax { scores: &mut again, bias: &bias, width });
            assert_eq!(again, got, "{set}");
        }
        for (row, got) in got.chunks_exact(width).enumerate() {
            let exact = |i: usize| f64::from(scores[row * width + i] + bias[row * width + i]).exp();
            let sum: f64 = (0..width).map(exact).sum();
            for (i, got) in got.iter().enumerate() {
                assert!((f64::from(*got) - exact(i) / sum).abs() < 3e-7, "row {row}, {i}: {got}");
            }
            assert!(got[width - 3..].iter().all(|weight| *weight < 1e-37));
        }
    }
}
