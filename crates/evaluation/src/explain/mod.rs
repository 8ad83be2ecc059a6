//! Explanations of a policy's failure on a clip, and the smallest change of the clip that would help.
//!
//! The main path: an [`Evaluation`] with falls → [`explain`] → an [`Explanation`] per clip, which
//! has:
//!
//! - [`Failure`]: time and kind of the fall;
//! - defects of the clip at that time ([`feasibility`](lifelike_motion::feasibility));
//! - the mildest [`ClipModification`] with which it survives from all starts, tried in physics.

mod modification;
mod table;
#[cfg(test)]
mod tests;

use lifelike_motion::MotionClip;
use lifelike_motion::feasibility::{Finding, check};

use super::failure::Failure;
use super::{EpisodeConditions, Evaluation, EvaluationOptions, EvaluationSetup, EvaluationSuite};
use crate::EvaluationError;

pub use modification::ClipModification;
pub use table::table;

/// Stretch of a clip that is looked at around a fall (s): a fall is often begun a step or two before it is one.
const MARGIN: f64 = 1.0;
/// Findings that are told, the longest first.
const TOLD: usize = 3;

/// Outcome of a modification.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Tried {
    /// The change.
    pub modification: ClipModification,
    /// Share of episodes without a fall.
    pub survival: f64,
}

/// A clip that a policy fails on.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Explanation {
    /// The clip.
    pub clip: String,
    /// Episodes that fell.
    pub falls: usize,
    /// Of so many.
    pub episodes: usize,
    /// The fall that is explained: the first.
    pub failure: Failure,
    /// Findings in the clip itself within a second of that fall.
    pub findings: Vec<Finding>,
    /// Nothing in the whole clip rules it out.
    pub trackable: bool,
    /// Modifications tried, the mildest first; the last one helped where [`Self::modification`] says so.
    pub tried: Vec<Tried>,
    /// The mildest change with which no episode falls.
    pub modification: Option<ClipModification>,
    /// The changed clip.
    #[serde(skip)]
    pub repaired: Option<MotionClip>,
}

impl Explanation {
    /// Returns the defects of the clip itself, in words.
    pub fn clip_words(&self) -> String {
        if self.findings.is_empty() {
            let verdict = if self.trackable { "nothing speaks against it" } else { "nothing near the fall" };
            return verdict.into();
        }
        self.findings.iter().map(Finding::words).collect::<Vec<_>>().join("; ")
    }

    /// The proposal, in words.
    pub fn proposal(&self) -> String {
        match (&self.modification, self.tried.iter().max_by(|a, b| a.survival.total_cmp(&b.survival))) {
            (Some(modification), _) => format!("{}: survives from all starts", modification.words()),
            (None, Some(best)) if best.survival > 0.0 => {
                format!(
                    "nothing tried helps enough; best {}: {:.0}% survive",
                    best.modification.words(),
                    100.0 * best.survival
                )
            }
            _ => "nothing tried helps".into(),
        }
    }

    /// All of it, in a few sentences.
    pub fn words(&self) -> String {
        let f = &self.failure;
        let (clip, falls, episodes, cause) = (&self.clip, self.falls, self.episodes, f.cause.words());
        let why = f.why();
        let before = if why.is_empty() { String::new() } else { format!(" Before that: {why}.") };
        format!(
            "{clip} falls in {falls} of {episodes} episodes; {cause} at {:.2} s of the clip, {:.2} s into the episode.{before} \
             The clip itself: {}. Proposal: {}.",
            f.clip_second,
            f.second,
            self.clip_words(),
            self.proposal()
        )
    }
}

/// Explains every clip with a fall, in the order of the evaluation, and tries
/// [`ClipModification::ALL`] until one helps. `clips` are those of the evaluation; `progress` is told which clip it is at.
///
/// # Errors
/// As [`EvaluationSuite::new`], and what the simulations fail with.
pub fn explain(
    setup: &EvaluationSetup<'_>,
    evaluation: &Evaluation,
    clips: &[MotionClip],
    options: &EvaluationOptions,
    mut progress: impl FnMut(&str, usize, usize),
) -> Result<Vec<Explanation>, EvaluationError> {
    let robot = setup.robot();
    let fell: Vec<&MotionClip> =
        clips.iter().filter(|clip| evaluation.failures().any(|failure| failure.clip == clip.name)).collect();
    let mut all = Vec::new();
    for (done, clip) in fell.iter().enumerate() {
        progress(&clip.name, done, fell.len());
        let falls: Vec<&Failure> = evaluation.failures().filter(|failure| failure.clip == clip.name).collect();
        let Some(&failure) = falls.first() else { continue };
        let feasibility = check(clip, &robot.character, &robot.anatomy, &robot.speeds())?;
        // A cycle goes on beyond its end; its frames repeat.
        let second = if clip.cyclic { failure.clip_second % clip.seconds().max(1e-9) } else { failure.clip_second };
        let (mut tried, mut repaired, mut helps) = (Vec::new(), None, None);
        for modification in ClipModification::ALL {
            let changed = modification.apply(clip, robot)?;
            // Episodes grow with the clip, so that they begin and end at the same moments of it.
            let options = EvaluationOptions { seconds: options.seconds * modification.stretch(), ..options.clone() };
            let suite = EvaluationSuite::new(setup, std::slice::from_ref(&changed), &options)?;
            let simulation = (setup.simulate)(None, suite.episodes().len().max(1))?;
            let survival = suite.run(simulation, |_| EpisodeConditions::default(), |_, _| {})?.overall.survival;
            tried.push(Tried { modification, survival });
            if survival >= 1.0 {
                (repaired, helps) = (Some(changed), Some(modification));
                break;
            }
        }
        all.push(Explanation {
            clip: clip.name.clone(),
            falls: falls.len(),
            episodes: evaluation.episodes.iter().filter(|e| e.clip == clip.name).count(),
            failure: failure.clone(),
            findings: feasibility.around(second, MARGIN).take(TOLD).cloned().collect(),
            trackable: feasibility.trackable,
            tried,
            modification: helps,
            repaired,
        });
    }
    progress("", fell.len(), fell.len());
    Ok(all)
}
