//! A layout against the statistics that the policy's own normalizer has seen.
//!
//! A normalizer betrays the order of its numbers. The reference's orientation in the anchor's frame is near the identity. Gravity
//! points down. A tracker's joints have the means of its reference's joints, and move about as fast. A layout that
//! contradicts its normalizer is not the one that the policy was trained with; or the policy has hardly learnt to follow.

use std::ops::Range;

use lifelike_robot::ObservationSpec;

/// A contradiction between a layout and a normalizer.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Contradiction {
    /// The part of the observation.
    pub part: String,
    /// Property that its numbers would have.
    pub expected: String,
    /// Statistics of the normalizer.
    pub got: String,
}

impl std::fmt::Display for Contradiction {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}: expected {}, got {}", self.part, self.expected, self.got)
    }
}

/// Greatest difference of a joint's mean from its reference's (rad). Published trackers have up to 0.09.
const MEAN: f32 = 0.4;
/// Ratios of a joint's spread to its reference's, and what it may have beside (rad): a joint whose reference rests trembles all the
/// same. Published trackers have 0.5 to 1.8 for positions.
const POSITION: (f32, f32, f32) = (0.3, 2.5, 0.25);
/// Likewise of velocities (rad/s): published trackers have 0.28 to 4.3.
const VELOCITY: (f32, f32, f32) = (0.15, 5.0, 2.0);
/// Least ratio of the spread of a joint's targets to that of its positions. Published trackers have 0.98 to 2.4: a joint with a
/// spring moves less than its target.
const TARGETS: f32 = 0.4;
/// Least correlation of the means of targets and positions over the joints. Published trackers have 0.94 and more.
const LIKENESS: f32 = 0.4;
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
    let range_of = |name: &str| parts.iter().find(|part| part.name == name).map(|part| part.range.clone());
    let mut found = Vec::new();
    let mut add = |part: &str, expected: &str, got: String| {
        found.push(Contradiction { part: part.into(), expected: expected.into(), got });
    };
    if let Some(range) = range_of("anchor_orientation_b") {
        let identity = [1.0, 0.0, 0.0, 1.0, 0.0, 0.0];
        let off = mean[range.clone()].iter().zip(identity).any(|(m, expected): (&f32, f32)| (m - expected).abs() > 0.4);
        if off {
            add("anchor_orientation_b", "means near 1, 0, 0, 1, 0, 0", rounded(&mean[range]));
        }
    }
    for name in ["projected_gravity_b", "reference_gravity_b"] {
        if let Some(range) = range_of(name).filter(|range| mean[range.start + 2] > -0.5) {
            add(name, "means near 0, 0, -1", rounded(&mean[range]));
        }
    }
    if let Some(range) = range_of("reference_height") {
        let (height, spread) = (mean[range.start], deviation[range.start]);
        if !(0.05..5.0).contains(&height) || spread > 1.0 {
            add("reference_height", "a mean of 0.05 to 5 m, spread less than 1 m", rounded(&[height, spread]));
        }
    }
    for name in
        ["root_angular_velocity_b", "reference_angular_velocity_b", "joint_velocity", "reference_joint_velocity"]
    {
        let Some(range) = range_of(name) else { continue };
        let stands = |i: &usize| mean[*i].abs() > deviation[*i].max(0.2);
        if let Some(i) = range.clone().find(stands) {
            let got = format!("{:.2}, spread {:.2}, for number {}", mean[i], deviation[i], i - range.start + 1);
            add(name, "means within the spread about 0", got);
        }
    }
    let position = range_of("joint_position");
    let joint = |j: usize| spec.joints[j].clone();
    if let (Some(own), Some(reference)) = (position.clone(), range_of("reference_joint_position")) {
        let difference = |j: usize| (mean[reference.start + j] - mean[own.start + j] - spec.default_pose[j]).abs();
        if let Some(j) = worst(own.len(), MEAN, &difference) {
            let expected =
                format!("the mean of '{}' that its reference has, {:.2} rad", joint(j), mean[reference.start + j]);
            let got = format!("{:.2} rad", mean[own.start + j] + spec.default_pose[j]);
            add("joint_position", &expected, got);
        }
        spreads(&mut add, "joint_position", deviation, [&own, &reference], POSITION, &joint);
    }
    if let (Some(own), Some(reference)) = (range_of("joint_velocity"), range_of("reference_joint_velocity")) {
        spreads(&mut add, "joint_velocity", deviation, [&own, &reference], VELOCITY, &joint);
    }
    if let (Some(own), Some(action)) = (position, range_of("last_action")) {
        let ratio = |j: usize| action_scale * deviation[action.start + j] / deviation[own.start + j];
        if let Some(j) = worst(own.len(), 1.0 / TARGETS, &|j| 1.0 / ratio(j)) {
            let expected = format!("targets of '{}' that spread at least {TARGETS} times as its positions", joint(j));
            add("last_action", &expected, format!("{:.2} times", ratio(j)));
        }
        let likeness = correlation(&mean[action.clone()], &mean[own.clone()]);
        if likeness < LIKENESS {
            let expected = format!("means that correlate with those of the joints, at least {LIKENESS}");
            add("last_action", &expected, format!("{likeness:.2}"));
        }
        let difference = |j: usize| (action_scale * mean[action.start + j] - mean[own.start + j]).abs();
        if let Some(j) = worst(own.len(), TARGET, &difference) {
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
    (low, high, beside): (f32, f32, f32),
    joint: &dyn Fn(usize) -> String,
) {
    let bounds = |j: usize| {
        let reference = deviation[reference.start + j];
        ((low * reference - beside).max(0.0), high * reference + beside)
    };
    // How far outside, as a share of the bound.
    let outside = |j: usize| {
        let (own, (least, most)) = (deviation[own.start + j], bounds(j));
        if own < least { least / own } else { own / most }
    };
    if let Some(j) = worst(own.len(), 1.0, &outside) {
        let (least, most) = bounds(j);
        let expected = format!("a spread of '{}' from {least:.2} to {most:.2} by its reference's", joint(j));
        add(part, &expected, format!("{:.2}", deviation[own.start + j]));
    }
}

/// The joint that is furthest beyond a limit; none where all are within.
fn worst(joints: usize, limit: f32, measure: &dyn Fn(usize) -> f32) -> Option<usize> {
    let worst = (0..joints).max_by(|a, b| measure(*a).total_cmp(&measure(*b)))?;
    (measure(worst) > limit || measure(worst).is_nan()).then_some(worst)
}

/// Pearson's correlation; 1 where one of the two does not vary.
fn correlation(a: &[f32], b: &[f32]) -> f32 {
    let mean = |x: &[f32]| x.iter().sum::<f32>() / x.len().max(1) as f32;
    let (of_a, of_b) = (mean(a), mean(b));
    let product = |x: &[f32], of_x: f32, y: &[f32], of_y: f32| -> f32 {
        x.iter().zip(y).map(|(x, y)| (x - of_x) * (y - of_y)).sum()
    };
    let spread = product(a, of_a, a, of_a) * product(b, of_b, b, of_b);
    if spread > 0.0 { product(a, of_a, b, of_b) / spread.sqrt() } else { 1.0 }
}

fn rounded(values: &[f32]) -> String {
    let texts: Vec<String> = values.iter().map(|x| format!("{x:.2}")).collect();
    texts.join(", ")
}
