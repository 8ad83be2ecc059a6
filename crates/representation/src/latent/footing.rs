//! Foot contact errors of a motion, which people see first when a network made it.

use lifelike_character::{Anatomy, Character, Kinematics, Role, Vec3};
use lifelike_motion::MotionClip;

use crate::RepresentationError;

/// A foot higher than this does not stand (m): decoded heights are some centimetres off, and swings reach higher.
const BEARING: f64 = 0.03;

/// Foot contact errors of a motion on level ground at height 0.
#[derive(Debug, Clone, Copy, Default, PartialEq, serde::Serialize)]
pub struct Footing {
    /// Horizontal speed (m/s) of the lowest corner of the soles, mean over the frames in which one stands.
    pub skate: f64,
    /// Share of frames in which one is below 3 cm.
    pub bearing: f64,
    /// Deepest that a corner is below the ground (m).
    pub deepest: f64,
}

/// Measures it. No labels are needed, so made motion and captured motion are measured alike: whatever is lowest stands.
///
/// # Errors
/// A clip whose joints are not the character's.
pub fn footing(clip: &MotionClip, character: &Character, anatomy: &Anatomy) -> Result<Footing, RepresentationError> {
    let columns = clip.columns_for(character)?;
    let soles: Vec<_> = [Role::LeftFoot, Role::RightFoot].iter().filter_map(|r| anatomy.soles.get(r)).collect();
    let mut kinematics = Kinematics::new(character);
    let mut q = character.reference_position();
    let mut before: Option<Vec<Vec3>> = None;
    let (mut path, mut bearing, mut lowest) = (0.0, 0_usize, f64::INFINITY);
    for t in 0..clip.len() {
        clip.write_position(character, &columns, t, &mut q);
        kinematics.update(character, &q);
        let now: Vec<Vec3> = soles.iter().flat_map(|s| s.corners.iter().map(|c| kinematics.point(s.body, c))).collect();
        lowest = now.iter().map(|c| c.z).fold(lowest, f64::min);
        let pairs = before.iter().flat_map(|b| b.iter().zip(&now));
        if let Some((old, new)) = pairs.min_by(|a, b| a.0.z.total_cmp(&b.0.z)).filter(|(old, _)| old.z < BEARING) {
            path += (new - old).xy().norm();
            bearing += 1;
        }
        before = Some(now);
    }
    let steps = clip.len().saturating_sub(1).max(1) as f64;
    Ok(Footing {
        skate: path * clip.fps / bearing.max(1) as f64,
        bearing: bearing as f64 / steps,
        deepest: if lowest.is_finite() { (-lowest).max(0.0) } else { 0.0 },
    })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use lifelike_motion::Provenance;
    use lifelike_robot::Robot;

    #[test]
    fn standing_sliding_and_floating() {
        let robot = Robot::load("lima").unwrap();
        let root = Kinematics::new(&robot.character);
        let body = robot.character.root_joint().unwrap().body;
        let mut clip = MotionClip {
            name: "stand".into(),
            fps: 50.0,
            joint_names: robot.layout.joints.clone(),
            root_position: vec![root.body_position[body]; 51],
            root_orientation: vec![root.body_orientation[body]; 51],
            joints: robot.default_pose.repeat(51),
            contacts: None,
            cyclic: false,
            provenance: Provenance::default(),
        };
        let of = |clip: &MotionClip| footing(clip, &robot.character, &robot.anatomy).unwrap();
        let stands = of(&clip);
        assert_eq!((stands.skate, stands.bearing, stands.deepest), (0.0, 1.0, 0.0));
        for (i, p) in clip.root_position.iter_mut().enumerate() {
            p.x += 0.004 * i as f64;
            p.z -= 0.1;
        }
        let slides = of(&clip);
        // 4 mm per frame at 50 frames per second.
        assert!((slides.skate - 0.2).abs() < 1e-9, "{slides:?}");
        clip.root_position.iter_mut().for_each(|p| p.z -= 0.1);
        assert!((of(&clip).deepest - slides.deepest - 0.1).abs() < 1e-9 && slides.deepest > 0.05, "{slides:?}");
        clip.root_position.iter_mut().for_each(|p| p.z += 0.4);
        assert_eq!(of(&clip), Footing::default(), "in the air");
    }
}
