//! The list of reward terms. To add one, add a declaration here: plan keys, metric, curriculum and table of keys follow.

use std::ops::Range;

use lifelike_motion::FeatureLayout;

use super::declare::{Bonus, Fault, Kernel, Penalty, TermKind, Tracking, reward_terms};
use super::floors::Floors;
use super::inputs::RewardInputs;
use super::norm::Norm;
use super::{Term, TermValues};

const HEIGHT: Range<usize> = FeatureLayout::HEIGHT..FeatureLayout::HEIGHT + 1;
const LINEAR_VELOCITY: Range<usize> = FeatureLayout::VELOCITY.start..FeatureLayout::VELOCITY.start + 3;
const ANGULAR_VELOCITY: Range<usize> = FeatureLayout::VELOCITY.start + 3..FeatureLayout::VELOCITY.start + 6;

/// Default of [`ExponentialReward::angular_share`].
const ANGULAR_SHARE: f32 = 0.0375;

reward_terms! {
    /// Root height: eq. 4.6, c^h.
    height: Tracking, "m²" = Kernel::new(0.1, 150.0), {
        thesis: |x, reward| reward.norm.of(x, HEIGHT),
        exponential: |x, _| x.square(HEIGHT)
    }
    /// Root orientation, heading removed, ‖R − R'‖²_F: eq. 4.6, c^θ.
    orientation: Tracking, "" = Kernel::new(0.15, 4.0), {
        thesis: |x, _| x.orientation_square(),
        exponential: |x, _| x.orientation_square()
    }
    /// Root velocities, ‖Δv‖² + `angular_share` ‖Δω‖²: eq. 4.6, c^v.
    velocity: Tracking, "m²/s²" = Kernel::new(0.2, 4.0), {
        thesis: |x, reward| reward.norm.of(x, FeatureLayout::VELOCITY),
        exponential: |x, reward| x.square(LINEAR_VELOCITY) + reward.angular_share * x.square(ANGULAR_VELOCITY)
    }
    /// Joint positions (exponential: mean over joints): eq. 4.6, c^q.
    joint_position: Tracking, "rad²" = Kernel::new(0.35, 40.0), {
        thesis: |x, reward| reward.norm.of(x, x.layout.joint_positions()),
        exponential: |x, _| x.square(x.layout.joint_positions()) / x.joints()
    }
    /// Joint velocities (exponential: mean over joints): eq. 4.6, c^q̇.
    joint_velocity: Tracking, "rad²/s²" = Kernel::new(0.1, 0.8), {
        thesis: |x, reward| reward.norm.of(x, x.layout.joint_velocities()),
        exponential: |x, _| x.square(x.layout.joint_velocities()) / x.joints()
    }
    /// End effectors, squared distance (exponential: mean over them): eq. 4.6, c^p.
    effectors: Tracking, "m²" = Kernel::new(0.2, 240.0), {
        thesis: |x, reward| reward.norm.of(x, x.layout.effectors()),
        exponential: |x, _| x.square(x.layout.effectors()) / x.effectors()
    }
    /// Every step survived: eq. 4.7, c^alive.
    alive: Bonus, "" = 0.0, {
        thesis: |_, _| 1.0,
        exponential: |_, _| 1.0
    }
    /// Getting up, u·h, and as much again for the reference's joints once both are near 1; not in the thesis.
    ///
    /// The trunk's up axis gives u, 0 or more, and the root's height over the reference's gives h, at most 1: height counts
    /// only when upright.
    #[serde(default)]
    get_up: Bonus, "" = 0.0, {
        thesis: |x, _| x.raised(),
        exponential: |x, reward| {
            let posture = x.square(x.layout.joint_positions()) / x.joints();
            x.raised() + x.raised().powi(8) * (-reward.joint_position.sharpness * posture).exp()
        }
    }
    /// Heading against the anchored reference; not in the thesis.
    #[serde(default)]
    heading: Tracking, "rad²" = Kernel::new(0.15, 10.0), {
        thesis: |x, _| x.heading * x.heading,
        exponential: |x, _| x.heading * x.heading
    }
    /// Distance on the ground from the anchored reference; not in the thesis.
    #[serde(default)]
    path: Tracking, "m²" = Kernel::new(0.15, 20.0), {
        thesis: |x, _| x.path * x.path,
        exponential: |x, _| x.path * x.path
    }
    /// Standing soles over the ground, sum of squared speeds; not in the thesis.
    #[serde(default)]
    slip: Fault, "m²/s²" = 0.0, {
        thesis: |x, _| x.slip_square,
        exponential: |x, _| x.slip_square
    }
    /// Number of soles that carry weight while the reference's swing; not in the thesis.
    ///
    /// Without it a robot that only stands loses little to one that steps, and falls less. Soles in the air cost nothing
    /// here, which would hurt a policy that cannot stand yet.
    #[serde(default)]
    swing: Fault, "" = 0.0, {
        thesis: |x, _| x.missed_swings,
        exponential: |x, _| x.missed_swings
    }
    /// Change of the action, ‖a_t − a_{t−1}‖²: eq. 4.8, c^Δa.
    action_rate: Penalty, "rad²" = 0.05, {
        thesis: |x, _| x.cost.rate_square(),
        exponential: |x, _| x.cost.rate_square()
    }
    /// Second difference of the action, ‖a_t − 2 a_{t−1} + a_{t−2}‖²: eq. 4.8, c^Δ²a.
    action_acceleration: Penalty, "rad²" = 0.015, {
        thesis: |x, _| x.cost.acceleration_square(),
        exponential: |x, _| x.cost.acceleration_square()
    }
    /// Torques, Σ τ² over the joints: eq. 4.8, c^τ.
    torque: Penalty, "N² m²" = 1e-5, {
        thesis: |x, _| x.cost.torque_squared,
        exponential: |x, _| x.cost.torque_squared
    }
}
