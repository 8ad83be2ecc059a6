//! From noise to a clean motion.

use super::{Known, Schedule};

/// Steps of sampling, and how much noise is added again in each.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sampler {
    /// Steps, evenly spread over the schedule's.
    pub steps: usize,
    /// η of Song et al. 2021: 0 is DDIM without noise, 1 is DDPM (Ho et al. 2020) on these steps.
    pub eta: f64,
}

impl Sampler {
    /// Returns motions from noise, which is replaced.
    ///
    /// `predict` gets all motions after step d and d itself and returns their clean forms. `noise` writes standard
    /// normal numbers for one motion and one step. Known numbers of a motion take their place in every prediction.
    ///
    /// # Errors
    /// Whatever `predict` fails with.
    pub fn sample<E>(
        &self,
        schedule: &Schedule,
        mut motions: Vec<Vec<f32>>,
        known: &[Option<Known>],
        mut noise: impl FnMut(usize, usize, &mut [f32]),
        mut predict: impl FnMut(&[Vec<f32>], usize) -> Result<Vec<Vec<f32>>, E>,
    ) -> Result<Vec<Vec<f32>>, E> {
        let steps = schedule.spread(self.steps);
        for (i, &d) in steps.iter().enumerate() {
            let next = steps.get(i + 1).copied();
            let clean = predict(&motions, d)?;
            for (m, (motion, mut clean)) in motions.iter_mut().zip(clean).enumerate() {
                if let Some(Some(known)) = known.get(m) {
                    known.put(&mut clean);
                }
                let mut fresh = vec![0.0; motion.len()];
                if next.is_some() && self.eta > 0.0 {
                    noise(m, d, &mut fresh);
                }
                self.step(schedule, (d, next), motion, &clean, &fresh);
            }
        }
        Ok(motions)
    }

    /// Takes a motion from step d to `next` (none: clean), given its predicted clean form (Song et al. 2021, eqs. 12
    /// and 16): √ᾱ' clean + √(1 − ᾱ' − σ²) ε + σ noise. Here ε is the noise that the prediction leaves in the motion,
    /// and σ² = η² (1 − ᾱ') / (1 − ᾱ) (1 − ᾱ / ᾱ').
    pub fn step(
        &self,
        schedule: &Schedule,
        (d, next): (usize, Option<usize>),
        motion: &mut [f32],
        clean: &[f32],
        noise: &[f32],
    ) {
        let (here, there) = (schedule.remaining(Some(d)), schedule.remaining(next));
        let variance = self.eta.powi(2) * (1.0 - there) / (1.0 - here) * (1.0 - here / there);
        let direction = ((1.0 - there - variance).max(0.0) / (1.0 - here)).sqrt();
        let by_motion = direction as f32;
        let by_clean = (there.sqrt() - direction * here.sqrt()) as f32;
        let by_noise = variance.sqrt() as f32;
        for ((x, clean), noise) in motion.iter_mut().zip(clean).zip(noise) {
            *x = by_clean * clean + by_motion * *x + by_noise * noise;
        }
    }
}

/// Moves a prediction from the one without a prompt beyond the one with it (Ho & Salimans 2022): free + weight (told
/// − free).
pub fn guide(told: &mut [f32], free: &[f32], weight: f32) {
    told.iter_mut().zip(free).for_each(|(told, free)| *told = free + weight * (*told - free));
}
