//! What policy and value function see of one environment.

use std::sync::Arc;

use lifelike_motion::FeatureLayout;
use lifelike_robot::{ObservationInputs, ObservationSpec, Robot};
use lifelike_sim::BatchState;

use super::alignment::{wrap, yaw};
use super::episode::Episode;
use super::errors::root;
use super::library::ReferenceLibrary;

/// Writes observations: the robot's own layout for the policy; for the value function, which only exists in training,
/// also what a robot cannot measure.
#[derive(Debug, Clone)]
pub struct Observer {
    spec: ObservationSpec,
    joints: usize,
    effectors: usize,
    feet: usize,
    weight: f32,
    layout: Arc<FeatureLayout>,
}

impl Observer {
    /// For a robot.
    pub fn new(robot: &Robot, spec: ObservationSpec) -> Self {
        Self {
            spec,
            joints: robot.joints(),
            effectors: robot.effectors.len(),
            feet: robot.anatomy.soles.len(),
            weight: (robot.character.mass() * robot.character.gravity.norm()).max(1e-3) as f32,
            layout: Arc::new(robot.layout.clone()),
        }
    }

    /// The policy's layout.
    pub fn spec(&self) -> &ObservationSpec {
        &self.spec
    }

    /// Length of the policy's row.
    pub fn actor_size(&self) -> usize {
        self.spec.size()
    }

    /// Length of the value function's row: the policy's, less the window that it encodes, then root height and its error, errors of root velocities (6),
    /// end effectors (3 each) and joints, path (2, robot's heading frame) and heading error, the steps for which the
    /// deviation has lasted, and each foot's load as a share of the weight.
    ///
    /// Not the time left: an episode that is cut is valued as if it went on, so the value must not depend on it.
    pub fn critic_size(&self) -> usize {
        self.actor_size() - self.spec.window_size() + 2 + 6 + 3 * self.effectors + self.joints + 3 + 1 + self.feet
    }

    /// Writes both rows. `next` is the frame to reach, `features` those of the simulated state.
    #[allow(clippy::too_many_arguments)]
    pub fn write(
        &self,
        state: &BatchState,
        i: usize,
        episode: &Episode,
        library: &ReferenceLibrary,
        next: usize,
        features: &[f32],
        actor: &mut [f32],
        critic: &mut [f32],
    ) {
        let reference = library.features_at(next);
        let (position, orientation) = root(state, i);
        let target_position = episode.alignment.position(library.position_at(next));
        let target_orientation = episode.alignment.orientation(library.orientation_at(next));
        self.write_actor(state, i, episode, library, next, (target_position, target_orientation), actor);
        if self.spec.root_height {
            // Above the ground, as in the features; the layout has it first.
            actor[0] = features[FeatureLayout::HEIGHT];
        }

        let (seen, extra) = critic.split_at_mut(actor.len() - self.spec.window_size());
        seen.copy_from_slice(&actor[..seen.len()]);
        let mut at = 0;
        let mut put = |x: f32| {
            extra[at] = x;
            at += 1;
        };
        put(features[FeatureLayout::HEIGHT]);
        put(features[FeatureLayout::HEIGHT] - reference[FeatureLayout::HEIGHT]);
        for range in [FeatureLayout::VELOCITY, self.layout.effectors(), self.layout.joint_positions()] {
            features[range.clone()].iter().zip(&reference[range]).for_each(|(a, b)| put(a - b));
        }
        let heading = yaw(orientation);
        let (sin, cos) = heading.sin_cos();
        let (x, y) = (position[0] - target_position[0], position[1] - target_position[1]);
        put(cos * x + sin * y);
        put(cos * y - sin * x);
        put(wrap(heading - yaw(target_orientation)));
        put(episode.deviated as f32);
        for foot in 0..self.feet {
            put(state.foot_force.get(i * self.feet + foot).copied().unwrap_or(0.0) / self.weight);
        }
    }

    #[allow(clippy::too_many_arguments)]
    fn write_actor(
        &self,
        state: &BatchState,
        i: usize,
        episode: &Episode,
        library: &ReferenceLibrary,
        next: usize,
        (target_position, target_orientation): ([f32; 3], [f32; 4]),
        out: &mut [f32],
    ) {
        let three = |values: &[f32]| [values[3 * i], values[3 * i + 1], values[3 * i + 2]];
        let (root_position, root_orientation) = root(state, i);
        let row = i * self.joints..(i + 1) * self.joints;
        let measured: Vec<f32> =
            state.joint_position[row.clone()].iter().zip(&episode.offset).map(|(q, o)| q + o).collect();
        let places = state.place_position.len() / state.root_position.len().max(1);
        let keys = 3 * (i * places + self.effectors)..3 * (i + 1) * places;
        let mut future = Vec::with_capacity(self.spec.reference.future.len() * self.layout.size());
        for offset in &self.spec.reference.future {
            future.extend_from_slice(library.features_at(library.ahead(episode.frame, *offset as usize)));
        }
        let window = library.window_at(next, &self.spec.reference.window);
        let inputs = ObservationInputs {
            root_position,
            root_orientation,
            linear_velocity_w: three(&state.linear_velocity_w),
            angular_velocity_w: three(&state.angular_velocity_w),
            joint_position: &measured,
            joint_velocity: &state.joint_velocity[row],
            key_bodies_w: &state.place_position[keys],
            last_action: &episode.last,
            action_before: &episode.before,
            reference: if self.spec.reference.frame { library.features_at(next) } else { &[] },
            future: &future,
            latent: if self.spec.reference.latent > 0 { library.latent_at(next) } else { &[] },
            window: &window,
            reference_root_position: target_position,
            reference_root_orientation: target_orientation,
        };
        if self.spec.write(inputs, out).is_err() {
            // Lengths were checked when the environment was made; were one wrong all the same, NaN makes it visible.
            out.fill(f32::NAN);
        }
    }
}
