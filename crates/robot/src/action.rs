//! Outputs of a policy as joint targets.

use nalgebra::RealField;

use crate::robot::Robot;

/// Map from the network's output `y` (one number per joint) to joint targets (rad).
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, tag = "base", rename_all = "snake_case")]
pub enum ActionSpec {
    /// `target = y`, clamped to the joint's limits and a margin: the thesis' form (eq. 4.9's a_t).
    Absolute,
    /// `target = default pose + scale · y`.
    DefaultPose {
        /// Offset of a joint target for an output of 1 (rad).
        #[schemars(extend("unit" = "rad"), range(min = 1e-6, max = 100.0))]
        scale: f64,
    },
    /// `target = reference(t+1) + scale · y`: the policy only corrects.
    Reference {
        /// Offset of a joint target for an output of 1 (rad).
        #[schemars(extend("unit" = "rad"), range(min = 1e-6, max = 100.0))]
        scale: f64,
    },
    /// `target = default pose + scale · y`, with neither outputs nor targets clamped: as other stacks do it.
    Unclamped {
        /// Offset of a joint target for an output of 1; 1 for a policy that was imported (rad).
        #[schemars(extend("unit" = "rad"), range(min = 1e-6, max = 100.0))]
        scale: f64,
    },
}

impl ActionSpec {
    /// Outputs are clamped to ± this before anything else is done with them.
    pub const OUTPUT_LIMIT: f64 = 4.0;

    /// Largest distance of a hinge's target beyond the joint's range (rad). A PD controller holds a load only with its
    /// target off the angle that it holds, at a joint's limit too.
    pub const TARGET_MARGIN: f64 = 0.5;

    /// Returns the distance of a target from its base for an output of 1 (rad).
    pub fn scale(&self) -> f64 {
        match *self {
            Self::Absolute => 1.0,
            Self::DefaultPose { scale } | Self::Reference { scale } | Self::Unclamped { scale } => scale,
        }
    }

    /// The output that counts: `y`, clamped to ±[`Self::OUTPUT_LIMIT`] unless [`Self::Unclamped`]. NaN stays NaN, for the caller
    /// to quarantine.
    #[inline]
    pub fn clamp_output<T: RealField + Copy>(&self, output: T) -> T {
        if matches!(self, Self::Unclamped { .. }) {
            return output;
        }
        let limit: T = nalgebra::convert(Self::OUTPUT_LIMIT);
        clamp(output, -limit, limit)
    }

    /// The target of one joint (rad), for an output `y`, the joint's default angle and the reference's angle at t+1.
    #[inline]
    pub fn target<T: RealField + Copy>(&self, output: T, default_pose: T, reference: T, (low, high): (T, T)) -> T {
        let output = self.clamp_output(output);
        let target = match *self {
            Self::Unclamped { scale } => return default_pose + output * nalgebra::convert(scale),
            Self::Absolute => output,
            Self::DefaultPose { scale } => default_pose + output * nalgebra::convert(scale),
            Self::Reference { scale } => reference + output * nalgebra::convert(scale),
        };
        clamp(target, low, high)
    }

    /// Returns true where [`Self::target`] reads the reference.
    pub fn needs_reference(&self) -> bool {
        matches!(self, Self::Reference { .. })
    }
}

/// `x` between `low` and `high`; NaN stays NaN.
#[inline]
fn clamp<T: RealField + Copy>(x: T, low: T, high: T) -> T {
    // Two choices, not three ways: vectors can do it.
    let above = if x < low { low } else { x };
    if above > high { high } else { above }
}

/// An [`ActionSpec`] for all joints of one robot.
#[derive(Debug, Clone, PartialEq)]
pub struct ActionMap {
    /// Meaning of the outputs.
    pub spec: ActionSpec,
    /// Default angle of each joint (rad).
    pub default_pose: Vec<f32>,
    /// Least and greatest target of each joint (rad): its range and the margin; infinite where it has no range.
    pub limits: Vec<(f32, f32)>,
}

impl ActionMap {
    /// The map for a robot.
    pub fn new(spec: ActionSpec, robot: &Robot) -> Self {
        let limits = robot
            .character
            .scalar_joints()
            .map(|joint| match joint.range {
                None => (f32::NEG_INFINITY, f32::INFINITY),
                Some((low, high)) => {
                    let margin = match joint.kind {
                        lifelike_character::JointKind::Slide => 0.1 * (high - low),
                        _ => ActionSpec::TARGET_MARGIN,
                    };
                    ((low - margin) as f32, (high + margin) as f32)
                }
            })
            .collect();
        Self { spec, default_pose: robot.default_pose.iter().map(|&q| q as f32).collect(), limits }
    }

    /// Writes the outputs that hold joints where they are: the inverse of [`Self::write`], clamped as outputs are.
    ///
    /// # Shapes
    /// `positions`, `reference`, `outputs`: `[J]`.
    pub fn holding(&self, positions: &[f32], reference: &[f32], outputs: &mut [f32]) {
        for (j, (output, &q)) in outputs.iter_mut().zip(positions).enumerate() {
            let y = match self.spec {
                ActionSpec::Absolute => q,
                ActionSpec::DefaultPose { scale } | ActionSpec::Unclamped { scale } => {
                    (q - self.default_pose[j]) / scale as f32
                }
                ActionSpec::Reference { scale } => (q - reference.get(j).copied().unwrap_or(q)) / scale as f32,
            };
            *output = self.spec.clamp_output(y);
        }
    }

    /// Writes the targets of one environment.
    ///
    /// # Shapes
    /// `outputs`, `targets`: `[J]`; `reference`: `[J]`, or empty where [`ActionSpec::needs_reference`] is false.
    ///
    /// # Panics
    /// Debug builds check the lengths.
    pub fn write(&self, outputs: &[f32], reference: &[f32], targets: &mut [f32]) {
        debug_assert_eq!(outputs.len(), self.limits.len());
        debug_assert_eq!(targets.len(), self.limits.len());
        debug_assert!(!self.spec.needs_reference() || reference.len() == self.limits.len());
        for (i, (target, &output)) in targets.iter_mut().zip(outputs).enumerate() {
            let reference = reference.get(i).copied().unwrap_or(0.0);
            *target = self.spec.target(output, self.default_pose[i], reference, self.limits[i]);
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::expect_used)]
    use super::*;

    const WIDE: (f64, f64) = (-10.0, 10.0);

    #[test]
    fn each_base_adds_what_it_says() {
        assert_eq!(ActionSpec::Absolute.target(0.5, 1.0, 2.0, WIDE), 0.5);
        assert_eq!(ActionSpec::DefaultPose { scale: 0.5 }.target(0.5, 1.0, 2.0, WIDE), 1.25);
        assert_eq!(ActionSpec::Reference { scale: 0.5 }.target(0.5, 1.0, 2.0, WIDE), 2.25);
        assert_eq!(ActionSpec::Unclamped { scale: 0.5 }.target(18.0, 1.0, 2.0, (0.0, 1.0)), 10.0);
        assert_eq!(ActionSpec::Reference { scale: 0.5 }.target(0.5_f32, 1.0, 2.0, (-10.0, 10.0)), 2.25);
    }

    #[test]
    fn outputs_and_targets_are_clamped_and_nan_is_not_hidden() {
        let spec = ActionSpec::DefaultPose { scale: 0.5 };
        assert_eq!(spec.target(100.0, 1.0, 0.0, WIDE), 3.0, "4 x 0.5 above the default");
        assert_eq!(spec.target(f64::NEG_INFINITY, 1.0, 0.0, WIDE), -1.0);
        assert_eq!(spec.target(4.0, 1.0, 0.0, (-0.25, 0.75)), 0.75);
        assert_eq!(spec.target(-4.0, 1.0, 0.0, (-0.25, 0.75)), -0.25);
        assert!(spec.target(f64::NAN, 1.0, 0.0, WIDE).is_nan());
    }

    #[test]
    fn text_names_the_base() {
        #[derive(serde::Deserialize)]
        struct Holder {
            action: ActionSpec,
        }
        let holder: Holder = toml::from_str("action = { base = \"reference\", scale = 0.5 }").unwrap();
        assert_eq!(holder.action, ActionSpec::Reference { scale: 0.5 });
        assert!(toml::from_str::<Holder>("action = { base = \"reference\", scale = 0.5, gain = 1 }").is_err());
    }
}
