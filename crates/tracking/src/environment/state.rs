//! Reading one environment out of a batch of simulated states.

use lifelike_character::rotation::{Turn, from_wxyz};
use lifelike_motion::{FeatureLayout, FrameRef};
use lifelike_sim::BatchState;

use super::setup::Setup;
use crate::observe::root;

/// Writes the features of one simulated environment, their height that above the ground below its root, and returns its
/// heading. A root without orientation (a diverged environment) is taken as upright.
#[inline]
pub(super) fn write_features(state: &BatchState, i: usize, setup: &Setup, out: &mut [f32]) -> Turn<f32> {
    let (joints, effectors) = (setup.robot.joints(), setup.robot.effectors.len());
    let (position, orientation) = root(state, i);
    let vector = |values: &[f32]| [values[3 * i], values[3 * i + 1], values[3 * i + 2]].into();
    let sites = state.site_position.len() / state.root_position.len().max(1);
    let frame = FrameRef {
        root_position: position.into(),
        root_orientation: from_wxyz(orientation).unwrap_or_default(),
        linear_velocity_w: vector(&state.linear_velocity_w),
        angular_velocity_w: vector(&state.angular_velocity_w),
        joint_positions: &state.joint_position[i * joints..(i + 1) * joints],
        joint_velocities: &state.joint_velocity[i * joints..(i + 1) * joints],
    };
    let heading = Turn::heading(&frame.root_orientation);
    let places = state.site_position[3 * i * sites..3 * (i * sites + effectors)].as_chunks::<3>().0;
    frame.write_features(places.iter().map(|place| (*place).into()), heading, out);
    let [x, y, z] = position.map(f64::from);
    out[FeatureLayout::HEIGHT] = (z - setup.ground.height(x, y)) as f32;
    heading
}
