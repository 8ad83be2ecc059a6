//! A sentence as motion: understood as a script, made by the network where every fact holds, else by the grammar's rules.

use std::collections::BTreeMap;
use std::sync::{Mutex, OnceLock, PoisonError};

use lifelike_generation::generator::Generator;
use lifelike_language::LanguageError;
use lifelike_language::grammar::{Generator as Rules, Grammar};
use lifelike_language::script::{Asked, Clause, Reader, Script};
use lifelike_motion::MotionClip;
use lifelike_motion::edit::trim;
use lifelike_motion::resample::resample;
use lifelike_robot::{Robot, clips};

use crate::StudioError;

/// A sentence that was understood, for one robot.
pub(crate) struct Understood<'a> {
    script: Script,
    rules: Rules<'a>,
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

/// Returns the script of a sentence: by another program where one was named, which is asked once for every
/// robot and sentence.
fn script(reader: &Reader<'_>, robot: &Robot, sentence: &str) -> Result<Script, LanguageError> {
    static ANSWERS: Mutex<BTreeMap<(String, String), Script>> = Mutex::new(BTreeMap::new());
    let Some(asked) = OTHER.get().cloned().flatten().or_else(|| Asked::new(None)) else {
        return Ok(reader.read(sentence));
    };
    let key = (robot.name.clone(), sentence.to_owned());
    let known = ANSWERS.lock().unwrap_or_else(PoisonError::into_inner).get(&key).cloned();
    if let Some(known) = known {
        return Ok(known);
    }
    let script = asked.script(reader, &robot.anatomy, sentence)?;
    ANSWERS.lock().unwrap_or_else(PoisonError::into_inner).insert(key, script.clone());
    Ok(script)
}

/// Command that reads sentences, where one was named.
static OTHER: OnceLock<Option<Asked>> = OnceLock::new();

/// Lets a command read sentences in every scene of this process, such as a language model. Only the first call counts.
pub fn read_by(command: Option<&str>) {
    OTHER.get_or_init(|| Asked::new(command));
}

fn failed(error: LanguageError) -> StudioError {
    StudioError::Operation(error.to_string())
}

impl<'a> Understood<'a> {
    /// Reads a sentence; nothing where no movement is in it, so that the network alone decides.
    ///
    /// # Errors
    /// [`StudioError::Operation`] for what cannot be done, or not by this robot, with the reason and the nearest that can.
    pub fn read(sentence: &str, seconds: Option<f64>, robot: &'a Robot) -> Result<Option<Self>, StudioError> {
        let (grammar, reader) = language().map_err(failed)?;
        let mut script = script(reader, robot, sentence).map_err(failed)?.with_the_rest();
        if let Some(one) = script.impossible.first() {
            let nearest =
                one.nearest.as_ref().map_or(String::new(), |verb| format!("; try '{}'", verb.replace('_', " ")));
            return Err(StudioError::Operation(format!("{one}{nearest}")));
        }
        if let (Some(seconds), [clause]) = (seconds, script.clauses.as_mut_slice()) {
            clause.seconds = Some(seconds);
        }
        if script.clauses.is_empty() {
            return Ok(None);
        }
        let mut options = clips::retarget_options(robot);
        clips::limit_speeds(&mut options, robot);
        let scripts = std::slice::from_mut(&mut script);
        let rules = Rules::of_scripts(grammar, &robot.character, &robot.anatomy, &options, scripts).map_err(failed)?;
        Ok(Some(Self { script, rules }))
    }

    /// Returns the script in a line, with what was not understood and what is done in another's place.
    pub fn words(&self) -> String {
        let unknown = match self.script.unknown.as_slice() {
            [] => String::new(),
            words => format!(" (not understood: {})", words.join(", ")),
        };
        let notes: String = self.script.notes.iter().map(|note| format!(" ({note})")).collect();
        format!("{}{unknown}{notes}", self.script)
    }

    /// Returns the one clause that a network may make.
    fn plain(&self) -> Option<&Clause> {
        let [clause] = self.script.clauses.as_slice() else { return None };
        self.rules.suits_network(clause).then_some(clause)
    }

    /// Returns whether the network was trained on what the sentence asks for.
    pub fn was_learned(&self, generator: &Generator, sentence: &str) -> bool {
        let Some(clause) = self.plain() else { return false };
        language().is_ok_and(|(_, reader)| {
            generator.header().known.has_actions(sentence, &clause.actions, reader).unwrap_or(false)
        })
    }

    /// Returns whether the network's motion from a time on (s) is the whole sentence, with every fact.
    ///
    /// # Errors
    /// [`StudioError::Operation`] for a motion that cannot be cut.
    pub fn holds(&self, clip: &MotionClip, from: f64) -> Result<bool, StudioError> {
        let Some(clause) = self.plain() else { return Ok(false) };
        let rest = trim(clip, Some(from), None)?;
        let Ok(findings) = self.rules.findings(&rest, clause) else { return Ok(false) };
        self.rules.holds(&rest, &findings, clause).map_err(failed)
    }

    /// Returns the motion by rule, at the robot's rate.
    ///
    /// # Errors
    /// [`StudioError::Operation`] for a motion that the robot cannot do.
    pub fn by_rules(&self, seed: u64, robot: &Robot) -> Result<MotionClip, StudioError> {
        let said = self.rules.say(&self.script, seed).map_err(failed)?;
        Ok(resample(&said, robot.control_hz)?)
    }
}
