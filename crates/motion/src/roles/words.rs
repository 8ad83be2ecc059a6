//! Words in joints' names, as the writers of motion files use them.

/// Words that name a part, best first. `arm` and `leg` come after the words that contain them.
pub(super) const THIGH: &[&str] = &["femur", "thigh", "upperleg", "upleg", "uleg", "hip"];
pub(super) const SHANK: &[&str] = &["tibia", "shin", "shank", "calf", "lowerleg", "lowleg", "lleg", "knee", "leg"];
pub(super) const FOOT: &[&str] = &["ankle", "foot"];
pub(super) const TOE: &[&str] = &["toebase", "toes", "toe", "ball"];
pub(super) const UPPER_ARM: &[&str] = &["humerus", "upperarm", "uparm", "uarm", "shldr", "arm", "shoulder"];
pub(super) const FOREARM: &[&str] = &["radius", "forearm", "lowerarm", "lowarm", "farm", "larm", "elbow"];
pub(super) const HAND: &[&str] = &["wrist", "hand"];
pub(super) const HEAD: &[&str] = &["head", "neck", "upperneck", "lowerneck"];
/// Sided words that no role has; a side's letter may be glued to them.
const OTHERS: &[&str] = &["collar", "clavicle", "hipjoint", "buttock"];
/// Words beside a part's that make something else of it: helper bones, controls, ends.
const HELPERS: &[&str] = &[
    "roll", "twist", "helper", "end", "nub", "tip", "site", "ik", "fk", "pole", "target", "ctrl", "control", "volume",
    "share", "stretch", "tweak",
];

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Side {
    Left,
    Right,
    Middle,
}

/// A name as words in lower case, without its side and numbers.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Name {
    pub side: Side,
    words: Vec<String>,
}

impl Name {
    /// Reads a name: `mixamorig:LeftUpLeg` → left, `up leg`; `Bip01 L Thigh`, `thigh.L`, `lThigh`, `LUArm` alike.
    pub fn read(name: &str) -> Self {
        let bare = name.rsplit([':', '|']).next().unwrap_or(name);
        let mut words = split(bare);
        let side = side_of(&mut words);
        Self { side, words }
    }

    /// Returns whether no word of the name is known: neither a part's nor a helper's.
    pub fn says_nothing(&self) -> bool {
        let parts = [THIGH, SHANK, FOOT, TOE, UPPER_ARM, FOREARM, HAND, HEAD, OTHERS];
        let is_known =
            |word: &String| HELPERS.contains(&word.as_str()) || parts.iter().any(|p| p.contains(&word.as_str()));
        !self.words.iter().any(is_known) && parts.iter().all(|part| part.iter().all(|word| self.misfit(word).is_none()))
    }

    /// Returns how badly the name fits a part's word: 0 for the word itself, more for what stands before and after it;
    /// `None` for another part, or a helper of this one.
    fn misfit(&self, part: &str) -> Option<usize> {
        let n = self.words.len();
        (0..n).flat_map(|from| (from + 1..=n).map(move |to| (from, to))).find_map(|(from, to)| {
            if self.words[from..to].concat() != part {
                return None;
            }
            let is_helper = |words: &[String]| words.iter().any(|word| HELPERS.contains(&word.as_str()));
            let after = &self.words[to..];
            let is_socket = after.first().is_some_and(|word| word == "joint");
            let fits = !is_socket && !is_helper(&self.words[..from]) && !is_helper(after);
            fits.then_some(from + 8 * after.len())
        })
    }
}

/// Returns the joints of a side whose names fit one of the words, best first.
pub(super) fn ranked(names: &[Name], side: Side, words: &[&str]) -> Vec<usize> {
    let mut found: Vec<(usize, usize, usize)> = Vec::new();
    for (joint, name) in names.iter().enumerate().filter(|(_, name)| name.side == side) {
        let fit = words.iter().enumerate().find_map(|(rank, word)| Some((rank, name.misfit(word)?)));
        found.extend(fit.map(|(rank, misfit)| (rank, misfit, joint)));
    }
    found.sort_unstable();
    found.into_iter().map(|(.., joint)| joint).collect()
}

/// Splits a name at separators, digits and capitals: `LUArm` → `l u arm`.
fn split(name: &str) -> Vec<String> {
    let mut words: Vec<String> = Vec::new();
    let chars: Vec<char> = name.chars().collect();
    let mut begins = true;
    for (at, &c) in chars.iter().enumerate() {
        if !c.is_alphabetic() {
            begins = true;
            continue;
        }
        let after_small = at > 0 && chars[at - 1].is_lowercase();
        let mut fresh = begins || (c.is_uppercase() && after_small);
        // In a run of capitals each is a word of its own, and the last begins one, if small letters follow anywhere.
        let run = c.is_uppercase() && at > 0 && chars[at - 1].is_uppercase();
        let is_shout = chars.iter().all(|c| !c.is_lowercase());
        if run && !is_shout {
            fresh = true;
        }
        let small = c.to_lowercase().collect::<String>();
        match words.last_mut() {
            Some(word) if !fresh => word.push_str(&small),
            _ => words.push(small),
        }
        begins = false;
    }
    words
}

/// Takes the side out of the words.
fn side_of(words: &mut Vec<String>) -> Side {
    const SIDES: [(&str, &str, Side); 2] = [("left", "l", Side::Left), ("right", "r", Side::Right)];
    for (long, short, side) in SIDES {
        if let Some(at) = words.iter().position(|word| word == long || word == short) {
            words.remove(at);
            return side;
        }
    }
    // leftupleg, lfemur: glued to a known word.
    for at in 0..words.len() {
        for (long, short, side) in SIDES {
            for mark in [long, short] {
                let Some(rest) = words[at].strip_prefix(mark).filter(|rest| is_known(rest)) else { continue };
                words[at] = rest.to_owned();
                return side;
            }
        }
    }
    Side::Middle
}

fn is_known(word: &str) -> bool {
    [THIGH, SHANK, FOOT, TOE, UPPER_ARM, FOREARM, HAND, OTHERS].iter().any(|words| words.contains(&word))
}
