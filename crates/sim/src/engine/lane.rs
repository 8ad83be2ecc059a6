//! Numbers of several environments at once: one environment per lane of a SIMD vector.
//!
//! A [`Lane`] is an array whose operations are written element by element; compiled for the machine
//! (`.cargo/config.toml`: `target-cpu=native`) each is one vector instruction. No lane ever sees another, so an
//! environment's numbers do not depend on its neighbours.

use std::fmt::Debug;
use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

use lifelike_simd::Number;

/// A number type of lanes: `f32` to be fast, `f64` to be compared.
pub trait Scalar: Number + PartialOrd + Default + Debug + Send + Sync + 'static {
    /// Rounded from double precision.
    fn new(value: f64) -> Self;
    /// In double precision.
    fn to_f64(self) -> f64;
    /// `self * a + b`, rounded once.
    fn mul_add(self, a: Self, b: Self) -> Self;
    /// Square root.
    fn sqrt(self) -> Self;
    /// Sine and cosine.
    fn sin_cos(self) -> (Self, Self);
}

impl Scalar for f64 {
    fn new(value: f64) -> Self {
        value
    }
    fn to_f64(self) -> f64 {
        self
    }
    #[inline(always)]
    fn mul_add(self, a: Self, b: Self) -> Self {
        self.mul_add(a, b)
    }
    fn sqrt(self) -> Self {
        self.sqrt()
    }
    fn sin_cos(self) -> (Self, Self) {
        self.sin_cos()
    }
}

impl Scalar for f32 {
    #[inline(always)]
    fn new(value: f64) -> Self {
        value as f32
    }
    fn to_f64(self) -> f64 {
        self.into()
    }
    #[inline(always)]
    fn mul_add(self, a: Self, b: Self) -> Self {
        self.mul_add(a, b)
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        self.sqrt()
    }
    /// Taylor polynomials of half the angle, brought into ±π first, and a doubling: no branches, so that a loop over lanes
    /// becomes vector instructions. Within 5e-7 for angles up to 100.
    #[inline(always)]
    fn sin_cos(self) -> (Self, Self) {
        const TURN: f32 = std::f32::consts::TAU;
        // TURN rounded, and what rounding took away.
        const REST: f32 = -1.748_455_6e-7;
        let polynomial = |y: f32, coefficients: [f64; 6]| {
            coefficients.into_iter().rev().fold(0.0, |sum: f32, c| sum.mul_add(y, (1.0 / c) as f32))
        };
        let turns = (self * (1.0 / TURN)).round_ties_even();
        let x = 0.5 * (-turns).mul_add(REST, (-turns).mul_add(TURN, self));
        let y = x * x;
        let sin = (x * y).mul_add(polynomial(y, [-6.0, 120.0, -5040.0, 362_880.0, -39_916_800.0, 6_227_020_800.0]), x);
        // 1 - cos, so that small angles keep their digits.
        let versed = y * polynomial(y, [2.0, -24.0, 720.0, -40_320.0, 3_628_800.0, -479_001_600.0]);
        (2.0 * sin * (1.0 - versed), 1.0 - 2.0 * sin * sin)
    }
}

/// One number of `W` environments.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(32))]
pub struct Lane<T, const W: usize>(pub [T; W]);

impl<T: Scalar, const W: usize> Lane<T, W> {
    /// The same in every lane.
    #[inline(always)]
    pub fn splat(value: T) -> Self {
        Self([value; W])
    }

    /// The same in every lane, rounded from double precision.
    #[inline(always)]
    pub fn splat_f64(value: f64) -> Self {
        Self([T::new(value); W])
    }

    /// Zero in every lane.
    #[inline(always)]
    pub fn zero() -> Self {
        Self::splat(T::default())
    }

    /// `f` of each lane.
    #[inline(always)]
    pub fn map(self, f: impl Fn(T) -> T) -> Self {
        let mut out = self.0;
        for x in &mut out {
            *x = f(*x);
        }
        Self(out)
    }

    /// `f` of each pair of lanes.
    #[inline(always)]
    pub fn zip(self, other: Self, f: impl Fn(T, T) -> T) -> Self {
        let mut out = self.0;
        for i in 0..W {
            out[i] = f(out[i], other.0[i]);
        }
        Self(out)
    }

    /// `self + a * b`, rounded once. Not named `mul_add`, which elsewhere means `self * a + b`.
    #[inline(always)]
    pub fn add_mul(self, a: Self, b: Self) -> Self {
        let mut out = self.0;
        for i in 0..W {
            out[i] = a.0[i].mul_add(b.0[i], out[i]);
        }
        Self(out)
    }

    /// `self - a * b`, rounded once.
    #[inline(always)]
    pub fn sub_mul(self, a: Self, b: Self) -> Self {
        let mut out = self.0;
        for i in 0..W {
            out[i] = (-a.0[i]).mul_add(b.0[i], out[i]);
        }
        Self(out)
    }

    /// `self > limit ? yes : no`, lane by lane. NaN is not greater.
    #[inline(always)]
    pub fn select_gt(self, limit: Self, yes: Self, no: Self) -> Self {
        let mut out = no.0;
        for i in 0..W {
            out[i] = if self.0[i] > limit.0[i] { yes.0[i] } else { no.0[i] };
        }
        Self(out)
    }

    /// The smaller of each pair of lanes.
    #[inline(always)]
    pub fn min(self, other: Self) -> Self {
        self.zip(other, T::least)
    }

    /// The larger of each pair of lanes.
    #[inline(always)]
    pub fn max(self, other: Self) -> Self {
        self.zip(other, T::most)
    }

    /// Square root.
    #[inline(always)]
    pub fn sqrt(self) -> Self {
        self.map(T::sqrt)
    }

    /// 1 / self.
    #[inline(always)]
    pub fn recip(self) -> Self {
        self.map(|x| T::new(1.0) / x)
    }

    /// Sine and cosine.
    #[inline(always)]
    pub fn sin_cos(self) -> (Self, Self) {
        let (mut sin, mut cos) = (self.0, self.0);
        for i in 0..W {
            (sin[i], cos[i]) = self.0[i].sin_cos();
        }
        (Self(sin), Self(cos))
    }

    /// Returns true when any lane is above zero.
    #[inline(always)]
    pub fn any_positive(self) -> bool {
        let mut any = false;
        for x in self.0 {
            any |= x > T::default();
        }
        any
    }
}

macro_rules! operator {
    ($trait:ident, $method:ident, $op:tt) => {
        impl<T: Scalar, const W: usize> $trait for Lane<T, W> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                self.zip(other, |a, b| a $op b)
            }
        }
    };
}
operator!(Add, add, +);
operator!(Sub, sub, -);
operator!(Mul, mul, *);
operator!(Div, div, /);

impl<T: Scalar, const W: usize> Neg for Lane<T, W> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        self.map(|x| -x)
    }
}

impl<T: Scalar, const W: usize> AddAssign for Lane<T, W> {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl<T: Scalar, const W: usize> SubAssign for Lane<T, W> {
    #[inline(always)]
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}

impl<T: Scalar, const W: usize> Number for Lane<T, W> {
    #[inline(always)]
    fn from_f64(value: f64) -> Self {
        Self::splat_f64(value)
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
        self.map(T::tanh)
    }
    #[inline(always)]
    fn tanh_ratio(self) -> Self {
        self.map(T::tanh_ratio)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn single_precision_sine_and_cosine() {
        let mut worst = 0.0_f64;
        for i in -100_000..100_000 {
            let x = i as f32 * 1e-3;
            let (s, c) = Scalar::sin_cos(x);
            let (es, ec) = f64::from(x).sin_cos();
            worst = worst.max((f64::from(s) - es).abs()).max((f64::from(c) - ec).abs());
        }
        assert!(worst < 5e-7, "{worst}");
        for exponent in 1..30 {
            let x = 0.1_f32.powi(exponent);
            assert!((Scalar::sin_cos(x).0 / x - 1.0).abs() < 2e-3 * x * x + 2e-7 + 0.17 * x * x);
        }
    }

    #[test]
    fn lanes_do_not_see_each_other() {
        let a = Lane([f32::NAN, 1.0, f32::INFINITY, -2.0]);
        let b = Lane([1.0, 2.0, 0.0, 4.0]);
        let c = (a * b + b).add_mul(a, b);
        assert_eq!((c.0[1], c.0[3]), (6.0, -12.0));
        assert_eq!(a.select_gt(Lane::zero(), Lane::splat_f64(1.0), Lane::splat_f64(-1.0)).0, [-1.0, 1.0, 1.0, -1.0]);
    }
}
