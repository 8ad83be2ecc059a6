//! exp and sums written so that the compiler makes vector instructions of loops over them: the C library's take one number at a
//! time and were a third of a training step.

use lifelike_simd::{Simd, prelude::*};

use super::tile::LANES;

/// x y + z, rounded once.
#[inline(always)]
pub(crate) fn fma(x: f32, y: f32, z: f32) -> f32 {
    x.mul_add(y, z)
}

/// Σ x y, in lanes.
#[inline(always)]
pub(crate) fn dot(x: &[f32], y: &[f32]) -> f32 {
    let mut sums = [0.0_f32; LANES];
    let (x_lanes, x_rest) = x.as_chunks::<LANES>();
    let (y_lanes, y_rest) = y.as_chunks::<LANES>();
    for (x, y) in x_lanes.iter().zip(y_lanes) {
        for ((sum, x), y) in sums.iter_mut().zip(x).zip(y) {
            *sum += x * y;
        }
    }
    sums.iter().sum::<f32>() + x_rest.iter().zip(y_rest).map(|(x, y)| x * y).sum::<f32>()
}

// exp(x) = 2^n exp(r) with |r| ≤ ln 2 / 2.
/// Below this exp is 0. e^-50 changes no sum beside 1. Products with much smaller numbers fall below single
/// precision's normal ones, with which processors compute tens of times as slowly: trainings whose attention had
/// become sharp took more than twice as long.
const LEAST: f32 = -50.0;
/// Adding 1.5 · 2^23 leaves the nearest whole number in the lowest bits.
const SHIFT: f32 = 12_582_912.0;
/// −ln 2 in two parts, the first exact when multiplied by n.
const LN_2: [f32; 2] = [-0.693_145_75, -1.428_606_8e-6];
/// Taylor's, highest power first: the first term left out is below 4e-9.
const TAYLOR: [f32; 8] = [1.0 / 5040.0, 1.0 / 720.0, 1.0 / 120.0, 1.0 / 24.0, 1.0 / 6.0, 0.5, 1.0, 1.0];

/// exp(x) to 2 units in the last place, for x from −50 up to 88; 0 below.
#[inline(always)]
pub(crate) fn exp(x: f32) -> f32 {
    let shifted = fma(x, std::f32::consts::LOG2_E, SHIFT);
    let n = shifted - SHIFT;
    let r = fma(n, LN_2[1], fma(n, LN_2[0], x));
    let [mut p, rest @ ..] = TAYLOR;
    for c in rest {
        p = fma(p, r, c);
    }
    let y = p * f32::from_bits((shifted.to_bits() << 23).wrapping_add(0x3f80_0000));
    if x > LEAST { y } else { 0.0 }
}

/// [`exp`] of each number, bit for bit.
#[inline(always)]
pub(crate) fn exp_of_vector<S: Simd>(simd: S, x: S::f32s) -> S::f32s {
    let splat = |c: f32| S::f32s::splat(simd, c);
    let shifted = x.mul_add_precise(splat(std::f32::consts::LOG2_E), splat(SHIFT));
    let n = shifted - splat(SHIFT);
    let r = n.mul_add_precise(splat(LN_2[1]), n.mul_add_precise(splat(LN_2[0]), x));
    let mut p = splat(TAYLOR[0]);
    for c in &TAYLOR[1..] {
        p = p.mul_add_precise(r, splat(*c));
    }
    let bits: S::u32s = shifted.bitcast();
    let power: S::f32s = ((bits << 23) + S::u32s::splat(simd, 0x3f80_0000)).bitcast();
    x.simd_gt(splat(LEAST)).select(p * power, splat(0.0))
}

#[cfg(test)]
mod tests {
    use lifelike_simd::{InstructionSet, Task};

    use super::*;

    #[test]
    fn exp_is_that_of_double_precision() {
        for i in -4_999..8_800 {
            let x = i as f32 * 0.01;
            let expected = f64::from(x).exp();
            assert!((f64::from(exp(x)) / expected - 1.0).abs() < 2.5e-7, "exp({x}) = {}", exp(x));
        }
        assert_eq!(exp(0.0), 1.0);
        assert_eq!([f32::NEG_INFINITY, -1e30, -50.1].map(exp), [0.0; 3]);
    }

    #[test]
    fn exp_of_a_vector_is_that_of_its_numbers() {
        struct Exp<'a>(&'a mut [f32]);
        impl Task for Exp<'_> {
            type Output = ();
            #[inline(always)]
            fn run<S: Simd>(self, simd: S) {
                for x in self.0.chunks_exact_mut(S::f32s::LEN) {
                    exp_of_vector(simd, S::f32s::from_slice(simd, x)).store_slice(x);
                }
            }
        }
        let numbers: Vec<f32> = (0..16_000).map(|i| 0.011 * (i as f32 - 8_000.0)).collect();
        let expected: Vec<f32> = numbers.iter().map(|x| exp(*x)).collect();
        for set in InstructionSet::available() {
            let mut got = numbers.clone();
            set.run(Exp(&mut got));
            assert_eq!(got, expected, "{set}");
        }
    }
}
