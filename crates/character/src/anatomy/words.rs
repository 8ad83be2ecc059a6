//! Words in names: a side, and a part of the body.

/// Left or right.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Side {
    Left,
    Right,
}

/// Words of a leg's parts, from the hip down; short forms as robots use them.
pub(crate) const LEG: [&str; 13] =
    ["hip", "thigh", "femur", "knee", "shank", "shin", "tibia", "calf", "ankle", "ank_", "foot", "leg", "toe"];
/// Words of an arm's parts, from the shoulder out.
pub(crate) const ARM: [&str; 13] = [
    "shoulder", "sho_", "clavicle", "humerus", "elbow", "elb_", "forearm", "radius", "wrist", "hand", "finger",
    "thumb", "arm",
];
/// Words of the knee's joint or of the body that it moves.
pub(crate) const SHANK: [&str; 8] = ["knee", "shank", "shin", "tibia", "calf", "lower_leg", "lowerleg", "lowleg"];
/// Words of a foot.
pub(crate) const FOOT: [&str; 4] = ["foot", "feet", "ankle", "sole"];
/// Words of the elbow's joint or of the body that it moves.
pub(crate) const FOREARM: [&str; 7] = ["elbow", "elb_", "forearm", "lower_arm", "lowerarm", "radius", "fore_arm"];
/// Words of a hand.
pub(crate) const HAND: [&str; 4] = ["hand", "palm", "gripper", "fist"];

/// Splits a name at capitals and at everything that does not belong to a word; in small letters.
fn split(name: &str, belongs: fn(char) -> bool) -> Vec<String> {
    let mut words = vec![String::new()];
    let mut last_small = false;
    for c in name.chars() {
        if !belongs(c) || (c.is_uppercase() && last_small) {
            words.push(String::new());
        }
        if let (true, Some(word)) = (belongs(c), words.last_mut()) {
            word.extend(c.to_lowercase());
        }
        last_small = c.is_lowercase();
    }
    words.retain(|w| !w.is_empty());
    words
}

/// Returns the words of a name, numbers left out.
fn words(name: &str) -> Vec<String> {
    split(name, char::is_alphabetic)
}

/// Returns whether the name holds one of the words.
pub(crate) fn has(name: &str, wanted: &[&str]) -> bool {
    // An underscore at the end of a wanted word asks for the end of a word.
    let spelled = words(name).join("_") + "_";
    wanted.iter().any(|w| spelled.contains(w))
}

/// Sides as words of their own.
const SIDES: [(&str, Side); 6] = [
    ("left", Side::Left),
    ("l", Side::Left),
    ("lft", Side::Left),
    ("right", Side::Right),
    ("r", Side::Right),
    ("rgt", Side::Right),
];

/// Returns the side that a word of a limb's part begins with, and the part: `lfemur`, `RLEG`.
fn of_part(word: &str) -> Option<(Side, &str)> {
    let is_part = |rest: &str| LEG.iter().chain(&ARM).any(|part| rest.starts_with(part.trim_end_matches('_')));
    let whole = SIDES.iter().filter(|(side, _)| !matches!(*side, "lft" | "rgt"));
    whole.filter_map(|(name, side)| Some((*side, word.strip_prefix(name)?))).find(|(_, rest)| is_part(rest))
}

/// Returns the side a name tells: `left_knee`, `l_knee`, `knee_L`, `LeftKnee`, `lfemur`. In `LLEG_HIP_R` the R is for roll.
pub(crate) fn side(name: &str) -> Option<Side> {
    let words = words(name);
    let first = words.first().and_then(|word| of_part(word)).map(|(side, _)| side);
    first.or_else(|| words.iter().find_map(|word| SIDES.iter().find(|(side, _)| side == word)).map(|(_, side)| *side))
}

/// Returns the name with its side taken out, so that both sides' names become one.
pub(crate) fn without_side(name: &str) -> String {
    let mut words = split(name, char::is_alphanumeric);
    if let Some(part) = words.first().and_then(|word| of_part(word)).map(|(_, part)| part.to_string()) {
        words[0] = part;
    } else {
        words.retain(|word| SIDES.iter().all(|(side, _)| side != word));
    }
    words.join("_")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sides_are_told_in_many_ways() {
        for name in
            ["left_knee", "l_knee", "knee_L", "LeftKnee", "lfemurrx", "leftHand", "L-foot", "leftfoot", "LLEG_HIP_R"]
        {
            assert_eq!(side(name), Some(Side::Left), "{name}");
        }
        for name in ["right_knee", "R_Foot", "rtibia", "knee_joint_r", "RightHand", "RARM_ELBOW_L"] {
            assert_eq!(side(name), Some(Side::Right), "{name}");
        }
        for name in ["lower_waist", "root", "head", "lowerback", "radius", "leg_spacer", "roll_link", "torso"] {
            assert_eq!(side(name), None, "{name}");
        }
    }

    #[test]
    fn names_without_their_side_agree() {
        for (left, right) in [
            ("left_knee", "right_knee"),
            ("lfemurrx", "rfemurrx"),
            ("KneeL", "KneeR"),
            ("LArm", "RArm"),
            ("LLEG_HIP_R", "RLEG_HIP_R"),
        ] {
            assert_eq!(without_side(left), without_side(right), "{left}");
        }
        assert_eq!(without_side("left_foot_2"), "foot_2");
    }

    #[test]
    fn short_words_need_an_end() {
        assert!(has("left_ank_pitch", &LEG) && has("leftAnk", &LEG));
        assert!(has("left_shank", &SHANK));
        assert!(!has("torso", &LEG) && !has("torso", &ARM));
    }
}
