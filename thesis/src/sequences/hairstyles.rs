//! Strands of hair drawn from a few numbers: what stands in for the 343 hair models of thesis 3.3.4 (Hu et al. 2015).
//!
//! First a HAIRSTYLE is drawn, then its strands around it (metres, z up, roots anywhere on the scalp):
//!
//! | number | of a hairstyle | of its strands |
//! | --- | --- | --- |
//! | length of the centre line | 0.05 to 0.4 m, uniform | relative deviation 0.1 |
//! | radius of the curls | 0.5 to 15 mm, log-uniform | relative deviation 0.2 |
//! | turns of the curls | 2 to 30 a metre, uniform | relative deviation 0.1, phase anywhere |
//! | length along which gravity bends | 0.02 to 0.3 m, log-uniform | relative deviation 0.2 |
//! | comb: a horizontal push at the root | 0 to 1, uniform, any direction | the same |
//! | normal of the scalp at the root | – | uniform on the sphere down to 110 degrees from the top |
//!
//! Deviations are those of a uniform distribution: mean × (1 ± √3 × deviation). The centre line leaves along normal
//! plus comb and turns down: its direction at arc length s is that of e^(−s/b) × first direction + (1 − e^(−s/b)) ×
//! down, with b the bending length. Around it the strand winds with a radius that grows from 0 at the root: 1 −
//! e^(−s/c) of the full one, c = 3 cm. So the root is the origin.

use std::f64::consts::TAU;

use lifelike_character::Vec3;
use rand::Rng;

/// Mean length of a hairstyle's strands (m).
const LENGTH: [f64; 2] = [0.05, 0.4];
/// Mean radius of the curls (m).
const CURL_RADIUS: [f64; 2] = [5e-4, 1.5e-2];
/// Mean turns of the curls (1/m).
const CURL_FREQUENCY: [f64; 2] = [2.0, 30.0];
/// Mean length along which gravity bends (m).
const BENDING: [f64; 2] = [0.02, 0.3];
/// Height of the lowest root on the scalp, as a unit sphere: 110 degrees from the top.
const LOWEST_ROOT: f64 = -0.342_020_143_325_668_7;
/// Arc length along which curls grow to 63% of their radius (m).
const CURLS_GROW: f64 = 0.03;
/// Steps of the integration between two points.
const STEPS: usize = 4;

/// Means of the strands of one hairstyle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hairstyle {
    /// Length of the centre line (m).
    pub length: f64,
    /// Radius of the curls (m).
    pub curl_radius: f64,
    /// Turns of the curls (1/m).
    pub curl_frequency: f64,
    /// Length along which gravity bends (m).
    pub bending: f64,
    /// Vector added to the scalp's normal: horizontal, at most 1 long.
    pub comb: [f64; 2],
}

/// One strand.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Strand {
    /// Length of the centre line (m).
    pub length: f64,
    /// Radius of the curls (m).
    pub curl_radius: f64,
    /// Turns of the curls (1/m).
    pub curl_frequency: f64,
    /// Phase at which the curl begins (rad).
    pub phase: f64,
    /// Length along which gravity bends (m).
    pub bending: f64,
    /// Unit vector in which the strand leaves the scalp.
    pub direction: Vec3,
}

impl Hairstyle {
    /// Returns one hairstyle.
    pub fn draw(rng: &mut impl Rng) -> Self {
        let length = uniform(LENGTH, rng);
        let curl_radius = uniform(CURL_RADIUS.map(f64::ln), rng).exp();
        let curl_frequency = uniform(CURL_FREQUENCY, rng);
        let bending = uniform(BENDING.map(f64::ln), rng).exp();
        let (strength, towards) = (rng.random_range(0.0..=1.0), rng.random_range(0.0..TAU));
        Self {
            length,
            curl_radius,
            curl_frequency,
            bending,
            comb: [strength * towards.cos(), strength * towards.sin()],
        }
    }

    /// Returns one of its strands.
    pub fn strand(&self, rng: &mut impl Rng) -> Strand {
        let length = around(self.length, 0.1, rng);
        let curl_radius = around(self.curl_radius, 0.2, rng);
        let curl_frequency = around(self.curl_frequency, 0.1, rng);
        let bending = around(self.bending, 0.2, rng);
        let phase = rng.random_range(0.0..TAU);
        // Equal areas of a sphere lie between equal heights.
        let (height, azimuth) = (uniform([LOWEST_ROOT, 1.0], rng), rng.random_range(0.0..TAU));
        let level = (1.0 - height * height).max(0.0).sqrt();
        let normal = Vec3::new(level * azimuth.cos(), level * azimuth.sin(), height);
        let pushed = normal + Vec3::new(self.comb[0], self.comb[1], 0.0);
        let direction = pushed.try_normalize(1e-9).unwrap_or(normal);
        Strand { length, curl_radius, curl_frequency, phase, bending, direction }
    }
}

impl Strand {
    /// Points at equal distances along the centre line, from the root, which is the origin, to the tip (m).
    pub fn points(&self, count: usize) -> Vec<Vec3> {
        let step = self.length / (count.saturating_sub(1).max(1) * STEPS) as f64;
        // All of the centre line lies in the plane of first direction and gravity, so this normal is one all along.
        let across = self.direction.cross(&Vec3::z()).try_normalize(1e-9).unwrap_or_else(Vec3::x);
        let mut centre = Vec3::zeros();
        let mut points = Vec::with_capacity(count);
        for i in 0..count {
            let s = (i * STEPS) as f64 * step;
            let radius = self.curl_radius * (1.0 - (-s / CURLS_GROW).exp());
            let angle = TAU * self.curl_frequency * s + self.phase;
            let other = self.heading(s).cross(&across);
            points.push(centre + (across * angle.cos() + other * angle.sin()) * radius);
            for k in 0..STEPS {
                centre += self.heading(s + (k as f64 + 0.5) * step) * step;
            }
        }
        points
    }

    /// Returns the direction of the centre line at an arc length.
    fn heading(&self, s: f64) -> Vec3 {
        let kept = (-s / self.bending).exp();
        (self.direction * kept - Vec3::z() * (1.0 - kept)).try_normalize(1e-9).unwrap_or_else(|| -Vec3::z())
    }
}

fn uniform([low, high]: [f64; 2], rng: &mut impl Rng) -> f64 {
    rng.random_range(low..=high)
}

/// Uniform around `mean`, with this relative standard deviation.
fn around(mean: f64, deviation: f64, rng: &mut impl Rng) -> f64 {
    mean * (1.0 + deviation * 3.0_f64.sqrt() * rng.random_range(-1.0..=1.0))
}

#[cfg(test)]
mod tests {
    use lifelike_checkpoint::rng::stream;

    use super::*;

    /// Returns the mean and standard deviation.
    fn moments(values: &[f64]) -> [f64; 2] {
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        [mean, (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / values.len() as f64).sqrt()]
    }

    #[track_caller]
    fn near(got: f64, expected: f64, tolerance: f64) {
        assert!((got - expected).abs() < tolerance, "{got}, not {expected}");
    }

    #[test]
    fn hairstyles_have_the_stated_means() {
        let styles: Vec<Hairstyle> = (0..20_000).map(|i| Hairstyle::draw(&mut stream(1, "test", i, 0))).collect();
        let of = |value: fn(&Hairstyle) -> f64| moments(&styles.iter().map(value).collect::<Vec<_>>());
        // Uniform: the middle, and the width over √12.
        let [mean, deviation] = of(|s| s.length);
        near(mean, 0.225, 0.002);
        near(deviation, 0.35 / 12.0_f64.sqrt(), 0.002);
        near(of(|s| s.curl_frequency)[0], 16.0, 0.2);
        // Log-uniform: the middle of the logarithms.
        near(of(|s| s.curl_radius.ln())[0].exp(), (5e-4_f64 * 1.5e-2).sqrt(), 5e-5);
        near(of(|s| s.bending.ln())[0].exp(), (0.02_f64 * 0.3).sqrt(), 2e-3);
        near(of(|s| s.comb[0].hypot(s.comb[1]))[0], 0.5, 0.01);
        near(of(|s| s.comb[0])[0], 0.0, 0.01);
    }

    #[test]
    fn strands_vary_around_their_hairstyle_as_stated() {
        let style = Hairstyle { length: 0.2, curl_radius: 0.01, curl_frequency: 10.0, bending: 0.1, comb: [0.0; 2] };
        let strands: Vec<Strand> = (0..20_000).map(|i| style.strand(&mut stream(2, "test", i, 0))).collect();
        let of = |value: fn(&Strand) -> f64| moments(&strands.iter().map(value).collect::<Vec<_>>());
        for ([mean, deviation], expected, relative) in [
            (of(|s| s.length), 0.2, 0.1),
            (of(|s| s.curl_radius), 0.01, 0.2),
            (of(|s| s.curl_frequency), 10.0, 0.1),
            (of(|s| s.bending), 0.1, 0.2),
        ] {
            near(mean / expected, 1.0, 0.01);
            near(deviation / expected, relative, 0.01);
        }
        // Not combed, a strand leaves along the normal: heights uniform from −0.342 to 1.
        let [height, spread] = of(|s| s.direction.z);
        near(height, 0.329, 0.01);
        near(spread, 1.342 / 12.0_f64.sqrt(), 0.01);
        near(of(|s| s.direction.y)[0], 0.0, 0.01);
        assert!(strands.iter().all(|s| (s.direction.norm() - 1.0).abs() < 1e-9 && s.direction.z > -0.3421));
    }

    #[test]
    fn a_strand_by_hand() {
        let still = Strand {
            length: 0.3,
            curl_radius: 0.0,
            curl_frequency: 0.0,
            phase: 0.0,
            bending: 1e9,
            direction: Vec3::new(0.6, 0.0, 0.8),
        };
        // Stiff and straight: a line.
        let line = still.points(4);
        assert_eq!(line[0], Vec3::zeros());
        assert!((line[3] - Vec3::new(0.18, 0.0, 0.24)).norm() < 1e-6 && (line[1] * 3.0 - line[3]).norm() < 1e-6);
        // Limp: it hangs.
        let limp = Strand { bending: 1e-3, ..still }.points(100);
        assert!((limp[99].z + 0.3).abs() < 0.005 && limp[99].x.abs() < 0.005, "{}", limp[99]);
        // Curls stand across the line with the radius that has grown, and wind as often as they say.
        let curly = Strand { curl_radius: 0.01, curl_frequency: 10.0, ..still }.points(100);
        let straight = still.points(100);
        let off = |i: usize| curly[i] - straight[i];
        let grown = 0.01 * (1.0 - (-0.3_f64 / 0.03).exp());
        assert!((off(99).norm() - grown).abs() < 1e-9 && off(99).dot(&still.direction).abs() < 1e-9);
        assert!(off(0).norm() == 0.0);
        // Three turns in 0.3 m, 33 points each.
        let turn = off(99).dot(&off(66)) / (off(99).norm() * off(66).norm());
        assert!(turn > 1.0 - 1e-9, "{turn}");
        // A bent centre line keeps its length.
        let bent = Strand { bending: 0.1, ..still }.points(400);
        let length: f64 = bent.windows(2).map(|w| (w[1] - w[0]).norm()).sum();
        near(length, 0.3, 1e-4);
        assert!(bent[399].z < bent[200].z, "down in the end");
    }
}
