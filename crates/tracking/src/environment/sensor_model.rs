//! The sensor model: noise and delay between the robot and the policy, and delay between the policy and the motors.
//!
//! The value function exists in training only and sees the truth.

use std::ops::Range;

use lifelike_robot::observation::{Part, Sensor, Source};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use crate::episode::Episode;
use crate::plan::SensorSpec;

/// A [`SensorSpec`] for one layout of observations.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct SensorModel {
    spec: SensorSpec,
    /// Standard deviation of the noise on each number of a row; empty: no noise.
    deviation: Vec<f32>,
    /// Parts that are measured, and so can be late.
    measured: Vec<Range<usize>>,
}

impl SensorModel {
    /// Returns the model for rows of `size` numbers with these parts.
    pub(super) fn new(spec: SensorSpec, size: usize, parts: impl IntoIterator<Item = Part>) -> Self {
        let mut deviation = vec![0.0; size];
        let mut measured = Vec::new();
        for Part { source, range, .. } in parts {
            let Source::Measured(sensor) = source else { continue };
            deviation[range.clone()].fill(match sensor {
                Sensor::RootOrientation => spec.orientation_noise,
                Sensor::RootLinearVelocity => spec.linear_velocity_noise,
                Sensor::RootAngularVelocity => spec.angular_velocity_noise,
                Sensor::JointPosition => spec.joint_position_noise,
                Sensor::JointVelocity => spec.joint_velocity_noise,
                Sensor::RootHeight | Sensor::KeyBodies | Sensor::Heading | Sensor::Place => 0.0,
            });
            measured.push(range);
        }
        if deviation.iter().all(|d| *d == 0.0) {
            deviation.clear();
        }
        Self { spec, deviation, measured }
    }

    /// Returns how many numbers an episode keeps of past measurements.
    pub(super) fn history(&self) -> usize {
        self.spec.observation_delay as usize * self.width()
    }

    fn width(&self) -> usize {
        self.measured.iter().map(ExactSizeIterator::len).sum()
    }

    /// Turns the true observation into the measured one, in place.
    pub(super) fn measure(&self, row: &mut [f32], episode: &mut Episode, rng: impl FnOnce() -> ChaCha8Rng) {
        if !self.deviation.is_empty() {
            let mut rng = rng();
            for (x, deviation) in row.iter_mut().zip(&self.deviation).filter(|(_, d)| **d > 0.0) {
                let z: f32 = StandardNormal.sample(&mut rng);
                *x += deviation * z;
            }
        }
        if episode.past_measurements.is_empty() {
            return;
        }
        let Episode { past_measurements: past, frame, segment_start, observation_delay, .. } = episode;
        let width = self.width();
        let slots = || self.measured.iter().flat_map(Clone::clone);
        if frame == segment_start {
            // Nothing was measured before, or only against another clip: the past is taken to be like the present.
            for past in past.chunks_exact_mut(width) {
                past.iter_mut().zip(slots()).for_each(|(past, slot)| *past = row[slot]);
            }
            return;
        }
        // What is late by all that is remembered comes back from where the present goes to.
        past.rotate_right(width);
        let (newest, older) = past.split_at_mut(width);
        for (k, slot) in slots().enumerate() {
            std::mem::swap(&mut row[slot], &mut newest[k]);
            match *observation_delay as usize {
                0 => row[slot] = newest[k],
                delay => row[slot] = older.get((delay - 1) * width + k).copied().unwrap_or(row[slot]),
            }
        }
    }
}

/// Turns the joint targets of this step into those that reach the motors in it, in place.
pub(super) fn delay_targets(target: &mut [f32], episode: &mut Episode) {
    let Episode { past_targets: past, length, action_delay, .. } = episode;
    if past.is_empty() {
        return;
    }
    let width = target.len();
    if *length == 0 {
        past.chunks_exact_mut(width).for_each(|past| past.copy_from_slice(target));
    }
    past.rotate_right(width);
    let (newest, older) = past.split_at_mut(width);
    newest.swap_with_slice(target);
    match *action_delay as usize {
        0 => target.copy_from_slice(newest),
        delay if delay * width <= older.len() => target.copy_from_slice(&older[(delay - 1) * width..delay * width]),
        _ => {}
    }
}
