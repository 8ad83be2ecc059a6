//! Reconstruction errors of windows from their latent codes, in units people can judge.

use lifelike_character::Vec3;
use lifelike_character::rotation::from_6d;
use lifelike_motion::FeatureLayout;

/// Mean absolute errors of decode(encode(window)).
#[derive(Debug, Clone, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct ReconstructionErrors {
    /// Joint positions (deg).
    pub joints_deg: f64,
    /// End-effector positions relative to the root: mean distance (mm).
    pub effectors_mm: f64,
    /// Root height (mm).
    pub height_mm: f64,
    /// Root orientation: mean angle (deg).
    pub orientation_deg: f64,
}

/// Reconstruction of the windows of some clips.
#[derive(Debug, Clone, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct ReconstructionReport {
    /// Windows looked at.
    pub windows: usize,
    /// Over all samples of all windows.
    pub window: ReconstructionErrors,
    /// Over the centre samples only: what the tracker is at when it reads the latent.
    pub centre: ReconstructionErrors,
    /// Over all samples, per clip, worst joints first.
    pub clips: Vec<(String, ReconstructionErrors)>,
}

/// Sums of errors on the way to their means.
#[derive(Debug, Clone, Default)]
pub(super) struct ErrorSums {
    sums: ReconstructionErrors,
    count: usize,
}

impl ErrorSums {
    /// Adds one sample: features in SI units, expected and decoded.
    pub(super) fn add(&mut self, layout: &FeatureLayout, expected: &[f64], got: &[f64]) {
        let joints = layout.joint_positions();
        let n = joints.len().max(1) as f64;
        let q: f64 = expected[joints.clone()].iter().zip(&got[joints]).map(|(a, b)| (a - b).abs()).sum();
        let effectors = layout.effectors();
        let points = |row: &[f64]| -> Vec<Vec3> {
            row[effectors.clone()].as_chunks::<3>().0.iter().map(|p| Vec3::new(p[0], p[1], p[2])).collect()
        };
        let (a, b) = (points(expected), points(got));
        let p: f64 = a.iter().zip(&b).map(|(a, b)| (a - b).norm()).sum();
        self.sums.joints_deg += (q / n).to_degrees();
        self.sums.effectors_mm += 1000.0 * p / a.len().max(1) as f64;
        self.sums.height_mm += 1000.0 * (expected[FeatureLayout::HEIGHT] - got[FeatureLayout::HEIGHT]).abs();
        self.sums.orientation_deg += angle(expected, got).to_degrees();
        self.count += 1;
    }

    pub(super) fn merge(&mut self, other: &Self) {
        self.sums.joints_deg += other.sums.joints_deg;
        self.sums.effectors_mm += other.sums.effectors_mm;
        self.sums.height_mm += other.sums.height_mm;
        self.sums.orientation_deg += other.sums.orientation_deg;
        self.count += other.count;
    }

    pub(super) fn mean(&self) -> ReconstructionErrors {
        let n = self.count.max(1) as f64;
        let ReconstructionErrors { joints_deg, effectors_mm, height_mm, orientation_deg } = self.sums;
        ReconstructionErrors {
            joints_deg: joints_deg / n,
            effectors_mm: effectors_mm / n,
            height_mm: height_mm / n,
            orientation_deg: orientation_deg / n,
        }
    }
}

/// Returns the angle between two 6D orientations (rad); half a turn where the decoded one is degenerate.
fn angle(a: &[f64], b: &[f64]) -> f64 {
    let rotation = |row: &[f64]| row.get(FeatureLayout::ORIENTATION).and_then(|d| from_6d(d.try_into().ok()?));
    match (rotation(a), rotation(b)) {
        (Some(a), Some(b)) => a.angle_to(&b),
        _ => std::f64::consts::PI,
    }
}
