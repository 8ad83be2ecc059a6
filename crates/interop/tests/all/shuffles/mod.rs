#![allow(dead_code)]

//! Ways to get an observation wrong, as they happen between stacks.

use std::ops::Range;

use lifelike_interop::lint::{Contradiction, Statistics, check};
use lifelike_motion::formats::robot_motion::Traversal;
use lifelike_robot::{ControllerFile, ObservationSpec};

/// Mean and deviation of every number.
type Numbers = (Vec<f32>, Vec<f32>);

/// A mistake: what a wrong layout takes for the numbers of a right one.
type Mistake = fn(&ObservationSpec, &Numbers, &[usize]) -> Numbers;

fn range(spec: &ObservationSpec, name: &str) -> Range<usize> {
    spec.parts().into_iter().find(|part| part.name == name).map(|part| part.range).unwrap_or_default()
}

/// Takes numbers from other places.
fn moved((mean, deviation): &Numbers, from: &[usize]) -> Numbers {
    (from.iter().map(|i| mean[*i]).collect(), from.iter().map(|i| deviation[*i]).collect())
}

fn places(spec: &ObservationSpec) -> Vec<usize> {
    (0..spec.size()).collect()
}

fn swapped(spec: &ObservationSpec, numbers: &Numbers, a: &str, b: &str) -> Numbers {
    let (a, b, mut from) = (range(spec, a), range(spec, b), places(spec));
    a.zip(b).for_each(|(i, j)| from.swap(i, j));
    moved(numbers, &from)
}

/// The terms in another order, without gaps.
fn in_order(spec: &ObservationSpec, numbers: &Numbers, order: &[&str]) -> Numbers {
    moved(numbers, &order.iter().flat_map(|name| range(spec, name)).collect::<Vec<_>>())
}

fn joints(spec: &ObservationSpec, numbers: &Numbers, parts: &[&str], order: &[usize]) -> Numbers {
    let mut from = places(spec);
    for part in parts {
        let range = range(spec, part);
        order.iter().enumerate().for_each(|(j, other)| from[range.start + j] = range.start + other);
    }
    moved(numbers, &from)
}

/// Left joints for right ones.
fn mirrored(spec: &ObservationSpec) -> Vec<usize> {
    let other = |name: &str| match name.split_once('_') {
        Some(("left", rest)) => format!("right_{rest}"),
        Some(("right", rest)) => format!("left_{rest}"),
        _ => name.to_string(),
    };
    let place = |name: &String| spec.joints.iter().position(|joint| *joint == other(name)).unwrap_or_default();
    spec.joints.iter().map(place).collect()
}

const OF_JOINTS: [&str; 5] =
    ["joint_position", "joint_velocity", "last_action", "reference_joint_position", "reference_joint_velocity"];

/// The mistakes with their names. Each takes the order of the joints level after level.
pub const MISTAKES: [(&str, Mistake); 12] = [
    ("positions and velocities of the command exchanged", |spec, numbers, _| {
        swapped(spec, numbers, "reference_joint_position", "reference_joint_velocity")
    }),
    ("measured positions and velocities exchanged", |spec, numbers, _| {
        swapped(spec, numbers, "joint_position", "joint_velocity")
    }),
    ("measured velocities and last actions exchanged", |spec, numbers, _| {
        swapped(spec, numbers, "joint_velocity", "last_action")
    }),
    ("terms in definition order for alphabetical, or the other way round", |spec, numbers, _| {
        let mut order: Vec<String> = spec.parts().into_iter().map(|part| part.name).collect();
        order.rotate_left(2);
        in_order(spec, numbers, &order.iter().map(String::as_str).collect::<Vec<_>>())
    }),
    ("an actions term in front for one at the end", |spec, numbers, _| {
        let mut from = places(spec);
        from.rotate_right(spec.joints.len());
        moved(numbers, &from)
    }),
    ("everything moved by three, as by a missing velocity", |spec, numbers, _| {
        let mut from = places(spec);
        from.rotate_left(3);
        moved(numbers, &from)
    }),
    ("orientation flattened column by column", |spec, numbers, _| {
        let (range, mut from) = (range(spec, "anchor_orientation_b"), places(spec));
        [0, 2, 4, 1, 3, 5].into_iter().enumerate().for_each(|(i, j)| from[range.start + i] = range.start + j);
        moved(numbers, &from)
    }),
    ("measured joints breadth-first, command depth-first", |spec, numbers, breadth_first| {
        joints(spec, numbers, &["joint_position", "joint_velocity"], breadth_first)
    }),
    ("all joints breadth-first for depth-first", |spec, numbers, breadth_first| {
        joints(spec, numbers, &OF_JOINTS, breadth_first)
    }),
    ("left and right of the command exchanged", |spec, numbers, _| {
        joints(spec, numbers, &["reference_joint_position", "reference_joint_velocity"], &mirrored(spec))
    }),
    ("positions absolute for relative to the default pose", |spec, (mean, deviation), _| {
        let mut mean = mean.clone();
        range(spec, "joint_position").zip(&spec.default_pose).for_each(|(i, pose)| mean[i] += pose);
        (mean, deviation.clone())
    }),
    ("the command in degrees", |spec, (mean, deviation), _| {
        let (mut mean, mut deviation) = (mean.clone(), deviation.clone());
        for i in range(spec, "reference_joint_position").chain(range(spec, "reference_joint_velocity")) {
            mean[i] = mean[i].to_degrees();
            deviation[i] = deviation[i].to_degrees();
        }
        (mean, deviation)
    }),
];

/// Contradictions that the lint finds in a controller's own layout (first), and in each mistake.
pub fn found(
    file: &ControllerFile,
    breadth_first: &[usize],
    action_scale: f32,
) -> Vec<(&'static str, Vec<Contradiction>)> {
    let (spec, normalizer) = (&file.header().observation, file.policy().normalizer());
    let deviation = normalizer.inverse_deviation().iter().map(|inverse| 1.0 / inverse).collect();
    let right: Numbers = (normalizer.mean().to_vec(), deviation);
    let lint = |(mean, deviation): &Numbers| check(spec, Statistics { mean, deviation, action_scale });
    let wrong = MISTAKES.iter().map(|(name, mistake)| (*name, lint(&mistake(spec, &right, breadth_first))));
    [("the policy's own layout", lint(&right))].into_iter().chain(wrong).collect()
}

/// The joints level after level, as Isaac Lab numbers them.
pub fn breadth_first(robot: &lifelike_robot::Robot) -> Vec<usize> {
    let place = |name: String| robot.layout.joints.iter().position(|joint| *joint == name);
    Traversal::BreadthFirst.joints(&robot.character).into_iter().filter_map(place).collect()
}
