//! Scripts that another program writes: what it is told, and what it answers.

use std::fmt::Write;

use lifelike_character::Anatomy;
use lifelike_character::anatomy::Role;

use super::limbs::is_above;
use super::reader::Reader;
use super::said::Said;
use super::{Clause, Script};
use crate::error::LanguageError;
use crate::facts::{Action, Direction, Side};
use crate::grammar::{Acts, Grammar, Synth, Verb};

const BRIEF: &str = include_str!("brief.md");
/// Part of the brief for a robot whose head does not turn.
const STIFF_NECK: &str = "
# This robot

Its head does not turn or nod, so a posture has no `head`. Looks to the side are turns of the trunk, or of the body by steps where they last.
Looks up and down are leans of the trunk, a nod is a small bow.
";
/// Phrases of a verb in the brief.
const PHRASES: usize = 3;

impl Grammar {
    /// Returns a text by which a language model, or a person, writes scripts for a robot: the form, examples, the verbs, and what
    /// the robot lacks.
    pub fn brief(&self, anatomy: &Anatomy) -> String {
        let mut text = BRIEF.to_owned();
        for verb in &self.verbs {
            let phrases: Vec<String> = verb.say.iter().take(PHRASES).map(|text| plain(text)).collect();
            let given = given(verb);
            let given = if given.is_empty() { String::new() } else { format!("; {}", given.join(", ")) };
            let _ = writeln!(text, "{}: {}{given}: {}", verb.name, part(verb.acts), phrases.join(", "));
        }
        if !anatomy.places.contains_key(&Role::Head) {
            text += STIFF_NECK;
        }
        text
    }
}

/// Returns a phrase without its marks.
fn plain(phrase: &str) -> String {
    let plain = phrase.replace(['[', ']', '{', '}'], "");
    plain.replace("nsteps", "").replace("steps", "").trim().to_owned()
}

fn part(acts: Acts) -> &'static str {
    match acts {
        Acts::Hand => "one hand",
        Acts::Hands => "both hands",
        Acts::Foot => "one foot",
        Acts::Head => "head",
        Acts::Body => "body",
        Acts::Feet => "feet",
    }
}

/// Returns what may be said of a verb beside speed, size and mood.
fn given(verb: &Verb) -> Vec<&'static str> {
    let has_way = matches!(verb.direction, Some(Direction::Left | Direction::Right));
    let travels = verb.acts == Acts::Feet
        && (verb.cycle.is_some() || matches!(verb.synth, Some(Synth::Sideways | Synth::Diagonal)))
        && verb.direction != Some(Direction::InPlace);
    let turns = matches!(verb.synth, Some(Synth::Turn | Synth::Curve));
    let all = [
        (matches!(verb.side, Some(Side::Left | Side::Right)) || verb.is_of_each_hand(), "side"),
        (has_way, "direction"),
        (verb.count.is_some(), "count"),
        (turns || verb.bends || verb.angles, "degrees"),
        (travels || verb.synth == Some(Synth::Curve), "metres"),
    ];
    all.into_iter().filter(|(is_given, _)| *is_given).map(|(_, name)| name).collect()
}

impl Reader<'_> {
    /// Reads a script that another program wrote by [`Grammar::brief`]: one JSON object, perhaps with words around it.
    ///
    /// Numbers that a verb has not become repetitions or notes, as those of sentences do.
    ///
    /// # Errors
    /// [`LanguageError::Grammar`] for a text without an object, an unknown key or verb, or actions that are not done at once.
    pub fn reply(&self, text: &str) -> Result<Script, LanguageError> {
        let object = text.find('{').zip(text.rfind('}')).and_then(|(from, to)| text.get(from..=to));
        let object = object.ok_or_else(|| LanguageError::Grammar("expected a JSON object, got none".into()))?;
        let mut script: Script =
            serde_json::from_str(object).map_err(|e| LanguageError::Grammar(format!("no script: {e}")))?;
        let Script { clauses, notes, .. } = &mut script;
        for clause in clauses {
            self.settle(clause, notes)?;
        }
        if script.clauses.is_empty() && script.impossible.is_empty() && script.unknown.is_empty() {
            return Err(LanguageError::Grammar("expected a clause, or something impossible, got none".into()));
        }
        if !script.clauses.is_empty() {
            script.check(self.grammar).map_err(LanguageError::Grammar)?;
        }
        Ok(script)
    }

    /// Gives the actions of a clause what their verbs need, and puts the upper one of two first.
    fn settle(&self, clause: &mut Clause, notes: &mut Vec<String>) -> Result<(), LanguageError> {
        for action in &mut clause.actions {
            let verb = self.grammar.verb(&action.verb)?;
            let (settled, times) = self.action(verb, &said_of(action), notes);
            *action = settled;
            clause.times = clause.times.max(1).saturating_mul(times);
        }
        if let [one, other] = &clause.actions[..] {
            let verbs = (self.grammar.verb(&one.verb)?, self.grammar.verb(&other.verb)?);
            if !is_above((verbs.0, one), (verbs.1, other)) && is_above((verbs.1, other), (verbs.0, one)) {
                clause.actions.reverse();
            }
        }
        Ok(())
    }
}

/// Returns an action as what is said of its verb.
fn said_of(action: &Action) -> Said {
    let Action { side, direction, count, degrees, metres, speed, size, mood, .. } = action.clone();
    let sides = [side, side, side];
    Said { side, sides, direction, count, degrees, metres, speed, size, mood, ..Said::default() }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use std::collections::BTreeMap;

    use super::*;
    use crate::fixtures;

    #[test]
    fn examples_of_the_brief_are_scripts() {
        let grammar = Grammar::builtin().unwrap();
        let reader = Reader::new(&grammar).unwrap();
        let examples: Vec<&str> = BRIEF.lines().filter(|line| line.starts_with("{\"clause\": [{")).collect();
        let read: Vec<String> = examples.iter().map(|line| reader.reply(line).unwrap().to_string()).collect();
        assert_eq!(read[0], "wave, left side while: march, in place, 8 times; then bow, 55 degrees");
        assert_eq!(
            read[1],
            "right arm to the side 88 degrees, elbow bent 90, forearm up, head turned left 55, held 4 s; then squat, 5 times, fast"
        );
        assert_eq!(read.len(), 4);
        assert_eq!(reader.reply(examples[3]).unwrap().impossible.len(), 1);
        let (_, lima) = fixtures::lima();
        assert!(!grammar.brief(&lima).contains("# This robot"));
        let brief = grammar.brief(&Anatomy { places: BTreeMap::new(), ..lima });
        assert!(grammar.verbs.iter().all(|verb| brief.contains(&format!("\n{}: ", verb.name))));
        assert!(brief.ends_with(STIFF_NECK));
    }

    #[test]
    fn a_reply_is_settled_or_refused() {
        let grammar = Grammar::builtin().unwrap();
        let reader = Reader::new(&grammar).unwrap();
        // Words around, the legs first, and a count that is no verb's.
        let text = "Sure!\n```json\n{\"clause\": [{\"action\": [{\"verb\": \"walk\"}, {\"verb\": \"wave\", \"side\": \"left\"}]}, {\"action\": [{\"verb\": \"hug\", \"count\": 2}]}]}\n```";
        let script = reader.reply(text).unwrap();
        assert_eq!(script.to_string(), "wave, left side while: walk, forward; then hug, both side, 2 times");
        let error = |text: &str| reader.reply(text).unwrap_err().to_string();
        assert!(error("no").contains("JSON object"), "{}", error("no"));
        assert!(error(r#"{"clause": [{"action": [{"verb": "fly"}]}]}"#).contains("fly"));
        assert!(
            error(r#"{"clause": [{"action": [{"verb": "walk"}, {"verb": "squat"}]}]}"#).contains("different limbs")
        );
        assert!(error(r#"{"clauses": []}"#).contains("unknown field `clauses`"));
        assert!(error("{}").contains("expected a clause"));
        assert!(reader.reply(r#"{"impossible": [{"said": "fly", "because": "no wings"}]}"#).is_ok());
    }
}
