//! A sentence in free words: understood as a script, performed clause by clause, and checked.

use std::sync::Arc;

use lifelike_checkpoint::rng::stream;
use lifelike_generation::representation::{FeatureMatrix, RepresentationSpec};
use lifelike_language::checks::Finding;
use lifelike_language::grammar::{FADE, Generator as Rules, Grammar, words};
use lifelike_language::script::{Asked, Clause, Reader, Script};
use lifelike_motion::edit::{Part, sequence, trim};
use lifelike_motion::{Caption, MotionClip};
use lifelike_robot::{Robot, clips};

use super::Args;
use super::maker::{Candidate, Maker};
use super::verdict::Verdict;
use crate::error::CliError;

/// Motions that the network makes of a clause until one holds all facts, at least.
const TRIES: usize = 4;
/// Distance of the seeds of two candidates.
const NEXT_SEED: u64 = 0xA24B_AED4_963E_E407;

/// Maker of clauses.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum By {
    /// The network; where what it makes does not hold the facts, the grammar's rules.
    Auto,
    /// The network alone.
    Network,
    /// The grammar's rules alone: keyframed clips, repeated, turned and composed.
    Rules,
}

/// A clause as it was performed.
#[derive(Debug, Clone, serde::Serialize)]
pub struct PartReport {
    /// The clause in words.
    pub clause: String,
    /// `network` or `rules`.
    pub by: &'static str,
    /// Begin and end in the clip (s); of what is done several times, of the first.
    pub range: [f64; 2],
    /// Facts that were checked.
    pub findings: Vec<Finding>,
    #[serde(skip)]
    clause_of: Clause,
}

/// Performs scripts on one robot.
pub struct Speaker<'a> {
    grammar: &'a Grammar,
    robot: Arc<Robot>,
    rules: Rules<'a>,
    by: By,
}

/// Reads the sentences of one motion, or the script of a file, and refuses what cannot be done.
pub fn understand(grammar: &Grammar, robot: &Robot, prompts: &[String], args: &Args) -> Result<Script, CliError> {
    if let Some(file) = &args.script {
        return Ok(Script::read(file, grammar)?);
    }
    let reader = Reader::new(grammar)?;
    let asked = Asked::new(args.reader.as_deref());
    let mut script = Script::default();
    for prompt in prompts {
        script.append(match &asked {
            Some(asked) => asked.script(&reader, &robot.anatomy, prompt)?,
            None => reader.read(prompt),
        });
    }
    possible(&reader, script, prompts, args)
}

/// Returns the part of a script that can be done.
///
/// # Errors
/// A script of which nothing can.
pub fn possible(reader: &Reader<'_>, mut script: Script, prompts: &[String], args: &Args) -> Result<Script, CliError> {
    let text = prompts.join(" then ");
    script = if args.nearest { script.with_nearest() } else { script.with_the_rest() };
    if let Some(first) = script.impossible.first() {
        let nearest = first.nearest.as_ref().map_or_else(
            || "nothing near it can be done".to_string(),
            |verb| format!("the nearest is '{}': --nearest does that", verb.replace('_', " ")),
        );
        return Err(CliError::Input(format!("\"{text}\": {first}; {nearest}")));
    }
    if script.clauses.is_empty() {
        let near = reader.nearest(&text).map_or_else(String::new, |(near, probability)| {
            format!("; the likeliest is \"{near}\" ({:.0}% sure)", 100.0 * probability)
        });
        let help = "`lifelike generate --verbs` lists what can be said, --as-is passes the sentence to the network";
        return Err(CliError::Input(format!("\"{text}\": expected a movement, understood none{near}; {help}")));
    }
    Ok(script)
}

impl<'a> Speaker<'a> {
    /// Prepares the verbs of some scripts for a robot. Verbs of a head that does not turn are replaced.
    pub fn new(grammar: &'a Grammar, robot: &'a Arc<Robot>, scripts: &mut [Script], by: By) -> Result<Self, CliError> {
        let mut options = clips::retarget_options(robot);
        clips::limit_speeds(&mut options, robot);
        let rules = Rules::of_scripts(grammar, &robot.character, &robot.anatomy, &options, scripts)?;
        Ok(Self { grammar, robot: Arc::clone(robot), rules, by })
    }

    /// Returns candidates of a script, those with fewest untrue facts first.
    pub fn make(
        &self,
        script: &Script,
        prompts: &[String],
        maker: Option<&Maker>,
        seed: u64,
        count: usize,
    ) -> Result<Vec<Candidate>, CliError> {
        let all = (0..count.max(1)).map(|k| {
            let seed = seed.wrapping_add(NEXT_SEED.wrapping_mul(k as u64));
            let mut one = self.one(script, prompts, maker, seed)?;
            one.candidate = k;
            Ok(one)
        });
        let mut all = all.collect::<Result<Vec<Candidate>, CliError>>()?;
        let untrue = |one: &Candidate| one.parts.iter().flat_map(|part| &part.findings).filter(|f| !f.passed).count();
        all.sort_by(|a, b| {
            untrue(a).cmp(&untrue(b)).then(a.verdict.compare(&b.verdict)).then(a.candidate.cmp(&b.candidate))
        });
        Ok(all)
    }

    fn one(
        &self,
        script: &Script,
        prompts: &[String],
        maker: Option<&Maker>,
        seed: u64,
    ) -> Result<Candidate, CliError> {
        let mut clips = Vec::new();
        let mut parts: Vec<PartReport> = Vec::new();
        let mut begin = 0.0;
        for (i, clause) in script.clauses.iter().enumerate() {
            let (clip, mut findings, by) = self.clause(clause, maker, seed, i as u64)?;
            findings.extend(self.rules.lasting(&clip, clause)?);
            let one = clip.seconds() / f64::from(clause.times.max(1));
            let range = [begin, begin + one];
            begin += clip.seconds() - FADE;
            parts.push(PartReport { clause: clause.to_string(), by, range, findings, clause_of: clause.clone() });
            clips.push(clip);
        }
        let pieces: Vec<Part<'_>> = clips.iter().map(Part::from).collect();
        let mut clip = if let [only] = clips.as_slice() { only.clone() } else { sequence(&pieces, FADE)? };
        let end = clip.seconds();
        clip.cyclic = false;
        clip.provenance.character = self.robot.character.name.clone();
        let text = if prompts.is_empty() { script.to_string() } else { prompts.join(", then ") };
        clip.provenance.captions = vec![Caption { start: 0.0, end, text }];
        let makers: Vec<&str> = parts.iter().map(|part| part.by).collect();
        clip.provenance.source = format!("script of seed {seed}: {script} (by {})", makers.join(", "));
        let verdict = self.verdict(&clip, maker)?;
        Ok(Candidate { clip, verdict, candidate: 0, parts })
    }

    fn verdict(&self, clip: &MotionClip, maker: Option<&Maker>) -> Result<Verdict, CliError> {
        let spec = maker.map(|maker| maker.generator.header().spec.clone());
        let spec = spec.unwrap_or_else(|| RepresentationSpec::of(&self.robot.layout));
        let rows = FeatureMatrix::from_clip(clip, &spec)?;
        Verdict::of(clip, &rows, &self.robot, maker.and_then(|maker| maker.critic.as_ref()))
    }

    /// Makes one clause; returns its motion, its facts, and who made it.
    fn clause(
        &self,
        clause: &Clause,
        maker: Option<&Maker>,
        seed: u64,
        index: u64,
    ) -> Result<(MotionClip, Vec<Finding>, &'static str), CliError> {
        let maker = maker.filter(|_| self.by != By::Rules);
        // What the network composes of two actions skates (docs/results/language.md).
        let whole = self.rules.suits_network(clause)
            || (self.by == By::Network && clause.times <= 1 && clause.postures.is_empty());
        if let Some(maker) = maker.filter(|_| whole) {
            let made = self.learned(maker, clause, seed, index)?;
            let holds = match &made {
                Some((clip, findings)) => self.rules.holds(clip, findings, clause)?,
                None => false,
            };
            if let Some((clip, findings)) = made.filter(|_| holds || self.by == By::Network) {
                return Ok((clip, findings, "network"));
            }
        }
        let made = self.rules.perform(clause, seed, index)?;
        Ok((made.clip, made.findings, "rules"))
    }

    /// Returns the network's motion with the fewest untrue facts; nothing where it makes none of this length.
    fn learned(
        &self,
        maker: &Maker,
        clause: &Clause,
        seed: u64,
        index: u64,
    ) -> Result<Option<(MotionClip, Vec<Finding>)>, CliError> {
        let mut rng = stream(seed, "sentence", index, 0);
        let Some(sentence) = words::captions(self.grammar, &clause.facts(), false, 1, &mut rng)?.pop() else {
            return Ok(None);
        };
        let reader = Reader::new(self.grammar)?;
        if !maker.generator.header().known.has_actions(&sentence, &clause.actions, &reader)? {
            return Ok(None);
        }
        let longest = maker.generator.header().max_seconds;
        if clause.seconds.is_some_and(|seconds| !(1.0..=longest).contains(&seconds)) {
            return Ok(None);
        }
        let options = maker.options;
        let candidates = maker.clauses(
            &sentence,
            clause.seconds.or(options.seconds),
            seed.wrapping_add(index),
            options.candidates.max(TRIES),
        )?;
        let mut best: Option<(usize, MotionClip, Vec<Finding>)> = None;
        for candidate in candidates {
            let findings = self.rules.findings(&candidate.clip, clause)?;
            let untrue = findings.iter().filter(|f| !f.passed).count() + usize::from(!candidate.verdict.feasible);
            let done = untrue == 0 && self.rules.holds(&candidate.clip, &findings, clause)?;
            if done {
                return Ok(Some((candidate.clip, findings)));
            }
            if best.as_ref().is_none_or(|(fewest, ..)| untrue < *fewest) {
                best = Some((untrue.max(1), candidate.clip, findings));
            }
        }
        Ok(best.map(|(_, clip, findings)| (clip, findings)))
    }

    /// Checks the facts again on what physics made of a motion; returns a line and how many do not hold.
    pub fn in_physics(&self, parts: &[PartReport], played: &MotionClip) -> Result<(String, usize), CliError> {
        let (mut held, mut all, mut untrue) = (0, 0, Vec::new());
        for part in parts {
            let end = part.range[1].min(played.seconds());
            if end - part.range[0] < 0.5 {
                untrue.push(format!("{}: not reached", part.clause));
                all += part.findings.len();
                continue;
            }
            let findings =
                self.rules.findings_in_physics(&trim(played, Some(part.range[0]), Some(end))?, &part.clause_of)?;
            all += findings.len();
            held += findings.iter().filter(|finding| finding.passed).count();
            untrue.extend(findings.iter().filter(|f| !f.passed).map(|f| format!("{}: {}", part.clause, said(f))));
        }
        let rest = if untrue.is_empty() { String::new() } else { format!("; {}", untrue.join("; ")) };
        Ok((format!("in physics: {held} of {all} facts hold{rest}"), untrue.len()))
    }
}

impl PartReport {
    /// Returns the clause, its maker and its facts in a line.
    pub fn line(&self, number: usize) -> String {
        let untrue: Vec<String> = self.findings.iter().filter(|f| !f.passed).map(said).collect();
        let held = self.findings.len() - untrue.len();
        let rest = if untrue.is_empty() { String::new() } else { format!(" ({})", untrue.join("; ")) };
        format!("  {number}. {}: by {}, {held} of {} facts hold{rest}\n", self.clause, self.by, self.findings.len())
    }

    /// Returns whether every fact holds.
    pub fn is_true(&self) -> bool {
        self.findings.iter().all(|finding| finding.passed)
    }
}

fn said(finding: &Finding) -> String {
    format!("{}: expected {}, got {}", finding.fact.name(), finding.expected, finding.got)
}

/// Returns what was understood, for people.
pub fn words_of(script: &Script) -> String {
    let mut text = format!("understood: {script}\n");
    if !script.unknown.is_empty() {
        text += &format!("not understood: {}\n", script.unknown.join(", "));
    }
    script.notes.iter().for_each(|note| text += &format!("note: {note}\n"));
    text
}
