//! The thesis' protocol (4.3.3, 5.3.3): episodes of one length that begin at random frames, errors over all of their frames.
//!
//! The only termination is eq. t^p for f seconds: the largest end-effector deviation stays above t^p for longer than f.
//! The episode then goes on with another motion, from a state of the reference. At the end of a clip it continues with
//! another motion from the robot's pose (4.2.2). The time of a deviation continues across that switch, so a fallen
//! robot among short clips is terminated too. Frames are drawn uniformly, not clips.

mod draw;
mod errors;
mod tables;

use lifelike_character::Kinematics;
use lifelike_checkpoint::rng::stream;
use lifelike_motion::MotionClip;
use lifelike_robot::ReferenceLibrary;

pub use errors::ThesisErrors;
pub use tables::thesis_tables;

use super::episode::EpisodeConditions;
use super::error::EvaluationError;
use super::recorder::Recorder;
use super::rollout::Snapshot;
use super::runner::{Ended, Runner};
use super::setup::EvaluationSetup;
use draw::Frames;
use errors::{ErrorSums, Persistence};

/// Extent and termination of the thesis' protocol.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ThesisProtocol {
    /// Number of episodes.
    pub episodes: usize,
    /// Length of every episode T (s).
    pub seconds: f64,
    /// End-effector deviation without consequence t^p (m); the robot's own where not given.
    pub distance: Option<f64>,
    /// Longest time above it f (s).
    pub patience: f64,
    /// Key of frames and clips.
    pub seed: u64,
}

impl Default for ThesisProtocol {
    fn default() -> Self {
        Self { episodes: 200, seconds: 30.0, distance: None, patience: 3.0, seed: 1 }
    }
}

/// An evaluation by the thesis' protocol.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct ThesisEvaluation {
    /// The robot.
    pub robot: String,
    /// The engine.
    pub engine: String,
    /// The protocol, its distance filled in.
    pub protocol: ThesisProtocol,
    /// Number of clips.
    pub clips: usize,
    /// The errors.
    #[serde(flatten)]
    pub errors: ThesisErrors,
}

/// One running episode.
struct Running {
    rng: rand_chacha::ChaCha8Rng,
    /// Reference and robot at the frame before.
    before: (Snapshot, Snapshot),
    rule: Persistence,
    sums: ErrorSums,
}

impl EvaluationSetup<'_> {
    /// Evaluates by the thesis' protocol, deterministically for its seed. The errors do not depend on how many episodes run at once.
    /// `progress` gets the number of episodes done, and of all.
    ///
    /// # Errors
    /// A clip does not fit the robot, or the simulation fails as a whole.
    pub fn evaluate_thesis(
        &self,
        clips: &[MotionClip],
        protocol: &ThesisProtocol,
        mut progress: impl FnMut(usize, usize),
    ) -> Result<ThesisEvaluation, EvaluationError> {
        let robot = self.robot();
        let library = ReferenceLibrary::new(robot, clips, self.latent_encoder()?)?;
        let distance = protocol.distance.unwrap_or_else(|| robot.deviation_limit());
        let protocol = ThesisProtocol { distance: Some(distance), ..protocol.clone() };
        let width = protocol.episodes.clamp(1, self.environments.max(1));
        let simulation = (self.simulate)(None, width)?;
        let engine = simulation.engine().to_owned();
        let mut runner = Runner::new(self.controller, &library, simulation)?;
        let numbers: Vec<usize> = (0..protocol.episodes).collect();
        let mut sums = Vec::with_capacity(numbers.len());
        progress(0, numbers.len());
        for wave in numbers.chunks(width) {
            sums.extend(run(&mut runner, &Recorder::new(robot, &library, &[]), &library, wave, &protocol)?);
            progress(sums.len(), numbers.len());
        }
        let errors = ThesisErrors::of(&sums, robot.control_hz);
        Ok(ThesisEvaluation { robot: robot.name.clone(), engine, protocol, clips: library.clips(), errors })
    }
}

/// Runs the episodes of these numbers side by side.
fn run(
    runner: &mut Runner<'_>,
    recorder: &Recorder<'_>,
    library: &ReferenceLibrary,
    numbers: &[usize],
    protocol: &ThesisProtocol,
) -> Result<Vec<ErrorSums>, EvaluationError> {
    let (fps, frames) = (recorder.fps(), Frames::of(library));
    let steps = (protocol.seconds * fps).round().max(1.0) as usize;
    let limit = protocol.distance.unwrap_or(f64::INFINITY);
    let mut kinematics = Kinematics::new(recorder.character());
    let mut rngs: Vec<_> = numbers.iter().map(|n| stream(protocol.seed, "thesis episode", *n as u64, 0)).collect();
    let starts: Vec<usize> = rngs.iter_mut().map(|rng| frames.any(rng)).collect();
    runner.begin(&starts, &vec![EpisodeConditions::default(); numbers.len()])?;
    let mut running: Vec<Running> = Vec::with_capacity(numbers.len());
    for (i, rng) in rngs.into_iter().enumerate() {
        let before = recorder.both(&runner.moment(i), &mut kinematics);
        let rule = Persistence::new(limit, protocol.patience, fps);
        running.push(Running { rng, before, rule, sums: ErrorSums::new(recorder.legs()) });
    }
    for _ in 0..steps {
        runner.step(|i| i < numbers.len())?;
        for (i, episode) in running.iter_mut().enumerate() {
            let ended = runner.ended(i);
            let diverged = ended == Some(Ended::Diverged);
            let mut terminated = diverged;
            if !diverged {
                let now = recorder.both(&runner.moment(i), &mut kinematics);
                terminated = episode.rule.exceeded(&now.0, &now.1);
                episode.sums.add(&episode.before, &now, fps);
                episode.before = now;
            }
            if !terminated && ended.is_none() {
                continue;
            }
            let next = frames.elsewhere(runner.moment(i).frame, &mut episode.rng);
            if terminated {
                episode.sums.terminations += 1;
                episode.sums.fell |= diverged;
                runner.restart(i, next, &EpisodeConditions::default())?;
                episode.rule.forget();
            } else {
                runner.jump(i, next);
            }
            // Velocities begin anew: nothing moved from one motion to the other.
            episode.before = recorder.both(&runner.moment(i), &mut kinematics);
        }
    }
    Ok(running.into_iter().map(|episode| episode.sums).collect())
}
