//! Two vectors as one: where one of them waits for its last result, the other goes on.

use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

use lifelike_simd::Number;

use super::lanes::Lanes;

/// Two vectors as one.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct Pair<V>(V, V);

impl<V: Lanes> Lanes for Pair<V> {
    type Scalar = V::Scalar;
    const LANES: usize = 2 * V::LANES;
    #[inline(always)]
    fn vectorize<R>(f: impl FnOnce() -> R) -> R {
        V::vectorize(f)
    }
    #[inline(always)]
    fn splat(value: V::Scalar) -> Self {
        let half = V::splat(value);
        Self(half, half)
    }
    #[inline(always)]
    fn lane(&self, lane: usize) -> V::Scalar {
        if lane < V::LANES { self.0.lane(lane) } else { self.1.lane(lane - V::LANES) }
    }
    #[inline(always)]
    fn set_lane(&mut self, lane: usize, value: V::Scalar) {
        if lane < V::LANES { self.0.set_lane(lane, value) } else { self.1.set_lane(lane - V::LANES, value) }
    }
    #[inline(always)]
    fn store(self, out: &mut [V::Scalar]) {
        let (first, second) = out.split_at_mut(V::LANES);
        self.0.store(first);
        self.1.store(second);
    }
    #[inline(always)]
    fn load(numbers: &[V::Scalar]) -> Self {
        let (first, second) = numbers.split_at(V::LANES);
        Self(V::load(first), V::load(second))
    }
    #[inline(always)]
    fn add_mul(self, a: Self, b: Self) -> Self {
        Self(self.0.add_mul(a.0, b.0), self.1.add_mul(a.1, b.1))
    }
    #[inline(always)]
    fn sub_mul(self, a: Self, b: Self) -> Self {
        Self(self.0.sub_mul(a.0, b.0), self.1.sub_mul(a.1, b.1))
    }
    #[inline(always)]
    fn sin_cos(self) -> (Self, Self) {
        let ((s, c), (t, d)) = (self.0.sin_cos(), self.1.sin_cos());
        (Self(s, t), Self(c, d))
    }
    #[inline(always)]
    fn any_positive(self) -> bool {
        self.0.max(self.1).any_positive()
    }
}

macro_rules! operator {
    ($trait:ident, $method:ident) => {
        impl<V: Lanes> $trait for Pair<V> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self(self.0.$method(other.0), self.1.$method(other.1))
            }
        }
    };
}
operator!(Add, add);
operator!(Sub, sub);
operator!(Mul, mul);
operator!(Div, div);

impl<V: Lanes> Neg for Pair<V> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self(-self.0, -self.1)
    }
}

impl<V: Lanes> AddAssign for Pair<V> {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl<V: Lanes> SubAssign for Pair<V> {
    #[inline(always)]
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}

impl<V: Lanes> Number for Pair<V> {
    #[inline(always)]
    fn from_f64(value: f64) -> Self {
        Self::splat_f64(value)
    }
    #[inline(always)]
    fn least(self, other: Self) -> Self {
        Self(self.0.least(other.0), self.1.least(other.1))
    }
    #[inline(always)]
    fn most(self, other: Self) -> Self {
        Self(self.0.most(other.0), self.1.most(other.1))
    }
    #[inline(always)]
    fn tanh(self) -> Self {
        Self(self.0.tanh(), self.1.tanh())
    }
    #[inline(always)]
    fn tanh_ratio(self) -> Self {
        Self(self.0.tanh_ratio(), self.1.tanh_ratio())
    }
    #[inline(always)]
    fn select_gt(self, limit: Self, yes: Self, no: Self) -> Self {
        Self(self.0.select_gt(limit.0, yes.0, no.0), self.1.select_gt(limit.1, yes.1, no.1))
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(self.0.sqrt(), self.1.sqrt())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_halves_of_a_pair_do_not_see_each_other() {
        let (a, b) = (Pair(f32::NAN, 3.0), Pair(1.0, 2.0));
        let c = (a * b + b).add_mul(a, b);
        assert_eq!((c.0.is_nan(), c.1), (true, 14.0));
        let sign = a.select_gt(Lanes::zero(), Lanes::splat(1.0), Lanes::splat(-1.0));
        assert_eq!((sign.lane(0), sign.lane(1)), (-1.0, 1.0));
    }
}
