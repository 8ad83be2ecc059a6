//! What stands between the robot and what the policy is told, and between the policy and the motors: noise and delays.
//!
//! The value function exists in training only and sees the truth.

use std::ops::Range;

use lifelike_robot::ObservationSpec;
use lifelike_robot::observation::{Sensor, Source};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use super::episode::Episode;
use super::plan::senses::SenseSpec;

/// A [`SenseSpec`] for one layout of observations.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Senses {
    pub(super) spec: SenseSpec,
    /// Deviation of the noise on each number of a row; empty: no noise.
    deviation: Vec<f32>,
    /// What is measured, and so can be late. The policy knows its own actions and its reference.
    measured: Vec<Range<usize>>,
}

impl Senses {
    pub(super) fn new(spec: SenseSpec, layout: &ObservationSpec) -> Self {
        let noise = |source: Source| match source {
            Source::Measured(Sensor::RootOrientation) => spec.orientation_noise,
            Source::Measured(Sensor::RootLinearVelocity) => spec.linear_velocity_noise,
            Source::Measured(Sensor::RootAngularVelocity) => spec.angular_velocity_noise,
            Source::Measured(Sensor::JointPosition) => spec.joint_position_noise,
            Source::Measured(Sensor::JointVelocity) => spec.joint_velocity_noise,
            Source::Measured(Sensor::RootHeight | Sensor::KeyBodies | Sensor::Heading | Sensor::Place)
            | Source::Action
            | Source::Reference => 0.0,
        };
        let parts = layout.parts();
        let mut deviation = vec![0.0; layout.size()];
        for part in &parts {
            deviation[part.range.clone()].fill(noise(part.source));
        }
        if deviation.iter().all(|d| *d == 0.0) {
            deviation.clear();
        }
        let measured = parts.into_iter().filter(|part| matches!(part.source, Source::Measured(_)));
        let measured = measured.map(|part| part.range).collect();
        Self { spec, deviation, measured }
    }

    /// Numbers that an episode keeps of what was measured.
    pub(super) fn memory(&self) -> usize {
        self.spec.observation_delay as usize * self.width()
    }

    fn width(&self) -> usize {
        self.measured.iter().map(ExactSizeIterator::len).sum()
    }

    /// Turns the truth into what the policy is told, in place.
    pub(super) fn tell(&self, row: &mut [f32], episode: &mut Episode, rng: impl FnOnce() -> ChaCha8Rng) {
        if !self.deviation.is_empty() {
            let mut rng = rng();
            for (x, deviation) in row.iter_mut().zip(&self.deviation).filter(|(_, d)| **d > 0.0) {
                let z: f32 = StandardNormal.sample(&mut rng);
                *x += deviation * z;
            }
        }
        let width = self.width();
        if episode.measured.is_empty() || width == 0 {
            return;
        }
        let now: Vec<f32> = self.measured.iter().flat_map(|range| row[range.clone()].iter().copied()).collect();
        if episode.frame == episode.stretch {
            // Nothing was measured before, or it was measured against another clip: it stood as it stands.
            episode.measured.chunks_exact_mut(width).for_each(|past| past.copy_from_slice(&now));
            return;
        }
        if episode.observation_delay > 0 {
            let mut past = episode.measured[(episode.observation_delay as usize - 1) * width..].iter();
            for slot in self.measured.iter().flat_map(Clone::clone) {
                row[slot] = past.next().copied().unwrap_or(row[slot]);
            }
        }
        episode.measured.rotate_right(width);
        episode.measured[..width].copy_from_slice(&now);
    }

    /// Turns the joint targets of now into those that reach the motors now, in place.
    pub(super) fn delay(target: &mut [f32], episode: &mut Episode) {
        let width = target.len();
        if episode.waiting.is_empty() {
            return;
        }
        let now = target.to_vec();
        if episode.length == 0 {
            episode.waiting.chunks_exact_mut(width).for_each(|past| past.copy_from_slice(&now));
        }
        if episode.action_delay > 0 {
            let at = (episode.action_delay as usize - 1) * width;
            target.copy_from_slice(&episode.waiting[at..at + width]);
        }
        episode.waiting.rotate_right(width);
        episode.waiting[..width].copy_from_slice(&now);
    }
}
