//! Mean and spread of the features of a data set, by which windows and single frames are normalised (thesis 4.2.1).

use lifelike_motion::{FeatureLayout, Frame};
use lifelike_nn::checkpoint::{Checkpoint, CheckpointError};

use crate::LearnError;
use crate::limits::range;

/// Smallest standard deviations to divide by. A joint that hardly moves in the data would otherwise turn tiny errors
/// into the largest term of the loss. They are about a fiftieth to a tenth of what walking shows.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SpreadFloors {
    /// Root height (m).
    pub height: f64,
    /// Root linear velocity (m/s).
    pub linear_velocity: f64,
    /// Root angular velocity (rad/s).
    pub angular_velocity: f64,
    /// Joint position (rad).
    pub joint_position: f64,
    /// Joint velocity (rad/s).
    pub joint_velocity: f64,
    /// End-effector position (m).
    pub effector: f64,
}

impl Default for SpreadFloors {
    fn default() -> Self {
        Self {
            height: 0.02,
            linear_velocity: 0.1,
            angular_velocity: 0.2,
            joint_position: 0.05,
            joint_velocity: 0.3,
            effector: 0.03,
        }
    }
}

impl SpreadFloors {
    pub(super) fn check(&self) -> Result<(), LearnError> {
        range("floors.height", self.height, 1e-6, 1e3)?;
        range("floors.linear_velocity", self.linear_velocity, 1e-6, 1e3)?;
        range("floors.angular_velocity", self.angular_velocity, 1e-6, 1e3)?;
        range("floors.joint_position", self.joint_position, 1e-6, 1e3)?;
        range("floors.joint_velocity", self.joint_velocity, 1e-6, 1e3)?;
        range("floors.effector", self.effector, 1e-6, 1e3)
    }

    /// The floor of every feature; orientation's is 0, it is never normalised.
    fn of(&self, layout: &FeatureLayout) -> Vec<f64> {
        let mut floors = vec![0.0; layout.size()];
        floors[FeatureLayout::HEIGHT] = self.height;
        floors[7..10].fill(self.linear_velocity);
        floors[10..13].fill(self.angular_velocity);
        floors[layout.joint_positions()].fill(self.joint_position);
        floors[layout.joint_velocities()].fill(self.joint_velocity);
        floors[layout.effectors()].fill(self.effector);
        floors
    }
}

/// Mean and spread of every feature over all frames of a data set, each frame in its own heading frame. Orientation has
/// mean 0 and spread 1 here, because it is not normalised.
#[derive(Debug, Clone, PartialEq)]
pub struct FeatureStatistics {
    mean: Vec<f64>,
    spread: Vec<f64>,
}

impl FeatureStatistics {
    /// Over these frames.
    pub fn of<'a>(layout: &FeatureLayout, floors: &SpreadFloors, frames: impl Iterator<Item = &'a Frame>) -> Self {
        let size = layout.size();
        let (mut mean, mut square, mut count) = (vec![0.0; size], vec![0.0; size], 0.0);
        let mut row = vec![0.0; size];
        for frame in frames {
            frame.write_features(&frame.root_orientation, &mut row);
            count += 1.0;
            for ((m, s), x) in mean.iter_mut().zip(&mut square).zip(&row) {
                let delta = x - *m;
                *m += delta / count;
                *s += delta * (x - *m);
            }
        }
        let floors = floors.of(layout);
        let mut spread: Vec<f64> =
            square.iter().zip(&floors).map(|(s, floor)| (s / f64::max(count, 1.0)).sqrt().max(*floor)).collect();
        mean[FeatureLayout::ORIENTATION].fill(0.0);
        spread[FeatureLayout::ORIENTATION].fill(1.0);
        Self { mean, spread }
    }

    /// Mean of every feature (SI).
    pub fn mean(&self) -> &[f64] {
        &self.mean
    }

    /// Standard deviation, floored, of every feature (SI).
    pub fn spread(&self) -> &[f64] {
        &self.spread
    }

    /// Normalises rows of features in place.
    pub fn normalize(&self, rows: &mut [f64]) {
        for row in rows.chunks_exact_mut(self.mean.len()) {
            for ((x, m), s) in row.iter_mut().zip(&self.mean).zip(&self.spread) {
                *x = (*x - m) / s;
            }
        }
    }

    /// Back to SI units.
    pub fn denormalize(&self, rows: &mut [f64]) {
        for row in rows.chunks_exact_mut(self.mean.len()) {
            for ((x, m), s) in row.iter_mut().zip(&self.mean).zip(&self.spread) {
                *x = *x * s + m;
            }
        }
    }

    pub(super) fn save_into(&self, checkpoint: &mut Checkpoint) -> Result<(), CheckpointError> {
        checkpoint.put_f64("statistics.mean", &[self.mean.len()], self.mean.clone())?;
        checkpoint.put_f64("statistics.spread", &[self.spread.len()], self.spread.clone())
    }

    pub(super) fn load_from(checkpoint: &Checkpoint, size: usize) -> Result<Self, CheckpointError> {
        let mean = checkpoint.f64s("statistics.mean", &[size])?;
        Ok(Self { mean, spread: checkpoint.f64s("statistics.spread", &[size])? })
    }
}
