//! Mean and standard deviation of the features of a data set, by which windows and single frames are normalised (thesis 4.2.1).

use lifelike_checkpoint::{Checkpoint, CheckpointError};
use lifelike_motion::{FeatureLayout, Frame};

use crate::standardizer::{Moments, Standardizer};

/// Smallest standard deviations to divide by. A joint that hardly moves in the data would otherwise turn tiny errors
/// into the largest term of the loss. They are about a fiftieth to a tenth of what walking shows.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct StdFloors {
    /// Root height (m).
    #[schemars(extend("unit" = "m"), range(min = 1e-6, max = 1e3))]
    pub height: f64,
    /// Root linear velocity (m/s).
    #[schemars(extend("unit" = "m/s"), range(min = 1e-6, max = 1e3))]
    pub linear_velocity: f64,
    /// Root angular velocity (rad/s).
    #[schemars(extend("unit" = "rad/s"), range(min = 1e-6, max = 1e3))]
    pub angular_velocity: f64,
    /// Joint position (rad).
    #[schemars(extend("unit" = "rad"), range(min = 1e-6, max = 1e3))]
    pub joint_position: f64,
    /// Joint velocity (rad/s).
    #[schemars(extend("unit" = "rad/s"), range(min = 1e-6, max = 1e3))]
    pub joint_velocity: f64,
    /// End-effector position (m).
    #[schemars(extend("unit" = "m"), range(min = 1e-6, max = 1e3))]
    pub effector: f64,
}

impl Default for StdFloors {
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

impl StdFloors {
    /// Returns the floor of every feature; orientation's is 0, it is never normalised.
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

/// Mean and standard deviation of every feature over all frames of a data set, each frame in its own heading frame.
/// Orientation has mean 0 and standard deviation 1 here, because it is not normalised.
#[derive(Debug, Clone, PartialEq)]
pub struct FeatureStatistics(Standardizer);

impl FeatureStatistics {
    /// Returns the statistics of these frames.
    pub fn of<'a>(layout: &FeatureLayout, floors: &StdFloors, frames: impl Iterator<Item = &'a Frame>) -> Self {
        let mut row = vec![0.0; layout.size()];
        let mut moments = Moments::new(row.len());
        for frame in frames {
            frame.write_features(&frame.root_orientation, &mut row);
            moments.add(row.iter().copied());
        }
        let (mut mean, mut std) = moments.finish();
        std.iter_mut().zip(floors.of(layout)).for_each(|(std, floor)| *std = std.max(floor));
        mean[FeatureLayout::ORIENTATION].fill(0.0);
        std[FeatureLayout::ORIENTATION].fill(1.0);
        Self(Standardizer::new(mean, std))
    }

    /// Returns the mean of every feature (SI).
    pub fn mean(&self) -> &[f64] {
        self.0.mean()
    }

    /// Returns the standard deviation, floored, of every feature (SI).
    pub fn std(&self) -> &[f64] {
        self.0.std()
    }

    /// Normalises rows of features in place.
    pub fn normalize(&self, rows: &mut [f64]) {
        self.0.normalize(rows);
    }

    /// Returns rows to SI units, in place.
    pub fn denormalize(&self, rows: &mut [f64]) {
        self.0.denormalize(rows);
    }

    pub(super) fn save_into(&self, checkpoint: &mut Checkpoint) -> Result<(), CheckpointError> {
        self.0.save_into(checkpoint, NAME)
    }

    pub(super) fn load_from(checkpoint: &Checkpoint, size: usize) -> Result<Self, CheckpointError> {
        Ok(Self(Standardizer::load_from(checkpoint, NAME, size)?))
    }
}

/// Name in files.
const NAME: &str = "statistics";
