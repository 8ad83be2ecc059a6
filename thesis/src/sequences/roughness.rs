//! Flyaway waves and kinks on strands, which a smooth drawing of hair lacks.
//!
//! Smooth strands are within millimetres of a cubic for each channel, so methods cannot be compared on them. Two
//! details are added. Both have a few parameters a strand, which an autoencoder can encode. Neither is a linear
//! function of its parameters, so principal components cannot:
//!
//! | | of each strand |
//! | --- | --- |
//! | [`WAVES`] waves across a direction | wavelength log-uniform between [`WAVELENGTH`], any direction and phase, slope of deviation `roughness` |
//! | [`KINKS`] kinks | anywhere along the strand, turning all that follows about any axis by an angle of deviation `roughness` |

use std::f64::consts::TAU;

use lifelike_character::{Quat, Vec3};
use rand::Rng;
use rand_distr::StandardNormal;

/// Waves of a strand.
const WAVES: usize = 2;
/// Kinks of a strand.
const KINKS: usize = 2;
/// Shortest and longest wave (m).
const WAVELENGTH: [f64; 2] = [0.01, 0.06];

/// The roughness of one strand.
#[derive(Debug, Clone, PartialEq)]
pub struct Roughness {
    /// Displacement (m), wave number (rad/m) and phase (rad).
    waves: Vec<(Vec3, f64, f64)>,
    /// Arc length (m) and turn, from the root on.
    kinks: Vec<(f64, Quat)>,
}

impl Roughness {
    /// Draws waves and kinks for a strand of some length (m).
    pub fn draw(roughness: f64, length: f64, rng: &mut impl Rng) -> Self {
        let waves = (0..WAVES).map(|_| wave(roughness, rng)).collect();
        let mut kinks: Vec<(f64, Quat)> = (0..KINKS).map(|_| kink(roughness, length, rng)).collect();
        kinks.sort_by(|a, b| a.0.total_cmp(&b.0));
        Self { waves, kinks }
    }

    /// Roughens points at equal distances along a strand of some length (m); the root stays.
    pub fn apply(&self, points: &mut [Vec3], length: f64) {
        let last = points.len().saturating_sub(1).max(1) as f64;
        let at = |i: usize| length * i as f64 / last;
        for (amplitude, number, phase) in &self.waves {
            for (i, point) in points.iter_mut().enumerate() {
                *point += amplitude * ((number * at(i) + phase).sin() - phase.sin());
            }
        }
        // From the tip: a kink turns what follows about its own place, which those nearer to the root turn later.
        for (place, turn) in self.kinks.iter().rev() {
            let first = (0..points.len()).find(|i| at(*i) >= *place).unwrap_or(points.len());
            let Some(pivot) = points.get(first).copied() else { continue };
            points[first..].iter_mut().for_each(|point| *point = pivot + turn * (*point - pivot));
        }
    }
}

fn wave(roughness: f64, rng: &mut impl Rng) -> (Vec3, f64, f64) {
    let number = TAU / uniform(WAVELENGTH.map(f64::ln), rng).exp();
    // The slope of a sine is its amplitude times its wave number; the waves share the slope's variance.
    let amplitude = roughness * (2.0 / WAVES as f64).sqrt() / number;
    (direction(rng) * amplitude, number, uniform([0.0, TAU], rng))
}

fn kink(roughness: f64, length: f64, rng: &mut impl Rng) -> (f64, Quat) {
    let (at, axis) = (uniform([0.0, length], rng), direction(rng));
    (at, Quat::from_scaled_axis(axis * (roughness * normal(rng))))
}

fn uniform([low, high]: [f64; 2], rng: &mut impl Rng) -> f64 {
    rng.random_range(low..=high)
}

fn normal(rng: &mut impl Rng) -> f64 {
    rng.sample(StandardNormal)
}

/// Returns a unit vector, uniform on the sphere.
fn direction(rng: &mut impl Rng) -> Vec3 {
    Vec3::from_fn(|_, _| normal(rng)).try_normalize(1e-9).unwrap_or_else(Vec3::x)
}

#[cfg(test)]
mod tests {
    use lifelike_checkpoint::rng::stream;

    use super::*;

    /// A line of 0.4 m along x, 5 points.
    fn line() -> Vec<Vec3> {
        (0..5).map(|i| Vec3::new(0.1 * f64::from(i), 0.0, 0.0)).collect()
    }

    #[test]
    fn a_kink_and_a_wave_by_hand() {
        let quarter = Quat::from_scaled_axis(Vec3::z() * std::f64::consts::FRAC_PI_2);
        let kinked = Roughness { waves: Vec::new(), kinks: vec![(0.15, quarter)] };
        let mut points = line();
        kinked.apply(&mut points, 0.4);
        // The point at 0.2 m is the pivot; what follows goes up along y.
        for (point, expected) in points.iter().zip([[0.0, 0.0], [0.1, 0.0], [0.2, 0.0], [0.2, 0.1], [0.2, 0.2]]) {
            assert!((point - Vec3::new(expected[0], expected[1], 0.0)).norm() < 1e-12, "{point}");
        }
        // A wave of 0.4 m: a quarter of it at 0.1 m.
        let waved = Roughness { waves: vec![(Vec3::z() * 0.01, TAU / 0.4, 0.0)], kinks: Vec::new() };
        let mut points = line();
        waved.apply(&mut points, 0.4);
        for (point, z) in points.iter().zip([0.0, 0.01, 0.0, -0.01, 0.0]) {
            assert!((point.z - z).abs() < 1e-12, "{point}");
        }
    }

    #[test]
    fn slopes_have_the_stated_deviation_and_roots_stay() {
        let (mut squares, mut count) = (0.0, 0.0);
        for i in 0..400 {
            let own = Roughness { kinks: Vec::new(), ..Roughness::draw(0.3, 0.4, &mut stream(1, "test", i, 0)) };
            let mut points = vec![Vec3::zeros(); 2000];
            own.apply(&mut points, 0.4);
            assert_eq!(points[0], Vec3::zeros());
            let step = 0.4 / 1999.0;
            squares += points.windows(2).map(|pair| ((pair[1] - pair[0]) / step).norm_squared()).sum::<f64>();
            count += 1999.0;
        }
        let deviation = (squares / count).sqrt();
        assert!((deviation / 0.3 - 1.0).abs() < 0.05, "{deviation}");
        let angles = (0..4000).flat_map(|i| Roughness::draw(0.3, 0.4, &mut stream(2, "test", i, 0)).kinks);
        let squares: Vec<f64> = angles.map(|(_, turn)| turn.angle().powi(2)).collect();
        let deviation = (squares.iter().sum::<f64>() / squares.len() as f64).sqrt();
        assert!((deviation / 0.3 - 1.0).abs() < 0.05, "{deviation}");
    }
}
