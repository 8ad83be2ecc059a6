//! Generated motion played in physics at once, by the robot's own controller.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use lifelike_evaluation::{EpisodeScore, Evaluation, EvaluationOptions, Verdict};
use lifelike_motion::MotionClip;
use lifelike_robot::Robot;

use super::maker::Candidate;
use super::softened::softened;
use crate::commands::best_of;
use crate::commands::controller_file::Loaded;
use crate::commands::eval::{Job, save};
use crate::commands::export::Source;
use crate::commands::physics::{self, Physics};
use crate::commands::projection::project;
use crate::error::CliError;
use crate::next::NextCommand;
use crate::output::Output;
use crate::shipped;

/// A controller that stands ready to play.
pub struct Player<'a> {
    loaded: Loaded,
    policy: PathBuf,
    physics: &'a Physics,
}

/// Outcome of playing.
#[derive(Debug, serde::Serialize)]
pub struct Played {
    /// The controller.
    pub policy: PathBuf,
    /// One line for each clip.
    pub lines: Vec<String>,
    /// Scores.
    pub evaluation: Evaluation,
    /// The page to look at.
    pub report: PathBuf,
}

impl<'a> Player<'a> {
    /// Loads the controller, the shipped one where none is given.
    pub fn new(policy: Option<&Path>, robot: &Arc<Robot>, file: &str, physics: &'a Physics) -> Result<Self, CliError> {
        physics::available(&physics.engine)?;
        physics.require_ready(robot)?;
        let again = || NextCommand::new("generate").word("a person walks").word("--physics");
        let policy = shipped::controller(policy, robot, file, again)?;
        let Source { policy, prior, .. } = Source::of(&policy)?;
        Ok(Self { loaded: Loaded::new(&policy, Arc::clone(robot), prior.as_deref())?, policy, physics })
    }

    /// Returns what physics makes of clips.
    pub fn project(&self, clips: &[MotionClip], output: &Output) -> Result<Vec<MotionClip>, CliError> {
        project(&Job { loaded: &self.loaded, physics: self.physics }, clips, output)
    }

    /// Sorts candidates by how the policy follows them in physics, the best first.
    pub fn sorted(&self, candidates: Vec<Candidate>, output: &Output) -> Result<Vec<Candidate>, CliError> {
        let costs = self.costs(&candidates, output)?;
        let mut pairs: Vec<(f64, Candidate)> = costs.into_iter().zip(candidates).collect();
        pairs.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.candidate.cmp(&b.1.candidate)));
        Ok(pairs.into_iter().map(|(_, one)| one).collect())
    }

    /// Returns the first candidate that stays on its feet, where one does.
    pub fn standing(&self, candidates: Vec<Candidate>, output: &Output) -> Result<Option<Candidate>, CliError> {
        let costs = self.costs(&candidates, output)?;
        Ok(candidates.into_iter().zip(costs).find(|(_, cost)| !best_of::is_fall(*cost)).map(|(one, _)| one))
    }

    fn costs(&self, candidates: &[Candidate], output: &Output) -> Result<Vec<f64>, CliError> {
        let clips: Vec<MotionClip> = candidates.iter().map(|one| one.clip.clone()).collect();
        best_of::costs(&Job { loaded: &self.loaded, physics: self.physics }, &clips, output)
    }

    /// Follows clips from their first frame to their end.
    pub fn evaluation(&self, clips: &[MotionClip], output: &Output) -> Result<Evaluation, CliError> {
        let seconds = clips.iter().map(MotionClip::seconds).fold(0.0, f64::max);
        let options = EvaluationOptions { seconds, starts: 1, keep: clips.len(), ..EvaluationOptions::default() };
        Job { loaded: &self.loaded, physics: self.physics }.run(clips, &options, output)
    }

    /// Plays clips from their first frame to their end, and writes the page.
    pub fn play(&self, clips: &[MotionClip], folder: &Path, output: &Output) -> Result<Played, CliError> {
        let evaluation = self.evaluation(clips, output)?;
        let robot = self.loaded.controller.robot();
        let title = match clips {
            [clip] => clip.provenance.captions.iter().map(|c| c.text.as_str()).collect::<Vec<_>>().join(", then "),
            _ => format!("{} generated motions", clips.len()),
        };
        let report = save(&evaluation, None, robot, &title, folder)?;
        let mut lines = Vec::new();
        for (i, (episode, clip)) in evaluation.episodes.iter().zip(clips).enumerate() {
            let verdict = Verdict::of(&[episode]);
            lines.push(line(episode, &verdict));
            // What fell was not softened.
            if let (None, Some(rollout)) = (&episode.failure, evaluation.rollouts.get(i)) {
                lines.extend(softened(clip, &rollout.played(clip.provenance.clone()), robot)?);
            }
        }
        let report = std::path::absolute(&report).unwrap_or(report);
        Ok(Played { policy: self.policy.clone(), lines, evaluation, report })
    }
}

/// Returns what became of one episode.
pub fn line(episode: &EpisodeScore, verdict: &Verdict) -> String {
    let error = format!("{verdict}; {:.1} s, joint error {:.1} deg", episode.planned_seconds, episode.joint_error_deg);
    match &episode.failure {
        None => format!("in physics: {error}"),
        Some(fall) => {
            let why = Some(fall.why()).filter(|why| !why.is_empty()).map_or(String::new(), |why| format!("; {why}"));
            format!("in physics: {error} before it {}{why}", fall.cause.words())
        }
    }
}
