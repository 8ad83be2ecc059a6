//! Share of a joint's range and speed that reference motions reach: excitation.

use lifelike_robot::Robot;
use lifelike_sim::trace::Trace;

use crate::{AugmentationError, FromInput};

/// Cells of the plane of position and velocity, in each direction.
const CELLS: usize = 10;

/// Demands of reference motions on one joint.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Coverage {
    /// The joint.
    pub joint: String,
    /// Lowest and highest target (rad).
    pub range: [f64; 2],
    /// Share of the joint's own range between them.
    pub reached: f64,
    /// Share of the plane of position (the joint's range) and velocity (to its largest, both ways) that is visited, in tenths.
    pub visited: f64,
    /// Half of the time it is slower than the first, a twentieth faster than the second (rad/s).
    pub speed: [f64; 2],
    /// Changes of direction (1/s).
    pub reversals: f64,
}

/// Measures what runs ask of a robot's joints.
///
/// # Errors
/// [`AugmentationError::Input`] for runs without targets of a joint.
pub fn coverage(robot: &Robot, runs: &[Trace]) -> Result<Vec<Coverage>, AugmentationError> {
    let speeds = robot.speeds();
    let joint = |(j, joint): (usize, &lifelike_character::model::Joint)| {
        let (low, high) = joint.range.unwrap_or((-std::f64::consts::PI, std::f64::consts::PI));
        let fastest = if speeds[j].is_finite() { speeds[j] } else { 10.0 };
        let (mut reached, mut visited) = ([f64::MAX, f64::MIN], vec![false; CELLS * CELLS]);
        let (mut velocities, mut reversals, mut time) = (Vec::new(), 0, 0.0);
        for run in runs {
            let block = run.blocks.iter().find(|block| block.name == joint.name);
            let Some(targets) = block.and_then(|block| block.reference.column("position")) else {
                let what = format!("references of '{}'", run.name);
                return Err(AugmentationError::mismatch(what, format!("positions of '{}'", joint.name), "none"));
            };
            let targets: Vec<f64> = targets.map(f64::from).collect();
            time += targets.len() as f64 / run.rate;
            let mut before = 0.0;
            for pair in targets.windows(2) {
                let velocity = (pair[1] - pair[0]) * run.rate;
                reached = [reached[0].min(pair[0]), reached[1].max(pair[0])];
                let cell = |x: f64| ((x * CELLS as f64).floor().max(0.0) as usize).min(CELLS - 1);
                let (across, up) = (cell((pair[0] - low) / (high - low)), cell(0.5 + 0.5 * velocity / fastest));
                visited[across * CELLS + up] = true;
                reversals += usize::from(velocity * before < 0.0);
                before = if velocity == 0.0 { before } else { velocity };
                velocities.push(velocity.abs());
            }
        }
        velocities.sort_unstable_by(f64::total_cmp);
        let quantile = |share: f64| {
            velocities.get((share * velocities.len().saturating_sub(1) as f64) as usize).copied().unwrap_or(0.0)
        };
        Ok(Coverage {
            joint: joint.name.clone(),
            range: reached,
            reached: ((reached[1] - reached[0]) / (high - low)).clamp(0.0, 1.0),
            visited: visited.iter().filter(|cell| **cell).count() as f64 / visited.len() as f64,
            speed: [quantile(0.5), quantile(0.95)],
            reversals: reversals as f64 / f64::max(time, 1e-9),
        })
    };
    robot.character.scalar_joints().enumerate().map(joint).collect()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::super::random::{RandomSpec, draw};
    use super::*;

    #[test]
    fn more_runs_reach_more() {
        let robot = Robot::load(concat!(env!("CARGO_MANIFEST_DIR"), "/../robot/robots/kickbot.xml")).unwrap();
        let runs = draw(&robot, &RandomSpec { runs: 10, seconds: 5.0, ..RandomSpec::default() }).unwrap();
        let (few, many) = (coverage(&robot, &runs[..2]).unwrap(), coverage(&robot, &runs).unwrap());
        for (few, many) in few.iter().zip(&many) {
            assert!(many.visited >= few.visited && many.reached >= few.reached, "{}", many.joint);
            assert!(many.visited > 0.2 && many.speed[1] > 0.3 && many.reversals > 0.1, "{many:?}");
        }
    }
}
