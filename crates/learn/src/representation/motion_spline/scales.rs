//! What the network's numbers are in SI units.

use lifelike_nn::checkpoint::{Checkpoint, CheckpointError};

use super::poses::Poses;

/// Smallest spreads to divide by, by [`Poses::KINDS`] and for joints: a robot that stands still all the time is no reason to
/// divide by nothing (m, rad, m/s, rad/s, rad).
const FLOORS: [f64; 5] = [0.01, 0.02, 0.1, 0.1, 0.05];

/// Mean of each number, and the spread of its kind. Joints have one spread together, so an error of a degree weighs the same in
/// all of them.
#[derive(Debug, Clone, PartialEq)]
pub struct Scales {
    mean: Vec<f64>,
    spread: Vec<f64>,
}

impl Scales {
    /// Of all frames.
    pub(super) fn of<'a>(poses: impl Iterator<Item = &'a Poses> + Clone, joints: usize) -> Self {
        let width = Poses::ROOT + joints;
        let rows = || poses.clone().flat_map(|p| p.rows.chunks_exact(width));
        let count = rows().count().max(1) as f64;
        let mut mean = vec![0.0; width];
        rows().for_each(|row| mean.iter_mut().zip(row).for_each(|(m, x)| *m += x / count));
        let mut squares = vec![0.0; width];
        rows().for_each(|row| {
            squares.iter_mut().zip(row.iter().zip(&mean)).for_each(|(s, (x, m))| *s += (x - m).powi(2) / count);
        });
        let mut spread = vec![1.0; width];
        let kinds = Poses::KINDS.into_iter().chain([Poses::ROOT..width]);
        for (range, floor) in kinds.zip(FLOORS) {
            let mean_square = squares[range.clone()].iter().sum::<f64>() / range.len().max(1) as f64;
            spread[range].fill(mean_square.sqrt().max(floor));
        }
        Self { mean, spread }
    }

    /// SI to the network's numbers.
    pub(super) fn normalized(&self, rows: &[f64]) -> Vec<f32> {
        let scales = self.mean.iter().zip(&self.spread).cycle();
        rows.iter().zip(scales).map(|(x, (mean, spread))| ((x - mean) / spread) as f32).collect()
    }

    /// The network's numbers to SI.
    pub(super) fn denormalized(&self, rows: &[f32]) -> Vec<f64> {
        let scales = self.mean.iter().zip(&self.spread).cycle();
        rows.iter().zip(scales).map(|(x, (mean, spread))| mean + spread * f64::from(*x)).collect()
    }

    pub(super) fn save_into(&self, checkpoint: &mut Checkpoint) -> Result<(), CheckpointError> {
        checkpoint.put_f64("scales.mean", &[self.mean.len()], self.mean.clone())?;
        checkpoint.put_f64("scales.spread", &[self.spread.len()], self.spread.clone())
    }

    pub(super) fn load_from(checkpoint: &Checkpoint, width: usize) -> Result<Self, CheckpointError> {
        Ok(Self {
            mean: checkpoint.f64s("scales.mean", &[width])?,
            spread: checkpoint.f64s("scales.spread", &[width])?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn training_rows_have_mean_0_and_each_kind_spread_1() {
        // Two joints, one of which moves three times as far as the other.
        let rows: Vec<f64> = (0..100)
            .flat_map(|i| {
                let x = f64::from(i) * 0.37;
                let swing = x.sin();
                [
                    0.8 + 0.05 * swing,
                    0.1 * swing,
                    0.2 * swing,
                    0.0,
                    swing,
                    0.5 * swing,
                    swing,
                    0.3 * swing,
                    0.9 * swing + 2.0,
                ]
            })
            .collect();
        let poses = Poses { fps: 25.0, joints: 2, rows };
        let scales = Scales::of([&poses].into_iter(), 2);
        let out = scales.normalized(&poses.rows);
        let column = |k: usize| out.iter().skip(k).step_by(9).map(|x| f64::from(*x)).collect::<Vec<_>>();
        let square = |k: usize| column(k).iter().map(|x| x * x).sum::<f64>() / 100.0;
        for k in 0..9 {
            assert!(column(k).iter().sum::<f64>().abs() < 1e-4, "{k}");
        }
        for kind in [0..1, 1..4, 4..6, 6..7, 7..9] {
            let mean = kind.clone().map(square).sum::<f64>() / kind.len() as f64;
            assert!((mean - 1.0).abs() < 1e-4, "{kind:?}: {mean}");
        }
        assert!((square(8) / square(7) - 9.0).abs() < 1e-3, "a degree is a degree");
        let back = scales.denormalized(&out);
        assert!(back.iter().zip(&poses.rows).all(|(a, b)| (a - b).abs() < 1e-6));
    }
}
