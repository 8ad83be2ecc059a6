//! One step of Adam (Kingma & Ba 2015, Algorithm 1) on plain numbers, with PyTorch's formulas and roundings.

use lifelike_simd::{InstructionSet, Simd, Task, prelude::*};
use rayon::prelude::*;

/// Numbers that a thread takes at a time, and whose squares are summed in single precision.
const SHARE: usize = 1 << 13;
/// Partial sums of squares.
const LANES: usize = 16;

/// Constants of one step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AdamStep {
    /// Decay of the first moment.
    pub beta_1: f64,
    /// Decay of the second moment.
    pub beta_2: f64,
    /// Added to the root of the second moment.
    pub epsilon: f64,
    /// Number of the step, from 1.
    pub step: u64,
    /// Learning rate.
    pub rate: f64,
    /// Factor of the gradient: what clipping its norm leaves of it.
    pub scale: f64,
}

/// Arrays of a step, all of one length.
#[derive(Debug)]
pub struct Slices<'a> {
    /// Parameters.
    pub values: &'a mut [f32],
    /// Gradient.
    pub gradient: &'a [f32],
    /// First moments.
    pub first: &'a mut [f32],
    /// Second moments.
    pub second: &'a mut [f32],
}

impl AdamStep {
    /// Takes the step, on all threads.
    ///
    /// # Panics
    /// The slices have different lengths.
    pub fn take(&self, set: InstructionSet, slices: Slices<'_>) {
        let Slices { values, gradient, first, second } = slices;
        let n = values.len();
        assert_eq!((gradient.len(), first.len(), second.len()), (n, n, n), "lengths of a step of Adam");
        let t = self.step as f64;
        let (bias_1, bias_2) = (1.0 - self.beta_1.powf(t), 1.0 - self.beta_2.powf(t));
        let constants = Constants {
            scale: self.scale as f32,
            beta_1: [self.beta_1 as f32, (1.0 - self.beta_1) as f32],
            beta_2: [self.beta_2 as f32, (1.0 - self.beta_2) as f32],
            root: bias_2.sqrt() as f32,
            epsilon: self.epsilon as f32,
            rate: (self.rate / bias_1) as f32,
        };
        let moments = first.par_chunks_mut(SHARE).zip(second.par_chunks_mut(SHARE));
        let shares = values.par_chunks_mut(SHARE).zip(gradient.par_chunks(SHARE)).zip(moments);
        shares.for_each(|((values, gradient), (first, second))| {
            set.run(Step { constants, slices: Slices { values, gradient, first, second } });
        });
    }
}

struct Step<'a> {
    constants: Constants,
    slices: Slices<'a>,
}

/// The constants of a step as its operations take them.
#[derive(Clone, Copy)]
struct Constants {
    scale: f32,
    beta_1: [f32; 2],
    beta_2: [f32; 2],
    root: f32,
    epsilon: f32,
    rate: f32,
}

impl Task for Step<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let Self { constants: c, slices: Slices { values, gradient, first, second } } = self;
        let len = S::f32s::LEN;
        let whole = values.len() / len * len;
        for i in (0..whole).step_by(len) {
            let range = i..i + len;
            let at = |x: &[f32]| S::f32s::from_slice(simd, &x[range.clone()]);
            let stepped = c.update(simd, [at(values), at(gradient), at(first), at(second)]);
            stepped[0].store_slice(&mut values[range.clone()]);
            stepped[1].store_slice(&mut first[range.clone()]);
            stepped[2].store_slice(&mut second[range]);
        }
        for i in whole..values.len() {
            let splat = |x: f32| S::f32s::splat(simd, x);
            let stepped = c.update(simd, [values[i], gradient[i], first[i], second[i]].map(splat));
            [values[i], first[i], second[i]] = stepped.map(|x| x.as_slice()[0]);
        }
    }
}

impl Constants {
    /// Returns parameters and moments after the step. Every operation is rounded by itself, in PyTorch's order.
    #[inline(always)]
    fn update<S: Simd>(&self, simd: S, [value, gradient, first, second]: [S::f32s; 4]) -> [S::f32s; 3] {
        let splat = |x: f32| S::f32s::splat(simd, x);
        let gradient = gradient * splat(self.scale);
        let first = first * splat(self.beta_1[0]) + gradient * splat(self.beta_1[1]);
        let second = second * splat(self.beta_2[0]) + gradient * gradient * splat(self.beta_2[1]);
        let denominator = second.sqrt() / splat(self.root) + splat(self.epsilon);
        [value - first / denominator * splat(self.rate), first, second]
    }
}

/// Returns the Euclidean norm. NaN or infinite when any number is.
pub fn norm(set: InstructionSet, values: &[f32]) -> f64 {
    let squares: Vec<f64> = values.par_chunks(SHARE).map(|values| set.run(Squares(values))).collect();
    squares.into_iter().sum::<f64>().sqrt()
}

struct Squares<'a>(&'a [f32]);

impl Task for Squares<'_> {
    type Output = f64;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> f64 {
        let (groups, rest) = self.0.as_chunks::<LANES>();
        let mut lanes = [0.0_f32; LANES];
        for (part, lanes) in lanes.chunks_exact_mut(S::f32s::LEN).enumerate() {
            let mut sum = S::f32s::splat(simd, 0.0);
            for group in groups {
                let x = S::f32s::from_slice(simd, &group[part * S::f32s::LEN..][..S::f32s::LEN]);
                sum = x.mul_add_precise(x, sum);
            }
            sum.store_slice(lanes);
        }
        lanes.iter().map(|x| f64::from(*x)).chain(rest.iter().map(|x| f64::from(*x).powi(2))).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_first_step_goes_by_the_learning_rate_on_every_instruction_set_alike() {
        let gradient: Vec<f32> = (0..100).map(|i| (i as f32 - 40.3) * 0.37).collect();
        let mut expected: Option<Vec<f32>> = None;
        for set in InstructionSet::available() {
            let (mut values, mut first, mut second) = (vec![1.0; 100], vec![0.0; 100], vec![0.0; 100]);
            let step = AdamStep { beta_1: 0.9, beta_2: 0.999, epsilon: 1e-8, step: 1, rate: 1e-3, scale: 0.5 };
            let (first, second) = (&mut first, &mut second);
            step.take(set, Slices { values: &mut values, gradient: &gradient, first, second });
            for (x, g) in values.iter().zip(&gradient) {
                assert!((x - (1.0 - 1e-3 * g.signum())).abs() < 1e-6, "{g}: {x}");
            }
            assert_eq!(*expected.get_or_insert(values.clone()), values, "{set}");
            let exact = gradient.iter().map(|g| f64::from(*g).powi(2)).sum::<f64>().sqrt();
            assert!((norm(set, &gradient) - exact).abs() < 1e-6 * exact);
        }
    }
}
