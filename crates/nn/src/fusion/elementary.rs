//! Functions of single numbers, written so that loops over them become vector instructions.

use crate::rows::elementary::exp;

/// 1 / (1 + e⁻ˣ).
#[inline(always)]
pub(super) fn sigmoid(x: f32) -> f32 {
    1.0 / (1.0 + exp(-x))
}

/// tanh x, to 2e-7 absolute.
#[inline(always)]
pub(super) fn tanh(x: f32) -> f32 {
    // exp is good up to 88; beyond 9 the result is 1 to the last digit.
    let x = x.clamp(-9.0, 9.0);
    1.0 - 2.0 / (exp(2.0 * x) + 1.0)
}

/// x for positive x, eˣ - 1 for others.
#[inline(always)]
pub(super) fn elu(x: f32) -> f32 {
    if x > 0.0 { x } else { exp(x) - 1.0 }
}

/// Derivative of [`elu`].
#[inline(always)]
pub(super) fn elu_gradient(x: f32) -> f32 {
    if x > 0.0 { 1.0 } else { exp(x) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn they_are_those_of_double_precision() {
        for i in -3000..3000 {
            let x = i as f32 * 0.01;
            let double = f64::from(x);
            assert!((f64::from(sigmoid(x)) - 1.0 / (1.0 + (-double).exp())).abs() < 3e-7, "sigmoid({x})");
            assert!((f64::from(tanh(x)) - double.tanh()).abs() < 3e-7, "tanh({x})");
            let expected = if double > 0.0 { double } else { double.exp_m1() };
            // exp itself is off by at most 2.5e-7 of its value, which is at most 1 here.
            assert!((f64::from(elu(x)) - expected).abs() < 3e-7 * expected.abs().max(1.0), "elu({x})");
        }
        assert!(tanh(1e30) <= 1.0 && tanh(-1e30) >= -1.0 && sigmoid(1e30) == 1.0, "nothing overflows");
    }
}
