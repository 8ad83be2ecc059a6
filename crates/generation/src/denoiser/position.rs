//! Sinusoidal positions (Vaswani et al. 2017, 3.5).

/// Adds sin(p ωᵢ) to the even and cos(p ωᵢ) to the odd numbers of a token, ωᵢ = 10000^(−2i / c).
pub(super) fn add(position: usize, token: &mut [f32]) {
    let c = token.len() as f64;
    for (i, pair) in token.chunks_mut(2).enumerate() {
        let angle = position as f64 * 10_000.0_f64.powf(-2.0 * i as f64 / c);
        for (x, value) in pair.iter_mut().zip([angle.sin(), angle.cos()]) {
            *x += value as f32;
        }
    }
}
