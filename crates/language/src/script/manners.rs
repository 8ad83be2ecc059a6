//! Manners in several words, such as "like you just won the lottery", as one word.

use std::sync::LazyLock;

use serde::Deserialize;

const TEXT: &str = include_str!("manners.toml");
/// Words between "like" and what it is like.
const SKIPPED: [&str; 48] = [
    "youd", "theyd", "you", "u", "he", "she", "it", "its", "they", "i", "we", "someone", "somebody", "one", "youve",
    "youre", "hes", "shes", "theyre", "theyve", "have", "has", "had", "are", "is", "were", "was", "been", "just",
    "really", "a", "an", "the", "this", "that", "there", "theres", "your", "some", "ur", "in", "at", "on", "be", "my",
    "his", "her", "very",
];

/// Words before the "like" of a wish.
const ASKS: [&str; 6] = ["would", "id", "i", "we", "wed", "really"];

/// Words of what nobody is happy about, and the manner of it.
const LOSSES: [&str; 8] = ["lost", "died", "dead", "gone", "broke", "broken", "stolen", "hurt"];
const SADLY: &str = "sadly";

/// Words at which a clause ends.
const JOINS: [&str; 7] = [",", "|", "and", "then", "while", "but", "with"];

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Entry {
    means: String,
    alone: Vec<String>,
    like: Vec<String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Table {
    manner: Vec<Entry>,
}

/// A phrase, and the word that it means.
type Phrase = (Vec<String>, String);

/// Phrases, longer ones first.
struct Manners {
    alone: Vec<Phrase>,
    like: Vec<Phrase>,
}

impl Manners {
    fn read() -> Result<Self, toml::de::Error> {
        let table: Table = toml::from_str(TEXT)?;
        let (mut alone, mut like) = (Vec::new(), Vec::new());
        for Entry { means, alone: as_said, like: likened } in table.manner {
            let words = |text: &String| text.split(' ').map(str::to_string).collect::<Vec<_>>();
            alone.extend(as_said.iter().map(|text| (words(text), means.clone())));
            like.extend(likened.iter().map(|text| (without_skipped(&words(text)).to_vec(), means.clone())));
        }
        for phrases in [&mut alone, &mut like] {
            phrases.sort_by_key(|(words, _)| std::cmp::Reverse(words.len()));
        }
        Ok(Self { alone, like })
    }
}

/// Returns words from the first that is not skipped.
fn without_skipped(words: &[String]) -> &[String] {
    let skipped = words.iter().take_while(|word| SKIPPED.contains(&word.as_str())).count();
    &words[skipped.min(words.len().saturating_sub(1))..]
}

/// Returns words with each manner of several words as one.
pub(super) fn with_manners(words: Vec<String>) -> Vec<String> {
    static MANNERS: LazyLock<Option<Manners>> = LazyLock::new(|| Manners::read().ok());
    let Some(manners) = MANNERS.as_ref() else { return words };
    let mut out: Vec<String> = Vec::with_capacity(words.len());
    let mut at = 0;
    while at < words.len() {
        let rest = &words[at..];
        let begins = |(phrase, _): &&Phrase| rest.starts_with(phrase);
        // "I would like you to walk" asks, and likens nothing.
        let asks = out.last().is_some_and(|last| ASKS.contains(&last.as_str()));
        let opening = match (rest[0].as_str(), rest.get(1).map(String::as_str)) {
            ("like", _) if asks => 0,
            ("as", Some("if" | "though")) => 2,
            ("like", Some("as")) => 2,
            ("like", _) => 1,
            _ => 0,
        };
        let likened = without_skipped(&rest[opening.min(rest.len())..]);
        let is_like = |(phrase, _): &&Phrase| opening > 0 && likened.starts_with(phrase);
        let alone = manners.alone.iter().find(begins).map(|(phrase, means)| (phrase.len(), means));
        let like =
            manners.like.iter().find(is_like).map(|(phrase, means)| (rest.len() - likened.len() + phrase.len(), means));
        match alone.or(like) {
            Some((length, means)) => {
                // "As if your puppy got lost" is no joy of puppies.
                let mut more = rest[length..].iter().take_while(|word| !JOINS.contains(&word.as_str()));
                let is_loss = means == "happily" && more.any(|word| LOSSES.contains(&word.as_str()));
                let means = if is_loss { SADLY } else { means.as_str() };
                // "Walk proudly with your chest out": a manner of the same, said once.
                let is_piece = rest.get(length).is_none_or(|word| JOINS.contains(&word.as_str()));
                if is_piece && out.len() > 1 && out.last().is_some_and(|last| last == "with") {
                    out.pop();
                }
                if out.last().is_none_or(|last| last != means) {
                    out.push(means.to_string());
                }
                // The rest of a clause about somebody, or about one who does something, says no more.
                let is_clause = opening > 0 && likened.len() < rest.len() - opening
                    || rest.get(length).is_some_and(|word| ["who", "that", "which"].contains(&word.as_str()));
                let more = rest[length..].iter().take_while(|word| !JOINS.contains(&word.as_str())).count();
                at += length + if is_clause && opening > 0 { more } else { 0 };
            }
            None => {
                out.push(words[at].clone());
                at += 1;
            }
        }
    }
    out
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::super::said::said;
    use super::*;

    #[test]
    fn every_manner_is_read_by_a_rule() {
        let table: Table = toml::from_str(TEXT).unwrap();
        for entry in &table.manner {
            let read = said(std::slice::from_ref(&entry.means));
            assert!(read.mood.is_some() || read.speed.is_some() || read.size.is_some(), "{}", entry.means);
        }
        let manner = |text: &str| with_manners(text.split(' ').map(str::to_string).collect()).join(" ");
        assert_eq!(manner("walk like you just lost your best friend"), "walk sadly");
        assert_eq!(manner("walk as if you had won the lottery and wave"), "walk happily and wave");
        assert_eq!(manner("dance like nobodys watching"), "dance wildly");
        assert_eq!(manner("walk like a duck"), "walk like a duck");
        assert_eq!(manner("i would like you to walk"), "i would like you to walk");
        let table: Table = toml::from_str(TEXT).unwrap();
        for text in table.manner.iter().flat_map(|entry| &entry.like) {
            let words: Vec<String> = text.split(' ').map(str::to_string).collect();
            let kept = without_skipped(&words);
            assert!(kept.len() > 1 || kept[0].len() > 2, "'{text}' is matched by '{}' alone", kept[0]);
        }
    }
}
