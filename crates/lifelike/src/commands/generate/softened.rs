//! Changes by physics that made a motion gentler, limb by limb.

use lifelike_motion::MotionClip;
use lifelike_motion::features::frames_of;
use lifelike_robot::Robot;

use crate::error::CliError;

/// A limb that moves with less than this share of the speed asked for is softened.
const SHARE: f64 = 0.75;
/// Limbs that are asked to move slower than this (m/s, beside the root) have nothing to soften.
const FAST: f64 = 1.0;
/// The same movement may come so much earlier or later (s).
const AROUND: f64 = 0.3;

/// Returns a line for each limb whose fastest moment was softened. Limbs move beside the root, so a robot that drifts is not blamed.
pub fn softened(asked: &MotionClip, played: &MotionClip, robot: &Robot) -> Result<Vec<String>, CliError> {
    let (wanted, done) = (speeds(asked, robot)?, speeds(played, robot)?);
    let line = |((name, wanted), done): ((&String, Vec<f64>), Vec<f64>)| {
        let (at, most) = wanted.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1))?;
        let second = at as f64 / asked.fps;
        let near = done.iter().enumerate().filter(|(i, _)| (*i as f64 / played.fps - second).abs() <= AROUND);
        let reached = near.map(|(_, speed)| *speed).fold(f64::NAN, f64::max);
        let gentle = *most >= FAST && reached < SHARE * most;
        let limb = name.replace('_', " ");
        gentle.then(|| {
            format!("the {limb} at {second:.1} s was softened: {reached:.1} m/s where {most:.1} were asked for")
        })
    };
    Ok(robot.layout.end_effectors.iter().zip(wanted).zip(done).filter_map(line).collect())
}

/// Speed of every end effector beside the root (m/s), between neighbouring frames.
fn speeds(clip: &MotionClip, robot: &Robot) -> Result<Vec<Vec<f64>>, CliError> {
    let frames = frames_of(clip, &robot.character, &robot.effectors)?;
    let place = |frame: &lifelike_motion::features::Frame, i: usize| {
        frame.root_orientation.inverse() * (frame.effectors_w[i] - frame.root_position)
    };
    let of = |i: usize| {
        let pairs = frames.windows(2);
        pairs.map(|pair| (place(&pair[1], i) - place(&pair[0], i)).norm() * clip.fps).collect()
    };
    Ok((0..robot.effectors.len()).map(of).collect())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::commands::clips;

    #[test]
    fn a_gentler_punch_is_told_and_the_same_one_is_not() {
        let robot = Robot::load("lima").unwrap();
        let punch = clips::load(&["builtin:punch".into()], &robot).unwrap().remove(0);
        assert!(softened(&punch, &punch, &robot).unwrap().is_empty());
        let mut gentle = punch.clone();
        let first = punch.joints.clone();
        let width = punch.joint_names.len();
        for (i, angle) in gentle.joints.iter_mut().enumerate() {
            *angle = first[i % width] + 0.5 * (*angle - first[i % width]);
        }
        let lines = softened(&punch, &gentle, &robot).unwrap();
        assert!(
            lines.iter().any(|line| line.starts_with("the right hand at ") && line.contains("softened")),
            "{lines:?}"
        );
    }
}
