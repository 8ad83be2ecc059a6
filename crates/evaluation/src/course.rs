//! The episodes of an evaluation: made once, run under any conditions.

use std::sync::Arc;

use lifelike_character::Kinematics;
use lifelike_motion::MotionClip;
use lifelike_motion::resample::resample;
use lifelike_robot::Robot;
use lifelike_sim::Simulation;
use lifelike_sim::randomization::RandomizationSpec;

use super::fall::fallen;
use super::hardship::Hardship;
use super::options::EvaluationOptions;
use super::recorder::Recorder;
use super::rollout::{Cause, Outcome, Rollout};
use super::schedule::{repeated, start_frames};
use super::score::{EpisodeScore, Evaluation};
use crate::EvaluationError;
use lifelike_tracking::plan::{EpisodeSpec, Termination};
use lifelike_tracking::starts::StartSpec;
use lifelike_tracking::{Encode, Environment, Policy, ReferenceLibrary, Start, TrackerPlan};

/// One episode to run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Task {
    /// Its number, from 0: the address of its randomness.
    pub number: usize,
    /// The frame of the library that it begins at.
    pub frame: usize,
    /// Frames that it has without a fall, the start included.
    pub planned: usize,
}

/// Clips at the policy's rate, and the episodes on them.
pub struct Course<'a> {
    policy: &'a Policy,
    robot: &'a Arc<Robot>,
    options: EvaluationOptions,
    library: Arc<ReferenceLibrary>,
    /// How high above level ground each frame of the library thinks that it stands (m); empty: on it.
    lift: Vec<f64>,
    tasks: Vec<Task>,
}

impl<'a> Course<'a> {
    /// The episodes on clips as they are.
    ///
    /// # Errors
    /// The policy does not fit the robot, or a clip does not.
    pub fn new(
        policy: &'a Policy,
        robot: &'a Arc<Robot>,
        clips: &[MotionClip],
        prior: Option<&dyn Encode>,
        options: &EvaluationOptions,
    ) -> Result<Self, EvaluationError> {
        Self::changed(policy, robot, clips, prior, options, |_| Ok(Vec::new()))
    }

    /// The episodes on clips that `change` was at, after they were resampled and repeated. It says how high above level
    /// ground each frame thinks that it stands (m), or nothing for level ground.
    ///
    /// # Errors
    /// As [`Self::new`], and those of `change`.
    pub fn changed(
        policy: &'a Policy,
        robot: &'a Arc<Robot>,
        clips: &[MotionClip],
        prior: Option<&dyn Encode>,
        options: &EvaluationOptions,
        mut change: impl FnMut(&mut MotionClip) -> Result<Vec<f64>, EvaluationError>,
    ) -> Result<Self, EvaluationError> {
        policy.check(robot)?;
        let fps = robot.control_hz;
        let episode = (options.seconds * fps).round().max(1.0) as usize;
        let prior = if policy.header().observation.reference.latent > 0 { prior } else { None };
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
        let library = Arc::new(ReferenceLibrary::new(robot, &long, prior)?);
        let mut tasks = Vec::new();
        for (clip, length) in lengths.iter().enumerate() {
            let range = library.range(clip);
            for start in start_frames(*length, episode, options.starts, clips[clip].cyclic) {
                let planned = (episode + 1).min(range.len() - start);
                tasks.push(Task { number: tasks.len(), frame: range.start + start, planned });
            }
        }
        Ok(Self { policy, robot, options: options.clone(), library, lift, tasks })
    }

    /// The episodes.
    pub fn tasks(&self) -> &[Task] {
        &self.tasks
    }

    /// All frames.
    pub fn library(&self) -> &ReferenceLibrary {
        &self.library
    }

    /// Runs every episode under the conditions that `hardship` gives it. As many run at once as the simulation has
    /// environments; the scores do not depend on how many. An episode with stretches of its own lasts as long as episodes
    /// may.
    ///
    /// # Errors
    /// The simulation does not fit the robot, or fails as a whole.
    pub fn run(
        &self,
        simulation: Box<dyn Simulation>,
        hardship: impl Fn(&Task) -> Hardship,
        mut progress: impl FnMut(usize, usize),
    ) -> Result<Evaluation, EvaluationError> {
        let (robot, engine, width) = (self.robot, simulation.engine(), simulation.len());
        let plan = plan(self.policy, width);
        let mut environment = Environment::new(&plan, Arc::clone(robot), Arc::clone(&self.library), simulation)?;
        let (expected, got) = (&self.policy.header().observation, environment.observation());
        if expected != got {
            return Err(EvaluationError::Mismatch {
                what: "what the policy sees".into(),
                expected: format!("{expected:?}"),
                got: format!("{got:?}"),
            });
        }
        let mut scores = Vec::with_capacity(self.tasks.len());
        let mut kept: Vec<Rollout> = Vec::new();
        progress(0, self.tasks.len());
        for wave in self.tasks.chunks(width.max(1)) {
            let hardships: Vec<Hardship> = wave.iter().map(&hardship).collect();
            for rollout in self.wave(&mut environment, wave, &hardships)? {
                let score = EpisodeScore::of(&rollout);
                let same = || kept.iter().filter(|k| k.clip == rollout.clip);
                let first_fall = !score.survived && !same().any(|k| k.outcome != Outcome::Survived);
                if same().count() < self.options.keep || first_fall {
                    kept.push(rollout);
                }
                scores.push(score);
            }
            progress(scores.len(), self.tasks.len());
        }
        let names = (robot.name.as_str(), robot.layout.joints.as_slice());
        Ok(Evaluation::new(names, engine, self.options.seconds, scores, kept))
    }

    /// Runs as many episodes as there are tasks, each in its own environment, in lockstep.
    fn wave(
        &self,
        environment: &mut Environment,
        wave: &[Task],
        hardships: &[Hardship],
    ) -> Result<Vec<Rollout>, EvaluationError> {
        let (fps, recorder) = (self.robot.control_hz, Recorder::new(self.robot, &self.library, &self.lift));
        let after_fall = (self.options.after_fall * fps).round() as usize;
        let ids: Vec<usize> = (0..wave.len()).collect();
        let starts: Vec<Start> = wave.iter().zip(hardships).map(|(task, hardship)| start(task, hardship)).collect();
        environment.reset(&ids, Some(&starts))?;
        let whole = (self.options.seconds * fps).round().max(1.0) as usize + 1;
        let planned = |k: usize| if hardships[k].stretches.is_empty() { wave[k].planned } else { whole };
        let mut rollouts: Vec<Rollout> = ids.iter().map(|&i| recorder.begin(starts[i].frame, planned(i))).collect();
        let mut kinematics = Kinematics::new(&self.robot.character);
        for (i, rollout) in rollouts.iter_mut().enumerate() {
            recorder.record(rollout, environment, i, &mut kinematics);
        }
        let mut outcome = lifelike_tracking::StepOutcome::default();
        // When each episode stops being recorded: at its planned end, or a while after its fall.
        let mut ends: Vec<usize> = rollouts.iter().map(|r| r.planned).collect();
        let mut frame = 1;
        while ends.iter().any(|end| frame < *end) {
            for (i, hardship) in hardships.iter().enumerate().filter(|(i, _)| frame < ends[*i]) {
                inflict(hardship, frame, i, environment)?;
            }
            let outputs = self.policy.outputs(environment.actor_rows().to_vec())?;
            environment.step(&outputs, &mut outcome)?;
            for (i, rollout) in rollouts.iter_mut().enumerate() {
                if frame >= ends[i] {
                    continue;
                }
                if outcome.terminated[i] || outcome.truncated[i] {
                    // The environment has begun another episode: this one's last state is gone, and so is its last frame.
                    ends[i] = frame;
                    if outcome.terminated[i] && rollout.outcome == Outcome::Survived {
                        rollout.outcome = Outcome::Fell { frame, cause: Cause::Diverged };
                    } else if rollout.outcome == Outcome::Survived {
                        rollout.planned = frame;
                    }
                    continue;
                }
                recorder.record(rollout, environment, i, &mut kinematics);
                if rollout.outcome == Outcome::Survived
                    && let Some(cause) = fallen(&rollout.reference[frame], &rollout.simulated[frame])
                {
                    rollout.outcome = Outcome::Fell { frame, cause };
                    ends[i] = ends[i].min(frame + 1 + after_fall);
                }
            }
            frame += 1;
        }
        Ok(rollouts)
    }
}

fn start(task: &Task, hardship: &Hardship) -> Start {
    let first = hardship.stretches.iter().find(|s| s.step <= 1).map_or(task.frame, |s| s.frame);
    Start { frame: first, spot: Some(hardship.spot), parameters: Some(hardship.parameters.clone()) }
}

/// What of a hardship begins or ends before this step (the first is 1).
fn inflict(hardship: &Hardship, step: usize, i: usize, environment: &mut Environment) -> Result<(), EvaluationError> {
    if step > 1
        && let Some(stretch) = hardship.stretches.iter().find(|s| s.step == step)
    {
        environment.jump(i, stretch.frame);
    }
    if hardship.pushes.iter().any(|p| p.until == step) {
        environment.simulation_mut().clear_pushes(i);
    }
    if let Some(timed) = hardship.pushes.iter().find(|p| p.from == step) {
        let push = timed.push;
        environment.simulation_mut().push(i, push.body, push.force_w, push.torque_w)?;
    }
    Ok(())
}

/// The environment of an evaluation: nothing is random and nothing but divergence ends an episode, which has its own idea
/// of a fall.
fn plan(policy: &Policy, environments: usize) -> TrackerPlan {
    let header = policy.header();
    let mut plan = TrackerPlan::new(&header.robot, &[]);
    plan.inputs = header.observation.reference.clone();
    plan.anchor = header.observation.anchor;
    plan.linear_velocity = header.observation.linear_velocity;
    plan.action = header.action;
    plan.termination = Termination::NONE;
    plan.episode = EpisodeSpec { seconds: 1e9, switch_clips: false, leash: false, grace_seconds: 0.0 };
    plan.starts = StartSpec {
        joint_noise: 0.0,
        velocity_noise: 0.0,
        path_noise: 0.0,
        heading_noise: 0.0,
        ..StartSpec::default()
    };
    plan.randomization = RandomizationSpec::none();
    plan.ppo.environments = environments;
    plan
}
