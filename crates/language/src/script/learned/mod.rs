//! Reading by a network: which words of a sentence ask for an action, and for which.
//!
//! A word has its vector ([`super::meaning`]) and numbers of its own. Two layers of attention (Vaswani et al. 2017) say of
//! each word whether it begins or continues an action, and of each stretch which action it is. Numbers, sides and ways are
//! read by rule from the stretch. The network was trained on sentences written for it (`data/README.md` of the crate).

mod file;
mod network;
mod reading;
mod sentences;
mod training;

use lifelike_checkpoint::Checkpoint;

use network::Network;
pub(super) use reading::{Learned, Stretch, Taken};
use sentences::Sentence;
pub use training::{ReaderPlan, ReaderScore};

use super::phrases::{Phrases, label_of};
use crate::error::LanguageError;
use crate::grammar::Grammar;

/// Label of what nothing here can do, of movements that no verb is, and of descriptions of limbs.
const IMPOSSIBLE: &str = "impossible";
const OTHER: &str = "other";
const POSTURE: &str = "posture";

/// Trains the network on marked sentences (`{wave|say hello} and {bow|bend low}`) and on the phrases of a grammar.
///
/// `report` gets of each epoch its number, the mean loss, and the score on the sentences held out. Returns the file of the network,
/// and the score of what is stored there.
///
/// # Errors
/// A sentence with a brace that does not close, or with a name that is no verb.
pub fn train_reader(
    grammar: &Grammar,
    marked: &[String],
    held_out: &[String],
    plan: ReaderPlan,
    mut report: impl FnMut(usize, f64, ReaderScore),
) -> Result<(Checkpoint, ReaderScore), LanguageError> {
    let phrases = Phrases::new(grammar)?;
    let labels = labels(grammar, &phrases);
    let number = |name: &str| labels.iter().position(|label| label == name);
    let read = |texts: &[String]| -> Result<Vec<Sentence>, LanguageError> {
        let sentences = texts.iter().map(|text| Sentence::read(text, number).map_err(LanguageError::Grammar));
        sentences.filter(|one| one.as_ref().is_ok_and(|one| !one.words.is_empty()) || one.is_err()).collect()
    };
    let held_out = read(held_out)?;
    let mut all = read(marked)?;
    all.extend(read(&phrases.marked(grammar))?);
    let network = training::trained(&all, labels.clone(), plan, |epoch, loss, network| {
        report(epoch, loss, training::score(network, &held_out));
    })?;
    // What is stored is what counts.
    let file = network.save()?;
    let stored = Network::load(&file.to_bytes().map_err(|e| LanguageError::Grammar(e.to_string()))?)?;
    Ok((file, training::score(&stored, &held_out)))
}

fn labels(grammar: &Grammar, phrases: &Phrases) -> Vec<String> {
    let verbs = grammar.verbs.iter().map(|verb| verb.name.clone());
    let mut compounds: Vec<String> = Vec::new();
    for label in phrases.compounds.iter().map(|text| label_of(text)) {
        // Of two with the same meaning one.
        if !compounds.contains(&label) {
            compounds.push(label);
        }
    }
    verbs.chain(compounds).chain([IMPOSSIBLE, OTHER, POSTURE].map(str::to_string)).collect()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    /// Of the sentences held out, 66% are read as marked (`data/README.md`).
    #[test]
    fn sentences_that_were_held_out_are_read_as_marked() {
        const MARKED: &str = include_str!("../../../data/sentences.txt");
        let grammar = Grammar::builtin().unwrap();
        let labels = labels(&grammar, &Phrases::new(&grammar).unwrap());
        let network = Network::load(reading::WEIGHTS).unwrap();
        // A grammar may have newer verbs at its end; names that were trained on stay.
        let unknown: Vec<&String> = network.labels.iter().filter(|label| !labels.contains(label)).collect();
        assert!(unknown.is_empty(), "train the reader again (`data/README.md`): no longer known are {unknown:?}");
        let number = |name: &str| network.labels.iter().position(|label| label == name);
        let read = MARKED.lines().skip(9).step_by(10).map(|line| Sentence::read(line, number).unwrap());
        let held_out: Vec<Sentence> = read.filter(|one| !one.words.is_empty()).collect();
        let score = training::score(&network, &held_out);
        assert!(score.right as f64 > 0.64 * score.sentences as f64, "{score:?}");
        assert!(score.named[1] as f64 > 0.79 * score.named[0] as f64, "{score:?}");
    }
}
