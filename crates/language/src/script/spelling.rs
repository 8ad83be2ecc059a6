//! Misspelt words.

use super::phrases::Phrases;
use super::said::said;

/// Words that say order, sides, numbers and limbs.
const SPELT: [&str; 25] = [
    "and",
    "then",
    "while",
    "with",
    "after",
    "left",
    "right",
    "both",
    "degrees",
    "seconds",
    "steps",
    "times",
    "twice",
    "once",
    "three",
    "four",
    "five",
    "seven",
    "hand",
    "hands",
    "arms",
    "foot",
    "forward",
    "backward",
    "backwards",
];

/// Corrects words that are none: a letter or two missing, doubled or exchanged.
pub(super) fn spelt(phrases: &Phrases, words: Vec<String>, notes: &mut Vec<String>) -> Vec<String> {
    let corrected = |word: String| match respelt(phrases, &word) {
        Some(found) => {
            notes.push(format!("read '{word}' as '{found}'"));
            found
        }
        None => word,
    };
    words.into_iter().map(corrected).collect()
}

/// Returns the word that was meant by one that is none: a word of a phrase, or one that says a side, a number or an order.
fn respelt(phrases: &Phrases, word: &str) -> Option<String> {
    let letters = word.chars().count();
    let is_word = phrases.is_spelt_right(word) || !word.chars().all(|c| c.is_ascii_lowercase());
    if letters < 3 || is_word || !said(&[word.to_string()]).used.is_empty() {
        return None;
    }
    let known = phrases.vocabulary.iter().map(String::as_str);
    let candidates = SPELT.into_iter().map(|target| (target, false)).chain(known.map(|target| (target, true)));
    // Of equal ones sides and numbers, then the longer one: "salut" is no salt.
    let rank = |target: &str, is_other: bool| Some((misspelling(target, word)?, is_other, usize::MAX - target.len()));
    let costs = candidates.filter_map(|(target, is_other)| Some((rank(target, is_other)?, target)));
    costs.reduce(|best, one| if one.0 < best.0 { one } else { best }).map(|(_, target)| target.to_string())
}

/// Returns the cost of a word as a misspelling of another, where it can be one: a letter missing, doubled or exchanged with
/// its neighbour costs least, another letter more. The first letter is right, or exchanged with the second.
fn misspelling(target: &str, word: &str) -> Option<usize> {
    let (letters, length) = (word.len(), target.len());
    let allowed = if letters >= 6 { 2 } else { 1 };
    if length < 3 || letters.abs_diff(length) > allowed {
        return None;
    }
    let [first, second] = [target, word].map(|text| text.chars().take(2).collect::<Vec<char>>());
    let begins = first[0] == second[0] || first[0] == second[1] && first[1] == second[0];
    let distance = strsim::osa_distance(target, word);
    let exchanged = letters == length && !is_transposed(target, word);
    // Two other letters make another word: a sister does not sit.
    if distance == 2 && (exchanged || letters != length && replaced(target, word) > 0) {
        return None;
    }
    // Of few letters another one makes another word: a book is no boot.
    let too_short = !is_transposed(target, word) && (letters.min(length) < 4 || exchanged && letters < 5);
    let cost = 3 * distance + usize::from(letters != length) + 2 * usize::from(exchanged);
    (begins && distance <= allowed && !too_short).then_some(cost)
}

/// Returns the number of letters that stand in the place of others, beside those that are missing or too many.
fn replaced(a: &str, b: &str) -> usize {
    let count = |text: &str, letter: char| text.chars().filter(|c| *c == letter).count();
    let missing = |a: &str, b: &str| ('a'..='z').map(|c| count(a, c).saturating_sub(count(b, c))).sum::<usize>();
    missing(a, b).min(missing(b, a))
}

/// Returns whether two words differ by two neighbouring letters that changed places.
fn is_transposed(a: &str, b: &str) -> bool {
    let mut of = [a, b].map(|word| word.chars().collect::<Vec<char>>());
    of.iter_mut().for_each(|letters| letters.sort_unstable());
    of[0] == of[1]
}
