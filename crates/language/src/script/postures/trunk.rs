//! Trunk and head: leans, twists and turns.

use super::Words;
use crate::facts::{Side, Size};
use crate::posture::Turn;

/// Lean forward, back and aside, twist, and turns of the head where no angle is said (degrees).
const FORWARD: f64 = 30.0;
const BACK: f64 = 14.0;
const ASIDE: f64 = 18.0;
const TWIST: f64 = 40.0;
const LOOK: f64 = 55.0;
const NOD: f64 = 25.0;
const MOST_LEAN: f64 = 50.0;

/// Reads a lean or a twist of the trunk.
pub(super) fn trunk(piece: &Words<'_>) -> Option<Turn> {
    let degrees = piece.degrees().map(|degrees| degrees.min(MOST_LEAN));
    let small = if piece.said.size == Some(Size::Small) { 0.5 } else { 1.0 };
    let usual = |angle: f64| degrees.unwrap_or(small * angle);
    let side = piece.said.side.filter(|side| *side != Side::Both);
    let sign = if side == Some(Side::Left) { 1.0 } else { -1.0 };
    if piece.has(&["twist", "turn", "rotate"]) {
        side?;
        return Some(Turn { yaw: sign * usual(TWIST), ..Turn::default() });
    }
    if side.is_some() {
        return Some(Turn { roll: -sign * usual(ASIDE), ..Turn::default() });
    }
    if piece.has(&["forward", "forwards", "front", "ahead", "down"]) {
        return Some(Turn { pitch: usual(FORWARD), ..Turn::default() });
    }
    if piece.has(&["back", "backward", "backwards"]) {
        return Some(Turn { pitch: -usual(BACK), ..Turn::default() });
    }
    let aside = piece.has(&["side", "sideways"]);
    aside.then(|| Turn { roll: usual(ASIDE), ..Turn::default() })
}

/// Reads where the head goes.
pub(super) fn head(piece: &Words<'_>) -> Option<Turn> {
    let degrees = piece.degrees().map(|degrees| degrees.min(MOST_LEAN));
    let side = piece.said.side.filter(|side| *side != Side::Both);
    let sign = if side == Some(Side::Left) { 1.0 } else { -1.0 };
    let turns = piece.has(&["turn", "rotate", "twist", "look", "snap"]);
    match () {
        () if turns && side.is_some() => Some(Turn { yaw: sign * degrees.unwrap_or(LOOK), ..Turn::default() }),
        () if side.is_some() => Some(Turn { roll: -sign * degrees.unwrap_or(NOD), ..Turn::default() }),
        () if piece.has(&["chin", "sink", "tuck"]) && piece.has(&["chest"]) => {
            Some(Turn { pitch: degrees.unwrap_or(NOD), ..Turn::default() })
        }
        () if piece.has(&["down", "lower", "drop", "hang", "forward", "sink", "bowed", "bow"]) => {
            Some(Turn { pitch: degrees.unwrap_or(NOD), ..Turn::default() })
        }
        () if piece.has(&["up", "raise", "lift", "back", "ceiling", "sky"]) => {
            Some(Turn { pitch: -degrees.unwrap_or(NOD), ..Turn::default() })
        }
        () if piece.has(&["side", "sideways", "tilt"]) => {
            Some(Turn { roll: degrees.unwrap_or(NOD), ..Turn::default() })
        }
        () if piece.has(&["straight", "level"]) => Some(Turn::default()),
        () => None,
    }
}
