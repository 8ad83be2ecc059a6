//! GELU (Hendrycks & Gimpel 2016), x Φ(x), and its derivative in the machine's widest vectors.

use lifelike_simd::{InstructionSet, Simd, Task, prelude::*};

use super::elementary::exp_of_vector;

/// out ← GELU of each number.
///
/// # Shapes
/// As many of `out` as of `x`.
pub(crate) fn gelu(x: &[f32], out: &mut [f32]) {
    InstructionSet::chosen().run(Forward { x, out });
}

/// Returns GELU of each number.
pub(crate) fn activated(x: &[f32]) -> Vec<f32> {
    let mut out = vec![0.0; x.len()];
    gelu(x, &mut out);
    out
}

/// As [`gelu`], and gradient ← gradient · GELU'(x): both need the error function, which is most of the work.
pub(crate) fn gelu_and_gradient(x: &[f32], out: &mut [f32], gradient: &mut [f32]) {
    InstructionSet::chosen().run(Backward { x, out, gradient });
}

struct Forward<'a> {
    x: &'a [f32],
    out: &'a mut [f32],
}

impl Task for Forward<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let n = S::f32s::LEN;
        for (x, out) in self.x.chunks(n).zip(self.out.chunks_mut(n)) {
            let x = load(simd, x);
            store(x * distribution(simd, x), out);
        }
    }
}

struct Backward<'a> {
    x: &'a [f32],
    out: &'a mut [f32],
    gradient: &'a mut [f32],
}

impl Task for Backward<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        const DENSITY_AT_0: f32 = 0.398_942_3;
        let n = S::f32s::LEN;
        let splat = |c: f32| S::f32s::splat(simd, c);
        for ((x, out), gradient) in self.x.chunks(n).zip(self.out.chunks_mut(n)).zip(self.gradient.chunks_mut(n)) {
            let x = load(simd, x);
            let share = distribution(simd, x);
            let density = exp_of_vector(simd, splat(-0.5) * x * x);
            store(x * share, out);
            store(load(simd, gradient) * (share + x * splat(DENSITY_AT_0) * density), gradient);
        }
    }
}

/// A vector; zeros where there are no more numbers.
#[inline(always)]
fn load<S: Simd>(simd: S, x: &[f32]) -> S::f32s {
    if x.len() == S::f32s::LEN {
        return S::f32s::from_slice(simd, x);
    }
    S::f32s::from_fn(simd, |i| x.get(i).copied().unwrap_or_default())
}

/// As many numbers of a vector as there is place for.
#[inline(always)]
fn store<V: SimdFloat<S, Element = f32>, S: Simd>(vector: V, out: &mut [f32]) {
    if out.len() == V::LEN {
        return vector.store_slice(out);
    }
    out.copy_from_slice(&vector.as_slice()[..out.len()]);
}

/// Φ(x), the standard normal distribution.
#[inline(always)]
fn distribution<S: Simd>(simd: S, x: S::f32s) -> S::f32s {
    let splat = |c: f32| S::f32s::splat(simd, c);
    splat(0.5) * (splat(1.0) + erf(simd, x * splat(std::f32::consts::FRAC_1_SQRT_2)))
}

// Eigen's and XLA's rational approximation of the error function for single precision, highest power first.
const NUMERATOR: [f32; 7] =
    [-2.726_142_3e-10, 2.770_681_4e-8, -2.101_024e-6, -5.692_506_4e-5, -7.349_906_3e-4, -2.954_6e-3, -1.609_603_3e-2];
const DENOMINATOR: [f32; 5] = [-1.456_607_2e-5, -2.133_740_6e-4, -1.682_827e-3, -7.373_329e-3, -1.426_473_9e-2];

/// Returns the error function within 3e-7.
#[inline(always)]
fn erf<S: Simd>(simd: S, x: S::f32s) -> S::f32s {
    let splat = |c: f32| S::f32s::splat(simd, c);
    let polynomial = |s: S::f32s, coefficients: &[f32]| {
        let mut sum = splat(coefficients[0]);
        for c in &coefficients[1..] {
            sum = sum.mul_add_precise(s, splat(*c));
        }
        sum
    };
    // Beyond 4 it is 1 to the last digit, and the approximation none.
    let s = x * x;
    let near = x * polynomial(s, &NUMERATOR) / polynomial(s, &DENOMINATOR);
    let near = x.simd_lt(splat(4.0)).select(near, splat(1.0));
    x.simd_gt(splat(-4.0)).select(near, splat(-1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn both(x: &[f32]) -> (Vec<f32>, Vec<f32>) {
        let (mut out, mut gradient) = (vec![0.0; x.len()], vec![1.0; x.len()]);
        gelu_and_gradient(x, &mut out, &mut gradient);
        (out, gradient)
    }

    #[test]
    fn the_error_function_has_its_known_values() {
        struct Erf(f32);
        impl Task for Erf {
            type Output = f32;
            #[inline(always)]
            fn run<S: Simd>(self, simd: S) -> f32 {
                erf(simd, S::f32s::splat(simd, self.0)).as_slice()[0]
            }
        }
        // Abramowitz & Stegun, table 7.1.
        for (x, expected) in [
            (0.0, 0.0),
            (0.1, 0.112_462_916),
            (0.5, 0.520_499_878),
            (1.0, 0.842_700_793),
            (1.5, 0.966_105_146),
            (2.0, 0.995_322_265),
            (3.0, 0.999_977_910),
            (6.0, 1.0),
        ] {
            for set in InstructionSet::available() {
                let got = set.run(Erf(x));
                assert!((f64::from(got) - expected).abs() < 3e-7, "erf({x}) = {got} ({set})");
                assert_eq!(set.run(Erf(-x)), -got);
            }
        }
    }

    #[test]
    fn every_instruction_set_returns_the_same_numbers_of_any_count_of_them() {
        // 1203 numbers leave a rest of every vector.
        let x: Vec<f32> = (0..1203).map(|i| (i as f32 - 600.0) * 0.0113).collect();
        let expected = both(&x);
        let mut forward = vec![0.0; x.len()];
        gelu(&x, &mut forward);
        assert_eq!(forward, expected.0);
        for set in InstructionSet::available() {
            let (mut out, mut gradient) = (vec![0.0; x.len()], vec![1.0; x.len()]);
            set.run(Backward { x: &x, out: &mut out, gradient: &mut gradient });
            assert_eq!((out, gradient), expected, "{set}");
            let mut out = vec![0.0; x.len()];
            set.run(Forward { x: &x, out: &mut out });
            assert_eq!(out, expected.0, "{set}");
        }
    }

    #[test]
    fn the_gradient_is_the_derivative_times_what_stood_there() {
        let step = 0.01;
        for i in -60..60 {
            let x = i as f32 * 0.1;
            let (values, gradients) = both(&[x - step, x, x + step]);
            let difference = (values[2] - values[0]) / (2.0 * step);
            assert!((difference - gradients[1]).abs() < 1e-4, "at {x}: {difference} {}", gradients[1]);
        }
        let (values, gradients) = both(&[1e4, -1e4]);
        assert_eq!(values, [1e4, 0.0]);
        assert!(gradients[0] == 1.0 && gradients[1].abs() < 1e-30);
        let mut gradient = [3.0];
        gelu_and_gradient(&[0.0], &mut [0.0], &mut gradient);
        assert_eq!(gradient, [1.5]);
    }
}
