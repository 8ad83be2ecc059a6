//! The last step of a generated motion: joints within their ranges, soles on the ground.

use lifelike_character::Kinematics;
use lifelike_motion::MotionClip;
use lifelike_motion::contacts::clip_contacts;
use lifelike_motion::edit::{settle, support_shift};
use lifelike_robot::{Robot, clips};

use crate::GenerationError;

/// Height by which planting soles may lift the lower one (m); beyond it the motion asked for what legs cannot do.
const MAX_LIFT: f64 = 0.02;

/// Puts a motion on the ground: first the lower sole wherever the body does not fall freely ([`support_shift`]), since
/// floating bodies have no support. Then come the standing soles, by the retargeter's own passes ([`settle`]). If
/// those lift the feet off the ground (soles that turn while they stand), the motion keeps the soles of the network.
///
/// # Errors
/// A clip of another robot, or a robot without soles.
pub fn grounded(clip: &MotionClip, robot: &Robot) -> Result<MotionClip, GenerationError> {
    let (character, anatomy) = (&robot.character, &robot.anatomy);
    let heights = lowest_soles(clip, robot)?;
    let roots: Vec<f64> = clip.root_position.iter().map(|p| p.z).collect();
    let shift = support_shift(&heights, &roots, clip.fps);
    let mut lifted = clip.clone();
    lifted.root_position.iter_mut().zip(&shift).for_each(|(p, shift)| p.z += shift);
    within_ranges(&mut lifted, robot);
    let mut options = clips::retarget_options(robot);
    clips::limit_speeds(&mut options, robot);
    // With the bounds of captured feet, planting took one step in ten away, even of motion that was only encoded and decoded.
    options.contact = options.contact.without_noise();
    lifted.contacts = Some(clip_contacts(&lifted, character, anatomy, &options.contact)?);
    let before = MotionClip { contacts: lifted.contacts.clone(), ..clip.clone() };
    let planted = settle(&before, lifted.clone(), character, anatomy, &options)?;
    let now = lowest_soles(&planted, robot)?;
    let asked = heights.iter().zip(&shift).map(|(height, shift)| (height + shift).max(0.0));
    let torn = asked.zip(&now).any(|(asked, now)| now - asked > MAX_LIFT);
    let mut out = if torn { lifted } else { planted };
    out.contacts = Some(clip_contacts(&out, character, anatomy, &options.contact)?);
    Ok(out)
}

/// Returns the height of the lowest corner of all soles (m) in every frame.
fn lowest_soles(clip: &MotionClip, robot: &Robot) -> Result<Vec<f64>, GenerationError> {
    let character = &robot.character;
    let columns = clip.columns_for(character)?;
    let mut kinematics = Kinematics::new(character);
    let mut q = character.reference_position();
    let lowest = |frame: usize| {
        clip.write_position(character, &columns, frame, &mut q);
        kinematics.update(character, &q);
        let soles = robot.anatomy.soles.values();
        let heights = soles.flat_map(|sole| sole.corners.iter().map(|c| kinematics.point(sole.body, c).z));
        heights.fold(f64::INFINITY, f64::min)
    };
    Ok((0..clip.len()).map(lowest).collect())
}

/// Puts every joint into its range.
fn within_ranges(clip: &mut MotionClip, robot: &Robot) {
    let width = clip.joint_names.len().max(1);
    for joint in robot.character.scalar_joints() {
        let column = clip.joint_names.iter().position(|name| *name == joint.name);
        if let (Some(column), Some((low, high))) = (column, joint.range) {
            clip.joints.iter_mut().skip(column).step_by(width).for_each(|q| *q = q.max(low).min(high));
        }
    }
}
