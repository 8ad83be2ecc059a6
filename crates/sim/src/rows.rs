//! The outputs of some environments, cut out of [`BatchState`] so that threads can write side by side.

use crate::batch::BatchState;

/// Columns of the outputs.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Widths {
    /// Scalar joints J.
    pub joints: usize,
    /// Places P.
    pub places: usize,
    /// Bodies B.
    pub bodies: usize,
    /// Feet F.
    pub feet: usize,
}

/// The outputs of environments that lie side by side. See [`BatchState`] for the fields.
pub(crate) struct Rows<'a> {
    pub root_position: &'a mut [f32],
    pub root_orientation: &'a mut [f32],
    pub linear_velocity_w: &'a mut [f32],
    pub angular_velocity_w: &'a mut [f32],
    pub joint_position: &'a mut [f32],
    pub joint_velocity: &'a mut [f32],
    pub place_position: &'a mut [f32],
    pub body_position: &'a mut [f32],
    pub body_orientation: &'a mut [f32],
    pub torque_squared: &'a mut [f32],
    pub torque: &'a mut [f32],
    pub foot_force: &'a mut [f32],
    pub constraint_force: &'a mut [f32],
    pub diverged: &'a mut [bool],
}

/// Outputs of `n` environments, all zero.
pub(crate) fn allocate(n: usize, widths: &Widths) -> BatchState {
    BatchState {
        root_position: vec![0.0; n * 3],
        root_orientation: vec![0.0; n * 4],
        linear_velocity_w: vec![0.0; n * 3],
        angular_velocity_w: vec![0.0; n * 3],
        joint_position: vec![0.0; n * widths.joints],
        joint_velocity: vec![0.0; n * widths.joints],
        place_position: vec![0.0; n * widths.places * 3],
        body_position: vec![0.0; n * widths.bodies * 3],
        body_orientation: vec![0.0; n * widths.bodies * 4],
        torque_squared: vec![0.0; n * widths.joints],
        torque: vec![0.0; n * widths.joints],
        foot_force: vec![0.0; n * widths.feet],
        constraint_force: vec![0.0; n * widths.joints],
        diverged: vec![false; n],
    }
}

/// The outputs of one environment.
pub(crate) fn single<'a>(state: &'a mut BatchState, id: usize, widths: &Widths) -> Rows<'a> {
    let mut rows = Rows::whole(state);
    rows.take(id, widths);
    rows.take(1, widths)
}

fn cut<'a, T>(rest: &mut &'a mut [T], n: usize) -> &'a mut [T] {
    let (head, tail) = std::mem::take(rest).split_at_mut(n);
    *rest = tail;
    head
}

impl<'a> Rows<'a> {
    /// All environments.
    pub fn whole(state: &'a mut BatchState) -> Self {
        Self {
            root_position: &mut state.root_position,
            root_orientation: &mut state.root_orientation,
            linear_velocity_w: &mut state.linear_velocity_w,
            angular_velocity_w: &mut state.angular_velocity_w,
            joint_position: &mut state.joint_position,
            joint_velocity: &mut state.joint_velocity,
            place_position: &mut state.place_position,
            body_position: &mut state.body_position,
            body_orientation: &mut state.body_orientation,
            torque_squared: &mut state.torque_squared,
            torque: &mut state.torque,
            foot_force: &mut state.foot_force,
            constraint_force: &mut state.constraint_force,
            diverged: &mut state.diverged,
        }
    }

    /// The first `n` environments; the others stay in `self`.
    pub fn take(&mut self, n: usize, widths: &Widths) -> Rows<'a> {
        Rows {
            root_position: cut(&mut self.root_position, n * 3),
            root_orientation: cut(&mut self.root_orientation, n * 4),
            linear_velocity_w: cut(&mut self.linear_velocity_w, n * 3),
            angular_velocity_w: cut(&mut self.angular_velocity_w, n * 3),
            joint_position: cut(&mut self.joint_position, n * widths.joints),
            joint_velocity: cut(&mut self.joint_velocity, n * widths.joints),
            place_position: cut(&mut self.place_position, n * widths.places * 3),
            body_position: cut(&mut self.body_position, n * widths.bodies * 3),
            body_orientation: cut(&mut self.body_orientation, n * widths.bodies * 4),
            torque_squared: cut(&mut self.torque_squared, n * widths.joints),
            torque: cut(&mut self.torque, n * widths.joints),
            foot_force: cut(&mut self.foot_force, n * widths.feet),
            constraint_force: cut(&mut self.constraint_force, n * widths.joints),
            diverged: cut(&mut self.diverged, n),
        }
    }
}
