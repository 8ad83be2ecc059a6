//! The outputs of some environments, cut out of [`BatchState`] so that threads can write side by side.

use lifelike_robot::Robot;

use crate::batch::BatchState;

/// Sizes of a robot: of its coordinates, and of the columns of the outputs.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Sizes {
    /// Generalised positions.
    pub nq: usize,
    /// Generalised velocities.
    pub nv: usize,
    /// First position of the free root; none for a robot that is fixed to the world.
    pub root_q: Option<usize>,
    /// Scalar joints J.
    pub joints: usize,
    /// Sites P: end effectors and key bodies.
    pub sites: usize,
    /// Bodies B.
    pub bodies: usize,
    /// Feet F.
    pub feet: usize,
}

impl Sizes {
    /// Numbers of an environment's outputs.
    pub fn columns(&self) -> usize {
        13 + 5 * self.joints + 3 * self.sites + 7 * self.bodies + self.feet
    }

    /// Sizes of a robot.
    pub fn of(robot: &Robot) -> Self {
        let character = &robot.character;
        Self {
            nq: character.nq,
            nv: character.nv,
            root_q: character.root_joint().map(|j| j.q_index),
            joints: robot.joints(),
            sites: robot.effectors.len() + robot.key_bodies.len(),
            bodies: character.bodies.len(),
            feet: robot.anatomy.soles.len(),
        }
    }
}

/// Declares the columns of [`BatchState`] and their widths, once for all that goes over them.
macro_rules! columns {
    ($($field:ident: |$sizes:pat_param| $width:expr,)+) => {
        /// The outputs of environments that lie side by side. See [`BatchState`] for the fields.
        pub(crate) struct Rows<'a> {
            $(pub $field: &'a mut [f32],)+
            pub diverged: &'a mut [bool],
        }

        /// Outputs of `n` environments, all zero.
        pub(crate) fn allocate(n: usize, sizes: &Sizes) -> BatchState {
            BatchState {
                $($field: { let $sizes = sizes; vec![0.0; n * $width] },)+
                diverged: vec![false; n],
            }
        }

        /// Copies the outputs of one environment.
        pub(crate) fn copy(from: &BatchState, to: &mut BatchState, id: usize, sizes: &Sizes) {
            $({
                let $sizes = sizes;
                let row = id * $width..(id + 1) * $width;
                to.$field[row.clone()].copy_from_slice(&from.$field[row]);
            })+
            to.diverged[id] = from.diverged[id];
        }

        impl<'a> Rows<'a> {
            /// All environments.
            pub fn whole(state: &'a mut BatchState) -> Self {
                Self { $($field: &mut state.$field,)+ diverged: &mut state.diverged }
            }

            /// The first `n` environments; the others stay in `self`.
            pub fn take(&mut self, n: usize, sizes: &Sizes) -> Rows<'a> {
                Rows {
                    $($field: { let $sizes = sizes; cut(&mut self.$field, n * $width) },)+
                    diverged: cut(&mut self.diverged, n),
                }
            }
        }
    };
}

columns! {
    root_position: |_| 3,
    root_orientation: |_| 4,
    linear_velocity_w: |_| 3,
    angular_velocity_w: |_| 3,
    joint_position: |s| s.joints,
    joint_velocity: |s| s.joints,
    site_position: |s| s.sites * 3,
    body_position: |s| s.bodies * 3,
    body_orientation: |s| s.bodies * 4,
    torque_squared: |s| s.joints,
    torque: |s| s.joints,
    foot_force: |s| s.feet,
    constraint_force: |s| s.joints,
}

/// The outputs of one environment.
pub(crate) fn single<'a>(state: &'a mut BatchState, id: usize, sizes: &Sizes) -> Rows<'a> {
    let mut rows = Rows::whole(state);
    rows.take(id, sizes);
    rows.take(1, sizes)
}

fn cut<'a, T>(rest: &mut &'a mut [T], n: usize) -> &'a mut [T] {
    let (head, tail) = std::mem::take(rest).split_at_mut(n);
    *rest = tail;
    head
}

impl Rows<'_> {
    /// The columns that say where everything is and how it moves: all but torques, forces and divergence.
    pub fn kinematic_columns(&mut self) -> [&mut [f32]; 9] {
        [
            self.root_position,
            self.root_orientation,
            self.linear_velocity_w,
            self.angular_velocity_w,
            self.joint_position,
            self.joint_velocity,
            self.site_position,
            self.body_position,
            self.body_orientation,
        ]
    }

    /// The other columns.
    pub fn force_columns(&mut self) -> [&mut [f32]; 4] {
        [self.torque_squared, self.torque, self.foot_force, self.constraint_force]
    }

    /// Sets torques and forces to zero: those of environments that did not step, or have diverged.
    pub fn clear_forces(&mut self) {
        self.force_columns().into_iter().for_each(|forces| forces.fill(0.0));
    }
}
