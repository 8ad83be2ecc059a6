//! Roundabout words about where limbs are: shapes, heights, angles to the horizontal, and details that ask for nothing.

use super::joints::by_joints;
use super::said::number;

/// Words that join.
const JOINS: [&str; 6] = [",", "|", "and", "then", "while", "but"];
/// Limbs that "the left one" may mean.
const LIMBS: [&str; 8] = ["arm", "hand", "leg", "foot", "knee", "elbow", "fist", "heel"];
const ARMS: [&str; 4] = ["arm", "arms", "hand", "hands"];
const FLOORS: [&str; 2] = ["floor", "ground"];
pub(super) const ARTICLES: [&str; 9] = ["the", "your", "ur", "his", "her", "its", "my", "both", "a"];
/// Parts of hands and feet that robots do not turn or close.
const DETAILS: [&str; 9] = ["palm", "palms", "fist", "fists", "finger", "fingers", "thumb", "thumbs", "toes"];
/// Words that say how such parts are.
const TURNED: [&str; 47] = [
    "facing",
    "face",
    "turned",
    "pointing",
    "pointed",
    "up",
    "down",
    "upward",
    "upwards",
    "downward",
    "downwards",
    "forward",
    "forwards",
    "in",
    "inward",
    "inwards",
    "out",
    "outward",
    "outwards",
    "each",
    "other",
    "closed",
    "open",
    "clenched",
    "spread",
    "relaxed",
    "straight",
    "toward",
    "towards",
    "the",
    "floor",
    "ground",
    "ceiling",
    "sky",
    "slightly",
    "touching",
    "body",
    "away",
    "from",
    "you",
    "your",
    "me",
    "front",
    "back",
    "tight",
    "to",
    "on",
];
/// Words of "back to the starting position", and those that end it.
const STARTS: [&str; 9] = ["the", "your", "starting", "start", "first", "normal", "initial", "original", "neutral"];
const RESTS: [&str; 13] = [
    "position",
    "stance",
    "pose",
    "posture",
    "start",
    "normal",
    "standing",
    "center",
    "centre",
    "middle",
    "neutral",
    "zero",
    "attention",
];

/// Returns words in which limbs are described plainly.
pub(super) fn plain_geometry(words: Vec<String>) -> Vec<String> {
    let words = without_sling(about_the_shoulder(standing_on_the_other(by_joints(words))));
    let words = at_heights(by_the_horizontal(level_with_the_floor(words)));
    let words = as_letters(named_lower_limbs(at_the_pockets(named_sides(named_ones(words)))));
    let words = without_details(hands_below_elbows(with_fingers(without_ears(beside_the_other_foot(words)))));
    at_rest(hanging_beside(bent_to(looking_ahead(without_straight_joints(words)))))
}

pub(super) fn has(all: &[&str], word: Option<&String>) -> bool {
    word.is_some_and(|word| all.contains(&word.as_str()))
}

/// Returns where the piece of a word begins, and where it ends.
fn piece_of(words: &[String], at: usize) -> [usize; 2] {
    let joins = |word: &String| JOINS.contains(&word.as_str()) || word == "with";
    let begin = words[..at].iter().rposition(joins).map_or(0, |join| join + 1);
    let end = words[at..].iter().position(joins).map_or(words.len(), |join| at + join);
    [begin, end]
}

/// "Swap to the right foot": standing on it.
fn standing_on_the_other(mut words: Vec<String>) -> Vec<String> {
    let swaps = |words: &[String], at: usize| {
        let goes = has(&["swap", "switch", "change", "swaps", "switches", "changes"], words.get(at));
        let article = usize::from(has(&ARTICLES, words.get(at + 2)));
        let is_side = has(&["left", "right"], words.get(at + 2 + article));
        let is_foot = has(&["foot", "leg"], words.get(at + 3 + article));
        goes && has(&["to", "onto"], words.get(at + 1)) && is_side && is_foot
    };
    while let Some(at) = (0..words.len()).find(|at| swaps(&words, *at)) {
        words.splice(at..at + 2, ["stand", "on"].map(String::from));
    }
    words
}

/// "A touch above shoulder height", "below the shoulders": some ten degrees more or less than level.
fn about_the_shoulder(mut words: Vec<String>) -> Vec<String> {
    const LITTLE: [&str; 7] = ["slightly", "just", "a", "bit", "touch", "little", "bring"];
    let place = |words: &[String]| {
        (1..words.len()).find_map(|at| {
            let angle = match words[at].as_str() {
                "above" => "105",
                "below" => "75",
                _ => return None,
            };
            let [begin, _] = piece_of(words, at);
            let article = usize::from(has(&ARTICLES, words.get(at + 1)));
            let is_shoulder = has(&["shoulder", "shoulders"], words.get(at + 1 + article));
            let is_arm = words[begin..at].iter().any(|word| ARMS.contains(&word.as_str()));
            let height = usize::from(has(&["height", "level"], words.get(at + 2 + article)));
            let little = words[begin..at].iter().rev().take_while(|word| LITTLE.contains(&word.as_str())).count();
            let is_near = little > 0 || height > 0;
            (is_shoulder && is_arm && is_near).then_some((at - little, at + 2 + article + height, angle))
        })
    };
    while let Some((begin, end, angle)) = place(&words) {
        words.splice(begin..end, [angle.to_string(), "degrees".into()]);
    }
    words
}

/// Drops "and slightly behind" of a limb that goes another way.
fn without_sling(mut words: Vec<String>) -> Vec<String> {
    const WAYS: [&str; 6] = ["behind", "back", "forward", "up", "down", "out"];
    let is_slight = |words: &[String], at: usize| {
        let ends = words.get(at + 3).is_none_or(|word| JOINS.contains(&word.as_str()));
        let [begin, _] = piece_of(words, at - 1);
        let names = words[begin..at].iter().any(|word| ARMS.contains(&word.as_str()) || word == "leg");
        words[at] == "and" && has(&["slightly"], words.get(at + 1)) && has(&WAYS, words.get(at + 2)) && ends && names
    };
    if let Some(at) = (1..words.len()).find(|at| is_slight(&words, *at)) {
        words.drain(at..at + 3);
    }
    words
}

/// "Level with the floor", "until it is parallel to the ground": horizontal.
fn level_with_the_floor(mut words: Vec<String>) -> Vec<String> {
    let is_level = |words: &[String], at: usize| {
        has(&["level", "parallel", "even"], words.get(at))
            && has(&["with", "to"], words.get(at + 1))
            && words.get(at + 2).is_some_and(|word| word == "the")
            && has(&FLOORS, words.get(at + 3))
    };
    while let Some(at) = (0..words.len()).find(|at| is_level(&words, *at)) {
        const BEFORE: [&str; 9] = ["until", "till", "so", "that", "it", "its", "is", "they", "are"];
        let before = words[..at].iter().rev().take_while(|word| BEFORE.contains(&word.as_str())).count();
        words.splice(at - before..at + 4, ["horizontal".to_string()]);
    }
    words
}

/// "45 degrees below the horizontal" is that much less than a right angle.
fn by_the_horizontal(mut words: Vec<String>) -> Vec<String> {
    let place = |words: &[String]| {
        (1..words.len()).find_map(|at| {
            let sign = match words.get(at + 1)?.as_str() {
                "below" | "under" => -1.0,
                "above" | "over" => 1.0,
                _ => return None,
            };
            let article = usize::from(words.get(at + 2)? == "the");
            let is_level = has(&["horizontal", "level", "shoulder"], words.get(at + 2 + article));
            let angle = number(&words[at - 1]).filter(|_| words[at] == "degrees" && is_level)?;
            let height = usize::from(has(&["height", "level"], words.get(at + 3 + article)));
            Some((at, at + 3 + article + height, 90.0 + sign * angle))
        })
    };
    while let Some((at, end, angle)) = place(&words) {
        words.splice(at - 1..end, [angle.to_string(), "degrees".into()]);
    }
    words
}

/// "At the height of your chin" is at chin height.
fn at_heights(mut words: Vec<String>) -> Vec<String> {
    let is_height = |words: &[String], at: usize| {
        words[at] == "the"
            && has(&["height", "level"], words.get(at + 1))
            && words.get(at + 2).is_some_and(|word| word == "of")
            && has(&ARTICLES, words.get(at + 3))
    };
    while let Some(at) = (0..words.len().saturating_sub(4)).find(|at| is_height(&words, *at)) {
        let part = words[at + 4].trim_end_matches('s').to_string();
        words.splice(at..at + 5, [part, "height".to_string()]);
    }
    words
}

/// "Arms in a T", "arms like a V": the way that they point.
fn as_letters(mut words: Vec<String>) -> Vec<String> {
    let letter = |word: &String| match word.as_str() {
        "t" => Some("out to the sides"),
        "v" | "y" => Some("diagonally up"),
        _ => None,
    };
    let Some((at, way)) = (1..words.len()).find_map(|at| Some((at, letter(&words[at])?))) else { return words };
    // "Make a T with your body" is one of arms, too.
    if words.get(at + 1).is_some_and(|word| word == "rex") {
        return words;
    }
    let body = words.get(at + 1..at + 4).is_some_and(|after| {
        after[0] == "with" && has(&ARTICLES, Some(&after[1])) && has(&["body", "arms"], Some(&after[2]))
    });
    if body {
        words.splice(at + 1..at + 4, []);
        let makes = words[..at].iter().rposition(|word| word == "make" || word == "form").unwrap_or(at);
        words.insert(makes, "arms".into());
        return as_letters(words);
    }
    if !words[..at].iter().any(|word| ARMS.contains(&word.as_str())) {
        return words;
    }
    const BEFORE: [&str; 20] = [
        "look", "looks", "u", "you", "so", "in", "into", "like", "as", "a", "the", "letter", "form", "forming", "up",
        "make", "makes", "making", "big", "large",
    ];
    let before = words[..at].iter().rev().take_while(|word| BEFORE.contains(&word.as_str())).count();
    let after = usize::from(has(&["shape", "pose", "position", "form"], words.get(at + 1)));
    words.splice(at - before..at + 1 + after, way.split(' ').map(str::to_string));
    words
}

/// "Your lower leg", "upper leg" and "lower arm" as one word each.
fn named_lower_limbs(mut words: Vec<String>) -> Vec<String> {
    const SIDES: [&str; 2] = ["left", "right"];
    const STATES: [&str; 6] = ["hanging", "hangs", "vertical", "vertically", "pointing", "straight"];
    let name = |two: [&str; 2]| match two {
        ["lower", "leg"] => Some("shin"),
        ["lower", "legs"] => Some("shins"),
        ["lower", "arm"] => Some("forearm"),
        ["lower", "arms"] => Some("forearms"),
        ["upper", "leg"] => Some("thigh"),
        ["upper", "legs"] => Some("thighs"),
        _ => None,
    };
    let mut at = 0;
    while at + 1 < words.len() {
        let is_noun = words[at] == "upper"
            || at > 0 && (has(&ARTICLES, words.get(at - 1)) || has(&SIDES, words.get(at - 1)))
            || has(&STATES, words.get(at + 2));
        if let Some(name) = name([words[at].as_str(), words[at + 1].as_str()]).filter(|_| is_noun) {
            words.splice(at..at + 2, [name.to_string()]);
        }
        at += 1;
    }
    words
}

/// "One hand in your pocket" is where a hip is.
fn at_the_pockets(mut words: Vec<String>) -> Vec<String> {
    for at in 2..words.len() {
        let is_in = words[at - 2] == "in" && has(&ARTICLES, words.get(at - 1));
        if is_in && has(&["pocket", "pockets"], words.get(at)) {
            words[at] = if words[at] == "pocket" { "hip".into() } else { "hips".into() };
            words[at - 2] = "on".into();
        }
    }
    words
}

/// "Salute with your right hand and put the left behind your back": the left hand.
fn named_sides(mut words: Vec<String>) -> Vec<String> {
    const AFTER: [&str; 9] = ["behind", "on", "in", "up", "down", "at", "out", "over", "above"];
    let opposite = |side: &str| if side == "left" { "right" } else { "left" };
    let mut at = 2;
    while at < words.len() {
        let is_side = words[at - 1] == "the" && ["left", "right"].contains(&words[at].as_str());
        let is_place = has(&["keep", "keeps", "put", "puts", "place", "hold"], words.get(at - 2));
        let goes = has(&AFTER, words.get(at + 1));
        let limb = words[..at]
            .windows(2)
            .find(|two| is_side && two[0] == opposite(&words[at]) && LIMBS[..4].contains(&two[1].as_str()));
        if let Some(limb) = limb.map(|two| two[1].clone()).filter(|_| is_place && goes) {
            words.insert(at + 1, limb);
        }
        at += 1;
    }
    words
}

/// "Lower the right arm, keep the left one up": the left arm; where no limb was named, the hand.
fn named_ones(mut words: Vec<String>) -> Vec<String> {
    for at in 2..words.len() {
        if words[at] != "one" || !["left", "right"].contains(&words[at - 1].as_str()) {
            continue;
        }
        let limb = words[..at - 1].iter().rev().find(|word| LIMBS.contains(&word.as_str()));
        let is_with =
            has(&["with"], at.checked_sub(3).and_then(|before| words.get(before))) || has(&["with"], words.get(at - 2));
        match limb.cloned() {
            Some(limb) => words[at] = limb,
            None if is_with => words[at] = "hand".into(),
            None => {}
        }
    }
    words
}

/// Drops "by the ear" of an arm that is up, and "from your side" of one that goes up.
fn without_ears(mut words: Vec<String>) -> Vec<String> {
    let is_beside = |words: &[String], at: usize| {
        let [begin, _] = piece_of(words, at);
        let near =
            has(&["by", "beside", "near", "to", "against"], words.get(at - 2)) && has(&ARTICLES, words.get(at - 1));
        let is_arm = words[begin..at].iter().any(|word| word == "arm" || word == "arms");
        near && is_arm && has(&["ear", "ears"], words.get(at))
    };
    if let Some(at) = (2..words.len()).find(|at| is_beside(&words, *at)) {
        let next = usize::from(at > 2 && words[at - 3] == "next");
        words.drain(at - 2 - next..=at);
    }
    let is_begin = |words: &[String], at: usize| {
        let rest = words.get(at + 1..piece_of(words, at)[1]).unwrap_or_default();
        words[at - 2] == "from"
            && has(&ARTICLES, words.get(at - 1))
            && has(&["side", "sides"], words.get(at))
            && rest.iter().any(|word| ["up", "to", "over"].contains(&word.as_str()))
            && !has(&["to"], words.get(at + 1))
    };
    if let Some(at) = (2..words.len()).find(|at| is_begin(&words, *at)) {
        words.drain(at - 2..=at);
    }
    words
}

/// "Elbows at shoulder height, hands hanging": the forearms hang.
fn hands_below_elbows(mut words: Vec<String>) -> Vec<String> {
    for at in 1..words.len() {
        let [begin, end] = piece_of(&words, at);
        let name = match words[at].as_str() {
            "hands" => "forearms",
            "hand" => "forearm",
            _ => continue,
        };
        let opens = words[begin..at].iter().all(|word| ARTICLES.contains(&word.as_str()));
        let says =
            words[at + 1..end].iter().any(|word| ["hanging", "pointing", "hang", "point"].contains(&word.as_str()));
        let [before, _] = piece_of(&words, begin.saturating_sub(1));
        let of_elbows = words[before..begin].iter().any(|word| word == "elbows" || word == "elbow");
        if begin > 0 && opens && says && of_elbows {
            words[at] = name.into();
        }
    }
    words
}

/// "Fingers interlocked" are hands together, and fingers that point are hands.
fn with_fingers(mut words: Vec<String>) -> Vec<String> {
    for at in 1..words.len() {
        if words[at - 1] != "fingers" {
            continue;
        }
        let is_locked = ["interlocked", "interlaced", "laced", "clasped", "locked", "intertwined"];
        if is_locked.contains(&words[at].as_str()) {
            words[at] = "together".into();
        }
        if ["together", "pointing", "point"].contains(&words[at].as_str()) {
            words[at - 1] = "hands".into();
        }
    }
    words
}

/// "The right foot a step ahead of the left" is ahead.
fn beside_the_other_foot(mut words: Vec<String>) -> Vec<String> {
    const FEET: [&str; 2] = ["foot", "leg"];
    const WAYS: [&str; 5] = ["ahead", "forward", "front", "back", "behind"];
    let Some(foot) = (1..words.len()).find(|at| has(&FEET, words.get(*at))) else { return words };
    let [_, end] = piece_of(&words, foot);
    let Some(way) = (foot..end).find(|at| has(&WAYS, words.get(*at))) else { return words };
    let mut rest = way + 1;
    rest += usize::from(has(&["of", "from"], words.get(rest)));
    let article = usize::from(has(&["the", "your"], words.get(rest)));
    let is_other = has(&["left", "right", "other"], words.get(rest + article));
    let noun = usize::from(has(&FEET, words.get(rest + 1 + article)));
    if is_other && rest + article < end {
        words.drain(way + 1..rest + 1 + article + noun);
    }
    let steps = |word: &&String| ["a", "one", "half", "small", "big", "step", "is", "in"].contains(&word.as_str());
    let before = words[foot + 1..way].iter().rev().take_while(steps).count();
    if words[way - before..way].iter().any(|word| word == "step") {
        words.drain(way - before..way);
    }
    words
}

/// Drops how palms, fingers and toes are turned, beside limbs that are described.
fn without_details(mut words: Vec<String>) -> Vec<String> {
    let is_detail = |words: &[String], at: usize| {
        let [begin, end] = piece_of(words, at);
        let opens = words[begin..at].iter().all(|word| ARTICLES.contains(&word.as_str()));
        let tells = words[at + 1..end].iter().all(|word| TURNED.contains(&word.as_str()));
        begin > 0 && at + 1 < end && opens && tells
    };
    while let Some(at) = (1..words.len()).find(|at| has(&DETAILS, words.get(*at)) && is_detail(&words, *at)) {
        let [begin, end] = piece_of(&words, at);
        // "Left leg back, toes on the floor": that foot is on the floor.
        let is_on_floor = words[at] == "toes" && words[at..end].iter().any(|word| FLOORS.contains(&word.as_str()));
        let [before, _] = piece_of(&words, begin - 1);
        if let Some(leg) = (before..begin).find(|leg| is_on_floor && words[*leg] == "leg") {
            words[leg] = "foot".into();
        }
        words.drain(begin - 1..end);
    }
    words
}

/// Drops "with a straight back" and "with straight knees".
fn without_straight_joints(mut words: Vec<String>) -> Vec<String> {
    const JOINTS: [&str; 7] = ["knee", "knees", "leg", "elbow", "elbows", "back", "spine"];
    let length = |words: &[String], at: usize| {
        let article = usize::from(has(&ARTICLES, words.get(at + 1)));
        let first = has(&["straight", "stretched", "locked"], words.get(at + 1 + article));
        (words[at] == "with" && first && has(&JOINTS, words.get(at + 2 + article))).then_some(3 + article)
    };
    while let Some((at, length)) = (1..words.len()).find_map(|at| Some((at, length(&words, at)?))) {
        words.drain(at..at + length);
    }
    words
}

/// Drops "look straight ahead" and "head facing front" beside what else is described.
fn looking_ahead(mut words: Vec<String>) -> Vec<String> {
    const LOOKS: [&str; 7] = ["look", "looks", "looking", "eyes", "gaze", "facing", "keep"];
    const AHEAD: [&str; 8] = ["straight", "ahead", "forward", "front", "to", "the", "head", "your"];
    let Some(at) = (1..words.len()).find(|at| {
        let [begin, end] = piece_of(&words, *at);
        let is_look = LOOKS[..5].contains(&words[*at].as_str())
            || words[*at] == "facing" && words[begin..end].iter().any(|word| word == "head");
        let is_all = words[begin..end].iter().all(|word| has(&LOOKS, Some(word)) || has(&AHEAD, Some(word)));
        begin > 0 && is_look && is_all && *at + 1 < end
    }) else {
        return words;
    };
    let [begin, end] = piece_of(&words, at);
    words.drain(begin - 1..end);
    words
}

/// "Bow from the hips until your back is flat" is a deep bow.
fn bent_to(mut words: Vec<String>) -> Vec<String> {
    const BENDS: [&str; 8] = ["bow", "bend", "lean", "hinge", "bows", "bends", "leans", "fold"];
    let Some(verb) = (0..words.len()).find(|at| has(&BENDS, words.get(*at))) else { return words };
    let joint = (verb..words.len().saturating_sub(2)).find(|at| {
        has(&["from", "at"], words.get(*at))
            && has(&ARTICLES, words.get(at + 1))
            && has(&["hips", "waist"], words.get(at + 2))
    });
    if let Some(at) = joint {
        words.drain(at..at + 3);
    }
    let back = (verb..words.len().saturating_sub(3)).find(|at| {
        has(&["until", "till"], words.get(*at))
            && has(&["back", "body", "torso", "trunk"], words.get(at + 2))
            && words[at + 3..].iter().take(4).any(|word| ["flat", "horizontal"].contains(&word.as_str()))
    });
    if let Some(at) = back {
        let [_, end] = piece_of(&words, at);
        words.splice(at..end, ["deeply".to_string()]);
    }
    words
}

/// Drops "arms hanging" beside an action.
fn hanging_beside(mut words: Vec<String>) -> Vec<String> {
    const HANG: [&str; 10] =
        ["hanging", "dangling", "hang", "dangle", "loose", "loosely", "down", "relaxed", "limp", "straight"];
    let is_hung = |words: &[String], at: usize| {
        let [begin, end] = piece_of(words, at);
        let opens = words[begin..at]
            .iter()
            .all(|word| has(&ARTICLES, Some(word)) || has(&["left", "right", "let"], Some(word)));
        // "Let both arms hang down like wet noodles".
        let like = words[at..end].iter().position(|word| word == "like").map_or(end, |like| at + like);
        let rest = &words[at + 1..like];
        let hangs = rest.iter().any(|word| ["hanging", "dangling", "hang", "dangle"].contains(&word.as_str()));
        begin > 0 && opens && hangs && rest.iter().all(|word| HANG.contains(&word.as_str()))
    };
    if let Some(at) = (1..words.len()).find(|at| has(&ARMS, words.get(*at)) && is_hung(&words, *at)) {
        let [begin, end] = piece_of(&words, at);
        words.drain(begin - 1..end);
    }
    words
}

/// "Back to the starting position", "return to neutral": standing.
fn at_rest(mut words: Vec<String>) -> Vec<String> {
    const GOES: [&str; 8] = ["come", "comes", "go", "goes", "get", "return", "returns", "settle"];
    let Some(to) = (1..words.len()).find(|at| {
        let returns = has(&["back", "return", "returns"], words.get(at - 1));
        let skipped = words[at + 1..].iter().take_while(|word| STARTS.contains(&word.as_str())).count();
        let [_, end] = piece_of(&words, *at);
        let last = at + 1 + skipped;
        let is_rest = last + 1 == end && has(&RESTS, words.get(last)) || skipped > 0 && last == end;
        returns && words[*at] == "to" && is_rest
    }) else {
        return words;
    };
    let [begin, end] = piece_of(&words, to);
    if words[begin..to - 1].iter().all(|word| GOES.contains(&word.as_str())) {
        words.splice(begin..end, ["stand".to_string(), "straight".into()]);
    }
    words
}

#[cfg(test)]
mod tests {
    use super::super::split::normal;

    #[test]
    fn limbs_are_described_plainly() {
        for (text, plain) in [
            ("raise the arm until it is parallel to the floor", "raise the arm horizontal"),
            ("right arm 30 degrees below the horizontal", "right arm 60 degrees"),
            ("hands at the height of your chin", "hands at chin height"),
            ("arms up in a V shape", "arms diagonally up"),
            ("arms like a T, then bow", "arms out to the sides , then bow"),
            ("do a t pose", "do a t pose"),
            ("your lower leg hangs", "your shin hangs"),
            ("raise both arms, lower arms", "raise both arms , lower arms"),
            ("raise the right hand, then the left one", "raise the right hand , then the left hand"),
            ("arms overhead, fingers interlocked", "arms overhead , hands together"),
            ("right foot a step ahead of the left, weight on it", "right foot ahead , weight on it"),
            ("left foot behind the right foot", "left foot behind"),
            ("arms out with palms up, toes pointing forward", "arms out"),
            ("palms together", "palms together"),
            ("lift a leg with a straight knee", "lift a leg"),
            ("squat, then return to the starting position", "squat , then stand straight"),
            ("twist left, back to the center", "twist left , stand straight"),
            ("left leg back, toes on the floor", "left foot back"),
            ("one hand in your pocket", "one hand on your hip"),
            (
                "salute with your right hand and put the left behind your back",
                "salute with your right hand and put the left hand behind your back",
            ),
            ("left arm up by the ear", "left arm up"),
            ("bring the hand from your side up to your chest", "bring the hand up to your chest"),
            ("elbows high, hands hanging down", "elbows high , forearms hanging down"),
            ("go back to the kitchen", "go back to the kitchen"),
            ("swap to the right foot", "stand on the right foot"),
            ("right arm forward a touch above shoulder height", "right arm forward 105 degrees"),
            ("left arm to the side and slightly behind", "left arm to the side"),
            ("bend forward until your back is about flat, let both arms hang down", "bend forward deeply"),
            ("make a T with your body", "arms out to the sides"),
        ] {
            assert_eq!(normal(text).join(" "), plain, "{text}");
        }
    }
}
