//! The last step of a generated motion: joints within their ranges, soles on the ground.

use lifelike_character::Kinematics;
use lifelike_motion::MotionClip;
use lifelike_motion::contacts::clip_contacts;
use lifelike_motion::edit::settle;
use lifelike_robot::{Robot, clips};

use crate::GenerationError;

/// Share of frames that may reach below the ground before the retargeter's passes: the others lift the motion.
const LOWEST: f64 = 0.1;

/// Puts a motion on the ground: as a whole by the height of its lower soles, then every standing sole by the retargeter's
/// own passes ([`settle`]).
///
/// # Errors
/// A clip of another robot, or a robot without soles.
pub fn grounded(clip: &MotionClip, robot: &Robot) -> Result<MotionClip, GenerationError> {
    let (character, anatomy) = (&robot.character, &robot.anatomy);
    let columns = clip.columns_for(character)?;
    let mut kinematics = Kinematics::new(character);
    let mut q = character.reference_position();
    let mut lowest: Vec<f64> = Vec::with_capacity(clip.len());
    for frame in 0..clip.len() {
        clip.write_position(character, &columns, frame, &mut q);
        kinematics.update(character, &q);
        let soles = anatomy.soles.values();
        let heights = soles.flat_map(|sole| sole.corners.iter().map(|c| kinematics.point(sole.body, c).z));
        lowest.push(heights.fold(f64::INFINITY, f64::min));
    }
    lowest.sort_by(f64::total_cmp);
    let level = lowest.get((LOWEST * lowest.len() as f64) as usize).copied().filter(|z| z.is_finite()).unwrap_or(0.0);
    let mut lifted = clip.clone();
    lifted.root_position.iter_mut().for_each(|p| p.z -= level);
    let mut options = clips::retarget_options(robot);
    clips::limit_speeds(&mut options, robot);
    lifted.contacts = Some(clip_contacts(&lifted, character, anatomy, &options.contact)?);
    let before = MotionClip { contacts: lifted.contacts.clone(), ..clip.clone() };
    let mut out = settle(&before, lifted, character, anatomy, &options)?;
    out.contacts = Some(clip_contacts(&out, character, anatomy, &options.contact)?);
    Ok(out)
}
