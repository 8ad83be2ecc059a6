//! Runs a policy in physics, from states of the reference.

use std::sync::Arc;

use lifelike_character::rotation::from_wxyz;
use lifelike_character::{JointKind, Kinematics, Quat, Vec3};
use lifelike_motion::MotionClip;
use lifelike_motion::resample::resample;
use lifelike_robot::Robot;
use lifelike_robot::robot::role_name;
use lifelike_sim::randomization::RandomizationSpec;
use lifelike_sim::{BatchState, Simulation};

use super::fall::fallen;
use super::rollout::{Cause, Names, Outcome, Rollout, Snapshot};
use super::schedule::{repeated, start_frames};
use super::score::{EpisodeScore, Evaluation};
use crate::error::LearnError;
use crate::tracking::plan::{EpisodeSpec, Termination};
use crate::tracking::starts::StartSpec;
use crate::tracking::{Alignment, Encode, Environment, Policy, ReferenceLibrary, TrackerPlan};

/// What to evaluate on.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct EvaluationOptions {
    /// Longest episode (s). Cyclic clips are repeated to last that long; episodes of others end with their clip.
    pub seconds: f64,
    /// Episodes per clip, from start frames spread evenly.
    pub starts: usize,
    /// Rollouts of each clip that are kept to be looked at; the first that fell is always kept.
    pub keep: usize,
    /// How long a fall is recorded (s).
    pub after_fall: f64,
}

impl Default for EvaluationOptions {
    fn default() -> Self {
        Self { seconds: 10.0, starts: 5, keep: 1, after_fall: 1.0 }
    }
}

/// One episode to run.
struct Task {
    clip: usize,
    /// Frame of the library.
    frame: usize,
    /// Frames that it has without a fall, the start included.
    planned: usize,
}

/// Evaluates a policy on clips, deterministically: no noise, no randomisation, the mean of the policy. As many episodes
/// run at once as the simulation has environments; the scores do not depend on how many.
///
/// `prior` gives the latent codes where the policy wants them. `progress` is told how many episodes are done, of how many.
///
/// # Errors
/// The policy does not fit the robot, a clip does not, or the simulation fails as a whole.
pub fn evaluate(
    policy: &Policy,
    robot: &Arc<Robot>,
    clips: &[MotionClip],
    prior: Option<&dyn Encode>,
    simulation: Box<dyn Simulation>,
    options: &EvaluationOptions,
    mut progress: impl FnMut(usize, usize),
) -> Result<Evaluation, LearnError> {
    policy.check(robot)?;
    let fps = robot.control_hz;
    let episode = (options.seconds * fps).round().max(1.0) as usize;
    let prior = if policy.header().observation.reference.latent > 0 { prior } else { None };

    // A cycle may begin at its very end, hence one repetition more than an episode.
    let mut lengths = Vec::with_capacity(clips.len());
    let mut long = Vec::with_capacity(clips.len());
    for clip in clips {
        let clip = resample(clip, fps)?;
        lengths.push(clip.len());
        long.push(repeated(&clip, clip.seconds() + options.seconds + 2.0 / fps));
    }
    let library = Arc::new(ReferenceLibrary::new(robot, &long, prior)?);
    let mut tasks = Vec::new();
    for (clip, length) in lengths.iter().enumerate() {
        let range = library.range(clip);
        for start in start_frames(*length, episode, options.starts, clips[clip].cyclic) {
            let planned = (episode + 1).min(range.len() - start);
            tasks.push(Task { clip, frame: range.start + start, planned });
        }
    }

    let engine = simulation.engine();
    let width = simulation.len();
    let mut environment = Environment::new(&plan(policy, width), Arc::clone(robot), Arc::clone(&library), simulation)?;
    let recorder = Recorder::new(robot, &library, options);
    let mut scores = Vec::with_capacity(tasks.len());
    let mut kept: Vec<Rollout> = Vec::new();
    progress(0, tasks.len());
    for wave in tasks.chunks(width.max(1)) {
        for rollout in run(policy, &mut environment, &recorder, wave)? {
            let score = EpisodeScore::of(&rollout);
            let same = || kept.iter().filter(|k| k.clip == rollout.clip);
            let first_fall = !score.survived && !same().any(|k| k.outcome != Outcome::Survived);
            if same().count() < options.keep || first_fall {
                kept.push(rollout);
            }
            scores.push(score);
        }
        progress(scores.len(), tasks.len());
    }
    Ok(Evaluation::new((&robot.name, &robot.layout.joints), engine, options.seconds, scores, kept))
}

/// The environment of an evaluation: nothing is random and nothing but divergence ends an episode, which has its own idea
/// of a fall.
fn plan(policy: &Policy, environments: usize) -> TrackerPlan {
    let header = policy.header();
    let mut plan = TrackerPlan::new(&header.robot, &[]);
    plan.inputs = header.observation.reference.clone();
    plan.anchor = header.observation.anchor;
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

/// Runs as many episodes as there are tasks, each in its own environment, in lockstep.
fn run(
    policy: &Policy,
    environment: &mut Environment,
    recorder: &Recorder<'_>,
    wave: &[Task],
) -> Result<Vec<Rollout>, LearnError> {
    let ids: Vec<usize> = (0..wave.len()).collect();
    let frames: Vec<usize> = wave.iter().map(|t| t.frame).collect();
    environment.reset(&ids, Some(&frames))?;
    let mut rollouts: Vec<Rollout> = wave.iter().map(|task| recorder.begin(task)).collect();
    let mut kinematics = Kinematics::new(&recorder.robot.character);
    let alignments: Vec<Alignment> = environment.episodes()[..wave.len()].iter().map(|e| e.alignment).collect();
    for (i, rollout) in rollouts.iter_mut().enumerate() {
        recorder.record(rollout, environment.state(), i, wave[i].frame, alignments[i], &mut kinematics);
    }
    let mut outcome = crate::tracking::Outcome::default();
    // When each episode stops being recorded: at its planned end, or a while after its fall.
    let mut ends: Vec<usize> = wave.iter().map(|t| t.planned).collect();
    let mut frame = 1;
    while ends.iter().any(|end| frame < *end) {
        let outputs = policy.outputs(environment.actor_rows().to_vec())?;
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
            let at = (wave[i].frame + frame).min(recorder.library.range(wave[i].clip).end - 1);
            recorder.record(rollout, environment.state(), i, at, alignments[i], &mut kinematics);
            if rollout.outcome == Outcome::Survived
                && let Some(cause) = fallen(&rollout.reference[frame], &rollout.simulated[frame])
            {
                rollout.outcome = Outcome::Fell { frame, cause };
                ends[i] = ends[i].min(frame + 1 + recorder.after_fall);
            }
        }
        frame += 1;
    }
    Ok(rollouts)
}

/// A sole of the reference lower than this is on the ground (m): retargeted feet stand within a millimetre of it, and swing
/// at least two centimetres above.
const SOLE_DOWN: f64 = 0.005;

/// Reads snapshots out of simulation and library.
struct Recorder<'a> {
    robot: &'a Robot,
    library: &'a ReferenceLibrary,
    names: Arc<Names>,
    torque_max: Vec<f32>,
    weight: f32,
    after_fall: usize,
}

impl<'a> Recorder<'a> {
    fn new(robot: &'a Robot, library: &'a ReferenceLibrary, options: &EvaluationOptions) -> Self {
        let character = &robot.character;
        let names = Names {
            joints: robot.layout.joints.clone(),
            effectors: robot.layout.end_effectors.clone(),
            bodies: character.bodies.iter().map(|b| b.name.clone()).collect(),
            feet: robot.anatomy.soles.keys().map(|role| role_name(*role)).collect(),
        };
        Self {
            robot,
            library,
            names: Arc::new(names),
            torque_max: robot.actuators.parameters.iter().map(|p| p.torque_max as f32).collect(),
            weight: ((character.mass() * character.gravity.norm()) as f32).max(1e-3),
            after_fall: (options.after_fall * robot.control_hz).round() as usize,
        }
    }

    fn begin(&self, task: &Task) -> Rollout {
        let range = self.library.range(task.clip);
        Rollout {
            clip: self.library.names[task.clip].clone(),
            start: (task.frame - range.start) as f64 / self.robot.control_hz,
            fps: self.robot.control_hz,
            names: Arc::clone(&self.names),
            reference: Vec::with_capacity(task.planned),
            simulated: Vec::with_capacity(task.planned),
            torque_share: Vec::new(),
            foot_force: Vec::new(),
            planned_contact: Vec::new(),
            planned: task.planned,
            outcome: Outcome::Survived,
        }
    }

    fn record(
        &self,
        rollout: &mut Rollout,
        state: &BatchState,
        i: usize,
        frame: usize,
        alignment: Alignment,
        kinematics: &mut Kinematics,
    ) {
        rollout.reference.push(self.reference(frame, alignment, kinematics));
        rollout.planned_contact.extend(self.robot.anatomy.soles.values().map(|sole| {
            let lowest = sole.corners.iter().map(|c| kinematics.point(sole.body, c).z).fold(f64::INFINITY, f64::min);
            lowest < SOLE_DOWN
        }));
        rollout.simulated.push(self.simulated(state, i));
        let (joints, feet) = (self.names.joints.len(), self.names.feet.len());
        let torques = &state.torque[i * joints..(i + 1) * joints];
        rollout.torque_share.extend(torques.iter().zip(&self.torque_max).map(|(t, max)| t.abs() / max.max(1e-9)));
        rollout.foot_force.extend(state.foot_force[i * feet..(i + 1) * feet].iter().map(|f| f / self.weight));
    }

    fn reference(&self, frame: usize, alignment: Alignment, kinematics: &mut Kinematics) -> Snapshot {
        let (robot, library) = (self.robot, self.library);
        let root_position = Vec3::from(alignment.position(library.position_at(frame)).map(f64::from));
        let root_orientation = quaternion(&alignment.orientation(library.orientation_at(frame)));
        let joints: Vec<f64> = library.joints_at(frame).iter().map(|q| f64::from(*q)).collect();
        let mut q = robot.default_position();
        let mut scalar = joints.iter();
        for joint in &robot.character.joints {
            let at = joint.q_index;
            if joint.kind == JointKind::Free {
                q[at..at + 3].copy_from_slice(root_position.as_slice());
                q[at + 3..at + 7].copy_from_slice(&lifelike_character::rotation::to_wxyz(&root_orientation));
            } else if joint.kind.nq() == 1 {
                q[at] = scalar.next().copied().unwrap_or(q[at]);
            }
        }
        kinematics.update(&robot.character, &q);
        Snapshot {
            root_position,
            root_orientation,
            joints,
            effectors: robot.effectors.iter().map(|(body, point)| kinematics.point(*body, point)).collect(),
            bodies: kinematics.body_position.iter().copied().zip(kinematics.body_orientation.iter().copied()).collect(),
        }
    }

    fn simulated(&self, state: &BatchState, i: usize) -> Snapshot {
        let vector = |values: &[f32]| Vec3::new(values[0].into(), values[1].into(), values[2].into());
        let (joints, bodies) = (self.names.joints.len(), self.names.bodies.len());
        let places = self.robot.effectors.len() + self.robot.key_bodies.len();
        Snapshot {
            root_position: vector(&state.root_position[3 * i..]),
            root_orientation: quaternion(&state.root_orientation[4 * i..]),
            joints: state.joint_position[i * joints..(i + 1) * joints].iter().map(|q| f64::from(*q)).collect(),
            effectors: (0..self.robot.effectors.len())
                .map(|p| vector(&state.place_position[3 * (i * places + p)..]))
                .collect(),
            bodies: (i * bodies..(i + 1) * bodies)
                .map(|b| (vector(&state.body_position[3 * b..]), quaternion(&state.body_orientation[4 * b..])))
                .collect(),
        }
    }
}

/// What is no rotation (a diverged environment) is taken as upright; its position tells that it diverged.
fn quaternion(wxyz: &[f32]) -> Quat {
    from_wxyz([wxyz[0].into(), wxyz[1].into(), wxyz[2].into(), wxyz[3].into()]).unwrap_or_else(Quat::identity)
}
