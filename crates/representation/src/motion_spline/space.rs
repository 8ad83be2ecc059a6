//! Meaning of the network's numbers: a robot's joints by name, and SI units.

use lifelike_checkpoint::Checkpoint;
use lifelike_motion::MotionClip;
use lifelike_motion::resample::resample;

use super::poses::Poses;
use crate::standardizer::{Moments, Standardizer};
use crate::{FromInput, RepresentationError};

/// Smallest standard deviations to divide by, by [`Poses::KINDS`] and for joints: a robot that stands still all the
/// time is no reason to divide by nothing (m, rad, m/s, rad/s, rad).
const FLOORS: [f64; 5] = [0.01, 0.02, 0.1, 0.1, 0.05];

/// In files.
const SCALES: &str = "scales";

/// Joints in the network's order, mean of each number of a row, and the standard deviation of its kind. Joints have
/// one together, so an error of a degree weighs the same in all of them.
#[derive(Debug, Clone, PartialEq)]
pub struct PoseSpace {
    joints: Vec<String>,
    scales: Standardizer,
}

impl PoseSpace {
    /// Of all frames of the clips.
    pub(super) fn of<'a>(joints: Vec<String>, poses: impl Iterator<Item = &'a Poses>) -> Self {
        let width = Poses::ROOT + joints.len();
        let mut moments = Moments::new(width);
        poses.flat_map(|p| p.rows.chunks_exact(width)).for_each(|row| moments.add(row.iter().copied()));
        let (mean, mut std) = moments.finish();
        let kinds = Poses::KINDS.into_iter().chain(std::iter::once(Poses::ROOT..width));
        for (range, floor) in kinds.zip(FLOORS) {
            let mean_square = std[range.clone()].iter().map(|s| s * s).sum::<f64>() / range.len().max(1) as f64;
            std[range].fill(mean_square.sqrt().max(floor));
        }
        Self { joints, scales: Standardizer::new(mean, std) }
    }

    /// Joints by name.
    pub(super) fn joints(&self) -> &[String] {
        &self.joints
    }

    /// Returns the numbers of a row.
    pub(super) fn width(&self) -> usize {
        Poses::ROOT + self.joints.len()
    }

    /// Turns SI units into the network's numbers.
    pub(super) fn normalized(&self, rows: &[f64]) -> Vec<f32> {
        let mut rows = rows.to_vec();
        self.scales.normalize(&mut rows);
        rows.into_iter().map(|x| x as f32).collect()
    }

    /// Returns the network's numbers to SI.
    pub(super) fn denormalized(&self, rows: &[f32]) -> Vec<f64> {
        let mut rows: Vec<f64> = rows.iter().copied().map(f64::from).collect();
        self.scales.denormalize(&mut rows);
        rows
    }

    pub(super) fn save_into(&self, checkpoint: &mut Checkpoint) -> Result<(), RepresentationError> {
        checkpoint.set_meta("joints", &self.joints)?;
        Ok(self.scales.save_into(checkpoint, SCALES)?)
    }

    pub(super) fn load_from(checkpoint: &Checkpoint) -> Result<Self, RepresentationError> {
        let joints: Vec<String> = checkpoint.meta("joints")?;
        let scales = Standardizer::load_from(checkpoint, SCALES, Poses::ROOT + joints.len())?;
        Ok(Self { joints, scales })
    }
}

/// Poses at a rate (Hz), the joints by name in this order.
///
/// # Errors
/// A clip of other joints.
pub(super) fn poses_of(clip: &MotionClip, joints: &[String], fps: f64) -> Result<Poses, RepresentationError> {
    let mut clip = resample(clip, fps)?;
    let column = |name: &String| clip.joint_names.iter().position(|own| own == name);
    let columns: Option<Vec<usize>> = joints.iter().map(column).collect();
    let Some(columns) = columns.filter(|all| all.len() == clip.joint_names.len()) else {
        let (expected, got) = (format!("joints {joints:?}"), format!("{:?}", clip.joint_names));
        return Err(RepresentationError::mismatch(format!("clip '{}'", clip.name), expected, got));
    };
    let cells = (0..clip.len()).flat_map(|frame| columns.iter().map(move |column| (frame, *column)));
    clip.joints = cells.map(|(frame, column)| clip.joints_at(frame)[column]).collect();
    Ok(Poses::of(&clip))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn training_rows_have_mean_0_and_each_kind_standard_deviation_1() {
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
        let mut out = poses.rows.clone();
        PoseSpace::of(vec!["a".into(), "b".into()], [&poses].into_iter()).scales.normalize(&mut out);
        let column = |k: usize| out.iter().skip(k).step_by(9).copied().collect::<Vec<_>>();
        let square = |k: usize| column(k).iter().map(|x| x * x).sum::<f64>() / 100.0;
        for k in 0..9 {
            assert!(column(k).iter().sum::<f64>().abs() < 1e-4, "{k}");
        }
        for kind in [0..1, 1..4, 4..6, 6..7, 7..9] {
            let mean = kind.clone().map(square).sum::<f64>() / kind.len() as f64;
            assert!((mean - 1.0).abs() < 1e-4, "{kind:?}: {mean}");
        }
        assert!((square(8) / square(7) - 9.0).abs() < 1e-3, "a degree is a degree");
    }
}
