//! The place of a reference's world in the robot's world.
//!
//! A clip may begin anywhere and face any way. When an episode begins (or switches to another clip) the two worlds are
//! laid over each other. A turn about the vertical and a shift on the ground do so; from then on path and heading can
//! be compared.

use lifelike_character::rotation::{Turn, from_wxyz, heading_angle};

/// `p ↦ turn(yaw) (p − from) + to` on the ground; heights stay.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Alignment {
    /// Turn about the vertical (rad).
    pub yaw: f32,
    /// A point of the clip's ground (m).
    pub from: [f32; 2],
    /// The same point in the robot's world (m).
    pub to: [f32; 2],
}

impl Alignment {
    /// Lays a clip's root pose over the robot's: same place on the ground, same heading.
    pub fn between(
        clip_position: [f32; 3],
        clip_orientation: [f32; 4],
        robot_position: [f32; 3],
        robot_orientation: [f32; 4],
    ) -> Self {
        Self {
            yaw: wrap(yaw(robot_orientation) - yaw(clip_orientation)),
            from: [clip_position[0], clip_position[1]],
            to: [robot_position[0], robot_position[1]],
        }
    }

    /// Returns it with its turn worked out, for who asks more than once.
    #[inline]
    pub fn laid(&self) -> Laid {
        Laid { turn: Turn::by(self.yaw), from: self.from, to: self.to }
    }

    /// Returns a point of the clip's world in the robot's.
    pub fn position(&self, p: [f32; 3]) -> [f32; 3] {
        self.laid().position(p)
    }

    /// Returns an orientation (`wxyz`) of the clip's world in the robot's.
    pub fn orientation(&self, q: [f32; 4]) -> [f32; 4] {
        let (s, c) = (0.5 * self.yaw).sin_cos();
        let [w, x, y, z] = q;
        [c * w - s * z, c * x - s * y, c * y + s * x, c * z + s * w]
    }

    /// Re-anchors the clip's world at a robot that has left it by `offset`: turned about the clip's root and shifted, no
    /// further than that the root's `clip` position is within `reach` (m) and `turn` (rad) of the robot's.
    #[must_use]
    pub fn re_anchored(self, clip: [f32; 3], offset: &Offset, reach: f32, turn: f32) -> Self {
        let [x, y] = offset.ground;
        let share = (1.0 - reach / offset.distance().max(reach)).max(0.0);
        let too_far = offset.heading - offset.heading.clamp(-turn, turn);
        Self {
            yaw: wrap(self.yaw + too_far),
            from: [clip[0], clip[1]],
            to: [offset.place[0] + share * x, offset.place[1] + share * y],
        }
    }
}

/// An [`Alignment`] with its turn worked out.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Laid {
    turn: Turn<f32>,
    from: [f32; 2],
    to: [f32; 2],
}

impl Laid {
    /// Returns a point of the clip's world in the robot's.
    #[inline]
    pub fn position(&self, p: [f32; 3]) -> [f32; 3] {
        let [x, y] = self.turn.on_ground([p[0] - self.from[0], p[1] - self.from[1]]);
        [x + self.to[0], y + self.to[1], p[2]]
    }

    /// Returns the heading, in the robot's world, of an orientation (`wxyz`) of the clip's; NaN where it has none.
    #[inline]
    pub fn heading(&self, q: [f32; 4]) -> Turn<f32> {
        let nowhere = Turn { cos: f32::NAN, sin: f32::NAN };
        self.turn.and(from_wxyz(q).map_or(nowhere, |q| Turn::heading(&q)))
    }

    /// Returns where a robot is, with this place and heading, against a root pose of the clip.
    #[inline]
    pub fn offset(&self, clip: ([f32; 3], [f32; 4]), position: [f32; 3], heading: Turn<f32>) -> Offset {
        let [x, y, _] = self.position(clip.0);
        Offset {
            place: [x, y],
            ground: [position[0] - x, position[1] - y],
            heading: heading.and(self.heading(clip.1).inverse()).angle(),
        }
    }
}

/// Pose of a robot against a frame of a clip that is laid in its world.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Offset {
    /// Place of the frame's root (m, robot's world).
    pub place: [f32; 2],
    /// Way from there to the robot's root (m, robot's world).
    pub ground: [f32; 2],
    /// Heading of the robot less that of the frame (rad, in −π..π).
    pub heading: f32,
}

impl Offset {
    /// Returns the distance on the ground (m).
    #[inline]
    pub fn distance(&self) -> f32 {
        (self.ground[0] * self.ground[0] + self.ground[1] * self.ground[1]).sqrt()
    }
}

/// Returns the heading of an orientation (rad); NaN where it has none.
pub fn yaw(wxyz: [f32; 4]) -> f32 {
    from_wxyz(wxyz).map_or(f32::NAN, |q| heading_angle(&q))
}

/// Returns the same angle in −π..π.
pub fn wrap(angle: f32) -> f32 {
    let turn = std::f32::consts::TAU;
    angle - turn * (angle / turn).round()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_two_root_poses_meet_and_a_step_ahead_is_a_step_ahead() {
        let half = std::f32::consts::FRAC_PI_4;
        // The clip faces +x at (3, 4); the simulated robot faces +y at (-1, 2).
        let a = Alignment::between(
            [3.0, 4.0, 0.9],
            [1.0, 0.0, 0.0, 0.0],
            [-1.0, 2.0, 0.8],
            [half.cos(), 0.0, 0.0, half.sin()],
        );
        let p = a.position([3.0, 4.0, 0.9]);
        assert!((p[0] + 1.0).abs() < 1e-6 && (p[1] - 2.0).abs() < 1e-6 && p[2] == 0.9, "{p:?}");
        let ahead = a.position([4.0, 4.0, 0.9]);
        assert!((ahead[0] + 1.0).abs() < 1e-6 && (ahead[1] - 3.0).abs() < 1e-6, "{ahead:?}");
        assert!((yaw(a.orientation([1.0, 0.0, 0.0, 0.0])) - 2.0 * half).abs() < 1e-6);
    }

    #[test]
    fn orientation_is_the_product_with_the_turn_about_z() {
        let a = Alignment { yaw: 0.7, ..Alignment::default() };
        let q = lifelike_character::Quat::from_euler_angles(0.3, -0.5, 1.1);
        let expected = lifelike_character::Quat::from_euler_angles(0.0, 0.0, 0.7) * q;
        let got = a.orientation([q.w as f32, q.i as f32, q.j as f32, q.k as f32]);
        for (g, e) in got.iter().zip([expected.w, expected.i, expected.j, expected.k]) {
            assert!((f64::from(*g) - e).abs() < 1e-6);
        }
    }

    #[test]
    fn re_anchoring_pulls_only_what_is_too_far_and_only_as_far_as_it_must() {
        let upright = |angle: f32| [(0.5 * angle).cos(), 0.0, 0.0, (0.5 * angle).sin()];
        let a = Alignment { yaw: 0.2, from: [1.0, 1.0], to: [5.0, -2.0] };
        let clip = ([2.0, 1.5, 0.4], upright(0.3));
        let target = a.position(clip.0);
        let re_anchored = |position: [f32; 3], angle: f32| {
            a.re_anchored(clip.0, &a.laid().offset(clip, position, Turn::by(angle)), 0.3, 0.5)
        };
        let near = re_anchored([target[0] + 0.1, target[1], 0.4], 0.6);
        let same = near.position([7.0, 8.0, 0.0]);
        let as_before = a.position([7.0, 8.0, 0.0]);
        assert!((0..2).all(|k| (same[k] - as_before[k]).abs() < 1e-5), "within reach nothing moves");

        // 0.5 m ahead along y and turned by 1.0 - 0.5 = 0.5 rad too far: pulled by 0.2 m and to the limit of the turn.
        let far = re_anchored([target[0], target[1] + 0.5, 0.4], 1.5);
        let pulled = far.position(clip.0);
        assert!((pulled[0] - target[0]).abs() < 1e-6 && (pulled[1] - target[1] - 0.2).abs() < 1e-6, "{pulled:?}");
        assert!((yaw(far.orientation(clip.1)) - 1.0).abs() < 1e-5);
    }

    #[test]
    fn angles_wrap() {
        assert!((wrap(6.0) - (6.0 - std::f32::consts::TAU)).abs() < 1e-6);
        assert!((wrap(-3.5) - (std::f32::consts::TAU - 3.5)).abs() < 1e-6);
        assert_eq!(wrap(1.0), 1.0);
    }
}
