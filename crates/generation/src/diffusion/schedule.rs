//! Share of the clean motion that is left after each diffusion step.

use std::f64::consts::FRAC_PI_2;

/// A noise schedule of D steps: ᾱ_d is the share of the clean signal's variance left after step d (counted from 0).
#[derive(Debug, Clone, PartialEq)]
pub struct Schedule {
    remaining: Vec<f64>,
}

impl Schedule {
    /// Returns the cosine schedule (Nichol & Dhariwal 2021, eq. 17): β_d = min(1 − f(d + 1) / f(d), 0.999),
    /// f(d) = cos²((d / D + 0.008) / 1.008 · π / 2), ᾱ_d = Π (1 − β).
    pub fn cosine(steps: usize) -> Self {
        let f = |d: usize| ((d as f64 / steps as f64 + 0.008) / 1.008 * FRAC_PI_2).cos().powi(2);
        let mut left = 1.0;
        let mut step = |d: usize| {
            left *= 1.0 - (1.0 - f(d + 1) / f(d)).min(0.999);
            left
        };
        Self { remaining: (0..steps).map(&mut step).collect() }
    }

    /// Returns D.
    pub fn len(&self) -> usize {
        self.remaining.len()
    }

    /// Returns whether there is no step.
    pub fn is_empty(&self) -> bool {
        self.remaining.is_empty()
    }

    /// Returns ᾱ_d; 1 before the first step.
    pub fn remaining(&self, d: Option<usize>) -> f64 {
        d.map_or(1.0, |d| self.remaining[d])
    }

    /// Returns √ᾱ_d clean + √(1 − ᾱ_d) noise (Ho et al. 2020, eq. 4).
    pub fn add_noise(&self, clean: &[f32], noise: &[f32], d: usize) -> Vec<f32> {
        let left = self.remaining[d];
        let (a, b) = (left.sqrt() as f32, (1.0 - left).sqrt() as f32);
        clean.iter().zip(noise).map(|(clean, noise)| a * clean + b * noise).collect()
    }

    /// Returns at most `count` steps from the last to the first, evenly spread.
    pub fn spread(&self, count: usize) -> Vec<usize> {
        let (last, count) = (self.len().saturating_sub(1), count.clamp(1, self.len().max(1)));
        if count == 1 {
            return vec![last];
        }
        (0..count).rev().map(|i| (i as f64 * last as f64 / (count - 1) as f64).round() as usize).collect()
    }
}
