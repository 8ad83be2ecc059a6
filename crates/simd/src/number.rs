//! A number, or the same number of many environments at once.

use std::ops::{Add, Div, Mul, Neg, Sub};

/// Number type that a law is written for once: `f32`, `f64`, or the same number of several environments at once.
///
/// The functions that are given are those of single precision, so that a vector has the bits of a scalar.
pub trait Number:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self> + Neg<Output = Self>
{
    /// Returns the nearest number.
    fn from_f64(value: f64) -> Self;
    /// Returns the smaller of the two.
    #[must_use]
    fn least(self, other: Self) -> Self;
    /// Returns the larger of the two.
    #[must_use]
    fn most(self, other: Self) -> Self;
    /// Returns the hyperbolic tangent.
    #[inline(always)]
    #[must_use]
    fn tanh(self) -> Self {
        self * self.tanh_ratio()
    }
    /// Returns tanh(x) / x, which is one at zero.
    #[inline(always)]
    #[must_use]
    fn tanh_ratio(self) -> Self {
        tanh_ratio(self)
    }
    /// Returns `self > limit ? yes : no`. NaN is not greater.
    #[must_use]
    fn select_gt(self, limit: Self, yes: Self, no: Self) -> Self;
    /// Returns the square root.
    #[must_use]
    fn sqrt(self) -> Self;
    /// Returns the exponential.
    #[inline(always)]
    #[must_use]
    fn exp(self) -> Self {
        exp(self)
    }
    /// Returns a positive number to the power of another.
    #[inline(always)]
    #[must_use]
    fn powf(self, exponent: Self) -> Self {
        powf(self, exponent)
    }
}

impl Number for f64 {
    #[inline(always)]
    fn from_f64(value: f64) -> Self {
        value
    }
    #[inline(always)]
    fn least(self, other: Self) -> Self {
        self.min(other)
    }
    #[inline(always)]
    fn most(self, other: Self) -> Self {
        self.max(other)
    }
    #[inline(always)]
    fn tanh(self) -> Self {
        self.tanh()
    }
    #[inline(always)]
    fn tanh_ratio(self) -> Self {
        if self.abs() < 1e-4 { 1.0 } else { self.tanh() / self }
    }
    #[inline(always)]
    fn select_gt(self, limit: Self, yes: Self, no: Self) -> Self {
        if self > limit { yes } else { no }
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        self.sqrt()
    }
    #[inline(always)]
    fn exp(self) -> Self {
        self.exp()
    }
    #[inline(always)]
    fn powf(self, exponent: Self) -> Self {
        self.powf(exponent)
    }
}

impl Number for f32 {
    #[inline(always)]
    fn from_f64(value: f64) -> Self {
        value as f32
    }
    #[inline(always)]
    fn least(self, other: Self) -> Self {
        if self < other { self } else { other }
    }
    #[inline(always)]
    fn most(self, other: Self) -> Self {
        if self > other { self } else { other }
    }
    #[inline(always)]
    fn select_gt(self, limit: Self, yes: Self, no: Self) -> Self {
        if self > limit { yes } else { no }
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        self.sqrt()
    }
}

/// Returns the exponential in single precision: Taylor's polynomial of a 256th of the number, and eight squarings. No branch.
/// Within 3e-5 of the result between -80 and 80, where numbers beyond end.
#[inline(always)]
fn exp<N: Number>(number: N) -> N {
    let one = N::from_f64(1.0);
    let x = number.most(N::from_f64(-80.0)).least(N::from_f64(80.0)) * N::from_f64(1.0 / 256.0);
    let mut power = one;
    for k in (1..=7).rev() {
        power = one + x * power * N::from_f64(1.0 / f64::from(k));
    }
    for _ in 0..8 {
        power = power * power;
    }
    power
}

/// Returns a number to the power of another in single precision, by [`exp`] and the series of atanh of its 64th root. No branch.
/// Within 1e-4 of the result for numbers from 1e-12 on and exponents up to 10; 1e-12 stands for those below.
#[inline(always)]
fn powf<N: Number>(number: N, exponent: N) -> N {
    let one = N::from_f64(1.0);
    let mut root = number.most(N::from_f64(1e-12));
    for _ in 0..6 {
        root = root.sqrt();
    }
    let t = (root - one) / (root + one);
    let mut series = N::from_f64(0.0);
    for k in (0..6).rev() {
        series = series * t * t + N::from_f64(1.0 / f64::from(2 * k + 1));
    }
    exp(exponent * (N::from_f64(128.0) * t * series))
}

/// Returns tanh(x) / x in single precision: the quotient of polynomials that Eigen uses (`generic_fast_tanh_float`) up to
/// 7.9, 1 / |x| beyond. No branch, so it serves vectors too. Within 1e-6.
#[inline(always)]
fn tanh_ratio<N: Number>(number: N) -> N {
    const ABOVE: [f64; 7] =
        [-2.760_768_5e-16, 2.000_188e-13, -8.604_672e-11, 5.122_297e-8, 1.485_722_4e-5, 6.372_619_5e-4, 4.893_524_6e-3];
    const BELOW: [f64; 4] = [1.198_258_4e-6, 1.185_347_1e-4, 2.268_434_6e-3, 4.893_525_3e-3];
    let size = number.most(-number).most(N::from_f64(1e-20));
    let x = size.least(N::from_f64(7.905_311));
    let y = x * x;
    let (mut above, mut below) = (N::from_f64(ABOVE[0]), N::from_f64(BELOW[0]));
    for c in &ABOVE[1..] {
        above = above * y + N::from_f64(*c);
    }
    for c in &BELOW[1..] {
        below = below * y + N::from_f64(*c);
    }
    above / below * (x / size)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn single_precision_tanh_over_x() {
        for exponent in -300..60 {
            let x = 10.0_f32.powf(exponent as f32 * 0.1);
            let expected = if x < 1e-4 { 1.0 } else { f64::from(x).tanh() / f64::from(x) };
            for x in [x, -x] {
                assert!((f64::from(x.tanh_ratio()) / expected - 1.0).abs() < 1e-6, "{x}");
            }
        }
        assert_eq!((0.0_f32.tanh_ratio() * 1e6).round(), 1e6);
    }

    #[test]
    fn single_precision_powers() {
        for i in -800..=800 {
            let x = i as f32 * 0.1;
            assert!((f64::from(exp(x)) / f64::from(x).exp() - 1.0).abs() < 3e-5, "exp({x})");
        }
        assert_eq!((exp(-1e9_f32), exp(1e9_f32)), (exp(-80.0), exp(80.0)));
        for exponent in [0.5_f32, 1.0, 1.35, 2.0, 8.7, 10.0] {
            for i in -60..=10 {
                let x = 10.0_f32.powf(i as f32 * 0.1);
                let expected = f64::from(x).powf(exponent.into());
                if expected > 1e-30 && expected < 1e30 {
                    let got = f64::from(powf(x, exponent));
                    assert!((got / expected - 1.0).abs() < 1e-4, "{x}^{exponent}: {got}, expected {expected}");
                }
            }
        }
        assert!(powf(0.0_f32, 2.0) < 1e-20);
    }
}
