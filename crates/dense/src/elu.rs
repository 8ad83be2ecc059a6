//! The exponential linear unit of Clevert et al. 2016, for one number and for a vector: the same bits.

use lifelike_simd::{Simd, prelude::*};

/// Below this exp(x) is no normal number; as an ELU it is −1 long before.
const LEAST: f32 = -87.0;
/// Adding and taking away 1.5 · 2²³ rounds to the nearest whole number, which the sum has in its last bits.
const MAGIC: f32 = 12_582_912.0;
/// −ln 2 in two parts, the first with zeros at its end (Cephes).
const LN_2: [f32; 2] = [-0.693_359_4, 2.121_944_4e-4];
/// The polynomial for (exp(r) − 1 − r) / r², |r| ≤ ½ ln 2 (Cephes), highest power first.
const POLYNOMIAL: [f32; 6] = [1.987_569_1e-4, 1.398_199_9e-3, 8.333_452e-3, 4.166_579_6e-2, 1.666_666_5e-1, 5e-1];

/// Returns x above zero, exp(x) − 1 below, within 1.5e-7; NaN for NaN.
#[inline]
pub fn elu(x: f32) -> f32 {
    if x <= 0.0 { exp_of_nonpositive(x) - 1.0 } else { x }
}

/// Returns exp(x) for x ≤ 0 to about one unit in the last place, in operations that vectors have too:
/// x = n ln 2 + r, a polynomial for exp(r), and the exponent n put together from bits.
#[inline]
fn exp_of_nonpositive(x: f32) -> f32 {
    let x = if x > LEAST { x } else { LEAST };
    let whole = x * std::f32::consts::LOG2_E + MAGIC;
    let n = whole - MAGIC;
    let r = n.mul_add(LN_2[1], n.mul_add(LN_2[0], x));
    let [mut p, rest @ ..] = POLYNOMIAL;
    for c in rest {
        p = p.mul_add(r, c);
    }
    let p = p.mul_add(r * r, r) + 1.0;
    p * f32::from_bits((whole.to_bits() << 23).wrapping_add(127 << 23))
}

/// Returns [`elu`] of each number, bit for bit.
#[inline(always)]
pub fn elu_of_vector<S: Simd>(simd: S, x: S::f32s) -> S::f32s {
    let splat = |c: f32| S::f32s::splat(simd, c);
    let (zero, one) = (splat(0.0), splat(1.0));
    let least = splat(LEAST);
    // Positive numbers go along as zeros, so that nothing overflows.
    let below = x.simd_le(zero);
    let y = x.simd_gt(least).select(below.select(x, zero), least);
    let whole = y * splat(std::f32::consts::LOG2_E) + splat(MAGIC);
    let n = whole - splat(MAGIC);
    let r = n.mul_add_precise(splat(LN_2[1]), n.mul_add_precise(splat(LN_2[0]), y));
    let mut p = splat(POLYNOMIAL[0]);
    for c in &POLYNOMIAL[1..] {
        p = p.mul_add_precise(r, splat(*c));
    }
    let p = p.mul_add_precise(r * r, r) + one;
    let bits: S::u32s = whole.bitcast();
    let power: S::f32s = ((bits << 23) + S::u32s::splat(simd, 127 << 23)).bitcast();
    below.select(p * power - one, x)
}

/// Returns the derivative of the ELU where its value is h: 1 above zero, exp(x) = h + 1 below.
#[inline(always)]
pub(crate) fn slope_of_vector<S: Simd>(simd: S, h: S::f32s) -> S::f32s {
    let zero = S::f32s::splat(simd, 0.0);
    h.simd_lt(zero).select(h, zero) + S::f32s::splat(simd, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use lifelike_simd::{InstructionSet, Task};

    #[test]
    fn the_exponential_is_right_to_the_last_digits() {
        for i in 0..200_000 {
            let x = -i as f32 * 4.3e-4;
            let (got, exact) = (f64::from(exp_of_nonpositive(x)), f64::from(x).exp());
            assert!((got - exact).abs() <= 1.5e-7 * exact, "exp({x}) = {got}, not {exact}");
        }
        assert_eq!((elu(0.0), elu(2.5), elu(f32::NEG_INFINITY)), (0.0, 2.5, -1.0));
        assert!(elu(-1e-3) < 0.0 && elu(f32::MAX) == f32::MAX && elu(f32::NAN).is_nan());
    }

    struct Elus<'a>(&'a mut [f32]);

    impl Task for Elus<'_> {
        type Output = ();
        #[inline(always)]
        fn run<S: Simd>(self, simd: S) {
            for x in self.0.chunks_exact_mut(S::f32s::LEN) {
                elu_of_vector(simd, S::f32s::from_slice(simd, x)).store_slice(x);
            }
        }
    }

    #[test]
    fn vectors_give_the_scalars_bits() {
        let mut x: Vec<f32> = (0..16_000).map(|i| (i as f32 - 15_000.0) * 6.1e-3).collect();
        x[..8].copy_from_slice(&[0.0, -0.0, f32::INFINITY, f32::NEG_INFINITY, f32::MAX, f32::MIN, -1e-30, 1e-30]);
        let expected: Vec<u32> = x.iter().map(|x| elu(*x).to_bits()).collect();
        for set in InstructionSet::available() {
            let mut got = x.clone();
            set.run(Elus(&mut got));
            assert!(got.iter().map(|y| y.to_bits()).eq(expected.iter().copied()), "{set}");
            let mut nan = [f32::NAN; 16];
            set.run(Elus(&mut nan));
            assert!(nan.iter().all(|y| y.is_nan()), "{set}");
        }
    }
}
