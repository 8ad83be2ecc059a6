//! Measured episodes: measured returns, and which episodes fell.

use std::collections::BTreeMap;
use std::ops::Range;

use lifelike_generation::critic::{RewardRecords, StepEnd};
use lifelike_generation::representation::{FeatureMatrix, RepresentationSpec};
use lifelike_tracking::Start;
use lifelike_tracking::plan::EpisodeSpec;

use lifelike::CliError;
use lifelike::Output;
use lifelike::commands::rollouts::Rollouts;

/// The mean measured return of a window.
pub struct Window {
    pub clip: usize,
    pub row: usize,
    pub value: f64,
}

/// An episode: the rows that it was to follow, and whether it fell before their end.
pub struct Fate {
    pub clip: usize,
    pub rows: Range<usize>,
    pub fell: bool,
}

fn row(records: &RewardRecords, rows: &[FeatureMatrix], clip: u32, frame: u32) -> usize {
    let place = (f64::from(frame) * RepresentationSpec::FPS / records.rate).round() as usize;
    place.min(rows[clip as usize].n - 1)
}

/// Returns the mean discounted return of every window that was met, over a horizon that leaves less than 1%.
pub fn measured(records: &RewardRecords, rows: &[FeatureMatrix], gamma: f64) -> Vec<Window> {
    let horizon = (0.01_f64.ln() / gamma.max(1e-9).ln()).ceil().max(1.0) as usize;
    let mut sums: BTreeMap<(usize, usize), (f64, f64)> = BTreeMap::new();
    let places = records.sequence.iter().zip(&records.frame).zip(records.returns(gamma, horizon));
    for ((clip, frame), value) in places.filter(|(_, value)| !value.is_nan()) {
        let (sum, count) = sums.entry((*clip as usize, row(records, rows, *clip, *frame))).or_default();
        *sum += f64::from(value);
        *count += 1.0;
    }
    sums.into_iter().map(|((clip, row), (sum, count))| Window { clip, row, value: sum / count }).collect()
}

/// Returns the episodes of records that ended, of at most these seconds each.
pub fn of_episodes(records: &RewardRecords, rows: &[FeatureMatrix], seconds: f64) -> Vec<Fate> {
    let n = records.environments;
    let mut fates = Vec::new();
    for environment in 0..n {
        let mut begin = environment;
        for i in (environment..records.len()).step_by(n) {
            let fell = match records.end[i] {
                StepEnd::Failed => true,
                StepEnd::Truncated => false,
                StepEnd::Continues | StepEnd::Jumped => continue,
            };
            let clip = records.sequence[begin];
            let first = row(records, rows, clip, records.frame[begin]);
            let length = seconds * RepresentationSpec::FPS;
            let end = (first as f64 + length).min(rows[clip as usize].n as f64) as usize;
            fates.push(Fate { clip: clip as usize, rows: first..end.max(first + 1), fell });
            begin = i + n;
        }
    }
    fates
}

/// Returns a fate per clip that has any: it fell when at least half of its episodes did.
pub fn of_clips(fates: &[Fate], clips: usize) -> Vec<Fate> {
    let of = |clip: usize| {
        let own = || fates.iter().filter(move |fate| fate.clip == clip);
        let rows = own().next()?.rows.clone();
        Some(Fate { clip, rows, fell: 2 * own().filter(|fate| fate.fell).count() >= own().count() })
    };
    (0..clips).filter_map(of).collect()
}

/// Records one episode per environment from the start of each clip, `repeats` of each.
pub fn from_starts(rollouts: &Rollouts<'_>, repeats: usize, output: &Output) -> Result<RewardRecords, CliError> {
    let clips = rollouts.clips.len();
    let episode = EpisodeSpec { seconds: 1e5, switch_clips: false, ..rollouts.tracker.episode };
    let mut environment = rollouts.environment(episode, clips * repeats)?;
    let rate = rollouts.controller.robot().control_hz;
    let frames: Vec<usize> = rollouts.clips.iter().map(|clip| (clip.seconds() * rate).floor() as usize + 1).collect();
    let first = |clip: usize| frames[..clip].iter().sum::<usize>();
    let starts: Vec<Start> = (0..clips * repeats).map(|i| Start::at(first(i / repeats))).collect();
    let all: Vec<usize> = (0..starts.len()).collect();
    environment.reset(&all, Some(&starts))?;
    let steps = frames.iter().max().map_or(1, |frames| *frames as u64);
    let mut records = rollouts.record(environment, steps, output)?;
    // Only the first episode of each counts: what follows began at random.
    let n = records.environments;
    for environment in 0..n {
        let ended = (environment..records.len()).step_by(n).find(|i| records.end[*i] != StepEnd::Continues);
        let after = ended.map_or(records.len(), |i| i + n);
        (after..records.len()).step_by(n).for_each(|i| records.end[i] = StepEnd::Continues);
    }
    Ok(records)
}

/// Returns the mean of numbers by group; NaN for groups without any.
pub fn means(values: &[f64], groups: &[usize], count: usize) -> Vec<f64> {
    let mut sums = vec![(0.0, 0.0); count];
    for (value, group) in values.iter().zip(groups) {
        sums[*group].0 += value;
        sums[*group].1 += 1.0;
    }
    sums.into_iter().map(|(sum, n)| sum / n).collect()
}

/// Returns the share of the variance of the windows' returns that predictions explain.
pub fn explained(windows: &[Window], predicted: &[f64]) -> f64 {
    let mean = windows.iter().map(|w| w.value).sum::<f64>() / windows.len() as f64;
    let error: f64 = windows.iter().zip(predicted).map(|(w, p)| (w.value - p).powi(2)).sum();
    1.0 - error / windows.iter().map(|w| (w.value - mean).powi(2)).sum::<f64>()
}
