//! Report of a placement, measured on the result.

use lifelike_character::{Kinematics, Vec3};

use super::Key;
use super::offset::{Hit, Track};
use crate::clip::MotionClip;
use crate::retarget::rig::Rig;
use crate::retarget::shapes::Shapes;

/// Result of one key.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Placed {
    /// Point that was placed, as the key names it.
    pub body: String,
    /// The frame's time (s).
    pub time: f64,
    /// Position in the clip before (m, world).
    pub was: [f64; 3],
    /// Target position (m, world).
    pub asked: [f64; 3],
    /// Position after (m, world).
    pub reached: [f64; 3],
    /// Distance from the target (m).
    pub residual: f64,
}

/// Report of a placement.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct PlaceReport {
    /// One per key, in their order.
    pub keys: Vec<Placed>,
    /// Frames that changed.
    pub frames: usize,
    /// The furthest that a corner of a sole moved while its foot stood, of feet without keys (m).
    pub feet_moved: f64,
    /// The deepest overlap of two parts in the frames that changed, and what it was there before (m).
    pub self_penetration: [f64; 2],
    /// The lowest point in the frames that changed, and what it was there before (m).
    pub lowest: [f64; 2],
}

/// Measures the result; `poses` are those before and after.
pub(super) fn measure(
    rig: &Rig,
    clip: &MotionClip,
    (old, new): (&[Vec<f64>], &[Vec<f64>]),
    keys: &[Key],
    tracks: &[Track],
) -> PlaceReport {
    let character = rig.character;
    let shapes = Shapes::new(character);
    let (mut before, mut after) = (Kinematics::new(character), Kinematics::new(character));
    let mut placed: Vec<Option<Placed>> = vec![None; keys.len()];
    for track in tracks {
        for &Hit { key, frame, offset } in &track.hits {
            before.update(character, &old[frame]);
            after.update(character, &new[frame]);
            let at = |k: &Kinematics| k.point(track.spot.body, &track.spot.point);
            let asked = at(&before) + offset;
            placed[key] = Some(Placed {
                body: keys[key].body.clone(),
                time: frame as f64 / clip.fps,
                was: at(&before).into(),
                asked: asked.into(),
                reached: at(&after).into(),
                residual: (asked - at(&after)).norm(),
            });
        }
    }
    let mut report = PlaceReport {
        keys: placed.into_iter().flatten().collect(),
        frames: 0,
        feet_moved: 0.0,
        self_penetration: [0.0; 2],
        lowest: [f64::INFINITY; 2],
    };
    for t in (0..old.len()).filter(|t| old[*t] != new[*t]) {
        report.frames += 1;
        before.update(character, &old[t]);
        after.update(character, &new[t]);
        for (i, k) in [&after, &before].into_iter().enumerate() {
            report.self_penetration[i] = report.self_penetration[i].max(shapes.self_penetration(k));
            report.lowest[i] = report.lowest[i].min(shapes.lowest(k));
        }
        for leg in &rig.legs {
            let body = leg.foot.body;
            let keyed = tracks.iter().any(|track| track.spot.body == body);
            if !keyed && stands(clip, &character.bodies[body].name, t) {
                let moved = |c: &Vec3| (after.point(body, c) - before.point(body, c)).norm();
                report.feet_moved = leg.foot.corners.iter().map(moved).fold(report.feet_moved, f64::max);
            }
        }
    }
    if report.frames == 0 {
        report.lowest = [0.0; 2];
    }
    report
}

/// Returns whether the clip says that a foot stands; of feet of which it says nothing, always.
pub(super) fn stands(clip: &MotionClip, foot: &str, frame: usize) -> bool {
    let Some(contacts) = &clip.contacts else { return true };
    let place = contacts.names.iter().position(|name| name == foot);
    place.is_none_or(|place| contacts.flags[frame * contacts.names.len() + place])
}
