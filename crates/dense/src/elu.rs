//! The exponential linear unit of Clevert et al. 2016.

/// Returns x above zero, exp(x) − 1 below.
#[inline]
pub fn elu(x: f32) -> f32 {
    let below = exp_of_nonpositive(x.min(0.0)) - 1.0;
    if x > 0.0 { x } else { below }
}

/// Returns exp(x) for x ≤ 0 to about one unit in the last place, in operations that a compiler turns into vector
/// instructions (the library's function is a call per number): x = n ln 2 + r with |r| ≤ ½ ln 2, a polynomial for exp(r)
/// (Cephes), and the exponent n put together from bits.
#[inline]
fn exp_of_nonpositive(x: f32) -> f32 {
    // Below this the result is no normal number; as an ELU it is −1 long before.
    let x = x.max(-87.0);
    // Adding and taking away 1.5 · 2²³ rounds to the nearest whole number.
    let magic = 12_582_912.0_f32;
    let n = (x * std::f32::consts::LOG2_E + magic) - magic;
    let r = n.mul_add(-0.693_359_4, x);
    let r = n.mul_add(2.121_944_4e-4, r);
    let mut p = 1.987_569_1e-4_f32;
    for c in [1.398_199_9e-3, 8.333_452e-3, 4.166_579_6e-2, 1.666_666_5e-1, 5e-1] {
        p = p.mul_add(r, c);
    }
    let p = p.mul_add(r * r, r) + 1.0;
    p * f32::from_bits(((n as i32 + 127) as u32) << 23)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_exponential_is_right_to_the_last_digits() {
        for i in 0..200_000 {
            let x = -i as f32 * 4.3e-4;
            let (got, exact) = (f64::from(exp_of_nonpositive(x)), f64::from(x).exp());
            assert!((got - exact).abs() <= 1.5e-7 * exact, "exp({x}) = {got}, not {exact}");
        }
        assert_eq!((elu(0.0), elu(2.5), elu(f32::NEG_INFINITY)), (0.0, 2.5, -1.0));
        assert!(elu(-1e-3) < 0.0 && elu(f32::MAX) == f32::MAX);
    }
}
