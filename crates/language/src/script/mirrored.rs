//! "The same on the other side": what was done, as in a mirror.

use super::split::normal;
use super::{Clause, Script};
use crate::facts::{Action, Direction, Side};
use crate::posture::{Arm, Foot, Posture, Turn};

/// Words of which a request for the mirror image consists.
const WORDS: [&str; 46] = [
    "do",
    "doing",
    "it",
    "the",
    "same",
    "thing",
    "now",
    "again",
    "on",
    "with",
    "to",
    "for",
    "repeat",
    "copy",
    "other",
    "side",
    "arm",
    "leg",
    "hand",
    "foot",
    "knee",
    "one",
    "way",
    "round",
    "around",
    "swap",
    "swaps",
    "switch",
    "switches",
    "change",
    "sides",
    "arms",
    "legs",
    "hands",
    "feet",
    "them",
    "over",
    "vice",
    "versa",
    "too",
    "as",
    "well",
    "mirror",
    "mirrored",
    "that",
    "everything",
];
/// Most clauses that are done again as a whole.
const MOST: usize = 4;

/// Returns the words before a request for the mirror image, and those after it.
pub(super) fn divided(text: &str) -> Option<(String, String)> {
    let words = normal(text);
    let joins = |word: &String| [",", "|", "and", "then"].contains(&word.as_str());
    let mut begin = 0;
    while begin < words.len() {
        let end = words[begin..].iter().position(joins).map_or(words.len(), |at| begin + at);
        if begin > 0 && is_request(&words[begin..end]) {
            let text = |words: &[String]| {
                let words: Vec<&str> = words.iter().map(|word| if word == "|" { "." } else { word.as_str() }).collect();
                words.join(" ")
            };
            let kept = begin - words[..begin].iter().rev().take_while(|word| joins(word)).count();
            let rest = words[end..].iter().take_while(|word| joins(word)).count();
            return (kept > 0).then(|| (text(&words[..kept]), text(&words[end + rest..])));
        }
        begin = end + 1;
    }
    None
}

fn is_request(words: &[String]) -> bool {
    let has = |all: &[&str]| words.iter().any(|word| all.contains(&word.as_str()));
    let swaps = has(&["swap", "swaps", "switch", "switches", "mirror", "mirrored", "versa"])
        || has(&["change"]) && has(&["sides", "arms", "legs", "hands", "feet"]);
    let again = has(&["other"]) && has(&["same", "repeat", "copy", "it", "that"]);
    let other = has(&["other"]) && (has(&["side"]) || has(&["way"]) && has(&["round", "around"]));
    (swaps || again || other) && words.iter().all(|word| WORDS.contains(&word.as_str()))
}

/// Appends what was done as in a mirror: all of a short script, else the last of it.
pub(super) fn add_mirror_image(script: &mut Script) {
    let from = if script.clauses.len() > MOST { script.clauses.len() - 1 } else { 0 };
    let images: Vec<Clause> = script.clauses[from..].iter().map(image).collect();
    match (script.clauses.last_mut(), images.as_slice()) {
        // Postures go over into each other.
        (Some(last), [only]) if last.is_only_postures() && only.is_only_postures() => {
            let mut postures = only.postures.clone();
            if let Some(first) = postures.first_mut() {
                put_down(first, &last.postures, &only.postures);
            }
            last.postures.extend(postures);
        }
        _ => script.clauses.extend(images),
    }
}

/// Puts down what was moved before and is not by the mirror image.
fn put_down(first: &mut Posture, before: &[Posture], image: &[Posture]) {
    let sum = |all: &[Posture]| {
        let mut sum = Posture::default();
        all.iter().for_each(|posture| sum.extend(posture));
        sum
    };
    let (before, image) = (sum(before), sum(image));
    let down = |before: Option<Arm>, image: Option<Arm>| before.filter(|_| image.is_none()).map(|_| Arm::HANGING);
    let stand = |before: Option<Foot>, image: Option<Foot>| before.filter(|_| image.is_none()).map(|_| Foot::STANDING);
    first.left_arm = first.left_arm.or(down(before.left_arm, image.left_arm));
    first.right_arm = first.right_arm.or(down(before.right_arm, image.right_arm));
    first.left_foot = first.left_foot.or(stand(before.left_foot, image.left_foot));
    first.right_foot = first.right_foot.or(stand(before.right_foot, image.right_foot));
}

fn image(clause: &Clause) -> Clause {
    let actions = clause.actions.iter().map(|action| Action {
        side: action.side.map(Side::mirrored),
        direction: action.direction.map(|way| match way {
            Direction::Left => Direction::Right,
            Direction::Right => Direction::Left,
            other => other,
        }),
        ..action.clone()
    });
    let postures = clause.postures.iter().map(|posture| Posture {
        left_arm: posture.right_arm,
        right_arm: posture.left_arm,
        left_foot: posture.right_foot.map(foot),
        right_foot: posture.left_foot.map(foot),
        head: posture.head.map(turn),
        trunk: posture.trunk.map(turn),
        ..posture.clone()
    });
    Clause { actions: actions.collect(), postures: postures.collect(), ..clause.clone() }
}

fn foot(foot: Foot) -> Foot {
    Foot { to: [foot.to[0], -foot.to[1]], ..foot }
}

fn turn(turn: Turn) -> Turn {
    Turn { roll: -turn.roll, yaw: -turn.yaw, ..turn }
}
