//! Evaluation of a step in one environment: reward, termination, next observation.

use lifelike_robot::reference::Offset;
use lifelike_robot::{Alignment, ObservationSpec};
use lifelike_sim::BatchState;

use super::reserved::Reserved;
use super::setup::Setup;
use super::soles::Soles;
use super::stage::Stage;
use super::state::write_features;
use crate::episode::Episode;
use crate::observe::Observed;
use crate::observe::root;
use crate::reference::RsiSampler;
use crate::rewards::{ActionCost, RewardInputs, TERMS, scale_penalties, sum};
use crate::terminations::Cause;
use crate::tracking_error::TrackingError;

/// Everything that the evaluation of a step reads.
pub(super) struct StepEvaluator<'a> {
    pub(super) setup: &'a Setup,
    pub(super) stage: &'a Stage,
    pub(super) rsi: &'a RsiSampler,
    pub(super) reserved: Option<&'a Reserved>,
    pub(super) soles: &'a Soles,
    pub(super) state: &'a BatchState,
    /// Steps done, this one included.
    pub(super) step: u64,
}

impl StepEvaluator<'_> {
    /// Moves the episode of environment `i` on by a step, and writes the features it reached and the next observations.
    pub(super) fn evaluate(
        &self,
        i: usize,
        episode: &mut Episode,
        features: &mut [f32],
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
        let heading = write_features(self.state, i, self.setup, features);
        let (position, _) = root(self.state, i);
        let clip = (library.position_at(episode.frame), library.orientation_at(episode.frame));
        let offset = episode.alignment.laid().offset(clip, position, heading);
        self.reward(i, episode, features, &offset);
        let reference = library.features_at(episode.frame);
        let error = TrackingError::between(&library.layout, features, reference, &offset);
        episode.joint_error = error.joints;
        let limits = &self.stage.limits;
        let far = limits.persistent.is_some_and(|p| error.effector > p.distance);
        episode.deviated = if far { episode.deviated + 1 } else { 0 };
        if episode.grace > 0 {
            episode.grace -= 1;
        } else {
            episode.failed = limits.exceeded(&error, episode.deviated as f64 / robot.control_hz);
        }
        if episode.reward().is_finite() {
            episode.episode_return += episode.reward();
        } else {
            episode.terms = [0.0; TERMS.len()];
            episode.failed = Some(Cause::Diverged);
        }
        let over = episode.frame >= clip_end;
        let switch = over && plan.episode.switch_clips;
        let late = episode.length >= self.setup.longest_episode();
        episode.truncated = episode.failed.is_none() && (late || (over && !switch));
        if switch && !episode.ended() {
            self.switch(i, episode);
        } else if plan.episode.reanchor {
            let (reach, turn) = (ObservationSpec::ANCHOR_REACH, ObservationSpec::ANCHOR_TURN);
            episode.alignment = episode.alignment.re_anchored(clip.0, &offset, reach, turn);
        }
        episode.memory.advance();
        let observed = Observed { state: self.state, i, episode, library, features, heading };
        self.setup.observer.write(&observed, actor, critic);
        self.setup.sensors.measure(actor, episode, || self.setup.stream("sense", i, self.step));
        self.setup.observer.recall(&mut episode.memory, actor);
    }

    fn reward(&self, i: usize, episode: &mut Episode, features: &[f32], offset: &Offset) {
        let Setup { plan, robot, library, divisor, .. } = self.setup;
        let torques = &self.state.torque_squared[i * robot.joints()..(i + 1) * robot.joints()];
        let inputs = RewardInputs {
            layout: &library.layout,
            simulated: features,
            reference: library.features_at(episode.frame),
            divisor,
            heading: offset.heading,
            path: offset.distance(),
            slip_square: self.soles.slip_square(self.state, i),
            missed_swings: self.soles.missed_swings(self.state, i, episode.frame),
            cost: ActionCost {
                action: &episode.last,
                previous: &episode.before,
                oldest: &episode.oldest,
                scale: self.setup.action_scale(),
                torque_squared: sum([torques], |[square]| square),
            },
        };
        episode.terms = plan.reward.terms(&inputs);
        scale_penalties(&mut episode.terms, self.stage.smoothness);
    }

    /// Goes on with another clip from where the robot is.
    fn switch(&self, i: usize, episode: &mut Episode) {
        let Setup { plan, robot, library, .. } = self.setup;
        let mut rng = self.setup.stream("switch", i, self.step);
        episode.finished_segment = Some((episode.segment_start, episode.frame));
        episode.frame = self.reserved.map_or(self.rsi, |reserved| reserved.sampler(i)).draw(&mut rng);
        episode.segment_start = episode.frame;
        episode.grace = (plan.episode.grace_seconds * robot.control_hz).round() as u64;
        episode.deviated = 0;
        let (p, q) = root(self.state, i);
        episode.alignment =
            Alignment::between(library.position_at(episode.frame), library.orientation_at(episode.frame), p, q);
    }
}
