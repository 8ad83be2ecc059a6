//! How far a simulated state is from its reference, and whether that ends the episode.

use lifelike_character::rotation::from_wxyz;
use lifelike_character::{Quat, Vec3};
use lifelike_motion::{FeatureLayout, Frame};
use lifelike_sim::BatchState;

use super::plan::termination::Termination;

/// Why an episode ended before its time.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Cause {
    /// The simulation left the realm of numbers.
    Diverged,
    /// Root height.
    Height,
    /// Tilt.
    Tilt,
    /// An end effector, at once.
    Effector,
    /// An end effector, persistently (the thesis' rule).
    Persistent,
    /// Position on the ground.
    Path,
    /// Heading.
    Heading,
}

impl Cause {
    /// All causes.
    pub const ALL: [Self; 7] =
        [Self::Diverged, Self::Height, Self::Tilt, Self::Effector, Self::Persistent, Self::Path, Self::Heading];

    /// Its name in the metrics.
    pub fn name(self) -> &'static str {
        match self {
            Self::Diverged => "diverged",
            Self::Height => "height",
            Self::Tilt => "tilt",
            Self::Effector => "effector",
            Self::Persistent => "persistent",
            Self::Path => "path",
            Self::Heading => "heading",
        }
    }
}

/// The deviations that termination looks at.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Deviation {
    /// Root height (m, absolute).
    pub height: f32,
    /// Angle between the two directions of gravity in the root's frame (rad).
    pub tilt: f32,
    /// Largest end-effector distance (m; heading frame, relative to the root).
    pub effector: f32,
    /// Distance on the ground (m).
    pub path: f32,
    /// Heading (rad, absolute).
    pub heading: f32,
}

impl Deviation {
    /// From the features of both (each in its own heading frame) and the anchored errors.
    pub fn between(layout: &FeatureLayout, simulated: &[f32], reference: &[f32], path: f32, heading: f32) -> Self {
        let places = layout.effectors();
        let effector = simulated[places.clone()]
            .chunks_exact(3)
            .zip(reference[places].chunks_exact(3))
            .map(|(a, b)| super::rewards::squared_distance(a, b))
            .fold(0.0, f32::max)
            .sqrt();
        let (a, b) = (gravity(simulated), gravity(reference));
        let cosine = a.iter().zip(b).map(|(a, b)| a * b).sum::<f32>();
        Self {
            height: (simulated[FeatureLayout::HEIGHT] - reference[FeatureLayout::HEIGHT]).abs(),
            tilt: cosine.clamp(-1.0, 1.0).acos(),
            effector,
            path,
            heading: heading.abs(),
        }
    }

    /// The first limit that is exceeded. `persisted` is how long the effector deviation has been above the limit of the
    /// persistent rule (s).
    pub fn exceeds(&self, limits: &Termination, persisted: f64) -> Option<Cause> {
        let over = |value: f32, limit: Option<f32>| limit.is_some_and(|l| value > l);
        if over(self.height, limits.height) {
            Some(Cause::Height)
        } else if over(self.tilt, limits.tilt) {
            Some(Cause::Tilt)
        } else if over(self.effector, limits.effector) {
            Some(Cause::Effector)
        } else if limits.persistent.is_some_and(|p| persisted > p.seconds) {
            Some(Cause::Persistent)
        } else if over(self.path, limits.path) {
            Some(Cause::Path)
        } else if over(self.heading, limits.heading) {
            Some(Cause::Heading)
        } else {
            None
        }
    }
}

/// The direction of up in the root's frame: the third row of the rotation, of which the features hold two columns.
fn gravity(features: &[f32]) -> [f32; 3] {
    let d = &features[FeatureLayout::ORIENTATION];
    [d[2], d[5], d[0] * d[4] - d[1] * d[3]]
}

/// Root position and orientation of one environment.
pub(super) fn root(state: &BatchState, i: usize) -> ([f32; 3], [f32; 4]) {
    let p = &state.root_position[3 * i..3 * i + 3];
    let q = &state.root_orientation[4 * i..4 * i + 4];
    ([p[0], p[1], p[2]], [q[0], q[1], q[2], q[3]])
}

/// Reads one environment of a batch into a frame, whose vectors are reused. A root without orientation (a diverged
/// environment) is taken as upright.
///
/// `effectors` is how many of the places are end effectors: the first ones.
pub fn read_frame(state: &BatchState, environment: usize, joints: usize, effectors: usize, out: &mut Frame) {
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
    let places = state.site_position.len() / state.root_position.len().max(1);
    out.effectors_w.clear();
    out.effectors_w.extend((0..effectors).map(|p| vector(&state.site_position, 3 * (i * places + p))));
}

/// A frame to read into.
pub fn empty_frame() -> Frame {
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

#[cfg(test)]
mod tests {
    use super::*;

    fn layout() -> FeatureLayout {
        FeatureLayout { joints: vec![], end_effectors: vec!["a".into(), "b".into()] }
    }

    fn features(q: Quat, height: f64, b: [f64; 3]) -> Vec<f32> {
        let frame = Frame {
            root_position: Vec3::new(0.0, 0.0, height),
            root_orientation: q,
            effectors_w: vec![Vec3::zeros(), Vec3::new(b[0], b[1], b[2] + height)],
            ..empty_frame()
        };
        let mut out = vec![0.0; layout().size()];
        frame.write_features(&q, &mut out);
        out.iter().map(|x| *x as f32).collect()
    }

    #[test]
    fn deviations_by_hand() {
        let simulated = features(Quat::from_euler_angles(0.5, 0.0, 2.0), 1.0, [0.0, 0.0, 0.0]);
        let reference = features(Quat::from_euler_angles(0.0, 0.0, -1.0), 1.0, [0.0, 0.0, 0.3]);
        let d = Deviation::between(&layout(), &simulated, &reference, 0.7, -0.2);
        assert!((d.tilt - 0.5).abs() < 1e-5, "turning about the vertical does not tilt: {}", d.tilt);
        assert!((d.effector - 0.3).abs() < 1e-6, "the worst of the two: {}", d.effector);
        assert_eq!((d.height, d.path, d.heading), (0.0, 0.7, 0.2));
    }

    #[test]
    fn only_given_limits_apply_and_the_persistent_one_waits() {
        let d = Deviation { height: 9.0, tilt: 0.1, effector: 0.4, path: 0.0, heading: 0.0 };
        assert_eq!(d.exceeds(&Termination::NONE, 0.0), None);
        let tight = Termination { effector: Some(0.3), ..Termination::NONE };
        assert_eq!(d.exceeds(&tight, 0.0), Some(Cause::Effector));
        let persistent = super::super::plan::Persistent { distance: 0.3, seconds: 3.0 };
        let thesis = Termination { persistent: Some(persistent), ..Termination::NONE };
        assert_eq!((d.exceeds(&thesis, 3.0), d.exceeds(&thesis, 3.02)), (None, Some(Cause::Persistent)));
    }
}
