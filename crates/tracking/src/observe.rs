//! Observations of the policy and of the value function.

use std::sync::Arc;

use lifelike_character::rotation::Turn;
use lifelike_motion::FeatureLayout;
use lifelike_robot::observation::Memory;
use lifelike_robot::{
    ClipPlayer, MeasuredState, ObservationInputs, ObservationSpec, ReferenceLibrary, ReferenceStream, Robot,
};
use lifelike_sim::BatchState;

use crate::episode::Episode;

/// Returns root position (m) and orientation (`wxyz`) of one environment.
#[inline]
pub(crate) fn root(state: &BatchState, i: usize) -> ([f32; 3], [f32; 4]) {
    let p = &state.root_position[3 * i..3 * i + 3];
    let q = &state.root_orientation[4 * i..4 * i + 4];
    ([p[0], p[1], p[2]], [q[0], q[1], q[2], q[3]])
}

/// One environment at one moment.
#[derive(Clone, Copy)]
pub struct Observed<'a> {
    /// States of all environments.
    pub state: &'a BatchState,
    /// Number of this one.
    pub i: usize,
    /// Its episode.
    pub episode: &'a Episode,
    /// The motion to follow.
    pub library: &'a ReferenceLibrary,
    /// Features of its simulated state, the height above the ground below it.
    pub features: &'a [f32],
    /// Heading of its root.
    pub heading: Turn<f32>,
}

/// Writes observations: the robot's own layout for the policy; for the value function, which only exists in training,
/// also what a robot cannot measure.
#[derive(Debug, Clone)]
pub struct Observer {
    spec: ObservationSpec,
    remembered: Vec<usize>,
    joints: usize,
    effectors: usize,
    feet: usize,
    weight: f32,
    layout: Arc<FeatureLayout>,
}

impl Observer {
    /// Returns the observer of a robot.
    pub fn new(robot: &Robot, spec: ObservationSpec) -> Self {
        Self {
            remembered: spec.remembered(),
            spec,
            joints: robot.joints(),
            effectors: robot.effectors.len(),
            feet: robot.anatomy.soles.len(),
            weight: (robot.character.mass() * robot.character.gravity.norm()).max(1e-3) as f32,
            layout: Arc::new(robot.layout.clone()),
        }
    }

    /// Returns the policy's layout.
    pub fn spec(&self) -> &ObservationSpec {
        &self.spec
    }

    /// Returns the length of the policy's row.
    pub fn actor_size(&self) -> usize {
        self.spec.size()
    }

    /// Returns the length of the last part of the policy's row, which the value function does not see: history or window.
    fn hidden_size(&self) -> usize {
        self.spec.window_size() + self.spec.history_size()
    }

    /// Takes note of an observation as the policy sees it, where it sees earlier ones.
    pub(crate) fn recall(&self, memory: &mut Memory, row: &mut [f32]) {
        memory.recall(&self.spec, &self.remembered, row);
    }

    /// Returns how many numbers of an observation the policy sees again in later steps.
    pub(crate) fn remembered(&self) -> usize {
        self.remembered.len()
    }

    /// Returns the length of the value function's row: the policy's, less history and window, then root height
    /// and its error, errors of root velocities (6), end effectors (3 each) and joints. Path (2, robot's heading
    /// frame) and heading error follow, the steps for which the deviation has lasted, and each foot's share of the
    /// weight.
    ///
    /// The time left is not in it: a truncated episode is valued as if it went on, so the value must not depend on it.
    pub fn critic_size(&self) -> usize {
        self.actor_size() - self.hidden_size() + 2 + 6 + 3 * self.effectors + self.joints + 3 + 1 + self.feet
    }

    /// Writes both rows.
    pub fn write(&self, of: &Observed<'_>, actor: &mut [f32], critic: &mut [f32]) {
        let &Observed { state, i, episode, library, features, heading } = of;
        let player = ClipPlayer::new(library, episode.frame);
        self.write_seen(of, &player, actor);

        let (target, reference) = (player.root(), player.around(0));
        let (position, _) = root(state, i);
        let offset = episode.alignment.laid().offset((target.position, target.orientation), position, heading);
        let (seen, mut rest) = critic.split_at_mut(actor.len() - self.hidden_size());
        seen.copy_from_slice(&actor[..seen.len()]);
        let height = features[FeatureLayout::HEIGHT];
        take(&mut rest, 2).copy_from_slice(&[height, height - reference[FeatureLayout::HEIGHT]]);
        for range in [FeatureLayout::VELOCITY, self.layout.effectors(), self.layout.joint_positions()] {
            let pairs = features[range.clone()].iter().zip(&reference[range.clone()]);
            take(&mut rest, range.len()).iter_mut().zip(pairs).for_each(|(out, (a, b))| *out = a - b);
        }
        let [ahead, left] = heading.inverse().on_ground(offset.ground);
        take(&mut rest, 4).copy_from_slice(&[ahead, left, offset.heading, episode.deviated as f32]);
        for (foot, out) in rest.iter_mut().enumerate() {
            *out = state.foot_force.get(i * self.feet + foot).copied().unwrap_or(0.0) / self.weight;
        }
    }

    /// Writes the policy's row alone.
    pub fn write_policy(&self, of: &Observed<'_>, out: &mut [f32]) {
        self.write_seen(of, &ClipPlayer::new(of.library, of.episode.frame), out);
    }

    fn write_seen(&self, of: &Observed<'_>, player: &ClipPlayer<&ReferenceLibrary>, out: &mut [f32]) {
        let &Observed { state, i, episode, features, .. } = of;
        let measured =
            MeasuredState { root_height: Some(features[FeatureLayout::HEIGHT]), ..state.measured(i, self.effectors) };
        let inputs = ObservationInputs {
            measured: &measured,
            joint_offset: &episode.offset,
            last_action: &episode.last,
            action_before: &episode.before,
            reference: player,
            alignment: episode.alignment,
            past: episode.memory.past(),
            latent: if self.spec.reference.latent > 0 { player.latent().unwrap_or_default() } else { &[] },
        };
        if self.spec.write(&inputs, out).is_err() {
            // Lengths were checked when the environment was made; were one wrong all the same, NaN makes it visible.
            out.fill(f32::NAN);
        }
    }
}

/// Returns the next `n` numbers of a row.
fn take<'a>(rest: &mut &'a mut [f32], n: usize) -> &'a mut [f32] {
    let (head, tail) = std::mem::take(rest).split_at_mut(n);
    *rest = tail;
    head
}
