//! Legs: feet that rise or step, and knees that bend.

use super::{Context, LEGS, Words, side_of, spreads};
use crate::facts::{Side, Size};
use crate::posture::{Foot, Posture, Turn};

/// Depths of the pelvis (m, of the keyframed figure): knees that bend, a little, and over feet far apart.
const DEEP: f64 = 0.13;
const SHALLOW: f64 = 0.06;
const FAR: f64 = 0.09;
/// Way of each foot to the other where they are together (m).
const CLOSE: f64 = 0.04;
/// Lean of the trunk over a leg that carries (degrees).
const OVER: f64 = 8.0;

/// Reads legs. Returns whether no verb's phrase says as much.
pub(super) fn legs(piece: &Words<'_>, context: &mut Context, posture: &mut Posture) -> Option<bool> {
    if piece.has(&["head", "chin"]) {
        return None;
    }
    let plural = piece.has(&["legs", "feet", "knees", "stance", "heels"]) || spreads(piece, context);
    // "The shin hangs", of a knee that is up.
    let is_shin = piece.has(&["shin", "shins"]) && context.legs.is_some();
    if is_shin && piece.has(&["hang", "dangle", "vertical", "vertically", "down", "relaxed", "loose"]) {
        return Some(true);
    }
    // "The knee points at the floor", of a foot that is up behind.
    let is_thigh = piece.has(&["knee", "thigh"]) && piece.has(&["point", "hang", "vertical", "straight"]);
    if is_thigh && !plural && !piece.has(&["up", "raise", "lift"]) && context.before.is_on_one_foot() {
        return Some(true);
    }
    // "Knees soft", "legs straight".
    if plural && piece.has(&["soft", "straight"]) && !piece.has(&["raise", "lift", "apart", "wide", "wider"]) {
        posture.sink = piece.has(&["soft"]).then_some(SHALLOW);
        return Some(true);
    }
    // "Bend your knee so that the heel comes to your bottom".
    if piece.has(&["heel"]) && piece.has(&["bottom", "bum", "butt", "backside", "glutes", "buttocks"]) && !plural {
        let side = side_of(piece, false, context.legs).or(context.legs).unwrap_or(Side::Right);
        let foot = Some(Foot { to: [-0.2, if side == Side::Left { 0.01 } else { -0.01 }], height: 0.24 });
        context.legs = Some(side);
        match side {
            Side::Left => posture.left_foot = foot,
            _ => posture.right_foot = foot,
        }
        return Some(true);
    }
    let bends = piece.has(&["bend", "bent"]) && piece.has(&["knee", "knees", "legs", "leg"]);
    if bends && (plural || piece.has(&["front"]) || context.legs.is_some()) && !piece.has(&["raise", "lift"]) {
        let deep = if piece.said.size == Some(Size::Small) || piece.has(&["slightly", "little", "bit", "tad"]) {
            SHALLOW
        } else {
            DEEP
        };
        posture.sink = Some(deep);
        return Some(true);
    }
    // "Foot off the ground", of one that is up.
    let says_way =
        piece.has(&["front", "forward", "ahead", "back", "behind", "side", "sideways", "out", "raise", "lift"]);
    if piece.has(&["off"]) && !plural && !says_way && context.before.is_on_one_foot() {
        return Some(true);
    }
    // "Stand on the left leg": the other one is up.
    if piece.has(&["stand"]) && piece.has(&["on"]) && piece.has(&["leg", "foot"]) {
        let side = piece.said.side.filter(|side| *side != Side::Both)?.mirrored();
        let foot = Some(Foot { to: [0.02, if side == Side::Left { 0.01 } else { -0.01 }], height: 0.2 });
        context.legs = Some(side);
        match side {
            Side::Left => posture.left_foot = foot,
            _ => posture.right_foot = foot,
        }
        return Some(false);
    }
    // "Put your weight on the left leg": over it.
    if piece.has(&["weight"]) {
        let side = side_of(piece, false, context.legs).or(context.legs)?;
        posture.trunk = Some(Turn { roll: if side == Side::Left { -OVER } else { OVER }, ..Turn::default() });
        context.legs = Some(side.mirrored());
        return Some(true);
    }
    let lowers = piece.has(&["lower", "drop"]) && piece.has(&["hip", "hips"]);
    if lowers {
        posture.sink = Some(DEEP);
        return Some(true);
    }
    if piece.has(&["straighten"]) && !piece.has(&["behind", "back", "front", "ahead", "forward", "side", "out"]) {
        posture.sink = Some(0.0);
        return Some(true);
    }
    if plural && piece.has(&["apart", "wide", "wider", "width"]) {
        // "Shoulder width apart" is hardly wider than people stand.
        let is_narrow = piece.has(&["width", "hip", "hips"]) && !piece.has(&["wider"]);
        let way = if is_narrow { 0.04 } else { 0.15 };
        (posture.left_foot, posture.right_foot) =
            (Some(Foot { to: [0.0, way], height: 0.0 }), Some(Foot { to: [0.0, -way], height: 0.0 }));
        if is_narrow {
            return Some(true);
        }
        posture.sink = Some(if piece.has(&["low", "bent"]) { DEEP } else { FAR });
        return Some(true);
    }
    if plural && piece.has(&["together"]) {
        (posture.left_foot, posture.right_foot) =
            (Some(Foot { to: [0.0, -CLOSE], height: 0.0 }), Some(Foot { to: [0.0, CLOSE], height: 0.0 }));
        return Some(true);
    }
    if plural && !piece.has(&["them"]) {
        return None;
    }
    let side = side_of(piece, false, context.legs).or(context.legs).or(piece.has(&LEGS).then_some(Side::Right))?;
    context.legs = Some(side);
    if piece.has_row(&["back", "leg"]) || piece.has_row(&["standing", "leg"]) {
        return Some(true);
    }
    let (foot, detail) = foot(piece, side, &context.last_verb)?;
    let before = if side == Side::Left { context.before.left_foot } else { context.before.right_foot };
    if foot == Foot::STANDING && before.is_none_or(|before| before == Foot::STANDING) {
        return None;
    }
    // "Left foot forward, left foot back": where it stood.
    let returns = before.is_some_and(|before| before.height == 0.0 && before.to[0] * foot.to[0] < 0.0);
    let foot = if returns && foot.height == 0.0 { Foot::STANDING } else { foot };
    // A leg reaches far on the ground with bent knees alone.
    if foot.height == 0.0 && foot != Foot::STANDING {
        posture.sink = Some(FAR);
    }
    match side {
        Side::Left => posture.left_foot = Some(foot),
        Side::Right => posture.right_foot = Some(foot),
        Side::Both => return None,
    }
    Some(detail)
}

/// Reads where a foot goes.
fn foot(piece: &Words<'_>, side: Side, last_verb: &str) -> Option<(Foot, bool)> {
    let out = if side == Side::Left { 1.0 } else { -1.0 };
    let knee = piece.has(&["knee", "thigh"]);
    let ahead = piece.has(&["forward", "forwards", "front", "ahead"]);
    let aside = piece.has(&["side", "sides", "sideways"]) || piece.has(&["out"]) && !ahead;
    let behind = piece.has(&["behind", "back", "backward", "backwards"]);
    let lifts = ["raise", "lift"].contains(&last_verb)
        || piece.has(&[
            "raise",
            "lift",
            "hold",
            "keep",
            "stretch",
            "straighten",
            "horizontal",
            "tucked",
            "extend",
            "up",
            "off",
            "air",
            "stick",
        ]);
    let steps = piece.has(&["move", "put", "place", "set", "bring", "slide", "step"])
        && (ahead || behind || aside)
        && !piece.has(&["up", "air"]);
    let lift = |to: [f64; 2], height: f64| Some((Foot { to, height }, false));
    if piece.has(&["down", "lower", "drop", "ground", "floor"]) && !piece.has(&["up", "off", "above"]) {
        return Some((Foot::STANDING, false));
    }
    if steps {
        let to = match () {
            () if behind => [-0.26, 0.0],
            () if ahead => [0.26, 0.0],
            () => [0.0, 0.2 * out],
        };
        return Some((Foot { to, height: 0.0 }, !piece.has(&["step"])));
    }
    // "Left foot back" is a step; a leg's base form is a foot, too.
    if piece.words.iter().any(|word| word == "foot") && !lifts {
        let to = match () {
            () if behind => [-0.26, 0.0],
            () if ahead => [0.26, 0.0],
            () if aside => [0.0, 0.2 * out],
            () => return None,
        };
        return Some((Foot { to, height: 0.0 }, false));
    }
    match () {
        () if !lifts && !ahead && !behind && !aside => None,
        () if knee => match piece.said.level {
            Some(level) if level <= 75 => lift([0.06, 0.01 * out], 0.38),
            _ => lift([0.06, 0.01 * out], 0.34),
        },
        () if piece.has(&["heel"]) => Some((Foot { to: [-0.2, 0.01 * out], height: 0.24 }, true)),
        () if behind => lift([-0.28, 0.01 * out], 0.17),
        () if aside => lift([0.0, 0.24 * out], 0.14),
        () if ahead => lift([0.3, 0.0], 0.14),
        () => lift([0.02, 0.01 * out], 0.2),
    }
}
