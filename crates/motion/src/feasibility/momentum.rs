//! Forces that the ground must exert for a body to move as it does.

use lifelike_character::{Character, Kinematics, Quat, Vec3};

/// Half the time over which motion is fitted by a parabola (s). Captured joints shake by a millimetre from frame to
/// frame, which at 50 Hz looks like half of gravity. Over a fifth of a second it is a tenth of that, and what remains
/// visible is what a leg can follow.
pub const SMOOTH_SECONDS: f64 = 0.1;

/// Less than this share of the weight on the ground is too little to say where or how flat it acts.
const LITTLE: f64 = 0.2;

/// Ground force that a frame needs.
#[derive(Debug, Clone, PartialEq)]
pub struct Momentum {
    /// Centre of mass (m, world).
    pub centre: Vec3,
    /// Force per mass that all contacts together must give: c̈ − g (m/s², world).
    pub specific_force: Vec3,
    /// Point of the ground (z = 0) at which it must act so that the rest is a torque about the vertical (m, world).
    /// `None` where there is hardly any force.
    pub zero_moment_point: Option<Vec3>,
}

impl Momentum {
    /// Returns the friction coefficient that the force needs; `None` where there is hardly any force.
    pub fn friction(&self) -> Option<f64> {
        self.zero_moment_point.map(|_| self.specific_force.xy().norm() / self.specific_force.z)
    }
}

/// Returns the ground force of each frame, `None` within [`SMOOTH_SECONDS`] of the ends. A character without mass needs
/// nothing.
pub fn momentum(character: &Character, poses: &[Kinematics], fps: f64) -> Vec<Option<Momentum>> {
    let mass = character.mass();
    let half = ((SMOOTH_SECONDS * fps).round() as usize).max(1);
    let gravity = character.gravity;
    if mass <= 0.0 || poses.len() <= 2 * half {
        return vec![None; poses.len()];
    }
    let centres: Vec<Vec3> = poses.iter().map(|pose| centre(character, pose) / mass).collect();
    let angular: Vec<Vec3> = (0..poses.len()).map(|frame| angular_momentum(character, poses, frame, fps)).collect();
    let fit = Fit::new(half, fps);
    (0..poses.len())
        .map(|frame| {
            let window = frame.checked_sub(half)?..frame + half + 1;
            let specific_force = fit.curvature(centres.get(window.clone())?) - gravity;
            let rate = fit.slope(angular.get(window)?) / mass;
            let c = centres[frame];
            // Moments about the centre: L̇ = (p − c) × F with p on the ground, its vertical part left over.
            let f = specific_force;
            let point = (f.z > LITTLE * gravity.norm())
                .then(|| Vec3::new(c.x - (rate.y + c.z * f.x) / f.z, c.y + (rate.x - c.z * f.y) / f.z, 0.0));
            Some(Momentum { centre: c, specific_force, zero_moment_point: point })
        })
        .collect()
}

/// Returns the sum of the bodies' centres of mass times their mass (kg m).
fn centre(character: &Character, pose: &Kinematics) -> Vec3 {
    let bodies = character.bodies.iter().enumerate();
    bodies.map(|(i, body)| body.inertial.mass * pose.point(i, &body.inertial.com)).sum()
}

/// Returns the centre of mass (m, world).
pub(crate) fn centre_of_mass(character: &Character, pose: &Kinematics) -> Vec3 {
    centre(character, pose) / character.mass()
}

/// Returns the angular momentum about the common centre of mass (kg m²/s, world), by central differences.
fn angular_momentum(character: &Character, poses: &[Kinematics], frame: usize, fps: f64) -> Vec3 {
    let (a, b) = (frame.saturating_sub(1), (frame + 1).min(poses.len() - 1));
    if a == b {
        return Vec3::zeros();
    }
    let rate = fps / (b - a) as f64;
    let mass = character.mass();
    let at = |frame: usize| centre(character, &poses[frame]) / mass;
    let (middle, velocity) = (at(frame), (at(b) - at(a)) * rate);
    let of = |i: usize| {
        let inertial = &character.bodies[i].inertial;
        let place = |frame: usize| poses[frame].point(i, &inertial.com);
        let turn = |frame: usize| -> Quat { poses[frame].body_orientation[i] };
        let spin = (turn(b) * turn(a).inverse()).scaled_axis() * rate;
        let frame_of = turn(frame).to_rotation_matrix();
        let inertia = frame_of * inertial.tensor() * frame_of.transpose();
        let orbit = (place(frame) - middle).cross(&((place(b) - place(a)) * rate - velocity));
        orbit * inertial.mass + inertia * spin
    };
    (0..character.bodies.len()).map(of).sum()
}

/// The parabola of least squares through 2 `half` + 1 values.
struct Fit {
    half: isize,
    fps: f64,
    squares: f64,
    fourths: f64,
}

impl Fit {
    fn new(half: usize, fps: f64) -> Self {
        let half = half as isize;
        let sum = |power: i32| (-half..=half).map(|j| (j as f64).powi(power)).sum();
        Self { half, fps, squares: sum(2), fourths: sum(4) }
    }

    fn weighted(&self, values: &[Vec3], weight: impl Fn(f64) -> f64) -> Vec3 {
        (-self.half..=self.half).zip(values).map(|(j, v)| v * weight(j as f64)).sum()
    }

    /// Returns the first derivative in the middle.
    fn slope(&self, values: &[Vec3]) -> Vec3 {
        self.weighted(values, |j| j) * (self.fps / self.squares)
    }

    /// Returns the second derivative.
    fn curvature(&self, values: &[Vec3]) -> Vec3 {
        let n = values.len() as f64;
        let top = self.weighted(values, |j| n * j * j - self.squares);
        top * (2.0 * self.fps * self.fps / (n * self.fourths - self.squares * self.squares))
    }
}
