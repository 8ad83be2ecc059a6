//! Facts as sentences in varied words.

use rand::Rng;
use rand::seq::IndexedRandom;

use super::table::{Acts, Grammar, Verb};
use crate::checks::SignalName;
use crate::error::LanguageError;
use crate::facts::{Action, Direction, Facts, Relation, Size, Speed};

/// Words that stand in no grammar's text: sides, numbers and angles are written by rule.
pub(super) const FIXED: &str = "is first the your their left right both hand hands arm arms foot leg some step steps \
    once twice time times to by a quarter half turn degrees clockwise counterclockwise \
    zero one two three four five six seven eight nine ten eleven twelve";

/// Form of a verb.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Form {
    /// wave
    Base,
    /// waves
    Third,
    /// waving
    Gerund,
}

impl Form {
    /// Every form.
    pub(crate) const ALL: [Self; 3] = [Self::Base, Self::Third, Self::Gerund];
}

/// Returns `count` different sentences that say these facts, fewer where the grammar has no more. Words are those that
/// are trained on, or the held-out ones.
///
/// # Errors
/// [`LanguageError::Grammar`] for a verb that is not in the grammar.
pub fn captions<R: Rng>(
    grammar: &Grammar,
    facts: &Facts,
    new: bool,
    count: usize,
    rng: &mut R,
) -> Result<Vec<String>, LanguageError> {
    let mut made: Vec<String> = Vec::new();
    // Words are drawn, so some sentences come twice.
    for _ in 0..8 * count {
        if made.len() == count {
            break;
        }
        let sentence = sentence(grammar, facts, new, rng)?;
        if !made.contains(&sentence) {
            made.push(sentence);
        }
    }
    Ok(made)
}

/// Draws one of the words; of what is empty, none.
fn one<'a, R: Rng>(words: &'a [String], rng: &mut R) -> &'a str {
    words.choose(rng).map_or("", String::as_str)
}

fn sentence<R: Rng>(grammar: &Grammar, facts: &Facts, new: bool, rng: &mut R) -> Result<String, LanguageError> {
    let subject = one(if new { &grammar.new_subjects } else { &grammar.subjects }, rng).to_string();
    let commands = if new { &grammar.new_imperative } else { &grammar.imperative };
    let say = |action: &Action, form: Form, rng: &mut R| -> Result<String, LanguageError> {
        let verb = grammar.verb(&action.verb)?;
        Ok(phrase(grammar, verb, action, form, new, rng))
    };
    let Some(first) = facts.actions.first() else {
        return Err(LanguageError::Grammar("expected facts with an action, got none".into()));
    };
    match (facts.relation, facts.actions.get(1)) {
        (Relation::Single, _) | (_, None) => match rng.random_range(0..10) {
            0..6 => Ok(format!("{subject} {}", say(first, Form::Third, rng)?)),
            6..8 => Ok(format!("{subject} is {}", say(first, Form::Gerund, rng)?)),
            _ => Ok(one(commands, rng).replace("{do}", &say(first, Form::Base, rng)?)),
        },
        (relation, Some(second)) => {
            let templates = match (relation, new) {
                (Relation::While, false) => &grammar.during,
                (Relation::While, true) => &grammar.new_during,
                (_, false) => &grammar.then,
                (_, true) => &grammar.new_then,
            };
            let template = one(templates, rng);
            // A held-out template speaks of "it", which commands cannot.
            let command = !template.contains(" it ") && rng.random_range(0..10) >= 8;
            let form = if command { Form::Base } else { Form::Third };
            let mut text = template.to_string();
            for (letter, action) in [('A', first), ('B', second)] {
                for (slot, form) in [(format!("{{{letter}}}"), form), (format!("{{{letter}ing}}"), Form::Gerund)] {
                    if text.contains(&slot) {
                        text = text.replacen(&slot, &say(action, form, rng)?, 1);
                    }
                }
            }
            Ok(match (command, text.strip_prefix("first ")) {
                (true, _) => one(commands, rng).replace("{do}", &text),
                (false, Some(rest)) => format!("first {subject} {rest}"),
                (false, None) => format!("{subject} {text}"),
            })
        }
    }
}

/// Returns the verb phrase of one action.
fn phrase<R: Rng>(g: &Grammar, verb: &Verb, action: &Action, form: Form, new: bool, rng: &mut R) -> String {
    let template = one(if new { &verb.new } else { &verb.say }, rng);
    let mut text = inflected(template, form);
    if let Some(side) = action.side {
        for limb in ["hand", "arm", "foot", "leg"] {
            let owner = match (form, rng.random_range(0..10)) {
                (_, 0..5) => "the",
                (Form::Base, _) => "your",
                (_, 5..8) => "their",
                _ => "the",
            };
            text = text.replace(&format!("{{{limb}}}"), &format!("{owner} {} {limb}", side.word()));
        }
        text = text.replace("{side}", side.word());
    }
    let way = match action.direction {
        Some(Direction::Left) => "left",
        Some(Direction::Right) => "right",
        _ => "",
    };
    text = text.replace("{side}", way);
    let steps = action.count.map(|n| format!(" {} step{}", number(n), if n == 1 { "" } else { "s" }));
    text = text.replace("{nsteps}", steps.as_deref().unwrap_or(" some steps"));
    text = text.replace("{steps}", steps.as_deref().unwrap_or(""));
    text = text.replace("{angle}", &angle(action, way, rng));

    let adverbs = if new { &g.new_adverbs } else { &g.adverbs };
    let mut after = |class: &str, rng: &mut R| {
        let adverb = adverbs.get(class).map_or("", |words| one(words, rng));
        // One word may stand before what is done: "slowly waves".
        if adverb.ends_with("ly") && !adverb.contains(' ') && rng.random_bool(0.3) {
            text = format!("{adverb} {text}");
        } else {
            text = format!("{text} {adverb}");
        }
    };
    match action.size {
        Some(Size::Big) => after("big", rng),
        Some(Size::Small) => after("small", rng),
        None => {}
    }
    if let Some(mood) = action.mood {
        after(mood.word(), rng);
    }
    match action.speed {
        Some(Speed::Slow) => after("slow", rng),
        Some(Speed::Fast) => after("fast", rng),
        None => {}
    }
    let steps_counted = verb.count.is_some_and(|count| count.signal == SignalName::Steps);
    let uncounted_feet = verb.acts == Acts::Feet && verb.count.is_none();
    if let (Some(n), false) = (action.count, steps_counted || uncounted_feet) {
        text = format!("{text} {}", times(n, rng));
    }
    text
}

fn times<R: Rng>(n: u32, rng: &mut R) -> String {
    match (n, rng.random_bool(0.7)) {
        (1, true) => "once".into(),
        (1, false) => "one time".into(),
        (2, true) => "twice".into(),
        (n, _) => format!("{} times", number(n)),
    }
}

fn number(n: u32) -> String {
    const WORDS: [&str; 13] =
        ["zero", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine", "ten", "eleven", "twelve"];
    WORDS.get(n as usize).map_or_else(|| n.to_string(), |word| (*word).into())
}

fn angle<R: Rng>(action: &Action, way: &str, rng: &mut R) -> String {
    let turning = match way {
        "left" => "counterclockwise",
        _ => "clockwise",
    };
    let to = match rng.random_range(0..4) {
        0 => turning.to_string(),
        1 => way.to_string(),
        _ => format!("to the {way}"),
    };
    let Some(degrees) = action.degrees else { return to };
    let named = match degrees {
        90 => Some("by a quarter turn"),
        180 => Some("by half a turn"),
        _ => None,
    };
    match named.filter(|_| rng.random_bool(0.5)) {
        Some(named) => format!("{to} {named}"),
        None => format!("{to} by {degrees} degrees"),
    }
}

/// Returns the phrase with the words in brackets in this form.
pub(crate) fn inflected(template: &str, form: Form) -> String {
    let mut out = String::new();
    let mut rest = template;
    while let Some((before, more)) = rest.split_once('[') {
        let Some((word, after)) = more.split_once(']') else { break };
        out += before;
        out += &match form {
            Form::Base => word.to_string(),
            Form::Third => third(word),
            Form::Gerund => gerund(word),
        };
        rest = after;
    }
    out + rest
}

fn third(word: &str) -> String {
    if word == "do" || word == "go" || ["s", "sh", "ch", "x", "z"].iter().any(|end| word.ends_with(end)) {
        return format!("{word}es");
    }
    match word.strip_suffix('y') {
        Some(stem) if !stem.ends_with(['a', 'e', 'o', 'u']) => format!("{stem}ies"),
        _ => format!("{word}s"),
    }
}

fn gerund(word: &str) -> String {
    // Short vowel, one consonant: it doubles.
    const DOUBLED: [&str; 16] = [
        "nod", "clap", "step", "shrug", "squat", "flap", "jog", "put", "stop", "rap", "bob", "trot", "grab", "strut",
        "trip", "tap",
    ];
    const ALSO: [&str; 37] = [
        "tug", "jab", "hop", "drag", "spin", "signal", "slap", "dip", "scan", "pat", "rub", "hug", "chop", "plug",
        "strum", "swim", "whip", "hit", "dab", "beg", "stir", "drum", "bat", "scrub", "wag", "cut", "mop", "sip",
        "dig", "plan", "run", "swat", "sob", "grip", "skip", "sit", "split",
    ];
    if DOUBLED.contains(&word) || ALSO.contains(&word) || word == "drop" {
        let last = word.chars().last().unwrap_or_default();
        return format!("{word}{last}ing");
    }
    match word.strip_suffix('e') {
        Some(stem) if !stem.ends_with(['e', 'o']) => format!("{stem}ing"),
        _ => format!("{word}ing"),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::facts::Side;
    use lifelike_checkpoint::rng::stream;

    #[test]
    fn verbs_are_inflected() {
        for (word, s, ing) in [
            ("wave", "waves", "waving"),
            ("do", "does", "doing"),
            ("push", "pushes", "pushing"),
            ("nod", "nods", "nodding"),
            ("carry", "carries", "carrying"),
            ("sway", "sways", "swaying"),
            ("step", "steps", "stepping"),
            ("throw", "throws", "throwing"),
        ] {
            assert_eq!((third(word).as_str(), gerund(word).as_str()), (s, ing));
        }
    }

    #[test]
    fn sentences_say_every_fact_and_leave_no_slot() {
        let grammar = Grammar::builtin().unwrap();
        let mut rng = stream(1, "words", 0, 0);
        for verb in &grammar.verbs {
            let action = Action {
                side: verb.side,
                direction: verb.direction,
                count: verb.count.map(|_| 3),
                speed: Some(Speed::Slow),
                ..Action::of(&verb.name)
            };
            let facts = Facts { relation: Relation::Single, actions: vec![action.clone()], held_out: None };
            for new in [false, true] {
                let slow = if new { &grammar.new_adverbs["slow"] } else { &grammar.adverbs["slow"] };
                for text in captions(&grammar, &facts, new, 8, &mut rng).unwrap() {
                    assert!(!text.contains(['{', '}', '[', ']']) && !text.contains("  "), "{text}");
                    assert!(slow.iter().any(|word| text.contains(word)), "{text}");
                    assert!(action.count.is_none() || text.contains("three"), "{text}");
                    if let Some(side @ (Side::Left | Side::Right)) = action.side {
                        assert!(text.contains(side.word()), "{text}");
                    }
                }
            }
        }
    }
}
