//! What a step gave in one environment: reward, end, next observation.

use lifelike_checkpoint::rng::stream;
use lifelike_motion::{FeatureLayout, Frame};
use lifelike_robot::reference::{wrap, yaw};
use lifelike_robot::{ActionSpec, Alignment, ObservationSpec, ReferenceLibrary, Robot};
use lifelike_sim::{BatchState, Ground};

use super::episode::Episode;
use super::errors::{Cause, Deviation, empty_frame, read_frame, root};
use super::observe::{Observed, Observer};
use super::plan::{Termination, TrackerPlan};
use super::rewards::{Effort, Errors, SMOOTHNESS, TERMS};
use super::senses::Senses;
use super::starts::StartSampler;

/// Everything that judging a step reads.
pub(super) struct Judge<'a> {
    pub(super) plan: &'a TrackerPlan,
    pub(super) robot: &'a Robot,
    pub(super) library: &'a ReferenceLibrary,
    pub(super) observer: &'a Observer,
    pub(super) ground: &'a Ground,
    pub(super) sampler: &'a StartSampler,
    pub(super) senses: &'a Senses,
    pub(super) divisor: &'a [f32],
    /// When an episode has failed, at this stage of the curriculum.
    pub(super) limits: Termination,
    /// Factor on the penalties of actions and torques, likewise.
    pub(super) smoothness: f32,
    pub(super) state: &'a BatchState,
    pub(super) step: u64,
    /// Number of the first environment among those of all processes.
    pub(super) first: usize,
    pub(super) longest: u64,
}

/// One thread's workspace.
pub(super) struct Scratch {
    frame: Frame,
    row: Vec<f64>,
    pub(super) features: Vec<f32>,
    efforts: [Vec<f32>; 3],
}

impl Scratch {
    pub(super) fn new() -> Self {
        Self { frame: empty_frame(), row: Vec::new(), features: Vec::new(), efforts: Default::default() }
    }

    /// Features of one simulated environment; its height is that above the ground below its root.
    pub(super) fn read(
        &mut self,
        state: &BatchState,
        i: usize,
        robot: &Robot,
        library: &ReferenceLibrary,
        ground: &Ground,
    ) {
        read_frame(state, i, robot.joints(), robot.effectors.len(), &mut self.frame);
        self.row.resize(library.layout.size(), 0.0);
        self.frame.write_features(&self.frame.root_orientation, &mut self.row);
        self.row[FeatureLayout::HEIGHT] -= ground.height(self.frame.root_position.x, self.frame.root_position.y);
        self.features.clear();
        self.features.extend(self.row.iter().map(|x| *x as f32));
    }
}

impl Judge<'_> {
    pub(super) fn judge(
        &self,
        i: usize,
        episode: &mut Episode,
        scratch: &mut Scratch,
        actor: &mut [f32],
        critic: &mut [f32],
    ) {
        let library = self.library;
        let clip_end = library.starts[library.clip_of(episode.frame) + 1] - 1;
        episode.frame = (episode.frame + 1).min(clip_end);
        episode.length += 1;
        episode.failed = None;
        episode.cut = false;
        episode.finished = None;
        if self.state.diverged[i] {
            episode.terms = [0.0; TERMS.len()];
            episode.failed = Some(Cause::Diverged);
            return;
        }
        scratch.read(self.state, i, self.robot, library, self.ground);
        let (path, heading) = anchored(self.state, i, library, episode);
        self.reward(i, episode, scratch, path, heading);
        let reference = library.features_at(episode.frame);
        let deviation = Deviation::between(&library.layout, &scratch.features, reference, path, heading);
        let limits = &self.limits;
        let far = limits.persistent.is_some_and(|p| deviation.effector > p.distance);
        episode.deviated = if far { episode.deviated + 1 } else { 0 };
        if episode.grace > 0 {
            episode.grace -= 1;
        } else {
            episode.failed = deviation.exceeds(limits, episode.deviated as f64 / self.robot.control_hz);
        }
        if !episode.reward().is_finite() {
            episode.terms = [0.0; TERMS.len()];
            episode.failed = Some(Cause::Diverged);
        }
        episode.gain += episode.reward();
        let over = episode.frame >= clip_end;
        let switch = over && self.plan.episode.switch_clips;
        episode.cut = episode.failed.is_none() && (episode.length >= self.longest || (over && !switch));
        if switch && !episode.ended() {
            self.switch(i, episode);
        } else if self.plan.episode.leash {
            let (reach, turn) = (ObservationSpec::ANCHOR_REACH, ObservationSpec::ANCHOR_TURN);
            let clip = (library.position_at(episode.frame), library.orientation_at(episode.frame));
            episode.alignment = episode.alignment.re_anchored(clip, root(self.state, i), reach, turn);
        }
        let observed = Observed { state: self.state, i, episode, library, features: &scratch.features };
        self.observer.write(&observed, actor, critic);
        self.senses.tell(actor, episode, || stream(self.plan.seed, "sense", (self.first + i) as u64, self.step));
    }

    fn reward(&self, i: usize, episode: &mut Episode, scratch: &mut Scratch, path: f32, heading: f32) {
        let scale = match self.plan.action {
            ActionSpec::Absolute => 1.0,
            ActionSpec::DefaultPose { scale } | ActionSpec::Reference { scale } => scale as f32,
        };
        let joints = self.robot.joints();
        let [now, previous, before] = &mut scratch.efforts;
        for (out, values) in
            [(&mut *now, &episode.last), (&mut *previous, &episode.before), (&mut *before, &episode.oldest)]
        {
            out.clear();
            out.extend(values.iter().map(|y| y * scale));
        }
        let errors = Errors {
            layout: &self.library.layout,
            simulated: &scratch.features,
            reference: self.library.features_at(episode.frame),
            heading,
            path,
        };
        let torque_squared = self.state.torque_squared[i * joints..(i + 1) * joints].iter().sum();
        let effort = Effort { action: now, previous, before, torque_squared };
        episode.terms = self.plan.reward.terms(&errors, &effort, self.divisor);
        episode.terms[SMOOTHNESS].iter_mut().for_each(|term| *term *= self.smoothness);
    }

    /// Goes on with another clip where the robot is.
    fn switch(&self, i: usize, episode: &mut Episode) {
        let mut rng = stream(self.plan.seed, "switch", (self.first + i) as u64, self.step);
        episode.finished = Some((episode.stretch, episode.frame));
        episode.frame = self.sampler.draw(&mut rng);
        episode.stretch = episode.frame;
        episode.grace = (self.plan.episode.grace_seconds * self.robot.control_hz).round() as u64;
        episode.deviated = 0;
        let (p, q) = root(self.state, i);
        let library = self.library;
        episode.alignment =
            Alignment::between(library.position_at(episode.frame), library.orientation_at(episode.frame), p, q);
    }
}

/// Distance on the ground (m) and heading (rad, simulated less reference) against the anchored reference.
fn anchored(state: &BatchState, i: usize, library: &ReferenceLibrary, episode: &Episode) -> (f32, f32) {
    let (p, q) = root(state, i);
    let target = episode.alignment.position(library.position_at(episode.frame));
    let turned = episode.alignment.orientation(library.orientation_at(episode.frame));
    ((p[0] - target[0]).hypot(p[1] - target[1]), wrap(yaw(q) - yaw(turned)))
}
