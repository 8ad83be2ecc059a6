//! Results of a sweep.

use super::disturbance::Disturbance;
use crate::tables::playback;
use crate::{ClipScore, Rollout};
use lifelike_report::{Curve, Playback};

/// One size of a disturbance.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Point {
    /// Its size, in the unit of the disturbance.
    pub size: f64,
    /// All episodes together.
    pub score: ClipScore,
}

/// Survival and error against one disturbance.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct RobustnessCurve {
    /// The disturbance.
    pub disturbance: Disturbance,
    /// Its name.
    pub name: &'static str,
    /// Unit of its sizes.
    pub unit: &'static str,
    /// Description of the disturbance, a sentence.
    pub what: &'static str,
    /// From the mildest to the hardest.
    pub points: Vec<Point>,
}

/// All curves of a policy.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Robustness {
    /// The robot.
    pub robot: String,
    /// The engine.
    pub engine: String,
    /// Seed of everything random.
    pub seed: u64,
    /// The clips.
    pub clips: Vec<String>,
    /// Longest episode (s).
    pub episode_seconds: f64,
    /// The curves.
    pub curves: Vec<RobustnessCurve>,
    /// One episode that survived and one that fell of each curve, as far as there are; not part of the JSON.
    #[serde(skip)]
    pub rollouts: Vec<Rollout>,
}

impl Robustness {
    /// Survival (%) and joint error (deg) of every disturbance, for a report.
    pub fn curves(&self) -> Vec<Curve> {
        let curve = |c: &RobustnessCurve, group: &str, value: fn(&ClipScore) -> f64| {
            let mut points: Vec<(f64, f64)> = c.points.iter().map(|p| (p.size, value(&p.score))).collect();
            points.sort_by(|a, b| a.0.total_cmp(&b.0));
            let (x, y) = points.into_iter().unzip();
            Curve { name: format!("{group}/{} [{}]", c.name, c.unit), x, y, ..Curve::default() }
        };
        let survival = self.curves.iter().map(|c| curve(c, "survival (%)", |s| 100.0 * s.survival));
        let error = self.curves.iter().map(|c| curve(c, "joint error (deg)", |s| s.joint_error_deg));
        survival.chain(error).collect()
    }

    /// The recorded episodes.
    pub fn playbacks(&self) -> Vec<Playback> {
        self.rollouts.iter().map(playback).collect()
    }
}
