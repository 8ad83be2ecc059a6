//! Inputs of reward terms: one step of one environment.

use std::ops::Range;

use lifelike_motion::FeatureLayout;

/// One step of one environment, as the reward sees it: simulated state, reference and action.
#[derive(Debug, Clone, Copy)]
pub struct RewardInputs<'a> {
    /// Layout of the features.
    pub layout: &'a FeatureLayout,
    /// Features of the simulated state (eq. 4.1) in its own heading frame, `[F]`.
    pub simulated: &'a [f32],
    /// Features of the reference in ITS own heading frame, `[F]`.
    pub reference: &'a [f32],
    /// Divisors of the features' differences, `[F]`; empty where nothing is normalised.
    pub divisor: &'a [f32],
    /// Heading against the anchored reference (rad, in −π..π).
    pub heading: f32,
    /// Distance on the ground from the anchored reference (m).
    pub path: f32,
    /// Sum over the standing soles of their squared speed over the ground (m²/s²).
    pub slip_square: f32,
    /// Number of soles that carry weight while the reference's are off the ground.
    pub missed_swings: f32,
    /// Actions and torques.
    pub cost: ActionCost<'a>,
}

/// Actions and torques of a step. Actions are the policy's outputs, `[J]` each; `scale` times them are the offsets of the joint
/// targets from their base (rad), which their costs are of.
#[derive(Debug, Clone, Copy)]
pub struct ActionCost<'a> {
    /// The action, a_t.
    pub action: &'a [f32],
    /// The action one step ago, a_{t−1}.
    pub previous: &'a [f32],
    /// The action two steps ago, a_{t−2}.
    pub oldest: &'a [f32],
    /// Offset of a joint target for an output of 1 (rad).
    pub scale: f32,
    /// Σ τ² over the joints (N² m²).
    pub torque_squared: f32,
}

impl RewardInputs<'_> {
    /// Returns the squared difference of some features.
    pub fn square(&self, features: Range<usize>) -> f32 {
        squared_distance(&self.simulated[features.clone()], &self.reference[features])
    }

    /// Returns the squared difference of some features, each divided by its divisor (the mean of the data cancels).
    pub fn normalised_square(&self, features: Range<usize>) -> f32 {
        let columns = [self.simulated, self.reference, self.divisor].map(|values| &values[features.clone()]);
        sum(columns, |[x, y, s]| ((x - y) / s) * ((x - y) / s))
    }

    /// Returns ‖R(θ) − R(θ')‖²_F: the 6D representation holds two columns, the third is their cross product.
    pub fn orientation_square(&self) -> f32 {
        let (a, b) = (&self.simulated[FeatureLayout::ORIENTATION], &self.reference[FeatureLayout::ORIENTATION]);
        squared_distance(a, b) + squared_distance(&third_column(a), &third_column(b))
    }

    /// Returns the share of the way up, 0 to 1: the up axis' vertical part times the root's height over the reference's.
    pub fn raised(&self) -> f32 {
        let upright = third_column(&self.simulated[FeatureLayout::ORIENTATION])[2].max(0.0);
        let [height, standing] = [self.simulated, self.reference].map(|features| features[FeatureLayout::HEIGHT]);
        upright * (height / standing.max(f32::EPSILON)).clamp(0.0, 1.0)
    }

    /// Returns the number of joints, at least 1.
    pub fn joints(&self) -> f32 {
        self.layout.joints.len().max(1) as f32
    }

    /// Returns the number of end effectors, at least 1.
    pub fn effectors(&self) -> f32 {
        self.layout.end_effectors.len().max(1) as f32
    }
}

impl ActionCost<'_> {
    /// Returns ‖a_t − a_{t−1}‖² (eq. 4.8).
    pub fn rate_square(&self) -> f32 {
        self.scale * self.scale * squared_distance(self.action, self.previous)
    }

    /// Returns ‖a_t − 2 a_{t−1} + a_{t−2}‖² (eq. 4.8).
    pub fn acceleration_square(&self) -> f32 {
        let second = |[a, b, c]: [f32; 3]| a - 2.0 * b + c;
        self.scale * self.scale * sum([self.action, self.previous, self.oldest], |row| second(row) * second(row))
    }
}

/// Returns ‖x − y‖².
#[inline(always)]
pub fn squared_distance(x: &[f32], y: &[f32]) -> f32 {
    sum([x, y], |[x, y]| (x - y) * (x - y))
}

/// Returns the sum of a function of each row, the slices being columns of one length.
///
/// Eight sums side by side, always the same eight: none waits for another, so they become vector instructions, and all
/// machines round alike.
#[inline(always)]
pub fn sum<const N: usize>(columns: [&[f32]; N], of: impl Fn([f32; N]) -> f32) -> f32 {
    let parts = columns.map(|column| column.as_chunks::<8>());
    let mut sums = [0.0_f32; 8];
    for at in 0..parts.iter().map(|(whole, _)| whole.len()).min().unwrap_or(0) {
        let rows = parts.map(|(whole, _)| whole[at]);
        for k in 0..8 {
            sums[k] += of(rows.map(|row| row[k]));
        }
    }
    for k in 0..parts.iter().map(|(_, rest)| rest.len()).min().unwrap_or(0) {
        sums[k] += of(parts.map(|(_, rest)| rest[k]));
    }
    let [a, b, c, d, e, f, g, h] = sums;
    ((a + e) + (b + f)) + ((c + g) + (d + h))
}

fn third_column(d: &[f32]) -> [f32; 3] {
    [d[1] * d[5] - d[2] * d[4], d[2] * d[3] - d[0] * d[5], d[0] * d[4] - d[1] * d[3]]
}
