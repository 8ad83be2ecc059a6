//! The place of a reference's world in the robot's world.
//!
//! A clip may begin anywhere and face any way. When an episode begins (or switches to another clip) the two worlds are laid
//! over each other, by a turn about the vertical and a shift on the ground; from then on path and heading can be compared.

use lifelike_character::rotation::{from_wxyz, heading_angle};

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

    /// Returns a point of the clip's world in the robot's.
    pub fn position(&self, p: [f32; 3]) -> [f32; 3] {
        let (sin, cos) = self.yaw.sin_cos();
        let (x, y) = (p[0] - self.from[0], p[1] - self.from[1]);
        [cos * x - sin * y + self.to[0], sin * x + cos * y + self.to[1], p[2]]
    }

    /// Returns a direction (a velocity) of the clip's world in the robot's.
    pub fn direction(&self, v: [f32; 3]) -> [f32; 3] {
        let (sin, cos) = self.yaw.sin_cos();
        [cos * v[0] - sin * v[1], sin * v[0] + cos * v[1], v[2]]
    }

    /// Returns an orientation (`wxyz`) of the clip's world in the robot's.
    pub fn orientation(&self, q: [f32; 4]) -> [f32; 4] {
        let (s, c) = (0.5 * self.yaw).sin_cos();
        let [w, x, y, z] = q;
        [c * w - s * z, c * x - s * y, c * y + s * x, c * z + s * w]
    }

    /// Re-anchors the clip's world at a robot that has left it: turned about the clip's root and shifted, no further than
    /// that the root's `clip` pose is within `reach` (m) and `turn` (rad) of the `robot`'s.
    #[must_use]
    pub fn re_anchored(self, clip: ([f32; 3], [f32; 4]), robot: ([f32; 3], [f32; 4]), reach: f32, turn: f32) -> Self {
        let place = self.position(clip.0);
        let ahead = wrap(yaw(robot.1) - yaw(self.orientation(clip.1)));
        let (x, y) = (robot.0[0] - place[0], robot.0[1] - place[1]);
        let share = (1.0 - reach / x.hypot(y).max(reach)).max(0.0);
        Self {
            yaw: wrap(self.yaw + ahead - ahead.clamp(-turn, turn)),
            from: [clip.0[0], clip.0[1]],
            to: [place[0] + share * x, place[1] + share * y],
        }
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
        let v = a.direction([1.0, 0.0, 5.0]);
        assert!(v[0].abs() < 1e-6 && (v[1] - 1.0).abs() < 1e-6 && v[2] == 5.0);
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
        let near = a.re_anchored(clip, ([target[0] + 0.1, target[1], 0.4], upright(0.6)), 0.3, 0.5);
        let same = near.position([7.0, 8.0, 0.0]);
        let as_before = a.position([7.0, 8.0, 0.0]);
        assert!((0..2).all(|k| (same[k] - as_before[k]).abs() < 1e-5), "within reach nothing moves");

        // 0.5 m ahead along y and turned by 1.0 - 0.5 = 0.5 rad too far: pulled by 0.2 m and to the limit of the turn.
        let far = a.re_anchored(clip, ([target[0], target[1] + 0.5, 0.4], upright(1.5)), 0.3, 0.5);
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
