//! Words beside an action: what is not to be done, how long it is held, which hand does it.

use super::said::said;
use crate::facts::Side;

/// Drops what is not to be done: from "don't", "not" or "without" to the next word that joins.
pub(super) fn without_negations(words: Vec<String>, notes: &mut Vec<String>) -> Vec<String> {
    const JOINS: [&str; 6] = ["and", "but", "then", ",", "|", "just"];
    let mut out: Vec<String> = Vec::new();
    let mut dropped: Vec<String> = Vec::new();
    for word in words {
        let is_answer = word == "no" && out.last().is_some_and(|last| last.starts_with("say") || last == "head");
        let begins = !is_answer && ["dont", "never", "without", "not", "no"].contains(&word.as_str());
        if begins || !dropped.is_empty() && !JOINS.contains(&word.as_str()) {
            if begins && out.last().is_some_and(|last| last == "do") {
                out.pop();
            }
            dropped.push(word);
            continue;
        }
        if !dropped.is_empty() {
            notes.push(format!("left out: {}", dropped.join(" ")));
            dropped.clear();
        }
        out.push(word);
    }
    // "Don't move" asks for something.
    let is_still = |word: &String| ["move", "moving", "budge"].contains(&word.as_str());
    if out.is_empty() && dropped.iter().any(is_still) {
        return vec!["stand".into(), "still".into()];
    }
    if !dropped.is_empty() {
        notes.push(format!("left out: {}", dropped.join(" ")));
    }
    out
}

/// Words that hold what was done before.
pub(super) const HOLDS: [&str; 20] = [
    "hang", "hangs", "stay", "stays", "hold", "holds", "keep", "keeps", "remain", "remains", "staying", "holding",
    "keeping", "there", "it", "that", "them", "pose", "position", "still",
];

/// Returns whether words say only how long something is held.
pub(super) fn is_hold(words: &[String]) -> bool {
    let said = said(words);
    let fillers = ["for", "in", "this", "the", "a", "your", "like", "about"];
    let is_way = |word: &String| ["up", "down", "low"].contains(&word.as_str());
    let is_part = |word: &String| HOLDS.contains(&word.as_str()) || is_way(word) || fillers.contains(&word.as_str());
    let holds = words.first().is_some_and(|word| HOLDS[..13].contains(&word.as_str()));
    let stays = words.len() > 1 && words.iter().all(|word| HOLDS.contains(&word.as_str()) || is_way(word));
    (said.seconds.is_some() || stays)
        && holds
        && words.iter().all(|word| is_part(word) || said.used.contains(word) || word == "seconds")
}

/// Returns whether a word after others is where somebody goes: "to the door".
pub(super) fn is_goal(before: &[String]) -> bool {
    const TO: [&str; 9] = ["to", "toward", "towards", "into", "through", "from", "past", "across", "around"];
    let articles = ["the", "a", "an", "your", "my", "his", "her"];
    matches!(before, [.., to, the] if TO.contains(&to.as_str()) && articles.contains(&the.as_str()))
}

/// Returns the side of the hand that words begin with.
pub(super) fn of_hand(words: &[String]) -> Option<Side> {
    let mut words = words
        .iter()
        .map(String::as_str)
        .skip_while(|word| ["the", "your", "ur", "with", "his", "her", "you", "hold", "keep", "put"].contains(word));
    let side = match words.next()? {
        "left" => Side::Left,
        "right" => Side::Right,
        _ => return None,
    };
    words.next().filter(|word| ["hand", "arm"].contains(word)).map(|_| side)
}

/// Returns the words after "the other", "the other hand" or "the other one".
pub(super) fn of_the_other(words: &[String]) -> Option<Vec<String>> {
    let from = usize::from(words.first().is_some_and(|word| word == "the"));
    if words.get(from).is_none_or(|word| word != "other") {
        return None;
    }
    let limb = words.get(from + 1).is_some_and(|word| ["hand", "arm", "one"].contains(&word.as_str()));
    let rest = words[from + 1 + usize::from(limb)..].to_vec();
    // "The other stays on the hip": that of a hand.
    let rests = rest.iter().any(|word| word == "on") && rest.iter().any(|word| word.starts_with("hip"));
    let hand = rests.then(|| "hand".to_string());
    Some(hand.into_iter().chain(rest).collect::<Vec<_>>()).filter(|rest| !rest.is_empty())
}

/// Drops "and" between sides, which joins no actions: "left and right".
pub(super) fn held_together(words: Vec<String>) -> Vec<String> {
    const PAIRS: [(&str, &str); 6] =
        [("left", "right"), ("right", "left"), ("up", "down"), ("fro", "to"), ("to", "fro"), ("back", "forth")];
    let word = |i: usize| words.get(i).map_or("", String::as_str);
    let joins = |i: usize| word(i) == "and" && i > 0 && PAIRS.contains(&(word(i - 1), word(i + 1)));
    (0..words.len()).filter(|i| !joins(*i)).map(|i| words[i].clone()).collect()
}
