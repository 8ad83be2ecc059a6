//! Motions that are made again: those that fell, and scripts that a reader makes better by what physics made of them.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use lifelike_evaluation::{Evaluation, Verdict};
use lifelike_language::grammar::Grammar;
use lifelike_language::script::{Asked, Reader, Script};
use lifelike_motion::clip::Provenance;
use lifelike_robot::Robot;

use super::Args;
use super::made::{self, Made};
use super::maker::{Candidate, Maker};
use super::play::{self, Player};
use super::spoken::{PartReport, Speaker, possible};
use crate::error::CliError;
use crate::output::Output;

/// Other motions of a sentence that are tried where the first falls in physics.
const REDRAWS: usize = 4;
/// Shares of a posture's way that are tried where it falls in physics.
const GENTLER: [f64; 2] = [0.75, 0.5];

/// The means to make a motion again.
pub struct Again<'a> {
    /// The grammar.
    pub grammar: &'a Grammar,
    /// The robot.
    pub robot: &'a Arc<Robot>,
    /// Its policy in physics.
    pub player: &'a Player<'a>,
    /// The networks, where there are some.
    pub maker: Option<&'a Maker>,
    /// Arguments of the command.
    pub args: &'a Args,
    /// Place of progress and warnings.
    pub output: &'a Output,
}

/// Outcome of one motion in physics.
struct Outcome {
    fell: bool,
    untrue: usize,
    lines: String,
}

impl Outcome {
    /// Returns the outcome of a motion with this number.
    fn new(
        speaker: &Speaker<'_>,
        parts: &[PartReport],
        evaluation: &Evaluation,
        number: usize,
    ) -> Result<Self, CliError> {
        let (episode, rollout) = (&evaluation.episodes[number], &evaluation.rollouts[number]);
        let (facts, untrue) = speaker.in_physics(parts, &rollout.played(Provenance::default()))?;
        let planned: String = parts.iter().enumerate().map(|(i, part)| part.line(i + 1)).collect();
        let lines = format!("{planned}{}\n{facts}\n", play::line(episode, &Verdict::of(&[episode])));
        Ok(Self { fell: episode.failure.is_some(), untrue, lines })
    }

    /// Returns its order: falls first count, then untrue facts.
    fn worth(&self) -> (bool, usize) {
        (self.fell, self.untrue)
    }
}

impl Again<'_> {
    /// Draws motions again that fell, at full size and then smaller, until one stands. Returns whether one does.
    pub fn drawn(
        &self,
        speaker: &Speaker<'_>,
        jobs: &[(Vec<String>, PathBuf)],
        scripts: &[Script],
        made: &mut [Made],
        fell: &[usize],
    ) -> Result<bool, CliError> {
        let mut changed = false;
        for number in fell.iter().copied() {
            let (prompts, file) = &jobs[number];
            let full = Script {
                notes: [&scripts[number].notes[..], &["drawn again: the first motion fell in physics".into()]].concat(),
                ..scripts[number].clone()
            };
            let smaller = GENTLER.iter().filter_map(|share| scripts[number].gentler(*share));
            for script in std::iter::once(full).chain(smaller) {
                let others = speaker.make(&script, prompts, self.maker, self.args.seed, 1 + REDRAWS)?;
                let Some(standing) = self.player.standing(others, self.output)? else { continue };
                let took = made[number].sampling_seconds;
                made[number] = self.written((prompts, file), vec![standing], script, took)?;
                changed = true;
                break;
            }
        }
        Ok(changed)
    }

    /// Asks the reader again for motions of which something failed in physics. Returns whether one became better; its script is
    /// among `scripts` then.
    pub fn read(
        &self,
        speaker: &Speaker<'_>,
        jobs: &[(Vec<String>, PathBuf)],
        scripts: &mut [Script],
        made: &mut [Made],
        evaluation: &Evaluation,
    ) -> Result<bool, CliError> {
        let Some(asked) = Asked::new(self.args.reader.as_deref()) else { return Ok(false) };
        let mut changed = false;
        for (number, (prompts, file)) in jobs.iter().enumerate() {
            let seen = (evaluation, number);
            let Some(better) = self.better(&asked, speaker, (prompts, file), &made[number], seen)? else { continue };
            scripts[number] = better.script.clone().unwrap_or_default();
            made[number] = better;
            changed = true;
        }
        Ok(changed)
    }

    /// Writes a motion and its script.
    fn written(
        &self,
        (prompts, file): (&[String], &Path),
        candidates: Vec<Candidate>,
        script: Script,
        took: f64,
    ) -> Result<Made, CliError> {
        let mut one = Made::write(prompts, candidates, file, self.args.keep_all, took, None)?;
        crate::output::write(&made::script_file(file), script.to_toml()?)?;
        one.script = Some(script);
        Ok(one)
    }

    /// Returns a better motion of a sentence, where something of the first failed in physics and the reader finds a script that
    /// does it better. Mistakes of the reader become warnings and change nothing.
    fn better(
        &self,
        asked: &Asked,
        speaker: &Speaker<'_>,
        (prompts, file): (&[String], &Path),
        first: &Made,
        (evaluation, number): (&Evaluation, usize),
    ) -> Result<Option<Made>, CliError> {
        let ([sentence], Some(mut script)) = (prompts, first.script.clone()) else { return Ok(None) };
        let mut outcome = Outcome::new(speaker, &first.parts, evaluation, number)?;
        let reader = Reader::new(self.grammar)?;
        let mut best = None;
        for _ in 0..self.args.revise {
            if outcome.worth() == (false, 0) {
                break;
            }
            let next = match asked.better(&reader, &self.robot.anatomy, sentence, (&script, &outcome.lines)) {
                Ok(next) => possible(&reader, next, prompts, self.args),
                Err(error) => Err(error.into()),
            };
            let next = match next {
                Ok(next) if next.clauses != script.clauses => next,
                Ok(_) => break,
                Err(error) => {
                    tracing::warn!("asked again: {error}");
                    break;
                }
            };
            let Some((next, candidates, after)) = self.made(next, prompts)? else { break };
            if after.worth() >= outcome.worth() {
                break;
            }
            let made = self.written((prompts, file), candidates, next.clone(), first.sampling_seconds)?;
            (script, best, outcome) = (next, Some(made), after);
        }
        Ok(best)
    }

    /// Makes the motion of a script and follows it in physics; nothing where the robot cannot do it.
    fn made(&self, script: Script, prompts: &[String]) -> Result<Option<(Script, Vec<Candidate>, Outcome)>, CliError> {
        let mut scripts = [script];
        let count = self.args.best_of.unwrap_or(self.args.candidates);
        let speaker = Speaker::new(self.grammar, self.robot, &mut scripts, self.args.made_by);
        let [mut script] = scripts;
        let made = speaker.and_then(|speaker| {
            let candidates = speaker.make(&script, prompts, self.maker, self.args.seed, count)?;
            Ok((speaker, candidates))
        });
        let (speaker, candidates) = match made {
            Ok(made) => made,
            Err(error) => {
                tracing::warn!("asked again: {error}");
                return Ok(None);
            }
        };
        let clips: Vec<_> = candidates.iter().take(1).map(|one| one.clip.clone()).collect();
        let evaluation = self.player.evaluation(&clips, self.output)?;
        let parts = candidates.first().map(|one| one.parts.clone()).unwrap_or_default();
        let outcome = Outcome::new(&speaker, &parts, &evaluation, 0)?;
        script.notes.push("read again after physics: less of the first script was done".into());
        Ok(Some((script, candidates, outcome)))
    }
}
