//! A layout against the statistics that the policy's own normalizer has seen.
//!
//! A normalizer betrays the order of its numbers. The reference's orientation in the anchor's frame is near the identity. Gravity
//! points down. A tracker's joints have the means of its reference's joints, and move about as fast. A layout that
//! contradicts its normalizer is not the one that the policy was trained with.

use std::ops::Range;

use lifelike_robot::ObservationSpec;

/// A contradiction between a layout and a normalizer.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Contradiction {
    /// The part of the observation.
    pub part: String,
    /// What its numbers would be.
    pub expected: String,
    /// What the normalizer says.
    pub got: String,
}

impl std::fmt::Display for Contradiction {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}: expected {}, got {}", self.part, self.expected, self.got)
    }
}

/// Greatest difference of a joint's mean from its reference's (rad). Published trackers have up to 0.09.
const MEAN: f32 = 0.4;
/// Ratios of a joint's spread to its reference's. Published trackers have 0.5 to 1.8 for positions.
const POSITION: (f32, f32) = (0.3, 3.0);
/// Likewise of velocities: published trackers have 0.28 to 4.3.
const VELOCITY: (f32, f32) = (0.15, 8.0);
/// Ratios of the spread of a joint's targets to that of its positions. Published trackers have 0.98 to 2.4: a joint with a spring
/// moves less than its target.
const TARGETS: (f32, f32) = (0.4, 10.0);
/// Greatest difference of a joint's mean target from its mean position (rad). Published trackers have up to 0.3.
const TARGET: f32 = 0.8;

/// Mean and deviation of each number of an observation, `[O]`, in the order of the layout.
#[derive(Debug, Clone, Copy)]
pub struct Statistics<'a> {
    /// Means.
    pub mean: &'a [f32],
    /// Standard deviations.
    pub deviation: &'a [f32],
    /// Joint target for an output of 1 (rad).
    pub action_scale: f32,
}

/// Returns what contradicts a layout; nothing for a policy that was trained with it.
pub fn check(spec: &ObservationSpec, statistics: Statistics<'_>) -> Vec<Contradiction> {
    let Statistics { mean, deviation, action_scale } = statistics;
    let parts = spec.parts();
    let of = |name: &str| parts.iter().find(|part| part.name == name).map(|part| part.range.clone());
    let mut found = Vec::new();
    let mut add = |part: &str, expected: &str, got: String| {
        found.push(Contradiction { part: part.into(), expected: expected.into(), got });
    };
    if let Some(range) = of("anchor_orientation_b") {
        let identity = [1.0, 0.0, 0.0, 1.0, 0.0, 0.0];
        let off = mean[range.clone()].iter().zip(identity).any(|(m, expected): (&f32, f32)| (m - expected).abs() > 0.4);
        if off {
            add("anchor_orientation_b", "means near 1, 0, 0, 1, 0, 0", rounded(&mean[range]));
        }
    }
    for name in ["projected_gravity_b", "reference_gravity_b"] {
        if let Some(range) = of(name).filter(|range| mean[range.start + 2] > -0.5) {
            add(name, "means near 0, 0, -1", rounded(&mean[range]));
        }
    }
    if let Some(range) = of("reference_height") {
        let (height, spread) = (mean[range.start], deviation[range.start]);
        if !(0.05..5.0).contains(&height) || spread > 1.0 {
            add("reference_height", "a mean of 0.05 to 5 m, spread less than 1 m", rounded(&[height, spread]));
        }
    }
    for name in
        ["root_angular_velocity_b", "reference_angular_velocity_b", "joint_velocity", "reference_joint_velocity"]
    {
        let Some(range) = of(name) else { continue };
        let stands = |i: &usize| mean[*i].abs() > deviation[*i].max(0.2);
        if let Some(i) = range.clone().find(stands) {
            let got = format!("{:.2}, spread {:.2}, for number {}", mean[i], deviation[i], i - range.start + 1);
            add(name, "means within the spread about 0", got);
        }
    }
    let position = of("joint_position");
    let joint = |j: usize| spec.joints[j].clone();
    if let (Some(own), Some(reference)) = (position.clone(), of("reference_joint_position")) {
        let far = (0..own.len()).find(|&j| {
            let difference = mean[reference.start + j] - mean[own.start + j] - spec.default_pose[j];
            difference.abs() > MEAN || difference.is_nan()
        });
        if let Some(j) = far {
            let expected =
                format!("the mean of '{}' that its reference has, {:.2} rad", joint(j), mean[reference.start + j]);
            let got = format!("{:.2} rad", mean[own.start + j] + spec.default_pose[j]);
            add("joint_position", &expected, got);
        }
        spreads(&mut add, "joint_position", deviation, [&own, &reference], POSITION, &joint);
    }
    if let (Some(own), Some(reference)) = (of("joint_velocity"), of("reference_joint_velocity")) {
        spreads(&mut add, "joint_velocity", deviation, [&own, &reference], VELOCITY, &joint);
    }
    if let (Some(own), Some(action)) = (position, of("last_action")) {
        let ratio = |j: usize| action_scale * deviation[action.start + j] / deviation[own.start + j];
        if let Some(j) = (0..own.len()).find(|&j| !(TARGETS.0..=TARGETS.1).contains(&ratio(j))) {
            let (low, high) = TARGETS;
            let expected = format!("targets of '{}' that spread {low} to {high} times as its positions", joint(j));
            add("last_action", &expected, format!("{:.2} times", ratio(j)));
        }
        let far =
            (0..own.len()).find(|&j| (action_scale * mean[action.start + j] - mean[own.start + j]).abs() > TARGET);
        if let Some(j) = far {
            let expected =
                format!("a mean target of '{}' near its mean position, {:.2} rad", joint(j), mean[own.start + j]);
            add("last_action", &expected, format!("{:.2} rad", action_scale * mean[action.start + j]));
        }
    }
    found
}

/// Compares the spread of each joint with its reference's.
fn spreads(
    add: &mut impl FnMut(&str, &str, String),
    part: &str,
    deviation: &[f32],
    [own, reference]: [&Range<usize>; 2],
    (low, high): (f32, f32),
    joint: &dyn Fn(usize) -> String,
) {
    let ratio = |j: usize| deviation[own.start + j] / deviation[reference.start + j];
    if let Some(j) = (0..own.len()).find(|&j| !(low..=high).contains(&ratio(j))) {
        let expected = format!("a spread of '{}' that is {low} to {high} times its reference's", joint(j));
        add(part, &expected, format!("{:.2} times", ratio(j)));
    }
}

fn rounded(values: &[f32]) -> String {
    let texts: Vec<String> = values.iter().map(|x| format!("{x:.2}")).collect();
    texts.join(", ")
}
