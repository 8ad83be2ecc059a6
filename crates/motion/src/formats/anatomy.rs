//! The body in a capture: which way it stands and faces, found from the places of its joints over time.
//!
//! Names of axes and frames of joints are conventions of writers; the places of joints are not. Up is from the feet to
//! the hips and to the head. Left is from the right hip to the left one, forward is the direction of toes and knees.

use lifelike_character::{Quat, Vec3};

use super::axes::Axis;
use crate::roles::Roles;

/// Most frames that are looked at.
const MOST_SAMPLES: usize = 150;
/// Largest angle (rad) between legs and trunk of a frame that tells the body's axis.
const STRAIGHT: f64 = 1.0;

/// Places and frames of all joints at some instants, in the file's axes.
pub(super) struct Samples {
    pub places: Vec<Vec<Vec3>>,
    pub frames: Vec<Vec<Quat>>,
}

impl Samples {
    /// Computes up to [`MOST_SAMPLES`] instants, evenly spread.
    pub fn new(parents: &[Option<usize>], offsets: &[Vec3], roots: &[Vec3], rotations: &[Vec<Quat>]) -> Self {
        let count = roots.len().min(MOST_SAMPLES);
        let mut samples = Self { places: Vec::with_capacity(count), frames: Vec::with_capacity(count) };
        for sample in 0..count {
            let t = sample * (roots.len() - 1) / (count - 1).max(1);
            let (mut places, mut frames) = (Vec::with_capacity(offsets.len()), Vec::with_capacity(offsets.len()));
            for (joint, parent) in parents.iter().enumerate() {
                let local = rotations[t][joint];
                let (place, frame): (Vec3, Quat) = match parent {
                    None => (roots[t], local),
                    Some(p) => (places[*p] + frames[*p] * offsets[joint], frames[*p] * local),
                };
                places.push(place);
                frames.push(frame);
            }
            samples.places.push(places);
            samples.frames.push(frames);
        }
        samples
    }
}

/// A pose as anatomy sees it.
pub(super) struct Body<'a> {
    pub places: &'a [Vec3],
    pub legs: [[usize; 3]; 2],
    pub roles: &'a Roles,
}

impl<'a> Body<'a> {
    pub fn new(places: &'a [Vec3], roles: &'a Roles) -> Option<Self> {
        Some(Self { places, legs: roles.legs()?, roles })
    }

    pub fn hips(&self) -> Vec3 {
        0.5 * (self.places[self.legs[0][0]] + self.places[self.legs[1][0]])
    }

    pub fn ankles(&self) -> Vec3 {
        0.5 * (self.places[self.legs[0][2]] + self.places[self.legs[1][2]])
    }

    /// Returns the length of thigh and shank, mean of both sides.
    pub fn leg_length(&self) -> f64 {
        let bones =
            |[a, b, c]: [usize; 3]| (self.places[b] - self.places[a]).norm() + (self.places[c] - self.places[b]).norm();
        0.5 * (bones(self.legs[0]) + bones(self.legs[1]))
    }

    /// Returns the direction from the hips to the head, or to the shoulders.
    fn trunk(&self) -> Option<Vec3> {
        use lifelike_character::Role::{Chest, Head, LeftUpperArm, RightUpperArm};
        let place = |role| self.roles.get(role).map(|joint| self.places[joint]);
        let shoulders = place(LeftUpperArm).zip(place(RightUpperArm)).map(|(a, b)| 0.5 * (a + b));
        let top = place(Head).or(shoulders).or_else(|| place(Chest))?;
        (top - self.hips()).try_normalize(1e-6)
    }

    /// Returns the direction from the feet through the hips to the head, where legs and trunk are stretched.
    pub fn axis(&self) -> Option<Vec3> {
        let legs = (self.hips() - self.ankles()).try_normalize(1e-6)?;
        let trunk = self.trunk().unwrap_or(legs);
        (legs.angle(&trunk) < STRAIGHT).then(|| legs + trunk)?.try_normalize(1e-6)
    }

    /// Returns the direction from the right hip and shoulder to the left ones.
    pub fn left(&self) -> Vec3 {
        let mut left = self.places[self.legs[0][0]] - self.places[self.legs[1][0]];
        if let [Some(arm), Some(other)] = self.roles.arms() {
            left += self.places[arm[0]] - self.places[other[0]];
        }
        left
    }

    /// Returns where the toes point, or without toes the bent knees.
    pub fn front(&self) -> Vec3 {
        let toes = self.legs.iter().zip(self.roles.toes).filter_map(|(leg, toe)| Some((leg[2], toe?)));
        let toes: Vec<Vec3> = toes.map(|(ankle, toe)| self.places[toe] - self.places[ankle]).collect();
        if !toes.is_empty() {
            return toes.iter().sum();
        }
        let bend = |leg: [usize; 3]| {
            let [hip, knee, ankle] = leg.map(|joint| self.places[joint]);
            knee - 0.5 * (hip + ankle)
        };
        bend(self.legs[0]) + bend(self.legs[1])
    }

    /// Returns the axis along which this pose stands: legs straight down, trunk straight up.
    pub fn standing_axis(&self) -> Option<Axis> {
        let (up, angle) = Axis::nearest(&(self.hips() - self.ankles()))?;
        let hangs = |from: usize, to: usize| (self.places[from] - self.places[to]).angle(&up.unit()) < 0.7;
        let legs = self.legs.iter().all(|[hip, knee, ankle]| hangs(*hip, *knee) && hangs(*knee, *ankle));
        let trunk = self.trunk().is_none_or(|trunk| trunk.angle(&up.unit()) < 0.7);
        let apart = Axis::nearest(&self.left()).is_some_and(|(left, _)| !left.is_parallel(up));
        (legs && trunk && apart && angle < 0.5).then_some(up)
    }
}

/// The body's axis over a clip.
pub(super) struct Posture {
    /// The axis along which the body is stretched most of the time.
    pub axis: Axis,
    /// Flag of a body that is never far from it.
    pub is_steady: bool,
}

impl Posture {
    pub fn of(samples: &Samples, roles: &Roles) -> Option<Self> {
        let axes: Vec<Vec3> =
            samples.places.iter().filter_map(|places| Body::new(places, roles).and_then(|body| body.axis())).collect();
        let sum = axes.iter().sum::<Vec3>();
        let (axis, angle) = Axis::nearest(&sum)?;
        let is_steady = 2 * axes.len() > samples.places.len() && sum.norm() > 0.8 * axes.len() as f64 && angle < 0.6;
        let near = axes.iter().filter(|a| a.angle(&axis.unit()) < 0.8).count();
        (2 * near > axes.len()).then_some(Self { axis, is_steady })
    }
}

/// Returns whether somebody walks with this axis up: the hips travel across it by more than a leg.
pub(super) fn walks(samples: &Samples, roles: &Roles, up: Axis) -> bool {
    let bodies: Vec<Body<'_>> = samples.places.iter().filter_map(|places| Body::new(places, roles)).collect();
    let Some(first) = bodies.first() else { return false };
    let leg = first.leg_length();
    let travel = |body: &Body<'_>| {
        let delta = body.hips() - first.hips();
        (delta - up.unit() * up.unit().dot(&delta)).norm()
    };
    let heights: Vec<f64> = bodies.iter().map(|body| body.hips().dot(&up.unit())).collect();
    let spread = heights.iter().copied().fold(f64::NEG_INFINITY, f64::max)
        - heights.iter().copied().fold(f64::INFINITY, f64::min);
    spread < 0.35 * leg && bodies.iter().map(travel).fold(0.0, f64::max) > leg
}

/// Returns whether feet rest at height zero along `up`, and the hips a leg above. Along `other` the hips must not be
/// those of somebody who lies on a floor at zero.
pub(super) fn stands_on_zero(samples: &Samples, roles: &Roles, up: Axis, other: Axis) -> bool {
    let bodies: Vec<Body<'_>> = samples.places.iter().filter_map(|places| Body::new(places, roles)).collect();
    let Some(leg) = bodies.first().map(Body::leg_length) else { return false };
    let median = |height: &dyn Fn(&Body<'_>) -> f64| {
        let mut heights: Vec<f64> = bodies.iter().map(|body| height(body) / leg).collect();
        heights.sort_by(f64::total_cmp);
        heights[heights.len() / 2]
    };
    let ankles = median(&|body| body.ankles().dot(&up.unit()));
    let hips = median(&|body| body.hips().dot(&up.unit()));
    let lying = median(&|body| body.hips().dot(&other.unit()));
    (-0.1..0.3).contains(&ankles) && hips > 0.7 && !(0.05..0.5).contains(&lying)
}
