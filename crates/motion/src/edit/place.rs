//! Precise edits (thesis fig. 4.7, "Precision"): this point of the body at this place at this time.
//!
//! The main path of [`place`]: every [`Key`] is an offset of one point from the clip. The offsets become functions of
//! time (`offset`), smooth and zero outside of the keys' windows. Frame by frame, the retargeter's inverse kinematics
//! moves the body as little as it takes while both feet stay (`solve`). Joints keep to their speeds (`pace`).
//! [`PlaceReport`] measures the result.

mod offset;
mod pace;
mod report;
mod solve;

use lifelike_character::{Anatomy, Character, Role, Vec3};

pub use report::{PlaceReport, Placed};

use super::poses::{positions, set_positions};
use super::story::{provenance, unfit};
use crate::clip::MotionClip;
use crate::contacts::clip_contacts;
use crate::error::MotionError;
use crate::retarget::RetargetOptions;
use crate::retarget::rig::{Rig, Spot};
use offset::Track;

/// Target of a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Target {
    /// Here (m, world).
    At(Vec3),
    /// So far from where the clip has it (m, world).
    By(Vec3),
}

/// One point at one place at one time.
#[derive(Debug, Clone, PartialEq)]
pub struct Key {
    /// A site, a body, or a role such as `left_hand`.
    pub body: String,
    /// The point in that body's frame (m); where not given: the site, the role's place, the body's origin.
    pub point: Option<Vec3>,
    /// When (s); the nearest frame is taken.
    pub time: f64,
    /// Location.
    pub target: Target,
    /// Duration before it in which the motion begins to deviate (s).
    pub before: f64,
    /// Duration after it until the motion is its own again (s).
    pub after: f64,
}

/// Returns the clip with these points at their places. Root and joints move as little as it takes, and both soles stay
/// unless a key is on that foot. Joints stay within their ranges, and are no faster than `options` or the clip itself
/// allows. Frames outside of all windows are untouched. Keys of one point that follow each other within their windows
/// are joined without going back in between. Contacts are found anew when a foot has keys. If the body cannot come
/// along without its soles giving way, all keys are met by the same share less.
///
/// # Errors
/// [`MotionError::Unfit`] for no key, a time outside of the clip, a bad number or window, or two keys of one point in
/// one frame. [`MotionError::Mismatch`] for an unknown body or a character without legs. A place out of reach is no
/// error: the report says how far off the point stays.
pub fn place(
    clip: &MotionClip,
    character: &Character,
    anatomy: &Anatomy,
    keys: &[Key],
    options: &RetargetOptions,
) -> Result<(MotionClip, PlaceReport), MotionError> {
    let old = positions(clip, character)?;
    let options = RetargetOptions { fps: clip.fps, ..options.clone() };
    let rig = Rig::new(character, anatomy, &options)?;
    if keys.is_empty() {
        return Err(unfit(clip, "expected at least one key, got none".into()));
    }
    let spots = keys.iter().map(|key| spot(character, anatomy, key)).collect::<Result<Vec<_>, _>>()?;
    let tracks = Track::of_keys(clip, &rig, &old, keys, &spots)?;
    let new = solve::solve(&rig, clip, &old, &tracks);
    let mut out = clip.clone();
    set_positions(&mut out, character, &new);
    // What no key touches is not even rounded.
    let width = clip.joint_names.len();
    for t in (0..clip.len()).filter(|t| old[*t] == new[*t]) {
        out.root_position[t] = clip.root_position[t];
        out.root_orientation[t] = clip.root_orientation[t];
        out.joints[t * width..(t + 1) * width].copy_from_slice(clip.joints_at(t));
    }
    let keyed = tracks.iter().any(|track| anatomy.foot_of(character, track.spot.body).is_some());
    if let (true, Some(_)) = (keyed, &clip.contacts) {
        let rule = options.contact.scaled(rig.leg_length);
        out.contacts = Some(clip_contacts(&out, character, anatomy, &rule)?);
    }
    let moved: Vec<String> = keys.iter().map(|key| format!("{} at {} s", key.body, key.time)).collect();
    let done = format!("'{}' with {} placed", clip.name, moved.join(", "));
    out.provenance = provenance(&[clip], done, clip.provenance.captions.clone());
    let report = report::measure(&rig, clip, (&old, &new), keys, &tracks);
    Ok((out, report))
}

/// Returns the point that a key names.
fn spot(character: &Character, anatomy: &Anatomy, key: &Key) -> Result<Spot, MotionError> {
    let name = key.body.as_str();
    let role = serde_json::from_value::<Role>(name.into()).ok().and_then(|role| anatomy.places.get(&role));
    let (body, point) = if let Ok(site) = character.site(name) {
        (character.sites[site].body, character.sites[site].position)
    } else if let Ok(body) = character.body(name) {
        (body, Vec3::zeros())
    } else if let Some(place) = role {
        (place.body, place.point)
    } else {
        let sites = character.sites.iter().map(|s| s.name.as_str());
        let names: Vec<&str> = sites.chain(character.bodies.iter().skip(1).map(|b| b.name.as_str())).collect();
        let message = format!("expected a site or body of {names:?}, or a role such as left_hand, got '{name}'");
        return Err(MotionError::Mismatch { clip: "(any)".into(), character: character.name.clone(), message });
    };
    Ok(Spot { body, point: key.point.unwrap_or(point) })
}
