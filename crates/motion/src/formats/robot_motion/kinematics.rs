//! Poses and velocities of a robot's bodies, as the field's converters compute them.
//!
//! Velocities of joints and root are those of `torch.gradient`: central differences, one-sided at the ends. The
//! root's angular velocity is a central difference of rotations, repeated at the ends. Bodies move at the origins of
//! their frames.

use lifelike_character::{Character, JointKind, Kinematics, Quat, Vec3};

use super::arrays::Arrays;
use super::{Context, names_of, vectors};
use crate::clip::MotionClip;
use crate::error::MotionError;

/// The order of bodies and joints in arrays without names.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Traversal {
    /// Limb after limb, as MuJoCo numbers them.
    DepthFirst,
    /// Level after level, as Isaac Lab numbers them.
    BreadthFirst,
}

impl Traversal {
    pub(super) fn words(self) -> &'static str {
        match self {
            Self::DepthFirst => "bodies and joints depth-first (MuJoCo)",
            Self::BreadthFirst => "bodies and joints breadth-first (Isaac Lab)",
        }
    }

    /// Returns the bodies in this order, without the world.
    pub(super) fn bodies(self, robot: &Character) -> Vec<usize> {
        let mut bodies: Vec<usize> = (1..robot.bodies.len()).collect();
        if self == Self::BreadthFirst {
            bodies.sort_by_key(|&body| depth(robot, body));
        }
        bodies
    }

    /// Returns the names of the joints in this order.
    pub fn joints(self, robot: &Character) -> Vec<String> {
        let mut joints: Vec<_> = robot.scalar_joints().collect();
        if self == Self::BreadthFirst {
            joints.sort_by_key(|joint| depth(robot, joint.body));
        }
        joints.iter().map(|joint| joint.name.clone()).collect()
    }
}

fn depth(robot: &Character, body: usize) -> usize {
    std::iter::successors(Some(body), |&b| (b != 0).then(|| robot.bodies[b].parent)).count()
}

/// Poses and velocities of bodies, `[frame][body]`, and velocities of joints.
pub struct States {
    /// Of the body frame's origin (m, world).
    pub position: Vec<Vec3>,
    /// In the world.
    pub orientation: Vec<Quat>,
    /// At the body frame's origin (m/s, world).
    pub linear: Vec<Vec3>,
    /// In the world (rad/s).
    pub angular: Vec<Vec3>,
    /// Joint positions, `[frame][joint]` in the robot's order.
    pub joints: Vec<f64>,
    /// Likewise (rad/s).
    pub joint_velocity: Vec<f64>,
    /// Of the root (m/s, world).
    pub root_linear: Vec<Vec3>,
    /// Of the root (rad/s, world).
    pub root_angular: Vec<Vec3>,
}

/// Computes the states of these bodies of a clip, with velocities as the field's converters compute them.
///
/// # Errors
/// The clip has other joints than the robot.
pub fn states(clip: &MotionClip, robot: &Character, bodies: &[usize]) -> Result<States, MotionError> {
    let columns = clip.columns_for(robot)?;
    let width = columns.len();
    let joints: Vec<f64> =
        (0..clip.len()).flat_map(|frame| columns.iter().map(move |column| clip.joints_at(frame)[*column])).collect();
    let root_linear = gradient(&clip.root_position, clip.fps);
    let root_angular = angular(&clip.root_orientation, clip.fps);
    let rows: Vec<nalgebra::DVector<f64>> = (0..clip.len())
        .map(|frame| nalgebra::DVector::from_row_slice(&joints[frame * width..(frame + 1) * width]))
        .collect();
    let joint_velocity: Vec<f64> = gradient(&rows, clip.fps).iter().flat_map(|row| row.iter().copied()).collect();

    let count = clip.len() * bodies.len();
    let mut states = States {
        position: Vec::with_capacity(count),
        orientation: Vec::with_capacity(count),
        linear: Vec::with_capacity(count),
        angular: Vec::with_capacity(count),
        joints,
        joint_velocity,
        root_linear,
        root_angular,
    };
    let mut kinematics = Kinematics::new(robot);
    let (mut q, mut v) = (robot.reference_position(), vec![0.0; robot.nv]);
    for frame in 0..clip.len() {
        clip.write_position(robot, &columns, frame, &mut q);
        kinematics.update(robot, &q);
        write_velocity(robot, clip, frame, &states, &mut v);
        for &body in bodies {
            let (mut linear, mut angular) = (Vec3::zeros(), Vec3::zeros());
            let place = kinematics.body_position[body];
            kinematics.for_each_column(robot, body, &place, |column, moves, turns| {
                linear += moves * v[column];
                angular += turns * v[column];
            });
            states.position.push(place);
            states.orientation.push(kinematics.body_orientation[body]);
            states.linear.push(linear);
            states.angular.push(angular);
        }
    }
    Ok(states)
}

/// Writes the generalised velocity of a frame, in MuJoCo's layout.
fn write_velocity(robot: &Character, clip: &MotionClip, frame: usize, states: &States, v: &mut [f64]) {
    let width = clip.joint_names.len();
    let mut scalar = 0;
    for joint in &robot.joints {
        let at = joint.v_index;
        match joint.kind {
            JointKind::Free => {
                let turning = clip.root_orientation[frame].inverse() * states.root_angular[frame];
                v[at..at + 3].copy_from_slice(states.root_linear[frame].as_slice());
                v[at + 3..at + 6].copy_from_slice(turning.as_slice());
            }
            _ if !joint.is_scalar() => {}
            _ => {
                v[at] = states.joint_velocity[frame * width + scalar];
                scalar += 1;
            }
        }
    }
}

/// Returns derivatives as `torch.gradient` computes them.
fn gradient<V>(values: &[V], fps: f64) -> Vec<V>
where
    for<'v> &'v V: std::ops::Sub<&'v V, Output = V>,
    V: std::ops::Mul<f64, Output = V>,
{
    let last = values.len().saturating_sub(1);
    let between = |at: usize| {
        let (from, to) = (at.saturating_sub(1), (at + 1).min(last));
        (&values[to] - &values[from]) * (fps / to.abs_diff(from).max(1) as f64)
    };
    (0..values.len()).map(between).collect()
}

/// Returns angular velocities in the world: over two frames, and at the ends those of the neighbours.
fn angular(rotations: &[Quat], fps: f64) -> Vec<Vec3> {
    let last = rotations.len().saturating_sub(1);
    let between = |at: usize| {
        let middle = at.clamp(1.min(last), last.saturating_sub(1).max(1.min(last)));
        let (from, to) = (middle.saturating_sub(1), (middle + 1).min(last));
        (rotations[to] * rotations[from].inverse()).scaled_axis() * (fps / to.abs_diff(from).max(1) as f64)
    };
    (0..rotations.len()).map(between).collect()
}

/// Frames at which bodies are compared with forward kinematics.
const SAMPLES: usize = 16;
/// Mean distance (m) from which bodies contradict the joints; models of one robot differ by mm.
const FAR: f64 = 0.05;

/// Returns a test for the frames that are compared.
pub(super) fn is_sample(frames: usize) -> impl Fn(usize) -> bool + Copy {
    let stride = (frames / SAMPLES).max(1);
    move |row: usize| row.is_multiple_of(stride)
}

/// Places of a file's bodies at some frames; none where it has no bodies.
#[derive(Debug, Clone, Default)]
pub(super) struct Bodies {
    /// Names; bodies without are in either order.
    names: Option<Vec<String>>,
    /// `[frame][body]`
    places: Vec<Vec3>,
}

impl Bodies {
    /// Reads an array `[frames, bodies, 3]`.
    pub(super) fn sampled(
        arrays: &mut Arrays<'_>,
        name: &str,
        frames: usize,
        names: Option<Vec<String>>,
    ) -> Result<Self, MotionError> {
        let is_sample = is_sample(frames);
        let places = vectors(&arrays.select(name, |row, _| is_sample(row))?);
        Ok(Self { names, places })
    }

    /// Returns a sentence where the bodies are far from where the joints put them. None where the robot is another.
    pub(super) fn contradiction(&self, clip: &MotionClip, robot: Option<&Character>) -> Option<String> {
        let robot = robot?;
        let columns = clip.columns_for(robot).ok()?;
        let is_sample = is_sample(clip.len());
        let frames: Vec<usize> = (0..clip.len()).filter(|frame| is_sample(*frame)).collect();
        let width = self.places.len() / frames.len().max(1);
        let place = |name: &String| robot.bodies.iter().position(|body| body.name == *name);
        let unnamed = |order: Traversal| order.bodies(robot).into_iter().map(Some).collect();
        let orders: Vec<Vec<Option<usize>>> = match &self.names {
            Some(names) => vec![names.iter().map(place).collect()],
            None => vec![unnamed(Traversal::DepthFirst), unnamed(Traversal::BreadthFirst)],
        };
        if width == 0 || orders.iter().any(|bodies| bodies.len() != width) {
            return None;
        }
        let known = orders[0].iter().flatten().count() * frames.len();
        let mut sums = vec![0.0; orders.len()];
        let mut kinematics = Kinematics::new(robot);
        let mut q = robot.reference_position();
        for (row, frame) in frames.into_iter().enumerate() {
            clip.write_position(robot, &columns, frame, &mut q);
            kinematics.update(robot, &q);
            for (sum, bodies) in sums.iter_mut().zip(&orders) {
                let pairs = bodies.iter().zip(&self.places[row * width..]);
                let known = pairs.filter_map(|(body, place)| Some((kinematics.body_position[(*body)?], place)));
                *sum += known.map(|(ours, place)| (ours - place).norm()).sum::<f64>();
            }
        }
        let mean = sums.into_iter().fold(f64::INFINITY, f64::min) / known.max(1) as f64;
        (mean > FAR).then(|| format!("bodies that are {mean:.2} m from where the joints of {} put them", robot.name))
    }
}

/// Returns the mean distance (m) of bodies in a file from where the robot's joints put them, in one order. None where
/// the robot has other numbers of bodies or joints.
pub(super) fn distance(clip: &Sampled<'_>, context: &Context<'_>, order: Traversal) -> Option<f64> {
    let robot = context.robot?;
    let bodies = order.bodies(robot);
    let names = order.joints(robot);
    if names.len() * clip.frames() != clip.joints.len() || bodies.len() * clip.frames() != clip.bodies.len() {
        return None;
    }
    let columns: Vec<usize> =
        names_of(robot).iter().filter_map(|name| names.iter().position(|other| other == name)).collect();
    let mut kinematics = Kinematics::new(robot);
    let mut q = robot.reference_position();
    let mut sum = 0.0;
    for frame in 0..clip.frames() {
        let motion = MotionClip {
            name: String::new(),
            fps: 1.0,
            joint_names: names.clone(),
            root_position: vec![clip.bodies[frame * bodies.len()]],
            root_orientation: vec![clip.root_orientation[frame]],
            joints: clip.joints[frame * names.len()..(frame + 1) * names.len()].to_vec(),
            contacts: None,
            cyclic: false,
            provenance: crate::clip::Provenance::default(),
        };
        motion.write_position(robot, &columns, 0, &mut q);
        kinematics.update(robot, &q);
        let places = bodies.iter().zip(&clip.bodies[frame * bodies.len()..]);
        sum += places.map(|(body, place)| (kinematics.body_position[*body] - place).norm()).sum::<f64>();
    }
    Some(sum / clip.bodies.len().max(1) as f64)
}

/// Some frames of a file with poses of bodies.
pub(super) struct Sampled<'s> {
    /// `[frame][joint]`
    pub(super) joints: &'s [f64],
    /// `[frame][body]`
    pub(super) bodies: &'s [Vec3],
    pub(super) root_orientation: &'s [Quat],
}

impl Sampled<'_> {
    fn frames(&self) -> usize {
        self.root_orientation.len()
    }
}
