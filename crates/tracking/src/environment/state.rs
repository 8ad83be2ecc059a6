//! Reading one environment out of a batch of simulated states.

use lifelike_character::rotation::from_wxyz;
use lifelike_character::{Quat, Vec3};
use lifelike_motion::Frame;
use lifelike_sim::BatchState;

/// Returns root position (m) and orientation (`wxyz`) of one environment.
pub(crate) fn root(state: &BatchState, i: usize) -> ([f32; 3], [f32; 4]) {
    let p = &state.root_position[3 * i..3 * i + 3];
    let q = &state.root_orientation[4 * i..4 * i + 4];
    ([p[0], p[1], p[2]], [q[0], q[1], q[2], q[3]])
}

/// Reads one environment of a batch into a frame, whose vectors are reused. A root without orientation (a diverged
/// environment) is taken as upright.
///
/// `effectors` is the number of sites that are end effectors: the first ones.
pub(super) fn read_frame(state: &BatchState, environment: usize, joints: usize, effectors: usize, out: &mut Frame) {
    let i = environment;
    let vector = |values: &[f32], at: usize| Vec3::new(values[at].into(), values[at + 1].into(), values[at + 2].into());
    let q = &state.root_orientation[4 * i..4 * i + 4];
    out.root_position = vector(&state.root_position, 3 * i);
    out.root_orientation =
        from_wxyz([q[0].into(), q[1].into(), q[2].into(), q[3].into()]).unwrap_or_else(Quat::identity);
    out.linear_velocity_w = vector(&state.linear_velocity_w, 3 * i);
    out.angular_velocity_w = vector(&state.angular_velocity_w, 3 * i);
    let row = i * joints..(i + 1) * joints;
    out.joint_positions.clear();
    out.joint_positions.extend(state.joint_position[row.clone()].iter().map(|x| f64::from(*x)));
    out.joint_velocities.clear();
    out.joint_velocities.extend(state.joint_velocity[row].iter().map(|x| f64::from(*x)));
    let sites = state.site_position.len() / state.root_position.len().max(1);
    out.effectors_w.clear();
    out.effectors_w.extend((0..effectors).map(|p| vector(&state.site_position, 3 * (i * sites + p))));
}

/// Returns a frame to read into.
pub(super) fn empty_frame() -> Frame {
    Frame {
        root_position: Vec3::zeros(),
        root_orientation: Quat::identity(),
        linear_velocity_w: Vec3::zeros(),
        angular_velocity_w: Vec3::zeros(),
        joint_positions: Vec::new(),
        joint_velocities: Vec::new(),
        effectors_w: Vec::new(),
    }
}
