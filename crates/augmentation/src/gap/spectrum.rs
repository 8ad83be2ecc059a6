//! The error by frequency.

use rustfft::FftPlanner;
use rustfft::num_complex::Complex;

/// A band of frequencies.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Band {
    /// From this frequency on (Hz).
    pub from: f64,
    /// Up to this one (Hz).
    pub to: f64,
    /// Root of the mean square of the error in it (SI).
    pub rms: f64,
}

/// Edges of the bands (Hz); the last ends at half the rate.
const EDGES: [f64; 7] = [0.0, 0.25, 1.0, 2.0, 5.0, 10.0, 20.0];

/// Returns the error's size in bands of frequencies. The squares of all bands sum to the mean square of the error (Parseval);
/// its mean is in the first.
pub fn spectrum(error: &[f64], rate: f64) -> Vec<Band> {
    let n = error.len();
    if n == 0 {
        return Vec::new();
    }
    let mut numbers: Vec<Complex<f64>> = error.iter().map(|x| Complex::new(*x, 0.0)).collect();
    FftPlanner::new().plan_fft_forward(n).process(&mut numbers);
    let half = rate / 2.0;
    let edges: Vec<f64> = EDGES.iter().copied().filter(|edge| *edge < half).collect();
    let mut power = vec![0.0; edges.len()];
    for (i, number) in numbers.iter().enumerate() {
        // The second half is the first, mirrored.
        let frequency = i.min(n - i) as f64 * rate / n as f64;
        let band = edges.iter().rposition(|edge| frequency >= *edge).unwrap_or(0);
        power[band] += number.norm_sqr() / (n * n) as f64;
    }
    let ends = edges.iter().skip(1).copied().chain([half]);
    edges.iter().zip(ends).zip(power).map(|((from, to), power)| Band { from: *from, to, rms: power.sqrt() }).collect()
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    #[test]
    fn a_wave_is_in_its_band_and_nothing_is_lost() {
        let error: Vec<f64> = (0..400).map(|i| 0.5 + 2.0 * (TAU * 3.0 * f64::from(i) / 100.0).sin()).collect();
        let bands = spectrum(&error, 100.0);
        assert!((bands[0].rms - 0.5).abs() < 1e-9);
        let own = bands.iter().find(|band| band.from == 2.0).map(|band| band.rms);
        assert!(own.is_some_and(|rms| (rms - 2.0_f64.sqrt()).abs() < 1e-9), "{bands:?}");
        let (all, square): (f64, f64) =
            (bands.iter().map(|band| band.rms.powi(2)).sum(), error.iter().map(|x| x * x).sum::<f64>() / 400.0);
        assert!((all - square).abs() < 1e-9);
        assert_eq!(bands.last().map(|band| band.to), Some(50.0));
        assert!(spectrum(&[], 100.0).is_empty());
    }
}
