//! A sentence as motion: understood as a script, made by the network where every fact holds, else by the grammar's rules.

use std::sync::OnceLock;

use lifelike_generation::generator::Generator;
use lifelike_language::LanguageError;
use lifelike_language::grammar::{FADE, Generator as Rules, Grammar};
use lifelike_language::script::{Reader, Script};
use lifelike_motion::MotionClip;
use lifelike_motion::edit::{Part, sequence, trim};
use lifelike_motion::resample::resample;
use lifelike_robot::{Robot, clips};

use crate::StudioError;

/// A sentence that was understood.
pub(crate) struct Understood {
    script: Script,
}

/// Returns the grammar and its reader, which are made once: the reader compares words with thousands of phrases.
fn language() -> Result<(&'static Grammar, &'static Reader<'static>), LanguageError> {
    static GRAMMAR: OnceLock<Grammar> = OnceLock::new();
    static READER: OnceLock<Reader<'static>> = OnceLock::new();
    let grammar = match GRAMMAR.get() {
        Some(grammar) => grammar,
        None => {
            let made = Grammar::builtin()?;
            GRAMMAR.get_or_init(|| made)
        }
    };
    let reader = match READER.get() {
        Some(reader) => reader,
        None => {
            let made = Reader::new(grammar)?;
            READER.get_or_init(|| made)
        }
    };
    Ok((grammar, reader))
}

fn failed(error: LanguageError) -> StudioError {
    StudioError::Operation(error.to_string())
}

impl Understood {
    /// Reads a sentence; nothing where no movement is in it, so that the network alone decides.
    ///
    /// # Errors
    /// [`StudioError::Operation`] for what cannot be done, with the reason and the nearest that can.
    pub fn read(sentence: &str, seconds: Option<f64>) -> Result<Option<Self>, StudioError> {
        let (_, reader) = language().map_err(failed)?;
        let mut script = reader.read(sentence).with_the_rest();
        if let Some(one) = script.impossible.first() {
            let nearest =
                one.nearest.as_ref().map_or(String::new(), |verb| format!("; try '{}'", verb.replace('_', " ")));
            return Err(StudioError::Operation(format!("{one}{nearest}")));
        }
        if let (Some(seconds), [clause]) = (seconds, script.clauses.as_mut_slice()) {
            clause.seconds = Some(seconds);
        }
        Ok((!script.clauses.is_empty()).then_some(Self { script }))
    }

    /// Returns the script in a line, with what was not understood.
    pub fn words(&self) -> String {
        let unknown = match self.script.unknown.as_slice() {
            [] => String::new(),
            words => format!(" (not understood: {})", words.join(", ")),
        };
        format!("{}{unknown}", self.script)
    }

    /// Returns whether the sentence asks for what the network does not do exactly: an angle, a duration, a posture,
    /// several actions.
    pub fn is_exact(&self) -> bool {
        let [clause] = self.script.clauses.as_slice() else { return true };
        let angle = clause.actions.iter().any(|action| action.degrees.is_some());
        let is_plain = clause.times <= 1 && clause.actions.len() == 1 && clause.postures.is_empty();
        angle || !is_plain || clause.seconds.is_some()
    }

    /// Returns whether the network was trained on the verbs of the sentence.
    pub fn was_learned(&self, generator: &Generator, sentence: &str) -> bool {
        let [clause] = self.script.clauses.as_slice() else { return false };
        language().is_ok_and(|(_, reader)| {
            generator.header().known.has_actions(sentence, &clause.actions, reader).unwrap_or(false)
        })
    }

    fn rules<'a>(&'a self, robot: &'a Robot) -> Result<Rules<'a>, StudioError> {
        let (grammar, _) = language().map_err(failed)?;
        let mut options = clips::retarget_options(robot);
        clips::limit_speeds(&mut options, robot);
        let actions = self.script.clauses.iter().flat_map(|clause| &clause.actions);
        let verbs: Vec<&str> = actions.map(|action| action.verb.as_str()).collect();
        Rules::of_verbs(grammar, &robot.character, &robot.anatomy, options, &verbs).map_err(failed)
    }

    /// Returns whether the network's motion from a time on (s) is the whole sentence, with every fact.
    ///
    /// # Errors
    /// [`StudioError::Operation`] for a verb that the robot cannot do.
    pub fn holds(&self, clip: &MotionClip, from: f64, robot: &Robot) -> Result<bool, StudioError> {
        let [clause] = self.script.clauses.as_slice() else { return Ok(false) };
        let rest = trim(clip, Some(from), None)?;
        let findings = self.rules(robot)?.findings(&rest, clause);
        Ok(findings.is_ok_and(|findings| findings.iter().all(|finding| finding.passed)))
    }

    /// Returns the motion by rule.
    ///
    /// # Errors
    /// [`StudioError::Operation`] for a verb that the robot cannot do.
    pub fn by_rules(&self, seed: u64, robot: &Robot) -> Result<MotionClip, StudioError> {
        let rules = self.rules(robot)?;
        let clauses = self.script.clauses.iter().zip(0..);
        let made = clauses.map(|(clause, index)| rules.perform(clause, seed, index).map(|made| made.clip));
        let made = made.collect::<Result<Vec<_>, _>>().map_err(failed)?;
        let joined = sequence(&made.iter().map(Part::from).collect::<Vec<_>>(), FADE)?;
        let mut clip = resample(&joined, robot.control_hz)?;
        clip.cyclic = false;
        Ok(clip)
    }
}
