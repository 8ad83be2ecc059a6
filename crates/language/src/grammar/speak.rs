//! Scripts as motion of one robot: what the command line and the studio share.

use lifelike_character::{Anatomy, Character};
use lifelike_motion::MotionClip;
use lifelike_motion::edit::{Part, sequence};
use lifelike_motion::retarget::RetargetOptions;

use super::generator::Generator;
use super::perform::FADE;
use super::table::Grammar;
use crate::checks::{Fact, Finding};
use crate::error::LanguageError;
use crate::facts::Size;
use crate::script::{Clause, Script};

/// Largest error of an angle (degrees).
const DEGREES: f64 = 10.0;

impl<'a> Generator<'a> {
    /// Prepares the verbs of some scripts for a robot. Verbs of a head that does not turn are replaced, and noted.
    ///
    /// # Errors
    /// [`LanguageError::Grammar`] for a verb that this robot cannot do, with the reason.
    pub fn of_scripts(
        grammar: &'a Grammar,
        character: &'a Character,
        anatomy: &'a Anatomy,
        options: &RetargetOptions,
        scripts: &mut [Script],
    ) -> Result<Self, LanguageError> {
        let prepared = |verbs: &[String]| {
            let verbs: Vec<&str> = verbs.iter().map(String::as_str).collect();
            Self::of_verbs(grammar, character, anatomy, options.clone(), &verbs)
        };
        let mut generator = prepared(&verbs(scripts))?;
        let left_out: Vec<&str> = generator.left_out.iter().map(|(verb, _)| verb.as_str()).collect();
        let mut changed = false;
        for script in scripts.iter_mut() {
            changed |= script.without_head(&left_out, grammar);
        }
        if changed {
            generator = prepared(&verbs(scripts))?;
        }
        let wanted = verbs(scripts);
        match generator.left_out.iter().find(|(verb, _)| wanted.contains(verb)) {
            Some((verb, why)) => Err(LanguageError::Grammar(format!("'{}' cannot do '{verb}': {why}", character.name))),
            None => Ok(generator),
        }
    }

    /// Makes a whole script by rule.
    ///
    /// # Errors
    /// As [`Self::perform`].
    pub fn say(&self, script: &Script, seed: u64) -> Result<MotionClip, LanguageError> {
        let made = script.clauses.iter().zip(0..).map(|(clause, index)| self.perform(clause, seed, index));
        let made = made.collect::<Result<Vec<_>, _>>()?;
        let parts: Vec<Part<'_>> = made.iter().map(|made| Part::from(&made.clip)).collect();
        let mut clip = sequence(&parts, FADE)?;
        clip.cyclic = false;
        Ok(clip)
    }

    /// Returns whether a shipped network may make a clause. It was trained before moods moved arms that are free, and before
    /// small gestures came near the body.
    pub fn suits_network(&self, clause: &Clause) -> bool {
        let mut verbs = clause.actions.iter().filter_map(|action| self.grammar().verb(&action.verb).ok());
        let has_manner = clause.actions.iter().any(|action| action.mood.is_some() || action.size == Some(Size::Small));
        clause.is_plain() && !has_manner && verbs.all(|verb| !verb.remade)
    }

    /// Returns whether the facts of a clause hold in a motion, its angle and its duration among them. `findings` are those
    /// of [`Self::findings`].
    ///
    /// # Errors
    /// As [`Self::findings`].
    pub fn holds(&self, clip: &MotionClip, findings: &[Finding], clause: &Clause) -> Result<bool, LanguageError> {
        let wanted = clause.actions.first().and_then(|action| action.degrees);
        let is_turned = |finding: &Finding| match (finding.fact, finding.got.parse::<f64>(), wanted) {
            (Fact::Degrees, Ok(got), Some(wanted)) => (got - f64::from(wanted)).abs() <= DEGREES,
            _ => true,
        };
        let lasts = self.lasting(clip, clause)?.is_none_or(|finding| finding.passed);
        Ok(lasts && findings.iter().all(|finding| finding.passed && is_turned(finding)))
    }
}

fn verbs(scripts: &[Script]) -> Vec<String> {
    let clauses = scripts.iter().flat_map(|script| &script.clauses);
    clauses.flat_map(|clause| &clause.actions).map(|action| action.verb.clone()).collect()
}
