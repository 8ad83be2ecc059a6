//! The unit of length of a BVH file, which does not say it.

use std::path::Path;

use lifelike_character::{Quat, Role, Vec3};

use crate::formats::raw::RawClip;
use crate::roles;
use crate::{FromInput, MotionError};

/// Sizes of people (m).
const PEOPLE: std::ops::Range<f64> = 1.0..2.5;
/// Units that are guessed (m): their ranges for a person do not meet.
const GUESSED: [f64; 3] = [1.0, 0.01, 0.001];
/// Unit of the CMU's skeletons and their conversions (m): inches over 0.45.
const CMU: f64 = 0.0254 / 0.45;
/// Other units, to be stated (m).
const OTHERS: [(f64, &str); 4] = [(CMU, "inches / 0.45"), (0.0254, "inches"), (0.3048, "feet"), (0.1, "dm")];

/// Returns the metres per unit.
pub(super) fn guess(file: &Path, clip: &RawClip, notes: &mut Vec<String>) -> Result<f64, MotionError> {
    let size = size_of(clip);
    if let Some(scale) = GUESSED.into_iter().find(|scale| PEOPLE.contains(&(size * scale))) {
        return Ok(scale);
    }
    // Inches begin at 39.4 units.
    if (18.0..39.0).contains(&size) {
        notes.push(format!("a body of {size:.1} units: read in the CMU's unit of {CMU:.5} m (--scale overrides it)"));
        return Ok(CMU);
    }
    let offer = OTHERS.iter().find(|(scale, _)| PEOPLE.contains(&(size * scale)));
    let offer = match offer {
        Some((scale, name)) => format!("--scale {scale:.5} if these are {name}"),
        None => "--scale METRES_PER_UNIT".to_owned(),
    };
    let expected = format!("a skeleton of 1 to 2.5 m in m, cm, mm or the CMU's unit; state the scale: {offer}");
    Err(MotionError::format(file.display(), expected, format!("one of {} units", four_digits(size))))
}

/// Writes a number with four significant digits at least.
fn four_digits(x: f64) -> String {
    let before_point = x.abs().max(1e-6).log10().floor() as i32 + 1;
    format!("{x:.*}", (4 - before_point).max(0) as usize)
}

/// Returns a person's size in units: along the bones from foot to head if roles are known, since zero rotations may be
/// no pose of a person. Else it is the longest side of the box around the rest pose.
fn size_of(clip: &RawClip) -> f64 {
    let found = roles::find(clip.tree(), &std::collections::BTreeMap::new());
    let length = |joint: usize, stop: usize| -> f64 {
        roles::ancestors(&clip.parents, joint).take_while(|&j| j != stop).map(|j| clip.offsets[j].norm()).sum()
    };
    if clip.known.is_none()
        && let (Some(legs), Some(head), Some(pelvis)) = (found.legs(), found.get(Role::Head), found.get(Role::Pelvis))
    {
        let end = clip.ends.iter().find(|(joint, _)| *joint == head).map_or(0.0, |(_, offset)| offset.norm());
        return length(legs[0][2], pelvis) + length(head, pelvis) + end;
    }
    let mut places: Vec<Vec3> = Vec::with_capacity(clip.offsets.len() + clip.ends.len());
    let turn = |joint: usize| clip.known.as_ref().map_or_else(Quat::identity, |known| known.rest[joint]);
    for (offset, parent) in clip.offsets.iter().zip(&clip.parents) {
        places.push(parent.map_or_else(Vec3::zeros, |p| places[p] + turn(p) * offset));
    }
    for (joint, offset) in &clip.ends {
        places.push(places[*joint] + turn(*joint) * offset);
    }
    let low = places.iter().fold(Vec3::zeros(), |a, b| a.inf(b));
    let high = places.iter().fold(Vec3::zeros(), |a, b| a.sup(b));
    (high - low).max()
}
