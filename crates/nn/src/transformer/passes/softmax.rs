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
        *greatest = reduced(lanes::<S, V>(most), |x, y| if x > y { x } else { y });
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
        *share = 1.0 / reduced(lanes::<S, V>(sums), |x, y| x + y);
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

/// The gradient by scores from the one by their weights, in place: w (g − Σ w g), Σ over a row of `width` numbers.
pub(super) fn through_softmax(weights: &[f32], gradients: &mut [f32], width: usize) {
    InstructionSet::chosen().run(Through { weights, gradients, width });
}

struct Through<'a> {
    weights: &'a [f32],
    gradients: &'a mut [f32],
    width: usize,
}

impl Task for Through<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let together = ROWS * self.width;
        for (weights, gradients) in self.weights.chunks(together).zip(self.gradients.chunks_mut(together)) {
            match S::f32s::LEN {
                16 => rows_back::<S, 1>(simd, weights, gradients, self.width),
                8 => rows_back::<S, 2>(simd, weights, gradients, self.width),
                _ => rows_back::<S, 4>(simd, weights, gradients, self.width),
            }
        }
    }
}

/// As [`rows`], for the way back.
#[inline(always)]
fn rows_back<S: Simd, const V: usize>(simd: S, weights: &[f32], gradients: &mut [f32], width: usize) {
    let length = S::f32s::LEN;
    let load = |numbers: &[f32]| S::f32s::from_slice(simd, numbers);
    let mut along = [0.0; ROWS];
    let rows = weights.chunks_exact(width).zip(gradients.chunks_exact(width));
    for ((weights, gradients), along) in rows.zip(&mut along) {
        let mut sums = [S::f32s::splat(simd, 0.0); V];
        for (weights, gradients) in weights.chunks_exact(LANES).zip(gradients.chunks_exact(LANES)) {
            let vectors = weights.chunks_exact(length).zip(gradients.chunks_exact(length));
            for ((weights, gradients), sum) in vectors.zip(&mut sums) {
                *sum = load(weights).mul_add_precise(load(gradients), *sum);
            }
        }
        *along = reduced(lanes::<S, V>(sums), |x, y| x + y);
    }
    let rows = weights.chunks_exact(width).zip(gradients.chunks_exact_mut(width));
    for ((weights, gradients), along) in rows.zip(along) {
        for (weights, gradients) in weights.chunks_exact(length).zip(gradients.chunks_exact_mut(length)) {
            (load(weights) * (load(gradients) - S::f32s::splat(simd, along))).store_slice(gradients);
        }
    }
}

/// Returns the numbers of vectors that are a panel together.
#[inline(always)]
fn lanes<S: Simd, const N: usize>(vectors: [S::f32s; N]) -> [f32; LANES] {
    let mut lanes = [0.0; LANES];
    lanes.chunks_exact_mut(LANES / N).zip(vectors).for_each(|(lanes, vector)| vector.store_slice(lanes));
    lanes
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
            assert!(got[width - 3..].iter().all(|weight| *weight == 0.0));
        }
    }

    #[test]
    fn gradients_through_softmax_are_those_of_double_precision_with_every_instruction_set() {
        let width = 2 * LANES;
        let number = |i: usize| ((i * 37) % 101) as f32 * 0.02 - 1.0;
        let gradients: Vec<f32> = (0..5 * width).map(number).collect();
        let weights: Vec<f32> = (0..5 * width).map(|i| (number(i * i) + 1.0) / width as f32).collect();
        let mut got = gradients.clone();
        through_softmax(&weights, &mut got, width);
        for set in InstructionSet::available() {
            let mut again = gradients.clone();
            set.run(Through { weights: &weights, gradients: &mut again, width });
            assert_eq!(again, got, "{set}");
        }
        for (row, got) in got.chunks_exact(width).enumerate() {
            let at = |i: usize| (f64::from(weights[row * width + i]), f64::from(gradients[row * width + i]));
            let along: f64 = (0..width).map(at).map(|(w, g)| w * g).sum();
            for (i, got) in got.iter().enumerate() {
                let (w, g) = at(i);
                assert!((f64::from(*got) - w * (g - along)).abs() < 1e-7, "row {row}, {i}: {got}");
            }
        }
    }
}
