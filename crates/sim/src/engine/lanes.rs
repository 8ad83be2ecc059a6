//! Numbers of several environments at once: one environment per lane of a vector.
//!
//! [`Lanes`] is what the engine computes with. Three things are lanes: one scalar (of double precision, to be compared
//! with oracles), a [`Native`](super::native::Native) vector of an instruction set, and a [`Pair`](super::pair::Pair)
//! of whatever is lanes. So sixteen environments are one vector of AVX-512, or a pair of AVX2's. They are four of
//! SSE2's one after the other, and a pair of pairs of NEON's. No lane ever sees another, and all operations round
//! alike, so an environment's numbers depend neither on its neighbours nor on the instruction set.

use std::fmt::Debug;
use std::ops::{Add, AddAssign, Mul, SubAssign};

use lifelike_simd::{Number, vectorize};

/// Number of a lane: `f32` to be fast, `f64` to be compared.
pub trait Scalar:
    Copy + PartialOrd + Default + Debug + Send + Sync + Add<Output = Self> + Mul<Output = Self> + 'static
{
    /// Rounded from double precision.
    fn new(value: f64) -> Self;
    /// In double precision.
    fn to_f64(self) -> f64;
}

impl Scalar for f64 {
    #[inline(always)]
    fn new(value: f64) -> Self {
        value
    }
    #[inline(always)]
    fn to_f64(self) -> f64 {
        self
    }
}

impl Scalar for f32 {
    #[inline(always)]
    fn new(value: f64) -> Self {
        value as f32
    }
    #[inline(always)]
    fn to_f64(self) -> f64 {
        self.into()
    }
}

/// One number of [`Self::LANES`] environments.
///
/// All operations are `#[inline(always)]`, and so is what calls them in loops, up to a call of [`Self::vectorize`]: a function
/// of its own would be compiled without the instruction set.
pub trait Lanes: Number + AddAssign + SubAssign + Debug + Send + Sync + 'static {
    /// Number of a lane.
    type Scalar: Scalar;
    /// Environments.
    const LANES: usize;
    /// Calls a function that is compiled with the instructions of these lanes.
    fn vectorize<R>(f: impl FnOnce() -> R) -> R;
    /// The same in every lane.
    fn splat(value: Self::Scalar) -> Self;
    /// The number of one lane.
    fn lane(&self, lane: usize) -> Self::Scalar;
    /// Sets the number of one lane.
    fn set_lane(&mut self, lane: usize, value: Self::Scalar);
    /// Writes the numbers of all lanes.
    fn store(self, out: &mut [Self::Scalar]);
    /// Reads the numbers of all lanes.
    fn load(numbers: &[Self::Scalar]) -> Self;
    /// `self + a * b`, rounded once. Not named `mul_add`, which elsewhere means `self * a + b`.
    #[must_use]
    fn add_mul(self, a: Self, b: Self) -> Self;
    /// Sine and cosine.
    fn sin_cos(self) -> (Self, Self);
    /// Returns true when any lane is above zero.
    fn any_positive(self) -> bool;

    /// The same in every lane, rounded from double precision.
    #[inline(always)]
    fn splat_f64(value: f64) -> Self {
        Self::splat(Self::Scalar::new(value))
    }
    /// Zero in every lane.
    #[inline(always)]
    fn zero() -> Self {
        Self::splat_f64(0.0)
    }
    /// `self - a * b`, rounded once.
    #[inline(always)]
    #[must_use]
    fn sub_mul(self, a: Self, b: Self) -> Self {
        self.add_mul(-a, b)
    }
    /// The smaller of each pair of lanes; the other's where one is not a number.
    #[inline(always)]
    #[must_use]
    fn min(self, other: Self) -> Self {
        self.least(other)
    }
    /// The larger of each pair of lanes; the other's where one is not a number.
    #[inline(always)]
    #[must_use]
    fn max(self, other: Self) -> Self {
        self.most(other)
    }
    /// Its size.
    #[inline(always)]
    #[must_use]
    fn abs(self) -> Self {
        self.most(-self)
    }
    /// 1 / self.
    #[inline(always)]
    #[must_use]
    fn recip(self) -> Self {
        Self::splat_f64(1.0) / self
    }
    /// `f` of each lane, one after the other: for what is rare and has no vector instruction.
    #[inline(always)]
    #[must_use]
    fn map(self, f: impl Fn(Self::Scalar) -> Self::Scalar) -> Self {
        let mut out = self;
        for lane in 0..Self::LANES {
            out.set_lane(lane, f(self.lane(lane)));
        }
        out
    }
}

/// A scalar that is lanes: one of them.
pub trait SingleLane: Scalar + Number + AddAssign + SubAssign {
    /// Calls a function that is compiled with instructions for what these numbers need.
    #[inline(always)]
    fn call<R>(f: impl FnOnce() -> R) -> R {
        f()
    }
    /// `self * a + b`, rounded once.
    #[must_use]
    fn fused(self, a: Self, b: Self) -> Self;
    /// Sine and cosine.
    fn sine_and_cosine(self) -> (Self, Self);
}

impl SingleLane for f64 {
    #[inline(always)]
    fn call<R>(f: impl FnOnce() -> R) -> R {
        vectorize(f)
    }
    #[inline(always)]
    fn fused(self, a: Self, b: Self) -> Self {
        self.mul_add(a, b)
    }
    #[inline(always)]
    fn sine_and_cosine(self) -> (Self, Self) {
        self.sin_cos()
    }
}

impl SingleLane for f32 {
    #[inline(always)]
    fn fused(self, a: Self, b: Self) -> Self {
        self.mul_add(a, b)
    }
    #[inline(always)]
    fn sine_and_cosine(self) -> (Self, Self) {
        sin_cos(self, (self * PER_TURN).round_ties_even())
    }
}

impl<T: SingleLane> Lanes for T {
    type Scalar = T;
    const LANES: usize = 1;
    #[inline(always)]
    fn vectorize<R>(f: impl FnOnce() -> R) -> R {
        T::call(f)
    }
    #[inline(always)]
    fn splat(value: T) -> Self {
        value
    }
    #[inline(always)]
    fn lane(&self, _: usize) -> T {
        *self
    }
    #[inline(always)]
    fn set_lane(&mut self, _: usize, value: T) {
        *self = value;
    }
    #[inline(always)]
    fn store(self, out: &mut [T]) {
        out[0] = self;
    }
    #[inline(always)]
    fn load(numbers: &[T]) -> Self {
        numbers[0]
    }
    #[inline(always)]
    fn add_mul(self, a: Self, b: Self) -> Self {
        a.fused(b, self)
    }
    #[inline(always)]
    fn sin_cos(self) -> (Self, Self) {
        self.sine_and_cosine()
    }
    #[inline(always)]
    fn any_positive(self) -> bool {
        self > T::default()
    }
}

/// Turns of a radian.
pub const PER_TURN: f32 = 1.0 / std::f32::consts::TAU;

/// Sine and cosine of an angle in single precision, given the nearest whole number of turns: Taylor polynomials of half the
/// angle, brought into ±π first, and a doubling. No branches. Within 5e-7 for angles up to 100.
#[inline(always)]
pub fn sin_cos<V: Lanes>(angle: V, turns: V) -> (V, V) {
    const SIN: [f64; 6] = [6_227_020_800.0, -39_916_800.0, 362_880.0, -5040.0, 120.0, -6.0];
    const VERSED: [f64; 6] = [-479_001_600.0, 3_628_800.0, -40_320.0, 720.0, -24.0, 2.0];
    // A turn in single precision, and what rounding took away.
    let (turn, rest) = (V::splat_f64(std::f32::consts::TAU.into()), V::splat_f64(-1.748_455_6e-7));
    let (one, two) = (V::splat_f64(1.0), V::splat_f64(2.0));
    let x = V::splat_f64(0.5) * angle.sub_mul(turns, turn).sub_mul(turns, rest);
    let y = x * x;
    let (mut odd, mut even) = (V::zero(), V::zero());
    for k in 0..6 {
        odd = V::splat_f64(1.0 / SIN[k]).add_mul(odd, y);
        even = V::splat_f64(1.0 / VERSED[k]).add_mul(even, y);
    }
    let sin = x.add_mul(x * y, odd);
    // 1 - cos, so that small angles keep their digits.
    let versed = y * even;
    (two * sin * (one - versed), one - two * sin * sin)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn single_precision_sine_and_cosine() {
        let mut worst = 0.0_f64;
        for i in -100_000..100_000 {
            let x = i as f32 * 1e-3;
            let (s, c) = Lanes::sin_cos(x);
            let (es, ec) = f64::from(x).sin_cos();
            worst = worst.max((f64::from(s) - es).abs()).max((f64::from(c) - ec).abs());
        }
        assert!(worst < 5e-7, "{worst}");
        for exponent in 1..30 {
            let x = 0.1_f32.powi(exponent);
            assert!((Lanes::sin_cos(x).0 / x - 1.0).abs() < 2e-3 * x * x + 2e-7 + 0.17 * x * x);
        }
    }
}
