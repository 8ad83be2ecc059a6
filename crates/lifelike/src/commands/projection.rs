//! Projection of motion onto what a controller can do (PhysDiff, Yuan et al. 2023): it is played in physics, and what came
//! of it takes its place. Nothing helps the robot to stay on its feet, so a motion that it falls in becomes a fall.

use lifelike_evaluation::EvaluationOptions;
use lifelike_motion::MotionClip;

use crate::commands::eval::Job;
use crate::error::CliError;
use crate::output::Output;

/// Returns what physics makes of clips, each from its first frame.
pub fn project(job: &Job<'_>, clips: &[MotionClip], output: &Output) -> Result<Vec<MotionClip>, CliError> {
    let seconds = clips.iter().map(MotionClip::seconds).fold(0.0, f64::max);
    let options = EvaluationOptions {
        seconds,
        starts: 1,
        keep: clips.len(),
        after_fall: seconds,
        ..EvaluationOptions::default()
    };
    let evaluation = job.run(clips, &options, output)?;
    if evaluation.rollouts.len() != clips.len() {
        let message = format!("expected {} motions out of physics, got {}", clips.len(), evaluation.rollouts.len());
        return Err(CliError::Failed(message));
    }
    let played = evaluation.rollouts.iter().zip(clips).map(|(rollout, clip)| {
        let mut provenance = clip.provenance.clone();
        provenance.source += &format!(", as {} plays it", evaluation.engine);
        rollout.played(provenance)
    });
    Ok(played.collect())
}
