//! Evaluation of a step in one environment: reward, termination, next observation.

use lifelike_motion::{FeatureLayout, Frame};
use lifelike_robot::reference::{wrap, yaw};
use lifelike_robot::{Alignment, ObservationSpec, ReferenceLibrary};
use lifelike_sim::BatchState;

use super::episode::Episode;
use super::setup::Setup;
use super::stage::Stage;
use super::state::{empty_frame, read_frame, root};
use super::tracking_error::TrackingError;
use crate::observe::Observed;
use crate::reference::RsiSampler;
use crate::rewards::{ActionCost, RewardInputs, TERMS, scale_penalties};
use crate::terminations::Cause;

/// Everything that the evaluation of a step reads.
pub(super) struct StepEvaluator<'a> {
    pub(super) setup: &'a Setup,
    pub(super) stage: &'a Stage,
    pub(super) rsi: &'a RsiSampler,
    pub(super) state: &'a BatchState,
    /// Steps done, this one included.
    pub(super) step: u64,
}

/// One thread's workspace.
pub(super) struct Workspace {
    frame: Frame,
    row: Vec<f64>,
    pub(super) features: Vec<f32>,
    actions: [Vec<f32>; 3],
}

impl Workspace {
    pub(super) fn new() -> Self {
        Self { frame: empty_frame(), row: Vec::new(), features: Vec::new(), actions: Default::default() }
    }

    /// Computes the features of one simulated environment; its height is that above the ground below its root.
    pub(super) fn read(&mut self, state: &BatchState, i: usize, setup: &Setup) {
        let (robot, library, ground) = (&setup.robot, &setup.library, &setup.ground);
        read_frame(state, i, robot.joints(), robot.effectors.len(), &mut self.frame);
        self.row.resize(library.layout.size(), 0.0);
        self.frame.write_features(&self.frame.root_orientation, &mut self.row);
        self.row[FeatureLayout::HEIGHT] -= ground.height(self.frame.root_position.x, self.frame.root_position.y);
        self.features.clear();
        self.features.extend(self.row.iter().map(|x| *x as f32));
    }
}

impl StepEvaluator<'_> {
    /// Moves the episode of environment `i` on by a step, and writes the next observations.
    pub(super) fn evaluate(
        &self,
        i: usize,
        episode: &mut Episode,
        workspace: &mut Workspace,
        actor: &mut [f32],
        critic: &mut [f32],
    ) {
        let Setup { plan, robot, library, .. } = self.setup;
        let clip_end = library.starts[library.clip_of(episode.frame) + 1] - 1;
        episode.frame = (episode.frame + 1).min(clip_end);
        episode.length += 1;
        episode.failed = None;
        episode.truncated = false;
        episode.finished_segment = None;
        if self.state.diverged[i] {
            episode.terms = [0.0; TERMS.len()];
            episode.failed = Some(Cause::Diverged);
            return;
        }
        workspace.read(self.state, i, self.setup);
        let (path, heading) = anchored(self.state, i, library, episode);
        self.reward(i, episode, workspace, path, heading);
        let reference = library.features_at(episode.frame);
        let error = TrackingError::between(&library.layout, &workspace.features, reference, path, heading);
        let limits = &self.stage.limits;
        let far = limits.persistent.is_some_and(|p| error.effector > p.distance);
        episode.deviated = if far { episode.deviated + 1 } else { 0 };
        if episode.grace > 0 {
            episode.grace -= 1;
        } else {
            episode.failed = limits.exceeded(&error, episode.deviated as f64 / robot.control_hz);
        }
        if !episode.reward().is_finite() {
            episode.terms = [0.0; TERMS.len()];
            episode.failed = Some(Cause::Diverged);
        }
        episode.episode_return += episode.reward();
        let over = episode.frame >= clip_end;
        let switch = over && plan.episode.switch_clips;
        let late = episode.length >= self.setup.longest_episode();
        episode.truncated = episode.failed.is_none() && (late || (over && !switch));
        if switch && !episode.ended() {
            self.switch(i, episode);
        } else if plan.episode.reanchor {
            let (reach, turn) = (ObservationSpec::ANCHOR_REACH, ObservationSpec::ANCHOR_TURN);
            let clip = (library.position_at(episode.frame), library.orientation_at(episode.frame));
            episode.alignment = episode.alignment.re_anchored(clip, root(self.state, i), reach, turn);
        }
        let observed = Observed { state: self.state, i, episode, library, features: &workspace.features };
        self.setup.observer.write(&observed, actor, critic);
        self.setup.sensors.measure(actor, episode, || self.setup.stream("sense", i, self.step));
    }

    fn reward(&self, i: usize, episode: &mut Episode, workspace: &mut Workspace, path: f32, heading: f32) {
        let Setup { plan, robot, library, divisor, .. } = self.setup;
        let (scale, joints) = (self.setup.action_scale(), robot.joints());
        let [action, previous, oldest] = &mut workspace.actions;
        for (out, values) in
            [(&mut *action, &episode.last), (&mut *previous, &episode.before), (&mut *oldest, &episode.oldest)]
        {
            out.clear();
            out.extend(values.iter().map(|y| y * scale));
        }
        let torque_squared = self.state.torque_squared[i * joints..(i + 1) * joints].iter().sum();
        let inputs = RewardInputs {
            layout: &library.layout,
            simulated: &workspace.features,
            reference: library.features_at(episode.frame),
            divisor,
            heading,
            path,
            cost: ActionCost { action, previous, oldest, torque_squared },
        };
        episode.terms = plan.reward.terms(&inputs);
        scale_penalties(&mut episode.terms, self.stage.smoothness);
    }

    /// Goes on with another clip from where the robot is.
    fn switch(&self, i: usize, episode: &mut Episode) {
        let Setup { plan, robot, library, .. } = self.setup;
        let mut rng = self.setup.stream("switch", i, self.step);
        episode.finished_segment = Some((episode.segment_start, episode.frame));
        episode.frame = self.rsi.draw(&mut rng);
        episode.segment_start = episode.frame;
        episode.grace = (plan.episode.grace_seconds * robot.control_hz).round() as u64;
        episode.deviated = 0;
        let (p, q) = root(self.state, i);
        episode.alignment =
            Alignment::between(library.position_at(episode.frame), library.orientation_at(episode.frame), p, q);
    }
}

/// Returns the distance on the ground (m) and the heading (rad, simulated less reference) against the anchored reference.
fn anchored(state: &BatchState, i: usize, library: &ReferenceLibrary, episode: &Episode) -> (f32, f32) {
    let (p, q) = root(state, i);
    let target = episode.alignment.position(library.position_at(episode.frame));
    let turned = episode.alignment.orientation(library.orientation_at(episode.frame));
    ((p[0] - target[0]).hypot(p[1] - target[1]), wrap(yaw(q) - yaw(turned)))
}
