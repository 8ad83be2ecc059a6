//! Random reference motions (thesis 2.3.3): end effectors along B-splines of order 0 to 4, joints by inverse kinematics.

use lifelike_checkpoint::rng::stream;
use lifelike_robot::Robot;
use lifelike_sim::trace::Trace;
use rand::Rng;
use rayon::prelude::*;

use super::inverse::{Goal, Inverse};
use super::{FIRST, bspline, commands, held};
use crate::{AugmentationError, FromInput};

/// Distribution of random reference motions.
#[derive(Debug, Clone, PartialEq)]
pub struct RandomSpec {
    /// Key of all randomness.
    pub seed: u64,
    /// Runs; the orders 0 to 4 take turns.
    pub runs: usize,
    /// Length of a run (s).
    pub seconds: f64,
    /// Bounds of the time between knots (s); each run draws one, in the logarithm.
    pub knots: [f64; 2],
    /// Bounds of the share of the joints' ranges that a run moves in.
    pub reach: [f64; 2],
}

impl Default for RandomSpec {
    fn default() -> Self {
        Self { seed: 0, runs: 60, seconds: 30.0, knots: [0.3, 2.0], reach: [0.2, 1.0] }
    }
}

/// Orders of the curves.
pub const ORDERS: usize = 5;
/// Joints that effectors leave free go towards curves of their own, with this weight (m/rad).
const WISH: f64 = 0.03;
/// Steps of the inverse kinematics for a row; it begins where the row before ended.
const STEPS: usize = 4;

/// Draws reference motions of a robot that is fixed to the world. Control points are where random poses bring the end effectors, so
/// curves stay within reach.
///
/// # Errors
/// [`AugmentationError::Input`] for a robot with a free root, and numbers out of range.
pub fn draw(robot: &Robot, spec: &RandomSpec) -> Result<Vec<Trace>, AugmentationError> {
    let positive = |[low, high]: [f64; 2]| low > 0.0 && low <= high && high.is_finite();
    for (name, bounds) in [("knots", spec.knots), ("reach", spec.reach)] {
        if !positive(bounds) {
            let got = format!("{bounds:?}");
            return Err(AugmentationError::mismatch(name, "two numbers above 0, the smaller first", got));
        }
    }
    if !(spec.seconds.is_finite() && spec.seconds * robot.control_hz >= 1.0) {
        return Err(AugmentationError::mismatch("length of a run", "a step or more (s)", spec.seconds));
    }
    let held = held(robot)?;
    let runs: Vec<usize> = (0..spec.runs).collect();
    Ok(runs.par_iter().map(|run| one(robot, spec, &held, *run)).collect())
}

fn one(robot: &Robot, spec: &RandomSpec, held: &[Goal], run: usize) -> Trace {
    let mut draw = stream(spec.seed, "reference motion", run as u64, 0);
    let character = &robot.character;
    let order = run % ORDERS;
    let between = |draw: &mut rand_chacha::ChaCha8Rng, [low, high]: [f64; 2]| draw.random_range(low..=high);
    let knot = between(&mut draw, spec.knots.map(f64::ln)).exp();
    let reach = between(&mut draw, spec.reach).min(1.0);
    let points = (spec.seconds / knot).ceil() as usize + order + 1;
    let (joints, effectors) = (robot.joints(), &robot.effectors);
    let (mut poses, mut places) = (Vec::new(), Vec::new());
    for point in 0..points {
        let pose: Vec<f64> = match point {
            // It begins in the default pose.
            0 => robot.default_pose.clone(),
            _ => character
                .scalar_joints()
                .zip(&robot.default_pose)
                .map(|(joint, rest)| {
                    let (low, high) = joint.range.unwrap_or((rest - 1.0, rest + 1.0));
                    rest + reach * (draw.random_range(low..=high.max(low)) - rest)
                })
                .collect(),
        };
        let there = Inverse::new(character, &pose);
        for (body, point) in effectors {
            places.extend(there.kinematics().point(*body, point).iter());
        }
        poses.extend(pose);
    }
    let mut inverse = Inverse::new(character, &robot.default_pose);
    // Steps of order 0 leap; the others are no faster than the actuators.
    let fastest: Vec<f64> = robot.speeds().iter().map(|speed| speed / robot.control_hz).collect();
    let mut rows = Vec::new();
    for row in 0..(spec.seconds * robot.control_hz).round() as usize {
        let time = row as f64 / robot.control_hz / knot;
        let wish = bspline::at(&poses, joints, order, time);
        let mut goals = held.to_vec();
        if !effectors.is_empty() {
            let places = bspline::at(&places, 3 * effectors.len(), order, time);
            let goal = |((body, point), place): (&(usize, lifelike_character::Vec3), &[f64])| Goal::Place {
                body: *body,
                point: *point,
                target: lifelike_character::Vec3::from_column_slice(place),
                weight: 1.0,
            };
            goals.extend(effectors.iter().zip(places.chunks_exact(3)).map(goal));
        }
        let before = inverse.pose();
        inverse.solve(&goals, &wish, WISH, if row == 0 { FIRST } else { STEPS });
        if order > 0 && row > 0 {
            inverse.stay_near(&before, &fastest);
        }
        rows.push(inverse.pose());
    }
    let source =
        format!("random B-spline of order {order}, a knot every {knot:.2} s, {:.0}% of the range", 100.0 * reach);
    commands(&format!("random_{run:03}"), source, robot, &rows)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn robot(name: &str) -> Robot {
        Robot::load(&format!("{}/../robot/robots/{name}.xml", env!("CARGO_MANIFEST_DIR"))).unwrap()
    }

    #[test]
    fn motions_are_seeded_within_limits_and_of_every_order() {
        let robot = robot("kickbot");
        let spec = RandomSpec { runs: 5, seconds: 4.0, ..RandomSpec::default() };
        let runs = draw(&robot, &spec).unwrap();
        assert_eq!(runs, draw(&robot, &spec).unwrap());
        assert_ne!(runs, draw(&robot, &RandomSpec { seed: 1, ..spec.clone() }).unwrap());
        for (order, run) in runs.iter().enumerate() {
            run.check().unwrap();
            assert_eq!((run.len(), run.blocks.len()), (1000, 12));
            assert!(run.source.contains(&format!("order {order}")));
            for (block, joint) in run.blocks.iter().zip(robot.character.scalar_joints()) {
                let (low, high) = joint.range.unwrap();
                let targets: Vec<f64> = block.reference.column("position").unwrap().map(f64::from).collect();
                assert!(targets.iter().all(|q| (low - 1e-6..=high + 1e-6).contains(q)), "{}", joint.name);
                let change = targets.windows(2).fold(0.0_f64, |most, pair| most.max((pair[1] - pair[0]).abs()));
                assert!(
                    change > 0.0 && (order == 0 || change < 6.01 / 250.0),
                    "order {order}, {}: {change}",
                    joint.name
                );
            }
        }
    }

    #[test]
    fn feet_that_are_held_stay() {
        let robot = robot("dancebot");
        let spec = RandomSpec { runs: 4, seconds: 3.0, reach: [0.1, 0.2], ..RandomSpec::default() };
        let foot = robot.character.body("left_foot").unwrap();
        let place = Inverse::new(&robot.character, &robot.default_pose).kinematics().body_position[foot];
        for run in &draw(&robot, &spec).unwrap()[1..] {
            for row in (0..run.len()).step_by(50) {
                let pose: Vec<f64> = run.blocks.iter().map(|block| f64::from(block.reference.values[row])).collect();
                let off = (Inverse::new(&robot.character, &pose).kinematics().body_position[foot] - place).norm();
                assert!(off < 3e-3, "{off} m at row {row}");
            }
        }
    }

    #[test]
    fn robots_that_walk_about_are_refused() {
        let text = draw(&Robot::load("lima").unwrap(), &RandomSpec::default()).unwrap_err().to_string();
        assert!(text.contains("fixed to the world"), "{text}");
    }
}
