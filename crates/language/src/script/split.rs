//! Text to pieces: normal form, and what joins the pieces.

use super::again::{done_again, elbow_to_knee, first_and_after, limbs_apart, off_after_turn, steps_apart};
use super::manners::with_manners;
use super::numbers::{with_digits, with_plain_numbers, with_units};
use super::plain::{as_somebody, plainly};

/// Relation of a piece to the one before it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::script) enum Join {
    /// After it: "then", a full stop.
    Then,
    /// During it: "while".
    While,
    /// After it or during it: "and".
    And,
    /// After it, or more words about it: a comma.
    Comma,
    /// During it, or with what: "with".
    With,
}

impl Join {
    /// Returns a word that joins so.
    pub fn word(self) -> &'static str {
        match self {
            Self::Then => "then",
            Self::While => "while",
            Self::And => "and",
            Self::Comma => ",",
            Self::With => "with",
        }
    }
}

/// Takes "together" from the end of a sentence, and marks hands that act at once. Returns whether the last piece is at once
/// with the one before.
fn says_together(pieces: &mut Vec<(Join, Vec<String>)>) -> bool {
    let is_limb = |word: &String| LIMBS.contains(&word.trim_end_matches('s'));
    // "Wave with the right hand and scratch your head with the left hand".
    if let [.., (_, before), (Join::With, one), (Join::And, words), (Join::With, other)] = &pieces[..]
        && !before.is_empty()
        && words.len() > 1
        && one.iter().any(is_limb)
        && other.iter().all(|word| is_limb(word) || ["the", "your", "left", "right"].contains(&word.as_str()))
        && (says(one, "left") && says(other, "right") || says(one, "right") && says(other, "left"))
    {
        let at = pieces.len() - 2;
        pieces[at].0 = Join::While;
    }
    let count = pieces.len();
    match pieces.last_mut() {
        // "Left arm up, right leg out, together".
        Some((Join::Comma, words)) if count > 2 && words.len() <= 2 && words.ends_with(&["together".into()]) => {
            pieces.pop();
            true
        }
        // "Jump and clap together", but not "put your feet together".
        Some((Join::And, words)) if words.len() > 1 && words.ends_with(&["together".into()]) => {
            let is_action = !words.iter().any(is_limb);
            if is_action {
                words.pop();
            }
            is_action
        }
        _ => false,
    }
}

/// Returns whether a word is a participle: "waving", but not "swing" or "bring".
pub(in crate::script) fn is_participle(word: &str) -> bool {
    word.strip_suffix("ing").is_some_and(|stem| stem.contains(['a', 'e', 'i', 'o', 'u', 'y']))
}

/// Returns whether a word is among others.
fn says(words: &[String], word: &str) -> bool {
    words.iter().any(|other| other == word)
}

/// Limbs, in the singular.
const LIMBS: [&str; 14] =
    ["hand", "arm", "leg", "foot", "feet", "knee", "elbow", "palm", "heel", "toe", "finger", "fist", "them", "it"];

/// Words that join, as they are in normal text; longer ones first.
const JOINS: [(&str, Join); 67] = [
    ("and at the same time", Join::While),
    ("while at the same time", Join::While),
    ("at the same time", Join::While),
    ("in the same time", Join::While),
    ("all at once", Join::While),
    ("at once", Join::While),
    ("all the while", Join::While),
    ("and simultaneously", Join::While),
    ("simultaneously", Join::While),
    ("and meanwhile", Join::While),
    ("meanwhile", Join::While),
    ("and while", Join::While),
    ("while", Join::While),
    ("whilst", Join::While),
    ("during", Join::While),
    ("as he", Join::While),
    ("as she", Join::While),
    ("as it", Join::While),
    ("as they", Join::While),
    ("as both", Join::While),
    ("as you", Join::While),
    ("as the", Join::While),
    ("as his", Join::While),
    ("as her", Join::While),
    ("as its", Join::While),
    ("as your", Join::While),
    ("and then", Join::Then),
    ("and to finish", Join::Then),
    ("to finish", Join::Then),
    ("finish with", Join::Then),
    ("end with", Join::Then),
    ("finish by", Join::Then),
    ("end by", Join::Then),
    ("finishing with", Join::Then),
    ("ending with", Join::Then),
    ("but then", Join::Then),
    ("and after that", Join::Then),
    ("after that", Join::Then),
    ("and afterwards", Join::Then),
    ("afterwards", Join::Then),
    ("afterward", Join::Then),
    ("and finally", Join::Then),
    ("finally", Join::Then),
    ("and next", Join::Then),
    ("and starts to", Join::Then),
    ("and start to", Join::Then),
    ("and begins to", Join::Then),
    ("and begin to", Join::Then),
    ("and ends with", Join::Then),
    ("and end with", Join::Then),
    ("next", Join::Then),
    ("followed by", Join::Then),
    ("before finally", Join::Then),
    ("before", Join::Then),
    ("and lastly", Join::Then),
    ("lastly", Join::Then),
    ("later", Join::Then),
    ("then", Join::Then),
    ("until", Join::Then),
    ("|", Join::Then),
    (", and", Join::And),
    ("and", Join::And),
    ("plus", Join::And),
    ("but", Join::And),
    ("or", Join::And),
    (",", Join::Comma),
    ("with", Join::With),
];

/// Returns words in small letters, with punctuation that joins as words of its own and units spelt out.
pub(super) fn normal(text: &str) -> Vec<String> {
    let mut out = String::new();
    let mut before = ' ';
    for c in with_plain_numbers(&without_list_numbers(without_title(&without_alternatives(text)))).chars() {
        match c {
            '.' | ';' | '!' | '?' | ':' => {
                // A point between digits is part of the number.
                if c == '.' && before.is_ascii_digit() { out.push('.') } else { out.push_str(" | ") }
            }
            ',' | '(' | ')' => out.push_str(" , "),
            '\u{b0}' | '\u{ba}' => out.push_str(" degrees "),
            '\'' | '\u{2019}' => {}
            '%' | '+' | '&' => out.push_str(" and "),
            // "Plié" is typed without its accent by most.
            '\u{e0}'..='\u{e5}' => out.push('a'),
            '\u{e8}'..='\u{eb}' => out.push('e'),
            _ if c.is_alphanumeric() => {
                // "90deg", "3x" and "5s" are a number and a unit.
                if before.is_ascii_digit() && c.is_alphabetic() || before == 'x' && c.is_ascii_digit() {
                    out.push(' ');
                }
                out.push(c);
            }
            _ => out.push(' '),
        }
        before = c;
    }
    let unit = |word: &str| match word.trim_end_matches('.') {
        "deg" | "degs" | "degree" | "grad" | "grads" => "degrees".to_string(),
        "s" | "sec" | "secs" | "second" => "seconds".into(),
        "x" | "time" | "reps" | "rep" | "repetitions" | "repetition" => "times".into(),
        "&" => "and".into(),
        other => other.to_string(),
    };
    let out = out.replace("counter clockwise", "counterclockwise").replace("anti clockwise", "counterclockwise");
    let mut words: Vec<String> = out.split_whitespace().map(unit).filter(|word| !word.is_empty()).collect();
    for (said, one) in ONE_WORD {
        let said: Vec<&str> = said.split(' ').collect();
        while let Some(at) = words.windows(said.len()).position(|part| part.iter().eq(said.iter())) {
            words.splice(at..at + said.len(), [one.to_string()]);
        }
    }
    let mut words = with_manners(likened(as_somebody(words)));
    // "The same time" is no unit.
    for at in 1..words.len() {
        if words[at - 1] == "same" && words[at] == "times" {
            words[at] = "time".into();
        }
    }
    let words: Vec<String> = words.into_iter().skip_while(|word| word == "|" || word == ",").collect();
    let words = plainly(with_units(with_digits(without_frame(&words))));
    let words = limbs_apart(steps_apart(elbow_to_knee(first_and_after(words))));
    done_again(off_after_turn(words))
}

/// Returns a list without its title: "warm up: circle the arms, squat, bow".
fn without_title(text: &str) -> &str {
    const SIDES: [&str; 5] = ["left", "right", "both", "the", "your"];
    const POSES: [&str; 9] = ["pose", "position", "stance", "posture", "thing", "move", "exercise", "arms", "combo"];
    let Some((title, list)) = text.split_once(": ") else { return text };
    let words: Vec<&str> = title.split_whitespace().collect();
    let is_limb = |word: &&str| LIMBS.contains(&word.trim_end_matches('s')) || SIDES.contains(word);
    // "Arabesque arms" is a title, "left arm" is none.
    let is_name = !words.iter().any(is_limb) || !words.iter().all(is_limb) && !words.iter().any(|w| SIDES.contains(w));
    let is_pose = words.last().is_some_and(|word| POSES.contains(word));
    let is_title = words.len() < 4 && is_name && list.matches([',', '.']).count() > usize::from(!is_pose);
    if is_title { list } else { text }
}

/// Returns small letters without what may be done as well: "touch your toes (or get close)".
fn without_alternatives(text: &str) -> String {
    let mut text = text.to_lowercase();
    while let Some(begin) = text.find("(or ") {
        let Some(length) = text[begin..].find(')') else { break };
        text.replace_range(begin..=begin + length, "");
    }
    text
}

/// "Nod!! like a child": the sentence goes on.
fn likened(words: Vec<String>) -> Vec<String> {
    let mut out: Vec<String> = Vec::with_capacity(words.len());
    for (at, word) in words.iter().enumerate() {
        let next = words.get(at + 1).map_or("", String::as_str);
        if word == "like" && !["this", "that", "so", ","].contains(&next) {
            while out.len() > 1 && out.last().is_some_and(|last| last == "|") {
                out.pop();
            }
        }
        out.push(word.clone());
    }
    out
}

/// Returns text with the numbers of a list as full stops: "1. squat 2) jump". A list has a first and a second item.
fn without_list_numbers(text: &str) -> String {
    let text = text.replace("w/o ", "without ").replace("w/ ", "with ");
    let item =
        |number: u32| [format!("{number}. "), format!("{number}) ")].into_iter().find(|item| text.contains(item));
    if item(1).is_none() || item(2).is_none() {
        return text;
    }
    let items = (1..30).map_while(item);
    items.fold(text.clone(), |text, item| text.replacen(&item, ". ", 1))
}

/// Phrases with words that join elsewhere, and units of several words, as one word; longer ones first.
const ONE_WORD: [(&str, &str); 28] = [
    ("after this", "then"),
    ("head , shoulders , knees and toes", "headandtoes"),
    ("head , shoulders , knees , toes", "headandtoes"),
    ("head shoulders knees and toes", "headandtoes"),
    ("tip toe", "tiptoe"),
    ("tippy toes", "tiptoes"),
    ("for a little while", "awhile"),
    ("for a good while", "awhile"),
    ("for a long while", "awhile"),
    ("for quite a while", "awhile"),
    ("for a while", "awhile"),
    ("for a long time", "awhile"),
    ("for a long times", "awhile"),
    ("over and over again", "repeatedly"),
    ("over and over", "repeatedly"),
    ("again and again", "repeatedly"),
    ("on and on", "continuously"),
    ("every now and then", "occasionally"),
    ("every now and again", "occasionally"),
    ("now and then", "occasionally"),
    ("now and again", "occasionally"),
    ("metres per seconds", "mpers"),
    ("meters per seconds", "mpers"),
    ("m per seconds", "mpers"),
    ("km per hour", "kmperh"),
    ("n", "and"),
    ("strait", "straight"),
    ("and den", "and then"),
];

/// Openings that ask for what follows, longer ones first.
const FRAMES: [&str; 27] = [
    "i want that you",
    "can you show me how to",
    "could you show me how to",
    "can you show me",
    "could you show me",
    "can you please",
    "could you please",
    "would you please",
    "would you mind",
    "i would like you to",
    "id like you to",
    "i want you to",
    "show me how to",
    "show me how you",
    "show me a",
    "show me some",
    "show me the",
    "lets see",
    "let me see",
    "how about",
    "what about",
    "gimme a",
    "gimme some",
    "i want the",
    "i want your",
    "i need the",
    "i need your",
];

/// Returns words without the polite frame around them: "can you show me a kick", "walk until I say stop".
fn without_frame(words: &[String]) -> Vec<String> {
    let opens = |frame: &&&str| {
        let frame: Vec<&str> = frame.split(' ').collect();
        words.iter().map(String::as_str).take(frame.len()).eq(frame.iter().copied())
    };
    let from = FRAMES.iter().find(opens).map_or(0, |frame| frame.split(' ').count());
    let told = |pair: &[String]| pair[0] == "until" && ["i", "you", "someone", "told"].contains(&pair[1].as_str());
    let mut rest = words[from.min(words.len())..].to_vec();
    if let Some(at) = rest.windows(2).position(told) {
        let ends = |word: &String| ["stop", "enough", "otherwise"].contains(&word.as_str());
        let end = rest[at..].iter().position(ends).map_or(rest.len(), |word| at + word + 1);
        rest.drain(at..end);
    }
    // What somebody thinks is not to be done.
    for thought in [&["i", "was", "thinking"][..], &["i", "am", "thinking"], &["i", "think"]] {
        if let Some(at) = rest.windows(thought.len()).position(|words| words.iter().eq(thought.iter())) {
            rest.drain(at..at + thought.len());
        }
    }
    rest
}

/// Actions as things: "kick after a bow".
const DEEDS: [&str; 12] =
    ["breath", "bow", "jump", "nod", "squat", "spin", "twirl", "clap", "salute", "pause", "curtsy", "stretch"];

/// Returns pieces with what joins each to the one before; the first is joined by `Then`. "After A, B" is A, then B.
pub(super) fn pieces(words: &[String]) -> Vec<(Join, Vec<String>)> {
    let mut all: Vec<(Join, Vec<String>)> = vec![(Join::Then, Vec::new())];
    let mut at = 0;
    let mut swapped = false;
    while at < words.len() {
        if at == 0 && words[at] == "before" {
            // "Before A, B" is B, then A: as "A after B".
            let comma = words.iter().position(|word| word == ",").unwrap_or(words.len());
            let (first, second) = (&words[1..comma], &words[(comma + 1).min(words.len())..]);
            let turned: Vec<String> = second.iter().chain([&"then".to_string()]).chain(first).cloned().collect();
            return if second.is_empty() { pieces(&words[1..]) } else { pieces(&turned) };
        }
        // "One arm circles the other one rests": what the other does is a piece of its own.
        let other = ["hand", "arm", "one"];
        let is_other = words[at] == "the"
            && words.get(at + 1).is_some_and(|word| word == "other")
            && words.get(at + 2).is_some_and(|word| other.contains(&word.as_str()))
            && words[..at].windows(2).any(|two| two[0] == "one" && ["hand", "arm"].contains(&two[1].as_str()))
            && all.last().is_some_and(|(_, piece)| piece.len() > 2);
        if is_other {
            all.push((Join::While, Vec::new()));
        }
        let opens = |w: &String| is_participle(w) || ["you", "he", "she", "it", "they"].contains(&w.as_str());
        let is_deed = words[at..].iter().skip(1).take(3).any(|word| DEEDS.contains(&word.as_str()));
        if words[at] == "after" && (at == 0 || is_deed || words.get(at + 1).is_some_and(opens)) {
            // What stands after it is done first.
            swapped = at > 0;
            if swapped {
                all.push((Join::Then, Vec::new()));
            }
            at += 1;
            continue;
        }
        let found = JOINS.iter().find(|(text, _)| {
            let joined: Vec<&str> = text.split(' ').collect();
            words[at..].iter().map(String::as_str).take(joined.len()).eq(joined.iter().copied())
        });
        match found {
            Some((text, join)) => {
                // "While A, B": the comma joins what is done at once.
                let opens = *join == Join::While && all.len() == 1 && all[0].1.is_empty();
                if opens {
                    all[0].0 = Join::While;
                } else {
                    all.push((*join, Vec::new()));
                }
                at += text.split(' ').count();
            }
            None => {
                if let Some((_, piece)) = all.last_mut() {
                    piece.push(words[at].clone());
                }
                at += 1;
            }
        }
    }
    if swapped {
        // With two pieces or more, what stood last is done first.
        let (_, last) = all.pop().unwrap_or((Join::Then, Vec::new()));
        all.insert(0, (Join::Then, last));
    }
    // The last of a list is one more of it: "wave, bow, and clap".
    let commas = all.iter().filter(|(join, _)| *join == Join::Comma).count();
    if let Some((join @ Join::And, _)) = all.last_mut().filter(|_| commas > 0) {
        *join = Join::Comma;
    }
    if all[0].0 == Join::While {
        all[0].0 = Join::Then;
        if let Some(second) = all.get_mut(1) {
            second.0 = Join::While;
        }
    }
    merged(all)
}

/// Two joins in a row are one: the stronger. Pieces without words go.
fn merged(all: Vec<(Join, Vec<String>)>) -> Vec<(Join, Vec<String>)> {
    let mut out: Vec<(Join, Vec<String>)> = Vec::new();
    let mut pending: Option<Join> = None;
    for (join, piece) in all {
        let strength = |join: Join| match join {
            Join::While => 4,
            Join::Then => 3,
            Join::And => 2,
            Join::Comma => 1,
            Join::With => 0,
        };
        let join = pending.filter(|p| strength(*p) > strength(join)).unwrap_or(join);
        if piece.is_empty() {
            pending = Some(join);
        } else {
            out.push((join, piece));
            pending = None;
        }
    }
    if says_together(&mut out) {
        pending = Some(Join::While);
    }
    // "Nod and clap at the same time": what ends with it is at once.
    if let (Some(Join::While), Some((join @ (Join::And | Join::Comma), _))) = (pending, out.last_mut()) {
        *join = Join::While;
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(text: &str) -> Vec<(Join, String)> {
        pieces(&normal(text)).into_iter().map(|(join, words)| (join, words.join(" "))).collect()
    }

    #[test]
    fn text_is_divided_where_something_joins() {
        let expected = [(Join::Then, "turn"), (Join::Comma, "wave"), (Join::Then, "bow")];
        assert_eq!(of("Turn, wave, then bow."), expected.map(|(j, t)| (j, t.to_string())));
        let expected = [(Join::Then, "a man walks"), (Join::While, "waving his hand")];
        assert_eq!(of("a man walks while waving his hand"), expected.map(|(j, t)| (j, t.to_string())));
        let expected = [(Join::Then, "bowing"), (Join::Comma, "wave")];
        assert_eq!(of("After bowing, wave"), expected.map(|(j, t)| (j, t.to_string())));
        let expected = [(Join::Then, "bowing"), (Join::Then, "wave")];
        assert_eq!(of("wave after bowing"), expected.map(|(j, t)| (j, t.to_string())));
        let expected = [(Join::Then, "take a bow"), (Join::Then, "you wave")];
        assert_eq!(of("Before you wave, take a bow"), expected.map(|(j, t)| (j, t.to_string())));
        let expected = [(Join::Then, "pat your head"), (Join::While, "rub it")];
        assert_eq!(of("pat your head and rub it at the same time"), expected.map(|(j, t)| (j, t.to_string())));
        let expected = [(Join::Then, "left arm up"), (Join::While, "right leg out")];
        assert_eq!(of("left arm up, right leg out, together"), expected.map(|(j, t)| (j, t.to_string())));
        let expected = [(Join::Then, "jump"), (Join::While, "clap")];
        assert_eq!(of("jump and clap together"), expected.map(|(j, t)| (j, t.to_string())));
        let expected = [(Join::Then, "walking"), (Join::While, "nod")];
        assert_eq!(of("while walking, nod"), expected.map(|(j, t)| (j, t.to_string())));
    }

    #[test]
    fn numbers_and_units_are_words_of_their_own() {
        assert_eq!(normal("turn 90° left").join(" "), "turn 90 degrees left");
        assert_eq!(normal("nod 3x, wait 2.5s").join(" "), "nod 3 times , wait 2.5 seconds");
        assert_eq!(normal("high-five!").join(" "), "high five |");
        assert_eq!(normal("warm up: squat, bow, clap").join(" "), "squat , bow , clap");
        assert_eq!(normal("left arm: up, out, down").join(" "), "left arm | up , out , down");
    }
}
