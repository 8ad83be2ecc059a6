//! The vectors of an instruction set, as [`Lanes`].

use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

use lifelike_simd::prelude::*;
use lifelike_simd::{Number, Simd};

use super::lanes::{Lanes, PER_TURN, sin_cos};

/// As many environments as a vector of an instruction set holds numbers of single precision.
#[derive(Debug, Clone, Copy)]
#[repr(transparent)]
pub struct Native<S: Simd>(S::f32s);

/// Proof that this machine has an instruction set: [`super::dispatch`] makes engines of `Native<S>` only where it was given
/// an `S`, and nothing else can name them.
#[inline(always)]
fn token<S: Simd>() -> S {
    const { assert!(size_of::<S>() == 0) };
    // SAFETY: a value without bytes has no invalid ones. That the machine has the instructions is said above.
    unsafe { std::ptr::NonNull::<S>::dangling().read() }
}

/// True where a fused multiply-add is one instruction; elsewhere it is dozens, and better a function than repeated.
pub(super) const fn fuses<S: Simd>() -> bool {
    cfg!(target_arch = "aarch64") || <S::f32s as SimdBase<S>>::LEN > 4
}

/// `a * b + c`, rounded once, without an instruction for it.
#[inline(never)]
fn emulated<S: Simd>(a: S::f32s, b: S::f32s, c: S::f32s) -> S::f32s {
    a.mul_add_precise(b, c)
}

impl<S: Simd> Lanes for Native<S> {
    type Scalar = f32;
    const LANES: usize = <S::f32s as SimdBase<S>>::LEN;
    #[inline(always)]
    fn vectorize<R>(f: impl FnOnce() -> R) -> R {
        token::<S>().vectorize(f)
    }
    #[inline(always)]
    fn splat(value: f32) -> Self {
        Self(S::f32s::splat(token(), value))
    }
    #[inline(always)]
    fn lane(&self, lane: usize) -> f32 {
        self.0.as_slice()[lane]
    }
    #[inline(always)]
    fn set_lane(&mut self, lane: usize, value: f32) {
        self.0.as_mut_slice()[lane] = value;
    }
    #[inline(always)]
    fn store(self, out: &mut [f32]) {
        self.0.store_slice(out);
    }
    #[inline(always)]
    fn load(numbers: &[f32]) -> Self {
        Self(S::f32s::from_slice(token(), numbers))
    }
    #[inline(always)]
    fn add_mul(self, a: Self, b: Self) -> Self {
        Self(if fuses::<S>() { a.0.mul_add_precise(b.0, self.0) } else { emulated::<S>(a.0, b.0, self.0) })
    }
    #[inline(always)]
    fn sin_cos(self) -> (Self, Self) {
        sin_cos(self, Self((self * Self::splat(PER_TURN)).0.round_ties_even()))
    }
    #[inline(always)]
    fn any_positive(self) -> bool {
        self.0.simd_gt(Self::zero().0).any_true()
    }
}

macro_rules! operator {
    ($trait:ident, $method:ident) => {
        impl<S: Simd> $trait for Native<S> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self(self.0.$method(other.0))
            }
        }
    };
}
operator!(Add, add);
operator!(Sub, sub);
operator!(Mul, mul);
operator!(Div, div);

impl<S: Simd> Neg for Native<S> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self(-self.0)
    }
}

impl<S: Simd> AddAssign for Native<S> {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl<S: Simd> SubAssign for Native<S> {
    #[inline(always)]
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}

impl<S: Simd> Number for Native<S> {
    #[inline(always)]
    fn from_f64(value: f64) -> Self {
        Self::splat_f64(value)
    }
    /// On x86 the instruction is `self < other ? self : other`, NaN and signed zeros included; elsewhere it is not.
    #[inline(always)]
    fn least(self, other: Self) -> Self {
        if cfg!(target_arch = "x86_64") { Self(self.0.min(other.0)) } else { other.select_gt(self, self, other) }
    }
    #[inline(always)]
    fn most(self, other: Self) -> Self {
        if cfg!(target_arch = "x86_64") { Self(self.0.max(other.0)) } else { self.select_gt(other, self, other) }
    }
    #[inline(always)]
    fn select_gt(self, limit: Self, yes: Self, no: Self) -> Self {
        Self(self.0.simd_gt(limit.0).select(yes.0, no.0))
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(self.0.sqrt())
    }
}

#[cfg(test)]
mod tests {
    use lifelike_simd::{InstructionSet, Task};

    use super::super::lanes::Scalar;
    use super::super::pair::Pair;
    use super::*;

    /// Results of every operation on every triple of some awkward numbers, as bits.
    fn results<V: Lanes>() -> Vec<u64> {
        let awkward = [0.0, -0.0, 1.0, -1.5, 0.1, 1e-30, -1e-44, 3.0e38, 7.3, f64::INFINITY, f64::NAN];
        let mut bits = Vec::new();
        for (x, y, z) in awkward
            .iter()
            .flat_map(|x| awkward.iter().map(move |y| (x, y)))
            .flat_map(|(x, y)| awkward.iter().map(move |z| (x, y, z)))
        {
            let [a, b, c] = [x, y, z].map(|x| V::splat_f64(*x));
            let (sin, cos) = a.sin_cos();
            let all = [
                a + b,
                a - b,
                a * b,
                a / b,
                -a,
                a.add_mul(b, c),
                a.sub_mul(b, c),
                a.select_gt(b, c, a),
                a.min(b),
                a.max(b),
                a.abs(),
                a.sqrt(),
                a.recip(),
                sin,
                cos,
                a.tanh(),
                a.tanh_ratio(),
                a.exp(),
                a.powf(b),
            ];
            for value in all {
                for lane in 0..V::LANES {
                    // One NaN is as good as another.
                    let value = value.lane(lane).to_f64();
                    let value = if value.is_nan() { 0 } else { value.to_bits() };
                    if lane == 0 { bits.push(value) } else { assert_eq!(bits.last(), Some(&value)) }
                }
            }
            bits.push(a.any_positive().into());
        }
        bits
    }

    struct Every;

    impl Task for Every {
        type Output = [Vec<u64>; 2];
        fn run<S: Simd>(self, _: S) -> Self::Output {
            [results::<Native<S>>(), results::<Pair<Native<S>>>()]
        }
    }

    #[test]
    fn every_instruction_set_computes_the_same_bits_as_a_scalar() {
        let expected = results::<f32>();
        for set in InstructionSet::available() {
            for got in set.run(Every) {
                for (i, (expected, got)) in expected.iter().zip(&got).enumerate() {
                    assert_eq!(expected, got, "{set}: result {i}");
                }
            }
        }
    }
}
