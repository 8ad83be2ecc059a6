//! `lifelike dataset check`: is what the captions promise true?

use std::collections::BTreeMap;
use std::path::PathBuf;

use lifelike_language::checks::{Fact, Finding, Tracks, check};
use lifelike_language::{CaptionedSet, Entry, Facts, LanguageError, Split};
use lifelike_motion::edit::mirror;
use lifelike_robot::Robot;
use rayon::prelude::*;
use serde_json::json;

use super::grammar::load_grammar;
use super::{extent, extent_table};
use crate::error::CliError;
use crate::output::{Output, table};
use crate::progress::Progress;

/// Failed clips that the table lists.
const LISTED: usize = 10;

/// Check a captioned data set: the index, and what the captions promise, exactly.
///
/// Which limb acts, how often, which way, how far it turns, how fast and how large is measured by forward kinematics.
/// Nothing is learned, so the same checks judge a generator. Clips without facts (captures) are counted only.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  lifelike dataset check data/lima/grammar
  lifelike dataset check data/lima/grammar --split held_out
  # the checks must fail on mirror images
  lifelike dataset check data/lima/grammar --mirrored --limit 500
  lifelike --json dataset check data/lima/grammar | jq .facts")]
pub struct Args {
    /// The data set's folder.
    pub folder: PathBuf,
    /// The robot: a name, or an MJCF or URDF file.
    #[arg(short, long, default_value = "lima")]
    pub robot: String,
    /// Only this split: train, validation, test or held_out.
    #[arg(long)]
    pub split: Option<String>,
    /// So many clips at most, spread over the data set.
    #[arg(long)]
    pub limit: Option<usize>,
    /// Check the mirror image of every clip that has a side against the unmirrored caption: all must fail.
    #[arg(long)]
    pub mirrored: bool,
    /// The grammar that the facts are of, if not the built-in one.
    #[arg(long)]
    pub grammar: Option<PathBuf>,
}

/// Runs the command.
pub fn run(args: &Args, output: &Output) -> Result<(), CliError> {
    let split = args.split.as_deref().map(parse_split).transpose()?;
    let grammar = load_grammar(args.grammar.as_deref())?;
    let robot = Robot::load(&args.robot)?;
    let set = CaptionedSet::read(&args.folder)?;
    // What has no side is true of the mirror image too.
    let asked = |facts: &Facts| !args.mirrored || facts.mirrored() != *facts;
    let wanted: Vec<&Entry> = set
        .entries
        .iter()
        .filter(|entry| entry.facts.as_ref().is_some_and(asked) && split.is_none_or(|split| split == entry.split))
        .collect();
    let every = args.limit.map_or(1, |limit| wanted.len().div_ceil(limit.max(1)).max(1));
    let wanted: Vec<&Entry> = wanted.into_iter().step_by(every).collect();
    let progress = Progress::new(output, "checking", wanted.len() as u64);
    let bar = progress.shared();
    let one = |entry: &&Entry| -> Result<Vec<Finding>, LanguageError> {
        let mut clip = set.clip(entry)?;
        if args.mirrored {
            clip = mirror(&clip, &robot.character)?;
        }
        let tracks = Tracks::of(&clip, &robot.character, &robot.anatomy)?;
        let found = entry.facts.as_ref().map_or(Ok(Vec::new()), |facts| check(&tracks, &grammar, facts));
        bar.inc(1);
        found
    };
    let findings: Vec<Result<Vec<Finding>, LanguageError>> = wanted.par_iter().map(one).collect();
    progress.finish();
    let mut facts: BTreeMap<(Split, Fact), [usize; 2]> = BTreeMap::new();
    let mut clips: BTreeMap<Split, [usize; 2]> = BTreeMap::new();
    let mut failed = Vec::new();
    for (entry, found) in wanted.iter().zip(findings) {
        let found = found?;
        for finding in &found {
            let count = facts.entry((entry.split, finding.fact)).or_default();
            count[0] += usize::from(finding.passed);
            count[1] += 1;
        }
        let passed = found.iter().all(|finding| finding.passed);
        let count = clips.entry(entry.split).or_default();
        count[0] += usize::from(passed);
        count[1] += 1;
        if let Some(first) = found.into_iter().find(|finding| !finding.passed) {
            failed.push((entry.file.clone(), first));
        }
    }
    let rate = |[passed, all]: &[usize; 2]| *passed as f64 / (*all).max(1) as f64;
    let by_fact: Vec<_> = facts
        .iter()
        .map(|((split, fact), count)| json!({ "split": split, "fact": fact, "checked": count[1], "rate": rate(count) }))
        .collect();
    let by_clip: Vec<_> = clips
        .iter()
        .map(|(split, count)| json!({ "split": split, "checked": count[1], "rate": rate(count) }))
        .collect();
    let failures: Vec<_> = failed.iter().map(|(file, finding)| json!({ "file": file, "finding": finding })).collect();
    let value = json!({ "splits": extent(&set), "facts": by_fact, "clips": by_clip, "failed": failures });
    output.result(&value, || {
        if wanted.is_empty() {
            return format!("{}\nno clip with facts to check\n", extent_table(&set));
        }
        let percent = |count: Option<&[usize; 2]>| {
            count.map_or("-".to_string(), |count| format!("{:.1} % of {}", 100.0 * rate(count), count[1]))
        };
        let splits: Vec<Split> = clips.keys().copied().collect();
        let row = |name: &str, of: &dyn Fn(Split) -> Option<[usize; 2]>| -> Vec<String> {
            std::iter::once(name.to_string()).chain(splits.iter().map(|s| percent(of(*s).as_ref()))).collect()
        };
        let mut rows = vec![row("every fact of a clip", &|split| clips.get(&split).copied())];
        for fact in Fact::ALL {
            rows.push(row(fact.name(), &|split| facts.get(&(split, fact)).copied()));
        }
        let head: Vec<&str> =
            std::iter::once("passed (higher is better)").chain(splits.iter().map(|s| s.name())).collect();
        let mut text = format!("{}\n{}", extent_table(&set), table(&head, &rows));
        for (file, f) in failed.iter().take(if args.mirrored { 0 } else { LISTED }) {
            text += &format!("{file}: {} {}: expected {}, got {}\n", f.verb, f.fact.name(), f.expected, f.got);
        }
        text
    })
}

fn parse_split(name: &str) -> Result<Split, CliError> {
    let names = Split::ALL.map(Split::name).join(", ");
    let found = Split::ALL.into_iter().find(|split| split.name() == name);
    found.ok_or_else(|| CliError::Usage(format!("--split: expected one of {names}, got '{name}'")))
}
