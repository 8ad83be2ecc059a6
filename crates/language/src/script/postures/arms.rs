//! Arms: where hands go, and how elbows bend.

use super::{ARMS, Context, ELBOWS, FOREARMS, LEGS, Words, side_of};
use crate::facts::{Side, Size};
use crate::posture::{Arm, Foot, Posture, Turn};
use crate::touch::Touch;

/// Angles of an arm that is lifted, and level (degrees).
const UP: f64 = 162.0;
const LEVEL: f64 = 90.0;
/// Lean of the trunk with which hands reach a knee (degrees).
const STOOP: f64 = 38.0;
/// Lean of the trunk to a hand that slides down a leg (degrees).
const SLID: f64 = 20.0;

/// Reads arms. Returns whether no verb's phrase says as much.
pub(super) fn arms(piece: &Words<'_>, context: &mut Context, posture: &mut Posture) -> Option<bool> {
    let plural = piece.has(&["arms", "hands", "elbows", "forearms", "fists", "palms", "upperarms", "them"])
        && (piece.has(&ARMS)
            || context.arms.is_none()
            || context.arms == Some(Side::Both)
            || both_moved(&context.before));
    let names = piece.has(&ARMS) || piece.has(&ELBOWS) || piece.has(&FOREARMS);
    // "Left elbow bent, hand up", "left hand on the hip, elbow out": the same arm.
    let bent = |arm: Option<Arm>| arm.is_some_and(|arm| arm.elbow > 60.0);
    let is_bent = match context.arms {
        Some(Side::Left) => bent(context.before.left_arm),
        Some(Side::Right) => bent(context.before.right_arm),
        _ => false,
    };
    let is_joint = piece.has(&ELBOWS) || piece.has(&FOREARMS) || is_bent;
    let is_same = !names || is_joint && !piece.has(&["a", "an", "one"]) && context.arms != Some(Side::Both);
    // "Until it rests on the right shoulder": the shoulder's side.
    let places = ["shoulder", "hip", "knee", "thigh", "ear"];
    let is_of_place = !names
        && context.arms.is_some()
        && places.into_iter().any(|place| piece.has_row(&["left", place]) || piece.has_row(&["right", place]));
    let said = side_of(piece, plural && piece.said.side.is_none(), context.arms).filter(|_| !is_of_place);
    let side = said.or(context.arms.filter(|_| is_same));
    // "An arm": the right one.
    let side = side.or(names.then_some(Side::Right))?;
    // "Slide the hand down along the leg": the trunk bends to it.
    if piece.has(&["slide"]) && piece.has(&LEGS) && piece.has(&["down"]) && side != Side::Both {
        let roll = if side == Side::Left { -SLID } else { SLID };
        posture.trunk = Some(Turn { roll, ..Turn::default() });
        posture.arm(side).into_iter().flatten().for_each(|own| *own = Some(Arm::HANGING));
        context.arms = Some(side);
        return Some(true);
    }
    let (arm, touch, detail) = arm(piece, context, side)?;
    context.arms = Some(side);
    // Knees that are lifted come to the hands.
    let stoops = !context.before.is_on_one_foot();
    if stoops && matches!(touch, Some(Touch::Knee | Touch::OtherKnee)) {
        (posture.trunk, posture.sink) = (Some(Turn { pitch: STOOP, ..Turn::default() }), Some(0.1));
    }
    for own in posture.arm(side).into_iter().flatten() {
        *own = Some(arm);
    }
    // Arms that are crossed lie over each other.
    if arm == CROSSED[0] {
        (posture.left_arm, posture.right_arm) = (Some(CROSSED[0]), Some(CROSSED[1]));
    }
    posture.touches = touch;
    Some(detail)
}

const CROSSED: [Arm; 2] = [
    Arm { raise: 29.0, aside: -19.0, turn: 58.0, elbow: 71.0 },
    Arm { raise: 54.0, aside: -19.0, turn: 53.0, elbow: 65.0 },
];

/// An arm whose hand is in front of the chest, and one with the elbow out besides.
const BEFORE_CHEST: Arm = Arm { raise: 38.0, aside: -4.0, turn: 38.0, elbow: 105.0 };
const FLARED: Arm = Arm { raise: 12.0, aside: 70.0, turn: 0.0, elbow: 125.0 };

/// Puts elbows out whose hands are in front of the chest: "elbows out, hands in front of the chest". Returns whether one
/// of two postures says the one, and the other the other.
pub(super) fn flare(posture: &mut Posture, next: &Posture) -> bool {
    let sides = [(posture.left_arm, next.left_arm), (posture.right_arm, next.right_arm)];
    let is_out = |arm: Arm| arm.aside > 60.0;
    let are_both = |(a, b): (Option<Arm>, Option<Arm>)| match (a, b) {
        (Some(a), Some(b)) => a == BEFORE_CHEST && is_out(b) || is_out(a) && b == BEFORE_CHEST,
        _ => false,
    };
    let flares = sides.map(are_both);
    for (arm, flares) in [&mut posture.left_arm, &mut posture.right_arm].into_iter().zip(flares) {
        if flares {
            *arm = Some(FLARED);
        }
    }
    let is_flared = flares.contains(&true);
    if is_flared {
        posture.touches = next.touches.or(posture.touches);
    }
    is_flared
}

/// Returns whether both arms were moved before.
fn both_moved(before: &Posture) -> bool {
    before.left_arm.is_some() && before.right_arm.is_some()
}

/// An arm, what its hand touches, and whether no verb's phrase says as much.
type Placed = (Arm, Option<Touch>, bool);

/// Reads where an arm goes, and what its hand touches.
fn arm(piece: &Words<'_>, context: &Context, side: Side) -> Option<Placed> {
    // "Turn the forearms outward", "forearms to the sides" of upper arms that hang.
    let hangs = [context.before.left_arm, context.before.right_arm].into_iter().flatten().all(|a| a.elevation() < 45.0);
    let to_sides = piece.has(&["outward", "inward"]) || hangs && piece.has(&["side", "sides", "sideways"]);
    if piece.has(&FOREARMS) && to_sides && !piece.has(&["at", "by", "against"]) {
        let turn = if piece.has(&["inward"]) { 50.0 } else { -55.0 };
        return Some((place(0.0, 8.0, turn, 90.0), None, true));
    }
    // How a hand is turned is no posture here.
    if piece.has(&["turn", "twist", "rotate"]) {
        return None;
    }
    at_a_place(piece, context, side).or_else(|| in_a_direction(piece, context, side))
}

fn place(raise: f64, aside: f64, turn: f64, elbow: f64) -> Arm {
    Arm { raise, aside, turn, elbow }
}

/// Reads an arm whose hand is at a part of the body.
fn at_a_place(piece: &Words<'_>, context: &Context, side: Side) -> Option<Placed> {
    let on = piece.has(&["on", "to", "against", "touch", "by", "at", "beside"]);
    let is_upon = piece.has(&["on", "to", "against", "touch"]);
    let both = side == Side::Both;
    if let Some(face) = at_the_face(piece).filter(|_| !piece.has(&["together"])) {
        return Some(face);
    }
    // "Forearms up, hands near the chin": as they are.
    let is_near = piece.has(&["near", "by", "beside", "at", "under"]) && piece.has(&["chin", "face", "cheeks"]);
    let held =
        context.before.left_arm.filter(|arm| arm.elbow > 60.0 && context.before.left_arm == context.before.right_arm);
    if let Some(arm) = held.filter(|_| both && is_near && !piece.has(&["height", "level"])) {
        return Some((arm, None, true));
    }
    // "The right knee up, the left hand touching it".
    let lifted = |foot: Option<Foot>| foot.is_some_and(|foot| foot.height > 0.0);
    let knee = [(Side::Left, context.before.left_foot), (Side::Right, context.before.right_foot)];
    let knee = knee.into_iter().find(|(_, foot)| lifted(*foot)).filter(|_| is_upon && piece.has(&["it"]) && !both);
    if let Some((knee, _)) = knee.filter(|_| piece.has(&["hand", "fist", "palm"])) {
        let touch = if knee == side { Touch::Knee } else { Touch::OtherKnee };
        return Some((place(50.0, if knee == side { 0.0 } else { -20.0 }, 10.0, 35.0), Some(touch), true));
    }
    // "The arms make a circle in front of the chest".
    if piece.has(&["circle", "ring"]) {
        let is_ring = both && piece.has(&["make", "form"]) && piece.has(&["front"]);
        return is_ring.then_some((place(68.0, 12.0, 48.0, 62.0), None, true));
    }
    // "Left hand holding the right elbow".
    let is_behind = piece.has(&["behind", "back"]);
    let grips =
        !is_behind && piece.has(&["hold", "grip", "grab", "touch", "on"]) && piece.has(&["elbow", "forearm", "wrist"]);
    if grips && !both && piece.has(&["hand", "fist"]) {
        return Some((place(24.0, -16.0, 55.0, 84.0), Some(Touch::Forearm), true));
    }
    // "Hands folded in front of your belly" is no crossing of arms.
    let folds = piece.has(&["fold", "folded", "clasp", "interlock", "together"]) && piece.has(&["hands", "palms"]);
    if folds && both && piece.has(&["belly", "stomach", "waist", "hips", "lap", "body"]) {
        return Some((place(22.0, -10.0, 42.0, 62.0), Some(Touch::Hands), true));
    }
    let is_level = piece.has(&["height", "level", "high"]) && piece.said.level.is_some();
    let crosses = piece.has(&["cross", "crossed", "fold", "folded"]) && !piece.has_row(&["the", "cross"]);
    // "Hands on opposite shoulders".
    if both && piece.has(&["opposite"]) && piece.has(&["shoulder", "shoulders"]) {
        return Some((place(62.0, -24.0, 40.0, 95.0), Some(Touch::Shoulder), false));
    }
    if crosses && !piece.has(&["shoulder", "back", "behind"]) && both {
        return Some((CROSSED[0], None, false));
    }
    if on && piece.has(&["hip", "hips", "waist"]) && !is_level {
        return Some((place(-22.0, 46.0, 52.0, 108.0), Some(Touch::Hip), false));
    }
    if is_upon && piece.has(&["head"]) && !is_level && !piece.has(&["above", "over", "behind"]) {
        return Some((place(180.0, 3.0, 101.0, 57.0), Some(Touch::Crown), false));
    }
    let is_neck = piece.has(&["neck", "nape"]) && (on || piece.has(&["behind"]));
    if is_neck || piece.has(&["behind", "back"]) && piece.has(&["head"]) && !piece.has(&["bring", "tilt"]) {
        return Some((place(160.0, 40.0, 60.0, 104.0), Some(Touch::Nape), false));
    }
    if on && piece.has(&["knee", "knees", "thigh", "thighs"]) && !piece.has(&ELBOWS) {
        let is_of_other = piece.said.sides[1].is_some_and(|knee| knee != side) || piece.has(&["opposite"]);
        return Some(match is_of_other && !both {
            true => (place(60.0, -24.0, 10.0, 12.0), Some(Touch::OtherKnee), true),
            false => (place(62.0, 4.0, 0.0, 15.0), Some(Touch::Knee), !both),
        });
    }
    if piece.has(&["ear", "ears"]) && !piece.has(&["above", "straight"]) && (both || !piece.has(&["over"])) {
        return Some((place(95.0, 40.0, 30.0, 135.0), Some(Touch::Ear), true));
    }
    // "At shoulder level so the hand is by the shoulder".
    let twice = piece.words.iter().filter(|word| word.starts_with("shoulder")).count() > 1;
    let is_low =
        piece.has_row(&["lower", "back"]) || on && piece.has(&["back"]) && !piece.has(&["bring", "put", "pull"]);
    if is_low && !piece.has(&["head"]) {
        return Some((place(-60.0, 6.0, 49.0, 81.0), Some(Touch::Back), false));
    }
    if piece.has_row(&["behind", "your", "back"]) || piece.has_row(&["behind", "the", "back"]) {
        return Some((place(-60.0, 6.0, 49.0, 81.0), Some(Touch::Back), false));
    }
    let is_across = piece.has(&["across"]) && piece.has(&["belly", "stomach", "tummy", "body", "waist"]);
    if is_across || on && piece.has(&["belly", "stomach", "tummy"]) {
        return Some((place(14.0, -14.0, 62.0, 88.0), Some(Touch::Belly), true));
    }
    if (on || piece.has(&["across"])) && piece.has(&["chest"]) && !is_level && !piece.has(&["front"]) {
        return Some((place(42.0, -20.0, 65.0, 86.0), Some(Touch::Chest), false));
    }
    if on && piece.has(&["shoulder", "shoulders"]) && (!is_level || twice) || crosses && !both {
        let is_far = piece.has(&["other", "far", "opposite"]);
        let crosses = crosses || is_far || piece.said.sides[2].is_some_and(|other| other != side);
        return match crosses && !both {
            true => Some((place(62.0, -24.0, 40.0, 95.0), Some(Touch::Shoulder), false)),
            false => Some((place(20.0, 62.0, -20.0, 129.0), Some(Touch::OwnShoulder), !both)),
        };
    }
    if piece.has(&["chest"]) && piece.has(&["bend", "bent"]) && piece.has(&["front"]) {
        return Some((place(50.0, -10.0, 40.0, 90.0), None, true));
    }
    // "The right arm, the left arm, then both together".
    let lowers = piece.has(&["lower", "drop", "down"]);
    if piece.has(&["together"])
        && both
        && !lowers
        && !piece.names_limb()
        && !piece.has(&["them", "over", "overhead", "above"])
    {
        return Some((place(UP, 8.0, 0.0, 6.0), None, false));
    }
    // "Hands in front of the chest": with elbows that point down, or out.
    let is_before_chest = ["chest", "heart"]
        .into_iter()
        .any(|part| piece.has_row(&["of", "your", part]) || piece.has_row(&["of", "the", part]));
    if is_before_chest && piece.has(&ELBOWS) && piece.has(&["touching", "together"]) {
        return Some((place(80.0, -12.0, 0.0, 95.0), None, true));
    }
    if is_before_chest {
        let touch = (both && piece.has(&["together"])).then_some(Touch::Hands);
        return Some((BEFORE_CHEST, touch, true));
    }
    if piece.has(&["together"]) && both && !lowers {
        let is_up = context.before.left_arm.is_some_and(|arm| arm.elevation() > 120.0);
        return match is_up || piece.has(&["overhead", "above", "over", "up"]) {
            true => Some((place(168.0, -6.0, 10.0, 20.0), Some(Touch::Hands), true)),
            false => Some((place(52.0, -8.0, 32.0, 60.0), Some(Touch::Hands), true)),
        };
    }
    None
}

/// Reads an arm whose hand is at the face.
fn at_the_face(piece: &Words<'_>) -> Option<Placed> {
    let is_there = piece.has(&["on", "to", "against", "touch", "front", "over", "at", "cover"])
        && !piece.has(&["height", "level"]);
    let touch = match () {
        () if piece.has(&["mouth", "lips"]) => Touch::Mouth,
        () if piece.has(&["nose"]) => Touch::Nose,
        () if piece.has(&["forehead"]) => Touch::Brow,
        () if piece.has(&["eyes", "face"]) => Touch::Eyes,
        () if piece.has(&["heart"]) => Touch::Heart,
        () => return None,
    };
    let arm = match touch {
        Touch::Heart => place(42.0, -20.0, 65.0, 86.0),
        Touch::Brow => place(110.0, -10.0, 45.0, 95.0),
        _ => place(84.0, -19.0, 33.0, 96.0),
    };
    is_there.then_some((arm, Some(touch), !piece.has(&["cover"])))
}

/// Returns whether upper arms are to stay at the body.
fn at_the_body(piece: &Words<'_>) -> bool {
    if piece.has(&ELBOWS) && piece.words.last().is_some_and(|word| word == "in") {
        return true;
    }
    let is_at = piece.has(&["at", "by", "against", "close", "tight", "near", "to"]);
    is_at && piece.has(&["sides", "ribs", "body", "waist"]) && !piece.has(&["out", "away", "across"])
}

const ARTICLES: [&str; 5] = ["your", "the", "its", "ur", "their"];

/// Reads an arm that points somewhere, or the bend of its elbow.
fn in_a_direction(piece: &Words<'_>, context: &Context, side: Side) -> Option<Placed> {
    let before = if side == Side::Left { context.before.left_arm } else { context.before.right_arm };
    // "Upper arms stay at your sides": the forearms stay as they are.
    // "Elbows at your sides", too.
    if piece.has(&["upper", "upperarms"]) && at_the_body(piece) || piece.has(&ELBOWS) && at_the_body(piece) {
        let elbow = before.map_or(Arm::HANGING.elbow, |before| before.elbow);
        return Some((Arm { elbow, ..Arm::HANGING }, None, true));
    }
    // "Upper arms out to the sides": the forearms stay as they are.
    if let Some(before) = before.filter(|before| piece.has(&["upper"]) && before.elbow > 60.0) {
        let turn = if before.raise > 60.0 { -88.0 } else { before.turn };
        return Some((place(0.0, 88.0, turn, before.elbow.min(90.0)), None, true));
    }
    let is_elbow = piece.has(&ELBOWS) || piece.has(&FOREARMS);
    let degrees = piece.degrees();
    let lifted = (!is_elbow).then_some(degrees).flatten().or(piece.said.level.map(f64::from));
    let (ahead, aside) = (
        piece.has(&["forward", "forwards", "front", "ahead"]),
        piece.has(&["side", "sides", "sideways", "wide", "apart", "outward"]),
    );
    let aside = aside || piece.has(&["spread", "open"]) || piece.has(&["out"]) && !ahead;
    let behind = piece.has(&["behind", "backward", "backwards"]) || piece.has(&["back"]) && !piece.has(&["bring"]);
    let is_diagonal = piece.has(&["diagonally", "diagonal"]);
    let to_floor = piece.has(&["floor", "ground"]);
    let up =
        piece.has(&["up", "overhead", "above", "over", "sky", "ceiling", "air", "upward", "vertical", "vertically"])
            || piece.has(&["high"]) && lifted.is_none();
    let is_lifted = piece.has(&["raise", "lift"]) || context.last_verb == "raise" || context.last_verb == "lift";
    let down = piece.has(&["down", "lower", "drop", "hang", "rest", "dangle", "sink", "fall"])
        || to_floor && !ahead
        || ["at", "by"].into_iter().any(|at| {
            let sides = ["side", "sides"];
            let is_row =
                |side| piece.has_row(&[at, side]) || ARTICLES.into_iter().any(|the| piece.has_row(&[at, the, side]));
            sides.into_iter().any(is_row)
        });
    // "Elbow bent, hand pointing up": the forearm does.
    let is_forearm = piece.has(&["point"]) && before.is_some_and(|arm| arm.elbow > 60.0 && arm.elevation() < 45.0);
    // "Elbows bent, hands pointing forward": as they do.
    if let Some(before) = before.filter(|_| is_forearm && ahead && !up) {
        return Some((before, None, true));
    }
    if is_elbow || up && is_forearm && context.before.touches.is_none() {
        return forearm(piece, before.unwrap_or(Arm::HANGING), up, aside, ahead);
    }
    if is_diagonal && down && !up {
        return Some((place(0.0, 45.0, 0.0, 6.0), None, false));
    }
    if to_floor && ahead && !up {
        return Some((place(45.0, 3.0, 0.0, 6.0), None, false));
    }
    // "The left arm to the left": to its own side, or across the body.
    if let Some(own) = to_a_side(piece).filter(|_| !(ahead || aside || behind || up || down)) {
        let arm = if own == side { place(0.0, 93.0, 0.0, 6.0) } else { place(84.0, -24.0, 30.0, 15.0) };
        return (side != Side::Both).then_some((arm, None, false));
    }
    if down && !up && lifted.is_none() {
        return Some((Arm::HANGING, None, false));
    }
    let bent = if piece.has(&["bent"]) { 90.0 } else { 6.0 };
    // "At shoulder height", "lower them to 45 degrees": the same way, another angle.
    let is_height = lifted.is_some() || piece.has(&["horizontal", "horizontally", "parallel"]);
    // "Elbows bent, parallel to the floor": the forearms are.
    let is_level = |arm: &Arm| lifted.is_none() && arm.elbow > 60.0 && arm.elevation() < 45.0;
    if let Some(before) = before.filter(|arm| is_height && !piece.names_limb() && is_level(arm)) {
        return Some((before, None, true));
    }
    if let Some(before) = before.filter(|_| is_height && !(ahead || aside || behind || up)) {
        let angle = lifted.unwrap_or(LEVEL);
        let arm = if before.aside > 45.0 { Arm { aside: angle, ..before } } else { Arm { raise: angle, ..before } };
        return Some((arm, None, false));
    }
    let found = match (ahead, aside, behind, up) {
        // "Away from the body": a little.
        _ if piece.has(&["away"]) && piece.has(&["body", "sides", "side", "trunk"]) => place(0.0, 35.0, 0.0, 6.0),
        // "Arms bent up in front": like a boxer's.
        (true, _, _, true) if piece.has(&["bent", "bend"]) => place(35.0, 4.0, 10.0, 115.0),
        (_, _, _, true) if piece.has(&["diagonally", "diagonal"]) => place(0.0, 135.0, 0.0, bent),
        (_, true, _, true) => place(0.0, lifted.unwrap_or(135.0), 0.0, bent),
        (true, ..) => place(lifted.unwrap_or(LEVEL), 3.0, 0.0, bent),
        (_, true, ..) => place(0.0, lifted.unwrap_or(LEVEL + 3.0), 0.0, bent),
        (_, _, true, false) => place(-40.0, 8.0, 0.0, bent),
        (.., true) => place(lifted.unwrap_or(UP), 8.0, 0.0, bent),
        _ if piece.has(&["horizontal", "horizontally", "parallel", "level"]) || lifted.is_some() => {
            place(lifted.unwrap_or(LEVEL), 3.0, 0.0, bent)
        }
        _ if is_lifted => place(UP, 8.0, 0.0, bent),
        // "Arms bent": where they are.
        _ if piece.has(&["bend", "bent"]) => Arm { elbow: 90.0, ..before.unwrap_or(Arm::HANGING) },
        _ => return None,
    };
    Some((found, None, piece.has(&["bent"]) || is_diagonal && up))
}

/// Returns the side of "to the left".
fn to_a_side(piece: &Words<'_>) -> Option<Side> {
    match () {
        () if piece.has_row(&["to", "the", "left"]) => Some(Side::Left),
        () if piece.has_row(&["to", "the", "right"]) => Some(Side::Right),
        () => None,
    }
}

/// Reads an elbow or a forearm of an arm.
fn forearm(piece: &Words<'_>, before: Arm, up: bool, aside: bool, ahead: bool) -> Option<Placed> {
    let is_bent = piece.has(&["bend", "bent"]) || piece.degrees().is_some();
    let is_straight = piece.has(&["straight", "straighten"]) && !is_bent && !piece.has(&FOREARMS);
    let elbow = match (piece.degrees(), is_straight) {
        (Some(degrees), _) => degrees.min(140.0),
        (None, true) => 6.0,
        (None, false) if piece.said.size == Some(Size::Small) => 35.0,
        (None, false) => 90.0,
    };
    let is_out = before.aside > 45.0 || aside;
    let arm = match () {
        // Forearms up: of arms to the sides, else of arms that are level ahead.
        // "Elbows at shoulder height, forearms hanging".
        () if piece.has(&FOREARMS) && piece.has(&["down", "hang"]) && before.elevation() > 45.0 => {
            Arm { raise: 0.0, aside: 88.0, turn: 70.0, elbow: 90.0 }
        }
        () if piece.has(&ELBOWS) && piece.said.level == Some(90) && !ahead => {
            Arm { raise: 0.0, aside: 88.0, turn: before.turn, elbow: before.elbow }
        }
        // "Hands at chin height, elbows bent": like a boxer's.
        () if is_bent && !up && before.raise > 95.0 && before.raise < 125.0 => place(48.0, 6.0, 12.0, 122.0),
        () if up && is_out => Arm { raise: 0.0, aside: 88.0, turn: -88.0, elbow },
        // "Bend your elbows so that your forearms point up": the upper arms hang.
        () if up && is_bent && before.raise < 45.0 => Arm { raise: 12.0, aside: 10.0, turn: 0.0, elbow: 140.0 },
        () if up && before.raise > 60.0 && before.elbow > 60.0 => before,
        () if up => Arm { raise: 84.0, aside: 10.0, turn: 0.0, elbow: elbow.max(85.0) },
        () if aside && !ahead => Arm { raise: 0.0, aside: 88.0, turn: before.turn, elbow },
        () if piece.has(&["back", "behind", "backward", "backwards"]) => {
            Arm { raise: -35.0, aside: 12.0, turn: 0.0, elbow }
        }
        () if is_bent || is_straight || ahead => Arm { elbow, ..before },
        () => return None,
    };
    Some((arm, None, true))
}
