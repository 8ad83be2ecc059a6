//! The episodes of an evaluation: made once, run under any conditions.

use lifelike_character::Kinematics;
use lifelike_motion::MotionClip;
use lifelike_motion::resample::resample;
use lifelike_robot::{Controller, ReferenceLibrary};
use lifelike_sim::Simulation;

use super::episode::{Episode, EpisodeConditions};
use super::error::EvaluationError;
use super::evaluation::Evaluation;
use super::fall::fallen;
use super::options::EvaluationOptions;
use super::recorder::Recorder;
use super::rollout::{Cause, Outcome, Rollout};
use super::runner::{Ended, Runner};
use super::schedule::{repeated, start_frames};
use super::score::EpisodeScore;
use super::setup::EvaluationSetup;

/// Clips at the policy's rate, and the episodes on them.
pub struct EvaluationSuite<'a> {
    controller: &'a Controller,
    options: EvaluationOptions,
    library: ReferenceLibrary,
    /// Height above level ground at which each frame of the library believes to stand (m); empty: on it.
    lift: Vec<f64>,
    episodes: Vec<Episode>,
}

impl<'a> EvaluationSuite<'a> {
    /// Makes the episodes on clips as they are.
    ///
    /// # Errors
    /// A clip does not fit the robot; the policy wants latent codes and there is no encoder of them.
    pub fn new(
        setup: &EvaluationSetup<'a>,
        clips: &[MotionClip],
        options: &EvaluationOptions,
    ) -> Result<Self, EvaluationError> {
        Self::changed(setup, clips, options, |_| Ok(Vec::new()))
    }

    /// Makes the episodes on clips that `change` was at, after they were resampled and repeated. It returns the
    /// height above level ground at which each frame believes to stand (m), or nothing for level ground.
    ///
    /// # Errors
    /// As [`Self::new`], and those of `change`.
    pub fn changed(
        setup: &EvaluationSetup<'a>,
        clips: &[MotionClip],
        options: &EvaluationOptions,
        mut change: impl FnMut(&mut MotionClip) -> Result<Vec<f64>, EvaluationError>,
    ) -> Result<Self, EvaluationError> {
        let (controller, robot) = (setup.controller, setup.robot());
        let fps = robot.control_hz;
        let frames = (options.seconds * fps).round().max(1.0) as usize;
        let encoder = setup.latent_encoder()?;
        let (mut lengths, mut long, mut lift) = (Vec::new(), Vec::new(), Vec::new());
        for clip in clips {
            let clip = resample(clip, fps)?;
            lengths.push(clip.len());
            // A cycle may begin at its very end, hence one repetition more than an episode.
            let mut clip = repeated(&clip, clip.seconds() + options.seconds + 2.0 / fps);
            let mut heights = change(&mut clip)?;
            heights.resize(clip.len(), 0.0);
            lift.extend(heights);
            long.push(clip);
        }
        let mut library = ReferenceLibrary::new(robot, &long, encoder)?;
        if let Some(seed) = options.permute_codes {
            library.permute_codes(seed)?;
        }
        let mut episodes = Vec::new();
        for (clip, length) in lengths.iter().enumerate() {
            let range = library.range(clip);
            for start in start_frames(*length, frames, options.starts, clips[clip].cyclic) {
                // The last frame of a clip has none to reach: no episode comes to it, whether it falls before or not.
                let planned = (frames + 1).min((range.len() - 1).saturating_sub(start)).max(1);
                episodes.push(Episode { number: episodes.len(), frame: range.start + start, planned });
            }
        }
        Ok(Self { controller, options: options.clone(), library, lift, episodes })
    }

    /// The episodes.
    pub fn episodes(&self) -> &[Episode] {
        &self.episodes
    }

    /// All frames.
    pub fn library(&self) -> &ReferenceLibrary {
        &self.library
    }

    /// Runs every episode under its conditions. As many run at once as the simulation has environments; the scores do not
    /// depend on how many. An episode with segments of its own lasts as long as episodes may.
    ///
    /// # Errors
    /// The simulation does not fit the robot, or fails as a whole.
    pub fn run(
        &self,
        simulation: Box<dyn Simulation>,
        conditions: impl Fn(&Episode) -> EpisodeConditions,
        mut progress: impl FnMut(usize, usize),
    ) -> Result<Evaluation, EvaluationError> {
        let (robot, engine, width) = (self.controller.robot(), simulation.engine().to_owned(), simulation.len());
        let mut runner = Runner::new(self.controller, &self.library, simulation)?;
        let mut scores = Vec::with_capacity(self.episodes.len());
        let mut kept: Vec<Rollout> = Vec::new();
        progress(0, self.episodes.len());
        for wave in self.episodes.chunks(width.max(1)) {
            let conditions: Vec<EpisodeConditions> = wave.iter().map(&conditions).collect();
            for rollout in self.wave(&mut runner, wave, &conditions)? {
                let score = EpisodeScore::of(&rollout);
                let same = || kept.iter().filter(|k| k.clip == rollout.clip);
                let first_fall = !score.survived && !same().any(|k| k.outcome != Outcome::Survived);
                if same().count() < self.options.keep || first_fall {
                    kept.push(rollout);
                }
                scores.push(score);
            }
            progress(scores.len(), self.episodes.len());
        }
        let names = (robot.name.as_str(), robot.layout.joints.as_slice());
        Ok(Evaluation::new(names, &engine, self.options.seconds, scores, kept))
    }

    /// Runs as many episodes as there are in a wave, each in its own environment, in lockstep.
    fn wave(
        &self,
        runner: &mut Runner<'_>,
        wave: &[Episode],
        conditions: &[EpisodeConditions],
    ) -> Result<Vec<Rollout>, EvaluationError> {
        let robot = self.controller.robot();
        let (fps, recorder) = (robot.control_hz, Recorder::new(robot, &self.library, &self.lift));
        let after_fall = (self.options.after_fall * fps).round() as usize;
        let whole = (self.options.seconds * fps).round().max(1.0) as usize + 1;
        let starts: Vec<usize> = wave.iter().zip(conditions).map(|(episode, of)| first_frame(episode, of)).collect();
        runner.begin(&starts, conditions)?;
        let planned = |k: usize| if conditions[k].segments.is_empty() { wave[k].planned } else { whole };
        let mut rollouts: Vec<Rollout> =
            starts.iter().enumerate().map(|(i, frame)| recorder.begin(*frame, planned(i))).collect();
        let mut kinematics = Kinematics::new(&robot.character);
        for (i, rollout) in rollouts.iter_mut().enumerate() {
            recorder.record(rollout, &runner.moment(i), &mut kinematics);
        }
        // When each episode stops being recorded: at its planned end, or a while after its fall.
        let mut ends: Vec<usize> = rollouts.iter().map(|r| r.planned).collect();
        let mut frame = 1;
        while ends.iter().any(|end| frame < *end) {
            for (i, conditions) in conditions.iter().enumerate().filter(|(i, _)| frame < ends[*i]) {
                if impose(conditions, frame, i, runner)? {
                    rollouts[i].jumps.push(frame);
                }
            }
            runner.step(|i| frame < ends[i])?;
            for (i, rollout) in rollouts.iter_mut().enumerate() {
                if frame >= ends[i] {
                    continue;
                }
                let survived = rollout.outcome == Outcome::Survived;
                match runner.ended(i) {
                    Some(Ended::Diverged) => {
                        ends[i] = frame;
                        if survived {
                            rollout.outcome = Outcome::Fell { frame, cause: Cause::Diverged };
                        }
                        continue;
                    }
                    Some(Ended::ClipOver) => {
                        // The last frame of a clip has none to reach: it is not recorded.
                        ends[i] = frame;
                        if survived {
                            rollout.planned = frame;
                        }
                        continue;
                    }
                    None => {}
                }
                recorder.record(rollout, &runner.moment(i), &mut kinematics);
                if survived && let Some(cause) = fallen(&rollout.reference[frame], &rollout.simulated[frame]) {
                    rollout.outcome = Outcome::Fell { frame, cause };
                    ends[i] = ends[i].min(frame + 1 + after_fall);
                }
            }
            frame += 1;
        }
        Ok(rollouts)
    }
}

fn first_frame(episode: &Episode, conditions: &EpisodeConditions) -> usize {
    conditions.segments.iter().find(|s| s.step <= 1).map_or(episode.frame, |s| s.frame)
}

/// Begins or ends the conditions of one episode that change before this step (the first is 1); returns whether its
/// reference jumps.
fn impose(
    conditions: &EpisodeConditions,
    step: usize,
    i: usize,
    runner: &mut Runner<'_>,
) -> Result<bool, EvaluationError> {
    let segment = conditions.segments.iter().find(|s| s.step == step && step > 1);
    if let Some(segment) = segment {
        runner.jump(i, segment.frame);
    }
    if conditions.pushes.iter().any(|p| p.until == step) {
        runner.simulation_mut().clear_pushes(i);
    }
    if let Some(timed) = conditions.pushes.iter().find(|p| p.from == step) {
        let push = timed.push;
        runner.simulation_mut().push(i, push.body, push.force_w, push.torque_w)?;
    }
    Ok(segment.is_some())
}
