//! exp, the error function and GELU written so that the compiler makes vector instructions of loops over them: the C library's
//! take one number at a time and were a third of a training step.

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

/// exp(x) to 2 units in the last place, for x up to 88; below −87 it stays at exp(−87), about 1e-38.
#[inline(always)]
pub(crate) fn exp(x: f32) -> f32 {
    // Adding 1.5 · 2^23 leaves the nearest whole number in the lowest bits.
    const SHIFT: f32 = 12_582_912.0;
    let x = if x > -87.0 { x } else { -87.0 };
    let shifted = fma(x, std::f32::consts::LOG2_E, SHIFT);
    let n = shifted - SHIFT;
    // ln 2 in two parts, the first exact when multiplied by n.
    let r = fma(n, -1.428_606_8e-6, fma(n, -0.693_145_75, x));
    // Taylor: |r| ≤ ln 2 / 2, so the first term left out is below 4e-9.
    let mut p = fma(r, 1.0 / 5040.0, 1.0 / 720.0);
    p = fma(p, r, 1.0 / 120.0);
    p = fma(p, r, 1.0 / 24.0);
    p = fma(p, r, 1.0 / 6.0);
    p = fma(p, r, 0.5);
    p = fma(p, r, 1.0);
    p = fma(p, r, 1.0);
    p * f32::from_bits((shifted.to_bits() << 23).wrapping_add(0x3f80_0000))
}

/// Returns the error function within 3e-7: the rational approximation of Eigen's and XLA's `erf` for single precision.
#[inline(always)]
fn erf(x: f32) -> f32 {
    // Beyond 4 it is 1 to the last digit.
    if x >= 4.0 {
        return 1.0;
    }
    if x <= -4.0 {
        return -1.0;
    }
    let s = x * x;
    let mut p = fma(s, -2.726_142_3e-10, 2.770_681_4e-8);
    p = fma(p, s, -2.101_024e-6);
    p = fma(p, s, -5.692_506_4e-5);
    p = fma(p, s, -7.349_906_3e-4);
    p = fma(p, s, -2.954_6e-3);
    p = fma(p, s, -1.609_603_3e-2);
    let mut q = fma(s, -1.456_607_2e-5, -2.133_740_6e-4);
    q = fma(q, s, -1.682_827e-3);
    q = fma(q, s, -7.373_329e-3);
    q = fma(q, s, -1.426_473_9e-2);
    x * p / q
}

/// Hendrycks & Gimpel 2016: x Φ(x).
#[inline(always)]
pub fn gelu(x: f32) -> f32 {
    0.5 * x * (1.0 + erf(x * std::f32::consts::FRAC_1_SQRT_2))
}

/// Its derivative Φ(x) + x φ(x).
#[inline(always)]
pub(crate) fn gelu_gradient(x: f32) -> f32 {
    const DENSITY_AT_0: f32 = 0.398_942_3;
    0.5 * (1.0 + erf(x * std::f32::consts::FRAC_1_SQRT_2)) + x * DENSITY_AT_0 * exp(-0.5 * x * x)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exp_is_that_of_double_precision() {
        for i in -8_699..8_800 {
            let x = i as f32 * 0.01;
            let expected = f64::from(x).exp();
            assert!((f64::from(exp(x)) / expected - 1.0).abs() < 2.5e-7, "exp({x}) = {}", exp(x));
        }
        assert_eq!(exp(0.0), 1.0);
        assert!(exp(f32::NEG_INFINITY) < 2e-38 && exp(-1e30) < 2e-38);
    }

    #[test]
    fn the_error_function_has_its_known_values() {
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
            assert!((f64::from(erf(x)) - expected).abs() < 3e-7, "erf({x}) = {}", erf(x));
            assert_eq!(erf(-x), -erf(x));
        }
    }

    #[test]
    fn gelu_gradient_is_the_derivative() {
        for i in -60..60 {
            let (x, step) = (i as f32 * 0.1, 0.01);
            let difference = (gelu(x + step) - gelu(x - step)) / (2.0 * step);
            assert!((difference - gelu_gradient(x)).abs() < 1e-4, "at {x}: {difference} {}", gelu_gradient(x));
        }
        assert_eq!((gelu(1e4), gelu_gradient(1e4), gelu(-1e4)), (1e4, 1.0, 0.0));
        assert!(gelu_gradient(-1e4).abs() < 1e-30);
    }
}
