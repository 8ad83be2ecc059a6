//! A motion that cannot be executed becomes one that can, with as little change as it takes.
//!
//! The main path of [`repair`]: [`feasibility`] finds what is wrong. A jump that falls slower than gravity lets it, or
//! a joint that is too fast, gets another pace (`pace`). A body that hovers comes down to the ground (`hover`). It
//! gets another sway if the ground's force would have to act beside the feet (`balance`, the zero moment point of
//! Vukobratović). The retargeter's own passes put the soles back. All this repeats until nothing is found or nothing
//! helps, and [`Repaired`] lists the changes.
//!
//! Only the time, the root and the legs change. Motions that lie, roll or climb are not for this.

mod balance;
mod hover;
mod pace;
mod report;

use lifelike_character::{Anatomy, Character, Kinematics};

use pace::Pace;
pub use report::{Change, Repaired};

use super::poses::{positions, set_positions};
use super::restyle::standing;
use super::story::provenance;
use crate::clip::MotionClip;
use crate::error::MotionError;
use crate::feasibility::{self, Feasibility, Kind, Momentum, Touch, momentum, touches};
use crate::retarget::rig::Rig;
use crate::retarget::{RetargetOptions, stand_as};

/// Sways are sought so often: each is right for the angular momentum of the one before.
const ROUNDS: usize = 12;
/// A body in the air that falls faster than this share of gravity is in flight; slower, it hovers.
const FALLING: f64 = 0.25;

/// Repairs a clip. `speeds` are the largest of the character's scalar joints, as for [`check`](feasibility::check);
/// `options` says how soles are put on the ground. A clip that can be tracked comes back as it is. One that cannot be
/// made feasible comes back as far as it was brought ([`Repaired::after`] tells). A clip that was changed is no cycle
/// any more.
///
/// # Errors
/// [`MotionError::Unfit`] for a clip that is inconsistent, [`MotionError::Mismatch`] when clip and character do not belong together or the
/// character has no legs.
pub fn repair(
    clip: &MotionClip,
    character: &Character,
    anatomy: &Anatomy,
    speeds: &[f64],
    options: &RetargetOptions,
) -> Result<(MotionClip, Repaired), MotionError> {
    let options = RetargetOptions { fps: clip.fps, ..options.clone() };
    let rig = Rig::new(character, anatomy, &options)?;
    let check = |clip: &MotionClip| feasibility::check(clip, character, anatomy, speeds);
    let before = check(clip)?;
    let mut best = clip.clone();
    let mut found = before.clone();
    let mut pace = Pace::of(clip);
    if !before.trackable {
        let needs = Needs::of(clip, &rig, anatomy)?;
        if let Some(other) = Pace::better(clip, &needs, &before)
            && keep_better(&mut best, &mut found, Some(other.applied(clip, &rig)?), &check)?
        {
            pace = other;
        }
        let lowered = hover::lower(&best, &Needs::of(&best, &rig, anatomy)?, &rig, &options)?;
        keep_better(&mut best, &mut found, lowered, &check)?;
        let swayed = sway(&best, &found, &rig, anatomy, &options, &check)?;
        keep_better(&mut best, &mut found, swayed, &check)?;
    }
    let change = Change::between(clip, &best, &pace, &rig)?;
    if best != *clip {
        let done = format!("'{}' made feasible", clip.name);
        // Its end may no longer be its beginning.
        best.cyclic = false;
        best.provenance = provenance(&[clip], done, best.provenance.captions.clone());
    }
    Ok((best, Repaired { clip: clip.name.clone(), before, after: found, change }))
}

/// Seconds of what rules a clip out.
fn amiss(found: &Feasibility) -> f64 {
    found.reasons().map(|finding| finding.seconds).sum()
}

/// Compares a motion with what somebody else made of it at the same times, as [`repair`] tells of its own.
///
/// # Errors
/// As [`repair`].
pub fn compare(
    clip: &MotionClip,
    made: &MotionClip,
    character: &Character,
    anatomy: &Anatomy,
    speeds: &[f64],
    options: &RetargetOptions,
) -> Result<Repaired, MotionError> {
    let rig = Rig::new(character, anatomy, options)?;
    Ok(Repaired {
        clip: clip.name.clone(),
        before: feasibility::check(clip, character, anatomy, speeds)?,
        after: feasibility::check(made, character, anatomy, speeds)?,
        change: Change::between(clip, made, &Pace::of(clip), &rig)?,
    })
}

/// Takes a change that leaves less amiss; whether it did.
fn keep_better(
    best: &mut MotionClip,
    found: &mut Feasibility,
    changed: Option<MotionClip>,
    check: &impl Fn(&MotionClip) -> Result<Feasibility, MotionError>,
) -> Result<bool, MotionError> {
    let Some(changed) = changed else { return Ok(false) };
    let now = check(&changed)?;
    let better = amiss(&now) < amiss(found);
    if better {
        (*best, *found) = (changed, now);
    }
    Ok(better)
}

/// Moves the body above its feet until the ground's force acts within them; the best of all rounds.
fn sway(
    clip: &MotionClip,
    found: &Feasibility,
    rig: &Rig,
    anatomy: &Anatomy,
    options: &RetargetOptions,
    check: &impl Fn(&MotionClip) -> Result<Feasibility, MotionError>,
) -> Result<Option<MotionClip>, MotionError> {
    if !found.findings.iter().any(|f| matches!(f.kind, Kind::Unbalanced | Kind::Slipping)) {
        return Ok(None);
    }
    let character = rig.character;
    let old = positions(clip, character)?;
    let stands = standing(clip, rig);
    let mut shift = balance::Shift::none(clip.len());
    let (mut best, mut least): (Option<MotionClip>, f64) = (None, amiss(found));
    let mut now = clip.clone();
    for _ in 0..ROUNDS {
        if !shift.improve(&Needs::of(&now, rig, anatomy)?, rig.leg_length, clip.fps) {
            break;
        }
        let new = stand_as(rig, &old, &old, &shift.applied(&old, rig.root.q_index), &stands, options);
        set_positions(&mut now, character, &new);
        let amiss = amiss(&check(&now)?);
        if amiss < least {
            (best, least) = (Some(now.clone()), amiss);
        }
        if amiss == 0.0 {
            break;
        }
    }
    Ok(best)
}

/// Needs of each frame towards the ground, and the parts of the body that can meet them.
struct Needs {
    momentum: Vec<Option<Momentum>>,
    touches: Vec<Touch>,
    /// Height of the lowest point of the left and the right sole (m).
    soles: Vec<[f64; 2]>,
    gravity: f64,
}

impl Needs {
    fn of(clip: &MotionClip, rig: &Rig, anatomy: &Anatomy) -> Result<Self, MotionError> {
        let character = rig.character;
        let poses: Vec<Kinematics> = positions(clip, character)?
            .iter()
            .map(|q| {
                let mut pose = Kinematics::new(character);
                pose.update(character, q);
                pose
            })
            .collect();
        let lowest = |pose: &Kinematics| {
            rig.legs.each_ref().map(|leg| {
                let heights = leg.foot.corners.iter().map(|corner| pose.point(leg.foot.body, corner).z);
                heights.fold(f64::INFINITY, f64::min)
            })
        };
        Ok(Self {
            momentum: momentum(character, &poses, clip.fps),
            touches: poses.iter().map(|pose| touches(character, anatomy, pose)).collect(),
            soles: poses.iter().map(lowest).collect(),
            gravity: character.gravity.norm(),
        })
    }

    /// Returns the frames in which nothing touches, as stretches.
    fn airborne(&self) -> Vec<(usize, usize)> {
        let flags: Vec<bool> = self.touches.iter().map(|touch| touch.points.is_empty()).collect();
        crate::contacts::runs(&flags, true)
    }

    /// Returns with what acceleration a stretch falls (m/s²): of the parabola of least squares through the heights of its centre of mass.
    fn falls(&self, (start, end): (usize, usize), fps: f64) -> Option<f64> {
        let heights: Vec<f64> = self.momentum[start..end].iter().flatten().map(|m| m.centre.z).collect();
        if heights.len() < 4 {
            return None;
        }
        let middle = (heights.len() - 1) as f64 / 2.0;
        let squares: Vec<f64> = (0..heights.len()).map(|i| ((i as f64 - middle) / fps).powi(2)).collect();
        let mean = squares.iter().sum::<f64>() / squares.len() as f64;
        let across: f64 = squares.iter().map(|x| (x - mean).powi(2)).sum();
        Some(-2.0 * squares.iter().zip(&heights).map(|(x, z)| z * (x - mean)).sum::<f64>() / across)
    }
}
