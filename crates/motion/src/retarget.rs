//! Whole-body inverse kinematics from a captured human onto a character.
//!
//! The main path of [`retarget`]:
//!
//! 1. The source's joints get roles ([`Correspondence`]).
//! 2. The human becomes directions of limbs, orientations of trunk, head and feet, and soles on the ground.
//! 3. Contacts are found.
//! 4. Pass A follows the human: damped Gauss-Newton over all joints, within ranges and speeds. Zero-phase smoothing
//!    follows.
//! 5. Pass B locks the stance soles to the ground with root and legs.
//! 6. A body that stands on one foot for long leans over it.
//! 7. A last shift in height; [`RetargetReport`] is measured on the result.
//!
//! Limbs are compared by the DIRECTIONS of their segments, never by rotations, so rest poses need not agree.

mod balance;
mod bounds;
mod correspondence;
mod feet;
mod ground;
mod human;
mod options;
mod own;
mod passes;
mod plant;
mod refuse;
mod report;
mod restart;
pub(crate) mod rig;
mod robot_source;
pub(crate) mod shapes;
pub(crate) mod smooth;
pub(crate) mod solver;

use std::time::Instant;

use lifelike_character::{Anatomy, Character, Quat, Vec3};

pub use bounds::Bounds;
pub use correspondence::{Correspondence, SourceRoles};
pub use options::{RetargetOptions, Tempo, TempoRule};
pub(crate) use report::Gather;
pub use report::{RetargetReport, Spread};
pub use robot_source::source_of_robot;

pub(crate) use plant::{replant, stand_as};

use crate::clip::{Contacts, MotionClip, Provenance};
use crate::error::MotionError;
use crate::source::SourceClip;
use feet::Stance;
use human::Human;
use rig::Rig;
use shapes::Shapes;

/// Most frames of a result: more than five hours at 50 per second.
const MOST_FRAMES: f64 = 1e6;

/// Converts a captured clip into a motion of this character, and says how well that went.
///
/// # Errors
/// [`MotionError::Unfit`] with the reason when the clip cannot be converted: too short, not finite, without legs,
/// carried by things other than flat ground, or beyond the [`Bounds`] of a conversion's errors. [`MotionError::Mismatch`] when the character cannot be: no free root, ball
/// joints, a leg or a sole missing.
pub fn retarget(
    source: &SourceClip,
    character: &Character,
    anatomy: &Anatomy,
    options: &RetargetOptions,
) -> Result<(MotionClip, RetargetReport), MotionError> {
    let started = Instant::now();
    let fps = options.fps;
    check_options(source, options)?;
    source.check()?;
    let roles = SourceRoles::guess(source, &options.correspondence)?;
    let rig = Rig::new(character, anatomy, options)?;
    let leg = Human::leg_length_of(source, &roles);
    if !(leg.is_finite() && leg > 1e-3) {
        let message = format!("its skeleton's legs are {leg} m long");
        return Err(MotionError::Unfit { clip: source.name.clone(), message });
    }
    let tempo = options.tempo.factor(leg, rig.leg_length);
    // What is said of the human is said in the human's time: a frame lasts longer there.
    let captured_fps = fps / tempo;
    let human = Human::read(source, &roles, captured_fps);
    let stances = feet::detect(&human, captured_fps, &options.contact);
    refuse::check_stance(source, &human, &stances)?;
    if !options.allow_off_ground {
        refuse::check_ground(source, &human, &stances, captured_fps)?;
    }
    let shapes = Shapes::new(character);
    let mut poses = solve(&rig, anatomy, &shapes, &human, &stances, options);
    ground::settle(&rig, &shapes, &mut poses, &stances);
    finish(&rig, &mut poses, fps);

    let keep = human.padding..poses.len() - human.padding;
    let stances = stances.map(|s| Stance { down: s.down.map(|d| d[keep.clone()].to_vec()) });
    let poses = &poses[keep.clone()];
    let outcome = report::Outcome {
        rig: &rig,
        shapes: &shapes,
        frames: &human.frames[keep],
        poses,
        stances: &stances,
        fps,
        tempo,
    };
    let seconds = started.elapsed().as_secs_f64();
    let mut report = report::measure(&outcome, &human, &source.name);
    report.notes.clone_from(&source.notes);
    report.frames_per_second = human.frames.len() as f64 / seconds.max(1e-9);
    let path = source.root_position.iter().map(|place| (place - source.root_position[0]).norm());
    let travels = path.fold(0.0, f64::max) > 0.1 * leg;
    options.bounds.check(&report, rig.leg_length, travels)?;
    Ok((make_clip(source, &rig, poses, &stances, (fps, tempo)), report))
}

/// Rates that motion can be retargeted at (Hz): more would fill the memory with frames between frames.
const FPS: std::ops::RangeInclusive<f64> = 1.0..=1000.0;

fn check_options(source: &SourceClip, options: &RetargetOptions) -> Result<(), MotionError> {
    let positive = |what: &str, value: f64| {
        if value.is_finite() && value > 0.0 {
            Ok(())
        } else {
            let message = format!("retargeting option {what} is {value}; it must be positive");
            Err(MotionError::Unfit { clip: source.name.clone(), message })
        }
    };
    if !FPS.contains(&options.fps) {
        let message =
            format!("retargeting option fps is {}; it must be from {} to {} Hz", options.fps, FPS.start(), FPS.end());
        return Err(MotionError::Unfit { clip: source.name.clone(), message });
    }
    let frames = options.fps * source.seconds();
    if frames > MOST_FRAMES {
        let message = format!(
            "{:.0} s are {frames:.0} frames at {} Hz, more than {MOST_FRAMES:.0}: is the capture's rate right (--fps)?",
            source.seconds(),
            options.fps
        );
        return Err(MotionError::Unfit { clip: source.name.clone(), message });
    }
    positive("tempo", options.tempo.factor(1.0, 1.0))?;
    positive("default_velocity_limit", options.default_velocity_limit)?;
    options.velocity_limit.iter().try_for_each(|(name, v)| positive(&format!("velocity_limit.{name}"), *v))?;
    for (what, value, most) in options.limited() {
        if !(value >= 0.0 && value <= most) {
            let message = format!("retargeting option {what} is {value}; it must be from 0 to {most}");
            return Err(MotionError::Unfit { clip: source.name.clone(), message });
        }
    }
    Ok(())
}

/// Returns the generalised positions for every frame, feet locked, before the last shift in height.
fn solve(
    rig: &Rig,
    anatomy: &Anatomy,
    shapes: &Shapes,
    human: &Human,
    stances: &[Stance; 2],
    options: &RetargetOptions,
) -> Vec<Vec<f64>> {
    let fps = options.fps;
    let sigma = options.smoothing * fps;
    let soft = feet::soft_targets(rig, human, stances, options, fps);
    let mut followed = passes::follow(rig, shapes, human, &soft, fps);
    limit_speeds(rig, &mut followed, fps);
    smooth::smooth_poses(rig, &mut followed, sigma);
    let planted = plant::plant(rig, &followed, &followed, &soft, stances, options);
    if options.balance { balance::balance(rig, anatomy, planted, stances, sigma, fps) } else { planted }
}

fn limit_speeds(rig: &Rig, poses: &mut [Vec<f64>], fps: f64) {
    for axis in &rig.axes {
        let mut column: Vec<f64> = poses.iter().map(|p| p[axis.q]).collect();
        smooth::limit_speed(&mut column, axis.speed / fps);
        for (pose, value) in poses.iter_mut().zip(column) {
            pose[axis.q] = value;
        }
    }
}

/// Brings the poses exactly within speeds and ranges, without sign flips.
fn finish(rig: &Rig, poses: &mut [Vec<f64>], fps: f64) {
    limit_speeds(rig, poses, fps);
    for pose in poses.iter_mut() {
        for axis in &rig.axes {
            pose[axis.q] = pose[axis.q].clamp(axis.range.0, axis.range.1);
        }
    }
    smooth::continuous(poses, rig.root.q_index + 3);
}

fn make_clip(
    source: &SourceClip,
    rig: &Rig,
    poses: &[Vec<f64>],
    stances: &[Stance; 2],
    (fps, tempo): (f64, f64),
) -> MotionClip {
    let character = rig.character;
    let (root_position, root_orientation, joints) = unpack(rig, poses);
    let names = rig.legs.iter().map(|l| character.bodies[l.foot.body].name.clone()).collect();
    MotionClip {
        name: source.name.clone(),
        fps,
        joint_names: character.scalar_joints().map(|j| j.name.clone()).collect(),
        root_position,
        root_orientation,
        joints,
        contacts: Some(Contacts {
            names,
            flags: (0..poses.len()).flat_map(|t| [stances[0].any(t), stances[1].any(t)]).collect(),
        }),
        cyclic: source.cyclic,
        provenance: Provenance {
            character: character.name.clone(),
            source: if tempo == 1.0 {
                source.name.clone()
            } else {
                format!("{} at {tempo:.3} times the captured tempo", source.name)
            },
            licence: source.provenance.clone(),
            captions: source.captions.clone(),
        },
    }
}

/// Returns the generalised positions as a clip holds them: root positions, root orientations, joints in the character's
/// order.
pub(crate) fn unpack(rig: &Rig, poses: &[Vec<f64>]) -> (Vec<Vec3>, Vec<Quat>, Vec<f64>) {
    let at = rig.root.q_index;
    (
        poses.iter().map(|p| Vec3::new(p[at], p[at + 1], p[at + 2])).collect(),
        poses.iter().map(|p| smooth::signed_orientation(p, at)).collect(),
        poses.iter().flat_map(|p| rig.axes.iter().map(|a| p[a.q])).collect(),
    )
}
