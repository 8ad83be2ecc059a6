//! Words beside what is asked for: parts that stay, legs of low poses, corrections, what is said twice.

use super::said::number;

/// Words that join.
const JOINS: [&str; 6] = [",", "|", "and", "then", "while", "but"];
const ARTICLES: [&str; 6] = ["the", "your", "ur", "his", "her", "my"];
/// Parts of the body that are said to stay as they are.
const STAYING: [&str; 18] = [
    "everything",
    "else",
    "rest",
    "body",
    "hips",
    "pelvis",
    "feet",
    "foot",
    "shoulders",
    "shoulder",
    "torso",
    "trunk",
    "legs",
    "leg",
    "thigh",
    "heels",
    "of",
    "both",
];
const STAYS: [&str; 8] = ["stay", "stays", "keep", "keeps", "keeping", "remain", "remains", "staying"];
/// Words that say how such parts stay.
const AS_THEY_ARE: [&str; 25] = [
    "still", "neutral", "facing", "face", "front", "forward", "forwards", "ahead", "fixed", "on", "ground", "floor",
    "flat", "planted", "put", "quiet", "same", "level", "in", "place", "upright", "straight", "normal", "to", "and",
];

/// Returns words without those that ask for nothing.
pub(super) fn without_asides(words: Vec<String>) -> Vec<String> {
    let words = simultaneously(with_its_side(with_these(as_pretended(with_its_manner(words)))));
    let words = without_low_legs(said_once(corrected(without_title_time(words))));
    without_comments(without_shares(without_last_stand(words)))
}

fn has(all: &[&str], word: Option<&String>) -> bool {
    word.is_some_and(|word| all.contains(&word.as_str()))
}

/// Returns where the piece of a word begins, and where it ends.
fn piece_of(words: &[String], at: usize) -> [usize; 2] {
    let joins = |word: &String| JOINS.contains(&word.as_str());
    let begin = words[..at].iter().rposition(joins).map_or(0, |join| join + 1);
    let end = words[at..].iter().position(joins).map_or(words.len(), |join| at + join);
    [begin, end]
}

/// Drops what is said of the actions: "that's the first bit of our line dance".
fn without_comments(mut words: Vec<String>) -> Vec<String> {
    let is_comment = |words: &[String], at: usize| {
        let begins = at > 1 && has(&[",", "|"], words.get(at - 1));
        let says = has(&["thats"], words.get(at))
            || has(&["that", "this"], words.get(at)) && has(&["is", "was"], words.get(at + 1));
        begins && says
    };
    while let Some(at) = (0..words.len()).find(|at| is_comment(&words, *at)) {
        let [_, end] = piece_of(&words, at);
        words.drain(at - 1..end);
    }
    words
}

/// "Three squats. Deep ones. Nice and slow.", "spin round once, clockwise": of what was said before.
fn with_its_manner(mut words: Vec<String>) -> Vec<String> {
    const HOW: [&str; 14] = [
        "slow",
        "slowly",
        "quick",
        "quickly",
        "fast",
        "deep",
        "big",
        "huge",
        "small",
        "tiny",
        "gentle",
        "clockwise",
        "counterclockwise",
        "anticlockwise",
    ];
    while let Some(at) = words.windows(3).position(|w| w[0] == "nice" && w[1] == "and" && has(&HOW, w.get(2))) {
        words.drain(at..at + 2);
    }
    let length = |words: &[String], at: usize| {
        let [_, end] = piece_of(words, at + 1);
        let ones = usize::from(has(&["ones"], words.get(at + 2)));
        let is_how = has(&[",", "|"], words.get(at)) && has(&HOW, words.get(at + 1));
        (is_how && end == at + 2 + ones).then_some(ones)
    };
    while let Some((at, ones)) = (1..words.len()).find_map(|at| Some((at, length(&words, at)?))) {
        words.drain(at + 2..at + 2 + ones);
        words.remove(at);
    }
    words
}

/// "Pretend you are a zombie": be one. "Look out!" warns.
fn as_pretended(mut words: Vec<String>) -> Vec<String> {
    let warns = has(&["look", "watch"], words.first()) && has(&["out"], words.get(1));
    if warns && words.len() > 3 && has(&[",", "|"], words.get(2)) {
        words.drain(..3);
    }
    if has(&["pretend"], words.first()) && has(&["you", "youre", "ur", "your"], words.get(1)) {
        let are = usize::from(has(&["are"], words.get(2)));
        if has(&["a", "an", "the"], words.get(2 + are)) {
            words.splice(..2 + are, ["be".to_string()]);
        }
    }
    words
}

/// "Ten curls, both arms together": with both arms.
fn with_these(mut words: Vec<String>) -> Vec<String> {
    const LIMBS: [&str; 4] = ["arms", "hands", "legs", "fists"];
    let length = |words: &[String], at: usize| {
        let names = words[at] == "," && has(&["both"], words.get(at + 1)) && has(&LIMBS, words.get(at + 2));
        let together = usize::from(has(&["together"], words.get(at + 3)));
        (names && has(&JOINS, words.get(at + 3 + together).or(Some(&words[at])))).then_some(3 + together)
    };
    while let Some((at, length)) = (1..words.len()).find_map(|at| Some((at, length(&words, at)?))) {
        let limbs = words[at + 2].clone();
        words.splice(at..at + length, ["with".to_string(), "both".to_string(), limbs]);
    }
    words
}

/// "Shrug and tilt the head simultaneously", "squat and push as you go down": while.
fn simultaneously(mut words: Vec<String>) -> Vec<String> {
    let goes = |at: &usize| {
        let is_way = has(&["down", "up"], words.get(at + 3)) && has(&["go", "come"], words.get(at + 2));
        has(&["as"], words.get(*at)) && has(&["you"], words.get(at + 1)) && is_way
    };
    let said = words.iter().position(|word| word == "simultaneously").map(|at| (at, 1));
    let Some((at, length)) = said.or_else(|| (0..words.len()).find(goes).map(|at| (at, 4))) else { return words };
    let [begin, end] = piece_of(&words, at);
    if begin > 0 && end - begin > length && has(&["and", ","], words.get(begin - 1)) {
        words.drain(at..at + length);
        words[begin - 1] = "while".into();
    }
    words
}

/// "Warm up time! Five squats": a title.
fn without_title_time(mut words: Vec<String>) -> Vec<String> {
    let end = words.iter().position(|word| word == "|").unwrap_or(0);
    let is_title = (2..=4).contains(&end) && has(&["time", "times"], words.get(end - 1)) && end + 1 < words.len();
    if is_title && !words[..end].iter().any(|word| number(word).is_some()) {
        words.drain(..=end);
    }
    words
}

/// "Stand on one leg. The right one": on the right leg.
fn with_its_side(mut words: Vec<String>) -> Vec<String> {
    const LIMBS: [&str; 6] = ["leg", "foot", "arm", "hand", "knee", "one"];
    let answers = |words: &[String], at: usize| {
        let [begin, end] = piece_of(words, at);
        let is_whole = begin + 1 == at && end == at + 2 && has(&ARTICLES, words.get(begin));
        is_whole && has(&["left", "right"], words.get(at)) && has(&LIMBS, words.get(at + 1))
    };
    let Some(at) = (3..words.len().max(3)).find(|at| answers(&words, *at)) else { return words };
    let is_open = |before: &usize| has(&["one", "a"], words.get(*before)) && has(&LIMBS[..5], words.get(before + 1));
    if let Some(open) = (0..at - 2).rev().find(is_open) {
        words[open] = words[at].clone();
        words.drain(at - 2..at + 2);
    }
    words
}

/// "Then a kick, no, just wave": the kick is taken back.
fn corrected(mut words: Vec<String>) -> Vec<String> {
    const BACK: [&str; 10] = ["a", "the", "then", "just", "rather", "actually", "instead", "wait", "sorry", "better"];
    let separates = |word: Option<&String>| has(&[",", "|"], word);
    let takes_back = |words: &[String], at: usize| {
        let after = words[at + 1..].iter().find(|word| !separates(Some(word)));
        let waits = usize::from(has(&["wait", "sorry"], words.get(at + 1)));
        words[at] == "no" && separates(words.get(at - 1)) && separates(words.get(at + 1 + waits)) && has(&BACK, after)
    };
    while let Some(at) = (1..words.len().saturating_sub(1)).find(|at| takes_back(&words, *at)) {
        let before = words[..at].iter().rposition(|word| !separates(Some(word))).unwrap_or(0);
        let [begin, _] = piece_of(&words, before);
        let waits = usize::from(has(&["wait", "sorry"], words.get(at + 1)));
        words.drain(begin..=at + 1 + waits);
    }
    words
}

/// "Say come here, come here": said twice.
fn said_once(mut words: Vec<String>) -> Vec<String> {
    let repeats = |words: &[String], at: usize| {
        let [_, end] = piece_of(words, at + 1);
        let again = &words[at + 1..end];
        words[at] == "," && again.len() > 1 && words[..at].len() > again.len() && words[..at].ends_with(again)
    };
    while let Some(at) = (1..words.len().saturating_sub(1)).find(|at| repeats(&words, *at)) {
        let [_, end] = piece_of(&words, at + 1);
        let [begin, _] = piece_of(&words, at - 1);
        // A whole piece again is done again.
        if at - begin == end - at - 1 {
            break;
        }
        words.drain(at..end);
    }
    words
}

/// Drops parts that stay as they are: "body stays facing front", "keep your hips and feet still".
pub(super) fn without_what_stays(mut words: Vec<String>) -> Vec<String> {
    let length = |words: &[String], at: usize| {
        let is_said = |word: &String| {
            [&STAYING[..], &STAYS, &AS_THEY_ARE, &ARTICLES].into_iter().any(|known| known.contains(&word.as_str()))
        };
        let all = words[at..].iter().take_while(|word| is_said(word)).count();
        let piece = &words[at..at + all];
        let names = |known: &[&str]| piece.iter().any(|word| known.contains(&word.as_str()));
        let ends = words.get(at + all).is_none_or(|word| JOINS.contains(&word.as_str()));
        let is_whole = ends && piece.last().is_some_and(|last| last != "and") && names(&AS_THEY_ARE[..21]);
        (is_whole && names(&STAYS) && names(&STAYING[..16])).then_some(all)
    };
    let starts = |words: &[String], at: usize| JOINS.contains(&words[at - 1].as_str());
    while let Some((at, length)) =
        (1..words.len()).filter(|at| starts(&words, *at)).find_map(|at| Some((at, length(&words, at)?)))
    {
        words.drain(at - 1..at + length);
    }
    // "Keep your hips still and twist".
    if let Some(length) = length(&words, 0).filter(|length| *length + 1 < words.len()) {
        words.drain(..=length);
    }
    words
}

/// Drops what the legs of a kneeling, a lunge or a squat are like by themselves.
fn without_low_legs(mut words: Vec<String>) -> Vec<String> {
    const LOW: [&str; 6] = ["kneel", "kneels", "lunge", "lunges", "squat", "crouch"];
    const PARTS: [&str; 10] = ["knee", "knees", "leg", "thigh", "thighs", "shin", "foot", "torso", "trunk", "heels"];
    const STATES: [&str; 23] = [
        "left",
        "right",
        "front",
        "back",
        "flat",
        "level",
        "straight",
        "90",
        "degrees",
        "bent",
        "in",
        "on",
        "to",
        "parallel",
        "horizontal",
        "vertical",
        "upright",
        "floor",
        "ground",
        "at",
        "is",
        "with",
        "behind",
    ];
    let Some(low) = words.iter().position(|word| LOW.contains(&word.as_str())) else { return words };
    let is_of_sides = words[low].starts_with("kneel") || words[low].starts_with("lunge");
    let mut at = low;
    while let Some(join) = (at..words.len()).find(|at| has(&[",", "|", "with"], words.get(*at))) {
        let [_, end] = piece_of(&words, join + 1);
        let end = (join + 1..end).find(|at| words[*at] == "with").unwrap_or(end);
        let like = (join + 1..end).find(|at| words[*at] == "like").unwrap_or(end);
        let piece = &words[join + 1..like];
        let is_trunk = has(&["torso", "trunk"], piece.first()) || has(&["torso", "trunk"], piece.get(1));
        let is_known = |word: &String| {
            let lists = [&PARTS[..], &STATES, &ARTICLES];
            is_trunk && word == "up" || lists.into_iter().any(|known| known.contains(&word.as_str()))
        };
        let names = |known: &[&str]| piece.iter().any(|word| known.contains(&word.as_str()));
        let is_back = piece.iter().find(|word| !ARTICLES.contains(&word.as_str())).is_some_and(|word| *word == "back");
        // "Lunge with the left leg" says the side; a squat with one leg ahead is another one.
        let is_state = names(&STATES[4..]) && (is_of_sides || !names(&STATES[..2]));
        if is_state && (names(&PARTS) || is_back) && piece.iter().all(is_known) {
            words.drain(join + 1..end);
            // "A lunge: front knee bent, hands up": the hands belong to it.
            words[join] = ",".into();
            if has(&[",", "|", "and", "then", "while", "with"], words.get(join + 1)) || join + 1 == words.len() {
                words.remove(join);
            }
            at = join;
        } else {
            at = join + 1;
        }
        if at >= words.len() {
            break;
        }
    }
    words
}

/// "Lift a leg, standing": who does it stands anyway.
fn without_last_stand(mut words: Vec<String>) -> Vec<String> {
    let last = words.iter().rposition(|word| word != "|").unwrap_or(0);
    if last > 2 && words[last] == "standing" && has(&[",", "|"], words.get(last - 1)) {
        words.drain(last - 1..=last);
    }
    words
}

/// "Twelve kicks, six each side": twelve.
fn without_shares(mut words: Vec<String>) -> Vec<String> {
    let share = |words: &[String], at: usize| {
        let on = usize::from(has(&["on", "per", "for"], words.get(at + 1)));
        let each = usize::from(has(&["each"], words.get(at + 1 + on)));
        let is_side = has(&["side", "leg", "arm", "hand", "foot"], words.get(at + 1 + on + each));
        let count = number(&words[at]).filter(|_| on + each > 0 && is_side && words[at - 1] == ",")?;
        let is_whole = |word: &String| {
            let whole = if word == "dozen" { Some(12.0) } else { number(word) };
            whole.is_some_and(|whole| (whole - 2.0 * count).abs() < 1e-6)
        };
        words[..at - 1].iter().any(is_whole).then_some(2 + on + each)
    };
    if let Some((at, length)) = (2..words.len()).find_map(|at| Some((at, share(&words, at)?))) {
        words.drain(at - 1..at + length);
    }
    words
}

#[cfg(test)]
mod tests {
    use super::super::split::normal;

    #[test]
    fn what_asks_for_nothing_goes() {
        for (text, plain) in [
            ("turn your head left, body stays facing front", "turn your head left"),
            ("twist the torso, keep pelvis + feet forward, arms out", "twist the torso , arms out"),
            ("bow, feet stay on the ground", "bow"),
            ("raise an arm and keep it up", "raise an arm and keep it up"),
            ("point up, then thumb... no, then just bow", "point up , then then just bow"),
            ("with the right you say come here, come here", "with the right you say come here"),
            ("kneel on the left knee, right foot flat in front, torso straight up", "kneel on the left knee"),
            ("lunge with the left leg, torso upright", "lunge with the left leg"),
            ("squat, left leg up", "squat , left leg up"),
            ("kneel, torso straight up like a knight", "kneel"),
            ("step into a lunge: front knee 90, back leg straight, hands up", "step into a lunge , hands up"),
            ("a dozen high knees, six each side, alternating", "a dozen high knees , alternating"),
            ("warm up time! 5 squats, 5 bows", "5 squats , 5 bows"),
            ("nod eagerly!! like a child", "nod eagerly happily"),
            ("stand on one leg for six seconds? The right one.", "stand on right leg for six seconds |"),
            ("pretend you're a zombie", "be a zombie"),
            ("Three squats. Deep ones. Nice and slow.", "three squats deep slow |"),
            ("spin all the way round once, clockwise", "spin all the way round once clockwise"),
            ("squat and push both arms out as you go down", "squat while push both arms out"),
            ("touch your toes (or get close), stand tall", "touch your toes , stand tall"),
        ] {
            assert_eq!(normal(text).join(" "), plain, "{text}");
        }
    }
}
