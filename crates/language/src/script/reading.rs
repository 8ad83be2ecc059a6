//! Reading by rules, by the network, or by both.

use std::collections::BTreeSet;

use super::beside::without_negations;
use super::learned::{Stretch, Taken};
use super::mirrored::{add_mirror_image, divided};
use super::phrases::{Fit, Meaning};
use super::postures::{AT_THE_END, Described, Segment, described, overlaid, segments};
use super::reader::{Before, MOST_WITHIN, Piece, Reader};
use super::said::said;
use super::situations::Reaction;
use super::spelling::spelt;
use super::split::{Join, is_participle, normal, pieces};
use super::{Clause, Impossible, Script};
use crate::grammar::Acts;
use crate::posture::Posture;

/// Certainty from which the network is followed where rules leave words over, and where they do not. Chosen on sentences
/// that the network was not trained on (`docs/results/language.md`).
const OPEN: f64 = 0.2;
const CLOSED: f64 = 0.55;
/// Certainty below which an action of the network is none, where it is sure of another.
const UNLIKELY: f64 = 0.25;
/// Certainty below which a reading by the network is said to be a guess.
const SURE: f64 = 0.5;
/// Certainty below which a reading by the network does not take an action of the rules away: where they leave words over,
/// and where they do not.
const GUESS: f64 = 0.4;
const CERTAIN: f64 = 0.6;
/// Certainty below which a reading by the network does not divide a row of actions otherwise than phrases do: where they
/// leave no words over, and where they do.
const ROW: f64 = 0.55;
const ROW_OPEN: f64 = 0.2;
/// Certainty from which the network's action is neither a situation nor a posture.
const VERY_SURE: f64 = 0.8;
/// Probability from which an action is named for words that were not understood.
const NAMED: f64 = 0.1;

/// Certainty from which a description by the network is followed where rules read it all otherwise.
const DESCRIBED: f64 = 0.6;

/// Most repetitions of a whole sentence.
const MOST_REPEATED: u32 = 10;

/// Way to read a sentence.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Reading {
    /// By phrases and rules alone.
    Rules,
    /// By the network, which divides the sentence and names the actions; rules read numbers, sides and ways.
    Network,
    /// By the network where it is certain and the rules leave something open.
    Both,
}

/// Reading by the network.
struct ByNetwork {
    script: Script,
    /// The least certainty of its actions; 0 where it finds none.
    certainty: f64,
    /// Words that ask for an action.
    asking: BTreeSet<String>,
}

impl Reader<'_> {
    /// Reads a sentence. Everything that was not understood is in the result.
    pub fn read(&self, text: &str) -> Script {
        self.read_by(text, Reading::Both)
    }

    /// Reads a sentence in one of the ways.
    pub fn read_by(&self, text: &str, way: Reading) -> Script {
        match way {
            Reading::Rules => self.read_within(text, MOST_WITHIN),
            Reading::Network => self.read_by_network(text).script,
            Reading::Both => self.once(self.with_held_leans(self.with_kept_hands(self.read_by_both(text)))),
        }
    }

    /// Reads a sentence by both. "Repeat it" does everything before it again, "on the other side" its mirror image.
    fn read_by_both(&self, text: &str) -> Script {
        if let Some((before, after)) = divided(text) {
            let mut script = self.read_by_both(&before);
            add_mirror_image(&mut script);
            script.append(self.read_by_both(&after));
            return script;
        }
        let Some((before, times)) = repeated(text) else { return self.read_once(text) };
        let mut script = self.read_once(&before);
        let clauses = std::mem::take(&mut script.clauses);
        script.clauses = (0..=times).flat_map(|_| clauses.iter().cloned()).collect();
        script
    }

    /// Reads a sentence that asks for no repetition of what stands before.
    fn read_once(&self, text: &str) -> Script {
        let named = self.with_objects(text);
        let text = named.as_str();
        let script = self.read_actions(text);
        let has_pair = |script: &Script| {
            script.clauses.iter().any(|clause| clause.actions.len() > 1 || !clause.postures.is_empty())
        };
        // A pair that only the network sees may be another place that hands touch, or a guess.
        let is_guess = || has_pair(&script) && !has_pair(&self.read_within(text, MOST_WITHIN));
        // A description that was divided from the rest is read already.
        if script.clauses.iter().any(Clause::is_only_postures) {
            return script;
        }
        let found = overlaid(&self.phrases, text).filter(|(_, posture, is_detailed)| {
            !has_pair(&script)
                || *is_detailed
                || is_guess() && (posture.touches.is_some() || self.certainty(text) < SURE)
        });
        let Some((rest, posture, _)) = found else { return script };
        if is_open(&self.read_within(&rest, MOST_WITHIN)) {
            return script;
        }
        let mut below = self.read_actions(&rest);
        let Some(last) = below.clauses.last_mut().filter(|last| self.has_free_arms(last)) else { return script };
        last.postures.push(posture);
        below.notes.extend(self.corrections(text));
        below
    }

    /// Returns a text with "it" as the thing named last, where a phrase does the same to that thing: "draw a sword, swing it".
    fn with_objects(&self, text: &str) -> String {
        const BEFORE: [&str; 17] = [
            "a", "an", "the", "his", "her", "your", "my", "their", "its", "heavy", "big", "large", "small", "little",
            "light", "huge", "tiny",
        ];
        let mut words = normal(text);
        let places: Vec<usize> = (1..words.len()).filter(|at| words[*at] == "it").collect();
        if places.is_empty() {
            return text.to_owned();
        }
        let mut is_changed = false;
        for at in places {
            let is_thing = |thing: &usize| {
                BEFORE.contains(&words[thing - 1].as_str()) && !BEFORE.contains(&words[*thing].as_str())
            };
            let things = (1..at.saturating_sub(1)).filter(is_thing).rev();
            let does = |thing: &usize| {
                let mut phrase = vec![words[at - 1].clone(), "the".to_owned(), words[*thing].clone()];
                let is_whole = self.whole(&phrase).is_some();
                phrase.extend(words.get(at + 1).cloned());
                is_whole || self.whole(&phrase).is_some()
            };
            if let Some(thing) = things.into_iter().find(does) {
                // "Put the box down": without its article a box is a punch.
                words[at] = format!("the {}", words[thing]);
                is_changed = true;
            }
        }
        if is_changed { words.join(" ").replace('|', ".") } else { text.to_owned() }
    }

    /// Returns notes on the words of a text that are read as others, or left out.
    fn corrections(&self, text: &str) -> Vec<String> {
        let mut notes = Vec::new();
        let words = spelt(&self.phrases, normal(text), &mut notes);
        without_negations(words, &mut notes);
        notes
    }

    /// Reads the actions of a sentence.
    fn read_actions(&self, text: &str) -> Script {
        let mut rules = self.read_within(text, MOST_WITHIN);
        let understood = |text: &str| !is_open(&self.read_within(text, MOST_WITHIN));
        let ByNetwork { script: network, certainty, asking } = self.read_by_network(text);
        let names_one = certainty >= VERY_SURE && names_one_action(&network);
        let segments = segments(&self.phrases, text, is_open(&rules), understood);
        let agrees = !is_open(&rules) && verbs(&rules) == verbs(&network);
        let is_named = |segments: &Vec<Segment>| names_one && is_one_posture(segments, text, agrees);
        if let Some(segments) = segments.filter(|segments| !is_named(segments)) {
            return self.read_segments(text, segments);
        }
        let says_little = is_open(&rules) || verbs(&rules) == ["stand"];
        let is_one = |one: &Reaction<'_>| {
            let is_clear = one.is_clear && is_open(&rules) && certainty < SURE;
            is_clear || rules.clauses.len() <= 1 && network.clauses.len() <= 2
        };
        // "Walk tired, as after a long day" asks for a walk; "someone throws a ball at you" for none.
        let words = normal(text);
        let begins = |(_, part): &(Join, Vec<String>)| self.phrases.is_main_verb(&part[0]) && !is_participle(&part[0]);
        let asks = !rules.clauses.is_empty() && pieces(&words).iter().any(begins);
        let happens =
            words.first().is_some_and(|word| ["someone", "somebody", "its", "theres"].contains(&word.as_str()))
                && words.iter().any(|word| ["you", "your", "u", "ur"].contains(&word.as_str()));
        // "Move your right leg out so that the foot is off the floor" asks for the leg.
        const LIMBS: [&str; 10] = ["leg", "arm", "hand", "foot", "knee", "elbow", "legs", "arms", "wrist", "fist"];
        let sides = |two: &[String]| ["left", "right"].contains(&two[0].as_str()) && LIMBS.contains(&two[1].as_str());
        let asks = asks || words.windows(2).any(sides);
        let fits = |one: &Reaction<'_>| {
            let is_told = one.is_clear && !names_one || happens || certainty < SURE;
            !asks && (says_little || happens) && is_one(one) && is_told
        };
        if let Some(reaction) = self.reaction(text).filter(fits) {
            let note = format!("read as a situation: {}", reaction.means);
            let mut script = self.read_within(reaction.means, MOST_WITHIN);
            script.notes.push(note);
            return script;
        }
        if network.clauses.iter().any(|clause| !clause.postures.is_empty())
            && (certainty > DESCRIBED || certainty > OPEN && is_open(&rules))
            && network.unknown.len() <= rules.unknown.len()
        {
            return network;
        }
        // A guess makes nothing possible.
        if !rules.impossible.is_empty() && certainty < SURE {
            return rules;
        }
        let least = if is_open(&rules) { OPEN } else { CLOSED };
        // A movement that no verb is, by the network, may have parameters that rules read.
        let knows_less = !network.unknown.is_empty() && !is_open(&rules);
        let is_same = verbs(&rules) == verbs(&network);
        // A guess that leaves out an action of the rules.
        let knows_most = rules.unknown.len() <= 1 && network.impossible.is_empty();
        let guess = if is_open(&rules) { GUESS } else { CERTAIN };
        let loses = certainty < guess && knows_most && is_part(&verbs(&network), &verbs(&rules));
        if is_same && certainty > SURE {
            // Words of a story around ask for nothing.
            rules.unknown.retain(|text| text.split(' ').any(|word| asking.contains(word)));
        }
        // "Sit like an exhausted old man" is no walk: the manner is the rules', and so is the action.
        const GAITS_OF_MOODS: [&str; 2] = ["walk_tired", "walk_proud"];
        let has_mood = |script: &Script| {
            script.clauses.iter().flat_map(|clause| &clause.actions).any(|action| action.mood.is_some())
        };
        let is_manner = network.impossible.is_empty()
            && has_mood(&rules)
            && (!is_open(&rules) || !words.iter().any(|word| self.phrases.base(word) == "walk"))
            && verbs(&network).iter().any(|verb| GAITS_OF_MOODS.contains(verb) && !verbs(&rules).contains(verb));
        // The network cannot name what is newer than it.
        let has_newer = knows_most && (verbs(&rules).iter().any(|verb| self.is_newer(verb)) || self.says_newer(text));
        // A piece of which a phrase says every word is no story around.
        let is_less = network.impossible.is_empty() && is_part(&verbs(&network), &verbs(&rules));
        let drops = !is_open(&rules) && is_less && self.drops(&words, &network);
        // "Wave angrily" is a wave.
        let is_kind = |verb: &&str| verbs(&rules).iter().any(|of| verb.strip_prefix(of).is_some());
        let is_other = !self.names(&words, &network) && !verbs(&network).iter().any(is_kind);
        let by_name = !is_open(&rules) && self.names(&words, &rules) && is_other;
        let lacks = loses
            || by_name
            || splits_more(&rules, &network)
            || knows_less
            || drops
            || self.keeps_row(&words, &rules, &network, certainty);
        if is_same || lacks || has_newer || is_manner || certainty < least { rules } else { network }
    }

    /// Reads the parts of a sentence that has described postures.
    fn read_segments(&self, text: &str, segments: Vec<Segment>) -> Script {
        let mut script = Script { notes: self.corrections(text), ..Script::default() };
        for segment in segments {
            match segment {
                Segment::Postures(clause) => script.clauses.push(clause),
                Segment::Words(text) => {
                    script.append(self.read_by_both(&text));
                }
            }
        }
        script
    }

    /// Returns whether a phrase is of a verb or compound that is newer than the network.
    fn is_of_newer(&self, fit: &Fit) -> bool {
        !matches!(fit.meaning, Meaning::Instead(_)) && !self.learned.knows(fit.meaning)
    }

    /// Returns whether words hold the name of each verb of a script. There are many kinds of walks.
    fn names(&self, words: &[String], script: &Script) -> bool {
        let bases: BTreeSet<String> = words.iter().map(|word| self.phrases.base(word)).collect();
        let is_named =
            |verb: &&str| *verb != "walk" && verb.split('_').all(|part| bases.contains(&self.phrases.base(part)));
        verbs(script).iter().all(is_named)
    }

    /// Returns whether a script lacks the verb of a sentence's part that a phrase explains as a whole.
    fn drops(&self, words: &[String], script: &Script) -> bool {
        let verbs = verbs(script);
        let is_lost = |fit: Fit| match fit.meaning {
            Meaning::Verb(number) => !verbs.contains(&self.grammar().verbs[number].name.as_str()),
            _ => false,
        };
        let parts = pieces(words);
        let phrase = |(join, part): &(Join, Vec<String>)| {
            let rest: Vec<String> = part.iter().filter(|word| !self.phrases.filler.contains(*word)).cloned().collect();
            let is_verb = part.len() > 1 || self.phrases.is_main_verb(&part[0]);
            let is_said = |fit: &Fit| fit.has_verb && is_verb || *join == Join::Then;
            self.fit(part).filter(|fit| is_said(fit) && !rest.is_empty() && self.explains(fit, &rest))
        };
        let lost = parts.iter().skip(1).filter(|part| phrase(part).is_some_and(is_lost)).count();
        verbs.len() < parts.len() && lost > 0 && script.clauses.len() + lost <= parts.len()
    }

    /// Returns whether phrases name an action in more parts of a row than the network does, or in all of them.
    fn keeps_row(&self, words: &[String], rules: &Script, network: &Script, certainty: f64) -> bool {
        let parts = pieces(words);
        let acting = parts.iter().filter(|(_, part)| self.acts(part)).count();
        let count = |script: &Script| {
            let actions = script.clauses.iter().map(|clause| clause.actions.len() + clause.postures.len());
            actions.sum::<usize>() + script.impossible.len()
        };
        let is_lost = |text: &String| text.split(' ').any(|word| self.phrases.is_main_verb(word));
        let keeps = acting > 1 && count(rules) >= acting && !rules.unknown.iter().any(is_lost);
        let least = if is_open(rules) { ROW_OPEN } else { ROW };
        keeps && certainty < least && (count(network) < acting || acting == parts.len())
    }

    /// Returns whether a phrase explains the verbs of a part of a sentence, and most of its words.
    fn acts(&self, part: &[String]) -> bool {
        let Some(fit) = self.fit(part).filter(|fit| fit.has_verb) else { return false };
        let said = said(part);
        let is_said = |word: &&String| fit.explained.contains(&self.phrases.base(word)) || said.used.contains(word);
        let open: Vec<&String> =
            part.iter().filter(|word| !self.phrases.filler.contains(*word) && !is_said(word)).collect();
        !open.iter().any(|word| self.phrases.is_main_verb(word)) && 2 * open.len() <= part.len()
    }

    /// Returns whether a verb is newer than the network.
    fn is_newer(&self, verb: &str) -> bool {
        let number = self.grammar().verbs.iter().position(|known| known.name == verb);
        number.is_some_and(|number| !self.learned.knows(Meaning::Verb(number)))
    }

    /// Returns whether a part of a sentence is of a verb or compound that is newer than the network.
    fn says_newer(&self, text: &str) -> bool {
        pieces(&normal(text)).iter().any(|(join, words)| {
            let fit = self.fit(words).filter(|fit| fit.has_verb || *join == Join::Then);
            fit.is_some_and(|fit| self.is_of_newer(&fit))
        })
    }

    /// Returns the reaction to a situation that a sentence tells.
    fn reaction(&self, text: &str) -> Option<Reaction<'_>> {
        self.situations.reaction(&self.phrases, &normal(text))
    }

    /// Returns how sure the network is of a sentence: the least certainty of its actions, 0 where it finds none.
    pub fn certainty(&self, text: &str) -> f64 {
        self.read_by_network(text).certainty
    }

    /// Reads a sentence by the network.
    fn read_by_network(&self, text: &str) -> ByNetwork {
        let mut script = Script::default();
        let words = spelt(&self.phrases, normal(text), &mut script.notes);
        let words = without_negations(words, &mut script.notes);
        // "Step left", "nod nod nod".
        let counts = words.iter().any(|word| word == "step") || words.windows(2).any(|two| two[0] == two[1]);
        let words = self.opened(if counts { self.counted_words(words) } else { words });
        let stretches = settled(self.learned.read(&words));
        let is_taken = |one: &&Stretch| one.taken != Taken::Other || one.certainty >= UNLIKELY;
        let certainty = stretches.iter().filter(is_taken).map(|one| one.certainty).reduce(f64::min).unwrap_or(0.0);
        let asking = stretches.iter().flat_map(|one| one.words.iter().cloned()).collect();
        let mut before = Before::default();
        for Stretch { join, words, taken, certainty } in stretches {
            match taken {
                // The network cannot name a verb that is newer than it; a phrase that says every word does.
                _ if let Some(fit) = self.whole(&words).filter(|fit| self.is_of_newer(fit)) => {
                    self.perform(&mut script, &Piece { join, words, fit: Some(fit) }, &mut before, MOST_WITHIN);
                }
                // So is one that the network only guesses.
                _ if certainty < SURE
                    && let Some(fit) = self.said_by_phrase(&words) =>
                {
                    self.perform(&mut script, &Piece { join, words, fit: Some(fit) }, &mut before, MOST_WITHIN);
                }
                Taken::For(meaning) => {
                    let explained = words.iter().map(|word| self.phrases.base(word)).collect();
                    let fit = Fit { meaning, score: certainty, explained, has_verb: true };
                    if certainty < SURE {
                        let text = words.join(" ");
                        let name = self.name(meaning);
                        script.notes.push(format!("'{text}' is taken for '{name}', {:.0}% sure", 100.0 * certainty));
                    }
                    self.perform(&mut script, &Piece { join, words, fit: Some(fit) }, &mut before, MOST_WITHIN);
                    self.lead_by(&mut script, join);
                }
                // A phrase that says every word is known better.
                Taken::Impossible if let Some(fit) = self.whole(&words) => {
                    self.perform(&mut script, &Piece { join, words, fit: Some(fit) }, &mut before, MOST_WITHIN);
                }
                Taken::Impossible => {
                    let instead = match self.fit(&words).map(|fit| fit.meaning) {
                        Some(Meaning::Instead(number)) => Some(&self.phrases.instead[number]),
                        _ => None,
                    };
                    script.impossible.push(Impossible {
                        said: words.join(" "),
                        because: instead.map_or("no motion here does that".into(), |one| one.because.clone()),
                        nearest: instead.and_then(|one| one.verb.clone()),
                        at: script.clauses.len(),
                    });
                }
                Taken::Other => script.unknown.push(words.join(" ")),
                Taken::Posture => self.describe(&mut script, join, &words),
            }
        }
        ByNetwork { script, certainty, asking }
    }

    /// Adds a description of limbs: during the last action where a join says so and its arms are free, else after it.
    fn describe(&self, script: &mut Script, join: Join, words: &[String]) {
        let Some(Described { mut clause, open, left_out }) = described(&self.phrases, words) else {
            let piece = Piece { join, words: words.to_vec(), fit: self.fit(words) };
            match piece.fit {
                Some(_) => self.perform(script, &piece, &mut Before::default(), MOST_WITHIN),
                None => script.unknown.push(words.join(" ")),
            }
            return;
        };
        script.notes.extend((!left_out.is_empty()).then(|| format!("left out: {}", left_out.join(" "))));
        let is_along = matches!(join, Join::While | Join::With);
        let is_of_arms = matches!(&clause.postures[..], [posture] if posture.moves_only_arms());
        match script.clauses.last_mut().filter(|last| is_along && is_of_arms && self.has_free_arms(last)) {
            Some(last) => last.postures.append(&mut clause.postures),
            None => script.clauses.push(clause),
        }
        // "Hands on the shoulders, and draw circles with the elbows".
        for text in open {
            let read = self.read_within(&text, MOST_WITHIN);
            match is_open(&read) {
                true => script.unknown.push(text),
                false => script.append(read),
            }
        }
    }

    /// Returns whether a clause is one action whose arms may be somewhere.
    fn has_free_arms(&self, clause: &Clause) -> bool {
        let is_free = |verb: &str| {
            let verb = self.grammar().verb(verb);
            verb.is_ok_and(|verb| !matches!(verb.acts, Acts::Hand | Acts::Hands) && verb.name != "stand")
        };
        clause.actions.len() == 1 && clause.postures.is_empty() && is_free(&clause.actions[0].verb)
    }

    /// Puts arms that are described before an action into it: "hands behind the head, march".
    fn lead_by(&self, script: &mut Script, join: Join) {
        let [.., described, action] = &script.clauses[..] else { return };
        let is_of_arms = described.is_only_postures()
            && matches!(&described.postures[..], [posture] if posture.moves_only_arms() && posture.hold <= AT_THE_END);
        if matches!(join, Join::Comma | Join::While) && is_of_arms && self.has_free_arms(action) {
            let at = script.clauses.len() - 2;
            let described = script.clauses.remove(at);
            script.clauses[at].postures = described.postures;
        }
    }

    /// Returns the verb or compound of which a phrase explains all words.
    fn whole(&self, words: &[String]) -> Option<Fit> {
        let is_action = |fit: &Fit| !matches!(fit.meaning, Meaning::Instead(_)) && fit.has_verb;
        self.fit(words).filter(|fit| is_action(fit) && self.explains(fit, words))
    }

    /// Returns the phrase of a verb that explains all words but adverbs, sides and numbers.
    fn said_by_phrase(&self, words: &[String]) -> Option<Fit> {
        let said = said(words);
        let rest: Vec<String> = words.iter().filter(|word| !said.used.contains(word)).cloned().collect();
        self.fit(words).filter(|fit| {
            !matches!(fit.meaning, Meaning::Instead(_)) && fit.has_verb && rest.len() > 1 && self.explains(fit, &rest)
        })
    }

    /// Returns whether a phrase explains all words.
    fn explains(&self, fit: &Fit, words: &[String]) -> bool {
        const NOTHING: [&str; 11] = ["a", "an", "the", "your", "you", "please", "his", "her", "their", "times", "time"];
        let is_said = |word: &String| fit.explained.contains(&self.phrases.base(word));
        let is_number = |word: &String| word.parse::<f64>().is_ok();
        words.iter().all(|word| is_said(word) || is_number(word) || NOTHING.contains(&word.as_str()))
    }

    /// Returns the likeliest action for a text that was not understood, and its probability.
    pub fn nearest(&self, text: &str) -> Option<(String, f64)> {
        let (meaning, probability) = self.learned.likeliest(&normal(text))?;
        Some((self.name(meaning), probability)).filter(|_| probability > NAMED)
    }

    fn name(&self, meaning: Meaning) -> String {
        match meaning {
            Meaning::Verb(verb) => self.grammar().verbs[verb].name.replace('_', " "),
            Meaning::Compound(number) => self.phrases.compounds[number].clone(),
            Meaning::Instead(_) => String::new(),
        }
    }
}

/// Returns stretches without guesses. One with the same action as the stretch before says more of it ("hop, whichever foot, six times").
/// An unlikely action beside something sure is none.
fn settled(stretches: Vec<Stretch>) -> Vec<Stretch> {
    let is_any_sure = stretches.iter().any(|one| one.certainty >= SURE);
    let mut out: Vec<Stretch> = Vec::with_capacity(stretches.len());
    for mut one in stretches {
        let same = out.last_mut().filter(|last| last.taken == one.taken && matches!(one.taken, Taken::For(_)));
        match same.filter(|_| one.certainty < SURE && one.join != Join::Then) {
            Some(last) => {
                last.words.push(",".into());
                last.words.append(&mut one.words);
            }
            None => {
                if is_any_sure && one.certainty < UNLIKELY {
                    one.taken = Taken::Other;
                }
                out.push(one);
            }
        }
    }
    out
}

/// Returns whether a script is one action that a verb names.
fn names_one_action(script: &Script) -> bool {
    let is_one =
        matches!(&script.clauses[..], [clause] if clause.actions.len() == 1 && clause.actions[0].verb != "stand");
    is_one && script.unknown.is_empty() && script.impossible.is_empty()
}

/// Returns whether a sentence is one posture of arms without an angle, which a verb may name as well. If rules and network
/// do not agree on the verb, that is only a sentence of one piece.
fn is_one_posture(segments: &[Segment], text: &str, agrees: bool) -> bool {
    let [Segment::Postures(clause)] = segments else { return false };
    let is_plain = |posture: &Posture| posture.moves_only_arms() && !posture.is_combined();
    let words = normal(text);
    let is_one = matches!(&clause.postures[..], [posture] if is_plain(posture));
    is_one && (agrees || pieces(&words).len() == 1) && !words.iter().any(|word| word == "degrees")
}

/// Returns what stands before "repeat it twice" at the end of a sentence, and how often it is repeated.
fn repeated(text: &str) -> Option<(String, u32)> {
    const WHAT: [&str; 16] = [
        "it",
        "that",
        "this",
        "everything",
        "all",
        "the",
        "whole",
        "thing",
        "sequence",
        "again",
        "of",
        "once",
        "more",
        "times",
        "and",
        "|",
    ];
    let words = normal(text);
    let repeats = words.iter().rposition(|word| word == "repeat" || word == "repeats");
    let at = repeats.or_else(|| done_again(&words))?;
    let after = &words[at + 1..];
    let said = said(after);
    let is_all = after.iter().all(|word| WHAT.contains(&word.as_str()) || said.used.contains(word));
    let joins = |word: &&String| [",", "and", "then", "|"].contains(&word.as_str());
    let kept = at - words[..at].iter().rev().take_while(joins).count();
    let before: Vec<&str> = words[..kept].iter().map(|word| if word == "|" { "." } else { word }).collect();
    (is_all && !before.is_empty()).then(|| (before.join(" "), said.count.unwrap_or(1).clamp(1, MOST_REPEATED)))
}

/// Returns where "do it all again" begins, at the end of words.
fn done_again(words: &[String]) -> Option<usize> {
    let at = words.iter().rposition(|word| word == "do" || word == "does")?;
    let is_whole =
        words.get(at + 1).is_some_and(|word| ["it", "that", "everything", "all", "this"].contains(&word.as_str()));
    (is_whole && words[at..].iter().any(|word| word == "again")).then_some(at)
}

/// Returns whether rules that leave nothing over divide a sentence more: more actions with counts ("3 steps forward 2 steps back 1
/// jump"), or the same verb again ("punch left, right, left").
fn splits_more(rules: &Script, network: &Script) -> bool {
    let counted = |script: &Script| {
        let actions = script.clauses.iter().flat_map(|clause| &clause.actions);
        actions.filter(|action| action.count.is_some()).count()
    };
    let row = verbs(rules);
    let is_row = row.len() > verbs(network).len() && row.windows(2).all(|two| two[0] == two[1]);
    !is_open(rules) && (is_row || counted(rules) > 1 && counted(network) < counted(rules))
}

/// Returns whether rules left something of a sentence over, or guessed.
fn is_open(script: &Script) -> bool {
    script.clauses.is_empty() || !script.unknown.is_empty()
}

/// Returns whether sorted verbs are some of others, and not all. Standing is said of every end.
fn is_part(some: &[&str], all: &[&str]) -> bool {
    let moves = |verbs: &[&str]| verbs.iter().filter(|verb| **verb != "stand").count();
    let mut rest = all.iter();
    !some.is_empty() && moves(some) < moves(all) && some.iter().all(|verb| rest.any(|other| other == verb))
}

/// Returns the verbs of a script, sorted.
fn verbs(script: &Script) -> Vec<&str> {
    let actions = script.clauses.iter().flat_map(|clause| &clause.actions);
    let mut verbs: Vec<&str> = actions.map(|action| action.verb.as_str()).collect();
    verbs.sort_unstable();
    verbs
}
