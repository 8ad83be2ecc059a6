//! Physics on the motion of a generator: what chooses the weights of an alignment and the round of a co-training.

use std::fmt;

use lifelike_evaluation::{ThesisErrors, ThesisProtocol};
use lifelike_generation::GenerationError;
use lifelike_generation::align::{JudgePlan, PhysicsJudge, PhysicsMarks};
use lifelike_generation::data::CaptionedMotion;
use lifelike_generation::generator::{Generated, Generator, SampleOptions};
use lifelike_language::Split;
use lifelike_motion::MotionClip;
use lifelike_robot::Robot;
use rayon::prelude::*;

use crate::commands::eval::Job;
use crate::error::CliError;
use crate::output::Output;

/// A sentence and the duration of its motion.
#[derive(Debug, Clone, PartialEq)]
pub struct Sentence {
    /// The text.
    pub text: String,
    /// Duration (s).
    pub seconds: f64,
}

/// Returns at most `count` of all, evenly.
pub fn evenly<T>(all: &[T], count: usize) -> impl Iterator<Item = &T> {
    let count = count.min(all.len());
    (0..count).map(move |i| &all[i * all.len() / count])
}

/// Returns one motion of each sentence: the rows as the network made them and the clip, named by prefix and number. The
/// noise of number i has the key `seed + i`.
pub fn motions(
    generator: &Generator,
    robot: &Robot,
    sentences: &[Sentence],
    seed: u64,
    prefix: &str,
) -> Result<Vec<(Generated, MotionClip)>, GenerationError> {
    let longest = generator.header().max_seconds;
    let make = |(i, sentence): (usize, &Sentence)| {
        let seconds = Some(sentence.seconds.min(longest));
        let options = SampleOptions { seconds, seed: seed.wrapping_add(i as u64), ..SampleOptions::default() };
        let made = generator.sample(&sentence.text, &options)?.swap_remove(0);
        let mut clip = generator.clip(&made, &sentence.text, robot)?;
        clip.name = format!("{prefix}-{i:05}");
        Ok((made, clip))
    };
    sentences.par_iter().enumerate().map(make).collect()
}

/// Returns falls and the errors of Table 5.3, root rotation without heading.
pub fn marks_of(errors: &ThesisErrors) -> PhysicsMarks {
    PhysicsMarks {
        falls: 1.0 - errors.survival,
        errors: [
            errors.root_velocity_error,
            errors.root_angular_velocity_error,
            errors.root_tilt_error_deg,
            errors.upper_joint_error_deg,
            errors.lower_joint_error_deg,
        ],
    }
}

/// A policy that plays what a generator makes of some sentences.
pub struct Judge<'a> {
    /// Policy and physics.
    pub job: Job<'a>,
    /// The sentences.
    pub sentences: Vec<Sentence>,
    /// Extent.
    pub plan: JudgePlan,
    /// Key of noise, starts and order.
    pub seed: u64,
}

impl<'a> Judge<'a> {
    /// Returns a judge on sentences of the plan's split, of the training split where that has none.
    pub fn of(job: Job<'a>, motions: &[CaptionedMotion], plan: JudgePlan, seed: u64) -> Self {
        let of = |split: Split| -> Vec<&CaptionedMotion> { motions.iter().filter(|m| m.split == split).collect() };
        let mut all = of(plan.split);
        if all.is_empty() {
            tracing::warn!("no motion of the split {}: physics judges sentences of training", plan.split.name());
            all = of(Split::Train);
        }
        let fps = lifelike_generation::representation::RepresentationSpec::FPS;
        let sentence = |motion: &&CaptionedMotion| Sentence {
            text: motion.captions[0].clone(),
            seconds: motion.rows.n.saturating_sub(1) as f64 / fps,
        };
        let sentences = evenly(&all, plan.sentences).map(sentence).collect();
        Self { job, sentences, plan, seed }
    }

    /// Plays a generator's motion.
    pub fn play(&self, generator: &Generator) -> Result<PhysicsMarks, CliError> {
        let robot = self.job.loaded.controller.robot();
        let made = motions(generator, robot, &self.sentences, self.seed, "judged")?;
        let clips: Vec<MotionClip> = made.into_iter().map(|(_, clip)| clip).collect();
        let JudgePlan { episodes, seconds, .. } = self.plan;
        let protocol = ThesisProtocol { episodes, seconds, seed: self.seed, ..ThesisProtocol::default() };
        let silent = Output { json: false, quiet: true, silent: true };
        Ok(marks_of(&self.job.thesis(&clips, &protocol, &silent)?.errors))
    }
}

impl fmt::Debug for Judge<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Judge").field("sentences", &self.sentences.len()).field("plan", &self.plan).finish()
    }
}

impl PhysicsJudge for Judge<'_> {
    fn judge(&self, generator: &Generator) -> Result<PhysicsMarks, GenerationError> {
        self.play(generator).map_err(|error| GenerationError::Judge(error.to_string()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sentences_are_taken_evenly() {
        let all: Vec<usize> = (0..10).collect();
        assert_eq!(evenly(&all, 4).copied().collect::<Vec<_>>(), [0, 2, 5, 7]);
        assert_eq!(evenly(&all, 40).count(), 10);
        assert_eq!(evenly::<usize>(&[], 3).count(), 0);
    }
}
