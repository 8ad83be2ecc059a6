//! Reasons for which a clip cannot be executed, from kinematics and masses alone.
//!
//! Momentum determines the force of the ground: M (c̈ − g) for a centre of mass c. It acts at the zero moment point of
//! Vukobratović, which gives the body its rate of angular momentum. [`momentum`] measures both, and [`touches`] finds
//! the parts of the body that can receive the force. This module compares them frame by frame on level ground at height
//! 0. [`Kind`] has the limits and their reasons. Joints are checked for range and speed. Torques are not checked: a
//! feasible clip may still exceed its motors.

mod finding;
mod momentum;
mod sway;
mod touch;

use lifelike_character::{Anatomy, Character, Kinematics};

use crate::clip::MotionClip;
use crate::error::MotionError;

pub use finding::{Feasibility, Finding, Kind};
pub(crate) use momentum::centre_of_mass;
pub use momentum::{Momentum, SMOOTH_SECONDS, momentum};
pub(crate) use sway::shift_for;
pub use touch::{TOUCH, Touch, nearest, outside, touches};

/// Checks a clip. `speeds` are the largest speeds of the character's scalar joints, in its order (rad/s or m/s;
/// infinite where there is none to exceed).
///
/// The first and last [`SMOOTH_SECONDS`] of a clip are not judged by their momentum, which cannot be told there.
///
/// # Errors
/// [`MotionError::Unfit`] for an inconsistent clip or another number of speeds, [`MotionError::Mismatch`] when clip and
/// character name different joints.
pub fn check(
    clip: &MotionClip,
    character: &Character,
    anatomy: &Anatomy,
    speeds: &[f64],
) -> Result<Feasibility, MotionError> {
    clip.check()?;
    let columns = clip.columns_for(character)?;
    if speeds.len() != columns.len() {
        let message = format!("expected the largest speeds of {} joints, got {}", columns.len(), speeds.len());
        return Err(MotionError::Unfit { clip: clip.name.clone(), message });
    }
    let mut poses = Vec::with_capacity(clip.len());
    let mut kinematics = Kinematics::new(character);
    let mut q = character.reference_position();
    for frame in 0..clip.len() {
        clip.write_position(character, &columns, frame, &mut q);
        kinematics.update(character, &q);
        poses.push(kinematics.clone());
    }
    let momentum = momentum(character, &poses, clip.fps);
    let touches: Vec<Touch> = poses.iter().map(|pose| touches(character, anatomy, pose)).collect();
    let mut findings = Vec::new();
    let mut tell = |kind: Kind, measure: &dyn Fn(usize) -> Option<(f64, usize)>, name: &dyn Fn(usize) -> String| {
        findings.extend(stretches(kind, clip, measure, name));
    };
    let nameless = |_: usize| String::new();
    let needed = |frame: usize| momentum[frame].as_ref();
    tell(
        Kind::Unsupported,
        &|f| Some((needed(f).filter(|_| touches[f].points.is_empty())?.specific_force.norm(), 0)),
        &nameless,
    );
    tell(
        Kind::Unbalanced,
        &|f| Some((touch::outside(&touches[f].points, &needed(f)?.zero_moment_point?)?, 0)),
        &nameless,
    );
    tell(Kind::Slipping, &|f| Some((needed(f).filter(|_| !touches[f].points.is_empty())?.friction()?, 0)), &nameless);
    let body = |b: usize| character.bodies[b].name.clone();
    tell(Kind::OtherParts, &|f| touches[f].other, &body);
    tell(Kind::Underground, &|f| touches[f].deepest, &body);
    let speed = |frame: usize| {
        let (a, b) = (clip.joints_at(frame.checked_sub(1)?), clip.joints_at(frame));
        let shares = columns.iter().zip(speeds).map(|(c, most)| (b[*c] - a[*c]).abs() * clip.fps / most);
        shares.enumerate().map(|(joint, share)| (share, joint)).max_by(|a, b| a.0.total_cmp(&b.0))
    };
    let joints: Vec<&str> = character.scalar_joints().map(|j| j.name.as_str()).collect();
    tell(Kind::TooFast, &speed, &|joint| joints[joint].to_string());
    let jump = |frame: usize| {
        let (a, b) = (clip.joints_at(frame.checked_sub(1)?), clip.joints_at(frame));
        let steps = columns.iter().zip(speeds).map(|(c, most)| ((b[*c] - a[*c]).abs(), *most));
        let fast = steps.enumerate().filter(|(_, (step, most))| step * clip.fps > *most);
        fast.map(|(joint, (step, _))| (step, joint)).max_by(|a, b| a.0.total_cmp(&b.0))
    };
    tell(Kind::Jump, &jump, &|joint| joints[joint].to_string());
    // How far an angle is from the middle between the frames beside it.
    let bend = |frame: usize, column: usize| {
        let at = |frame: usize| clip.joints_at(frame)[column];
        (at(frame) - 0.5 * (at(frame - 1) + at(frame + 1))).abs()
    };
    let spike = |frame: usize| {
        let inside = |f: &usize| (1..clip.len() - 1).contains(f);
        if !inside(&frame) {
            return None;
        }
        let near: Vec<usize> =
            (frame.saturating_sub(4)..frame + 5).filter(|f| f.abs_diff(frame) > 1 && inside(f)).collect();
        // A step bends the path as much at the frame beside it.
        let is_peak = |column: usize| {
            [frame - 1, frame + 1].iter().filter(|f| inside(f)).all(|f| bend(*f, column) < 0.75 * bend(frame, column))
        };
        let lone =
            |column: &usize| is_peak(*column) && near.iter().all(|f| bend(*f, *column) < 0.1 * bend(frame, *column));
        let spikes = columns.iter().enumerate().filter(|(_, column)| !near.is_empty() && lone(column));
        spikes.map(|(joint, column)| (bend(frame, *column), joint)).max_by(|a, b| a.0.total_cmp(&b.0))
    };
    tell(Kind::Spike, &spike, &|joint| joints[joint].to_string());
    let ranges: Vec<Option<(f64, f64)>> = character.scalar_joints().map(|joint| joint.range).collect();
    let beyond = |frame: usize| {
        let row = clip.joints_at(frame);
        let excess = columns.iter().zip(&ranges).enumerate().filter_map(|(joint, (c, range))| {
            let (low, high) = (*range)?;
            Some(((low - row[*c]).max(row[*c] - high), joint))
        });
        excess.max_by(|a, b| a.0.total_cmp(&b.0))
    };
    tell(Kind::BeyondRange, &beyond, &|joint| joints[joint].to_string());
    findings.sort_by(|a, b| b.seconds.total_cmp(&a.seconds));
    let trackable = !findings.iter().any(Finding::rules_out);
    Ok(Feasibility { clip: clip.name.clone(), seconds: clip.seconds(), trackable, findings })
}

/// Returns the frames in a row in which the measure is above the limit of its kind.
fn stretches(
    kind: Kind,
    clip: &MotionClip,
    measure: &dyn Fn(usize) -> Option<(f64, usize)>,
    name: &dyn Fn(usize) -> String,
) -> Vec<Finding> {
    let over: Vec<Option<(f64, usize)>> =
        (0..clip.len()).map(|frame| measure(frame).filter(|(value, _)| *value > kind.limit())).collect();
    let flags: Vec<bool> = over.iter().map(Option::is_some).collect();
    crate::contacts::runs(&flags, true)
        .into_iter()
        .map(|(start, end)| {
            let worst = over[start..end].iter().flatten().max_by(|a, b| a.0.total_cmp(&b.0));
            let (worst, part) = worst.copied().unwrap_or_default();
            let (from, seconds) = (start as f64 / clip.fps, (end - start) as f64 / clip.fps);
            Finding { kind, part: name(part), from, seconds, worst }
        })
        .collect()
}

#[cfg(test)]
mod tests;
