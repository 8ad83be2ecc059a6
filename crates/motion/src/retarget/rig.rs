//! The character as the retargeter sees it: where its parts are, how long its limbs, which way its joints may go.

use lifelike_character::{Anatomy, Character, Joint, JointKind, Kinematics, Quat, Role, Vec3};

use super::human::{ARM_ROLES, LEG_ROLES};
use super::options::RetargetOptions;
use crate::error::MotionError;

/// Joints within this share of the upper arm from the elbow are the elbow's.
const ELBOW: f64 = 0.1;

/// A point fixed to a body.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Spot {
    pub body: usize,
    pub point: Vec3,
}

/// A limb segment between two spots.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Segment {
    pub from: Spot,
    pub to: Spot,
    pub length: f64,
}

#[derive(Debug, Clone)]
pub(crate) struct Leg {
    pub thigh: Segment,
    pub shank: Segment,
    pub foot: Foot,
}

/// A foot with its sole; points in the body frame (m).
#[derive(Debug, Clone)]
pub(crate) struct Foot {
    pub body: usize,
    /// The sole's middle line under the ankle, at its front end and its rear end.
    pub under: Vec3,
    pub toe: Vec3,
    pub heel: Vec3,
    pub corners: Vec<Vec3>,
    /// Orientation of the body when the foot stands level, looking forward.
    pub rest: Quat,
}

#[derive(Debug, Clone)]
pub(crate) struct Arm {
    pub upper: Segment,
    pub fore: Segment,
    /// The hand, where it can move against the forearm; direction and palm normal in its body frame.
    pub hand: Option<(usize, Vec3, Vec3)>,
}

/// One hinge or slide.
#[derive(Debug, Clone)]
pub(crate) struct Axis {
    pub q: usize,
    pub v: usize,
    /// The joint's own range.
    pub range: (f64, f64),
    /// The range used, with the least knee bend.
    pub low: f64,
    pub high: f64,
    /// Largest speed (rad/s).
    pub speed: f64,
    /// Rest position when nothing is asked of it.
    pub neutral: f64,
    /// Flag of a coordinate that moves a foot.
    pub leg: bool,
}

#[derive(Debug)]
pub(crate) struct Rig<'a> {
    pub character: &'a Character,
    pub root: &'a Joint,
    pub axes: Vec<Axis>,
    pub legs: [Leg; 2],
    pub arms: [Option<Arm>; 2],
    /// Middle between the hip joints.
    pub hips: Spot,
    pub pelvis: (usize, Quat),
    pub chest: Option<(usize, Quat)>,
    pub head: Option<(usize, Quat)>,
    /// From the hip joint to the sole with the least knee bend (m).
    pub leg_length: f64,
    pub hip_half_width: f64,
}

fn unfit(character: &Character, message: String) -> MotionError {
    MotionError::Mismatch { clip: "(any)".into(), character: character.name.clone(), message }
}

impl<'a> Rig<'a> {
    pub fn new(character: &'a Character, anatomy: &Anatomy, options: &RetargetOptions) -> Result<Self, MotionError> {
        let root = character
            .root_joint()
            .ok_or_else(|| unfit(character, "it has no free joint: nothing to move through the world".into()))?;
        if let Some(ball) = character.joints.iter().find(|j| j.kind == JointKind::Ball) {
            let message = format!("joint '{}' is a ball joint; a motion clip holds hinges and slides only", ball.name);
            return Err(unfit(character, message));
        }
        if character.joints.iter().filter(|j| j.kind == JointKind::Free).count() > 1 {
            return Err(unfit(character, "it has more than one free joint".into()));
        }
        let rest = Rest::new(character, anatomy)?;
        let legs = [rest.leg(0)?, rest.leg(1)?];
        let arms = [rest.arm(0), rest.arm(1)];
        let hips_w = 0.5 * (rest.at(legs[0].thigh.from) + rest.at(legs[1].thigh.from));
        let pelvis = rest.place(Role::Pelvis)?.body;
        let mut rig = Self {
            character,
            root,
            axes: Vec::new(),
            hips: Spot { body: pelvis, point: rest.local(pelvis, hips_w) },
            pelvis: (pelvis, rest.orientation(pelvis)),
            chest: anatomy.places.get(&Role::Chest).map(|p| (p.body, rest.orientation(p.body))),
            head: anatomy.places.get(&Role::Head).map(|p| (p.body, rest.orientation(p.body))),
            leg_length: 0.0,
            hip_half_width: 0.5 * (rest.at(legs[0].thigh.from) - rest.at(legs[1].thigh.from)).norm(),
            legs,
            arms,
        };
        rig.axes = rig.make_axes(options);
        rig.bend_knees(options.min_knee_bend);
        rig.leg_length = (0..2).map(|side| 0.5 * rig.leg_reach(side, options.min_knee_bend, &rest)).sum();
        Ok(rig)
    }

    fn make_axes(&self, options: &RetargetOptions) -> Vec<Axis> {
        let character = self.character;
        let mut on_leg = vec![false; character.bodies.len()];
        for leg in &self.legs {
            let mut body = leg.foot.body;
            while body != self.pelvis.0 && body != 0 {
                on_leg[body] = true;
                body = character.bodies[body].parent;
            }
        }
        character
            .scalar_joints()
            .map(|joint| {
                let range = joint.range.unwrap_or((-1e3, 1e3));
                let speed = options.velocity_limit.get(&joint.name).copied();
                Axis {
                    q: joint.q_index,
                    v: joint.v_index,
                    range,
                    low: range.0,
                    high: range.1,
                    speed: speed.unwrap_or(options.default_velocity_limit),
                    neutral: joint.reference.clamp(range.0, range.1),
                    leg: on_leg[joint.body],
                }
            })
            .collect()
    }

    /// Forbids straight knees, where the shank hangs on a single hinge.
    fn bend_knees(&mut self, least: f64) {
        let character = self.character;
        for side in 0..2 {
            let (thigh, shank) = (self.legs[side].thigh, self.legs[side].shank);
            let between: Vec<usize> = chain(character, shank.from.body, thigh.from.body);
            let hinges: Vec<&Joint> =
                between.iter().flat_map(|&b| &character.joints[character.bodies[b].joints.clone()]).collect();
            let [knee] = hinges.as_slice() else { continue };
            let Some(axis) = self.axes.iter_mut().find(|a| a.q == knee.q_index) else { continue };
            let mut kinematics = Kinematics::new(character);
            let mut q = character.reference_position();
            let mut best = (f64::NEG_INFINITY, 0.0);
            let (low, high) = (axis.range.0.max(-3.0), axis.range.1.min(3.0));
            for i in 0..=600 {
                let angle = low + (high - low) * f64::from(i) / 600.0;
                q[knee.q_index] = angle;
                kinematics.update(character, &q);
                let reach = (kinematics.point(thigh.from.body, &thigh.from.point)
                    - kinematics.point(shank.to.body, &shank.to.point))
                .norm();
                if reach > best.0 {
                    best = (reach, angle);
                }
            }
            let straight = best.1;
            // The side with more range is the way it bends.
            if axis.range.1 - straight >= straight - axis.range.0 {
                axis.low = axis.low.max(straight + least).min(axis.high);
            } else {
                axis.high = axis.high.min(straight - least).max(axis.low);
            }
            axis.neutral = axis.neutral.clamp(axis.low, axis.high);
        }
    }

    /// Returns the distance from hip to sole with the knee bent by `bend`.
    fn leg_reach(&self, side: usize, bend: f64, rest: &Rest) -> f64 {
        let leg = &self.legs[side];
        let (a, b) = (leg.thigh.length, leg.shank.length);
        let sole = (leg.foot.rest * (leg.shank.to.point_in(leg.foot.body, rest) - leg.foot.under)).z;
        (a * a + b * b + 2.0 * a * b * bend.cos()).sqrt() + sole
    }
}

impl Spot {
    /// Returns this point in another body's frame, in the rest pose.
    fn point_in(&self, body: usize, rest: &Rest) -> Vec3 {
        rest.local(body, rest.at(*self))
    }
}

/// Returns the bodies from `from` up to but without `to`.
fn chain(character: &Character, from: usize, to: usize) -> Vec<usize> {
    let mut bodies = Vec::new();
    let mut body = from;
    while body != to && body != 0 {
        bodies.push(body);
        body = character.bodies[body].parent;
    }
    bodies
}

/// The reference pose, turned so that the left hip is to the left (y).
struct Rest<'a> {
    character: &'a Character,
    anatomy: &'a Anatomy,
    kinematics: Kinematics,
    turn: Quat,
}

impl<'a> Rest<'a> {
    fn new(character: &'a Character, anatomy: &'a Anatomy) -> Result<Self, MotionError> {
        let kinematics = Kinematics::new(character);
        let mut rest = Self { character, anatomy, kinematics, turn: Quat::identity() };
        let hip = |role| Ok::<_, MotionError>(rest.at(rest.place(role)?));
        let across = hip(Role::LeftThigh)? - hip(Role::RightThigh)?;
        rest.turn = Quat::from_axis_angle(&Vec3::z_axis(), across.x.atan2(across.y));
        Ok(rest)
    }

    fn place(&self, role: Role) -> Result<Spot, MotionError> {
        let place = self.anatomy.places.get(&role).ok_or_else(|| {
            let message = format!("no body plays the role {role:?}; name one under [anatomy] in the robot's profile");
            unfit(self.character, message)
        })?;
        Ok(Spot { body: place.body, point: place.point })
    }

    fn at(&self, spot: Spot) -> Vec3 {
        self.kinematics.point(spot.body, &spot.point)
    }

    fn local(&self, body: usize, point_w: Vec3) -> Vec3 {
        self.kinematics.body_orientation[body].inverse() * (point_w - self.kinematics.body_position[body])
    }

    fn orientation(&self, body: usize) -> Quat {
        self.turn * self.kinematics.body_orientation[body]
    }

    fn segment(&self, from: Spot, to: Spot) -> Segment {
        Segment { from, to, length: (self.at(to) - self.at(from)).norm() }
    }

    fn leg(&self, side: usize) -> Result<Leg, MotionError> {
        let roles = LEG_ROLES[side];
        let [hip, knee, ankle] = [self.place(roles[0])?, self.place(roles[1])?, self.place(roles[2])?];
        let (thigh, shank) = (self.segment(hip, knee), self.segment(knee, ankle));
        if thigh.length < 1e-4 || shank.length < 1e-4 {
            return Err(unfit(self.character, format!("the leg of role {:?} has a segment without length", roles[0])));
        }
        Ok(Leg { thigh, shank, foot: self.foot(roles[2], ankle)? })
    }

    fn foot(&self, role: Role, ankle: Spot) -> Result<Foot, MotionError> {
        let sole = self.anatomy.soles.get(&role).filter(|s| !s.corners.is_empty());
        let sole = sole.ok_or_else(|| unfit(self.character, format!("the foot of role {role:?} has no sole")))?;
        // The reference pose may stand on its toes: level the plane through the corners.
        let mut rest = self.orientation(sole.body);
        let centre = sole.corners.iter().sum::<Vec3>() / sole.corners.len() as f64;
        if let Some(normal) = plane_normal(&sole.corners, &centre) {
            let normal = rest * normal;
            let up = if normal.z < 0.0 { -normal } else { normal };
            if up.z > 0.5 {
                rest = Quat::rotation_between(&up, &Vec3::z()).unwrap_or_else(Quat::identity) * rest;
            }
        }
        let level = |p: &Vec3| rest * p;
        let mean = |keep: &dyn Fn(f64) -> bool| {
            let kept: Vec<Vec3> = sole.corners.iter().map(level).filter(|p| keep(p.x)).collect();
            kept.iter().sum::<Vec3>() / kept.len().max(1) as f64
        };
        let middle = level(&centre);
        let mut toe = mean(&|x| x >= middle.x);
        let mut heel = mean(&|x| x < middle.x);
        if heel == Vec3::zeros() {
            heel = middle;
        }
        let y = 0.5 * (toe.y + heel.y);
        (toe.y, heel.y) = (y, y);
        let under = Vec3::new(level(&self.local(sole.body, self.at(ankle))).x, y, middle.z);
        let back = rest.inverse();
        Ok(Foot {
            body: sole.body,
            under: back * under,
            toe: back * toe,
            heel: back * heel,
            corners: sole.corners.clone(),
            rest,
        })
    }

    fn arm(&self, side: usize) -> Option<Arm> {
        let roles = ARM_ROLES[side];
        let [shoulder, elbow, hand] =
            [self.place(roles[0]).ok()?, self.place(roles[1]).ok()?, self.place(roles[2]).ok()?];
        let upper = self.segment(shoulder, elbow);
        // Where the hand moves against the forearm, the forearm ends at the wrist: an elbow may have a second joint in its place.
        let between = chain(self.character, hand.body, elbow.body);
        let mut joints = between.iter().rev().filter_map(|&b| self.character.bodies[b].joints.clone().next());
        let reach = |joint: usize| (self.kinematics.joint_anchor[joint] - self.at(elbow)).norm();
        let wrist = joints.find(|&joint| reach(joint) > ELBOW * upper.length);
        let (fore, hand) = match wrist {
            None => (self.segment(elbow, hand), None),
            Some(joint) => {
                let anchor = self.kinematics.joint_anchor[joint];
                let forearm = self.character.bodies[self.character.joints[joint].body].parent;
                let wrist = Spot { body: forearm, point: self.local(forearm, anchor) };
                let fore = self.segment(elbow, wrist);
                let arm = (anchor - self.at(shoulder)).try_normalize(1e-9)?;
                let direction = (self.at(hand) - anchor).try_normalize(1e-6).unwrap_or(arm);
                let out = self.turn.inverse() * if side == 0 { Vec3::y() } else { -Vec3::y() };
                let palm = Quat::rotation_between(&out, &arm).unwrap_or_else(Quat::identity) * -Vec3::z();
                let palm = (palm - direction * palm.dot(&direction)).try_normalize(1e-3)?;
                let back = self.kinematics.body_orientation[hand.body].inverse();
                (fore, Some((hand.body, back * direction, back * palm)))
            }
        };
        (upper.length > 1e-4 && fore.length > 1e-4).then_some(Arm { upper, fore, hand })
    }
}

/// Returns the unit normal of the plane through the points, if they span one.
fn plane_normal(points: &[Vec3], centre: &Vec3) -> Option<Vec3> {
    let mut best = Vec3::zeros();
    for a in points {
        for b in points {
            let n = (a - centre).cross(&(b - centre));
            if n.norm() > best.norm() {
                best = n;
            }
        }
    }
    best.try_normalize(1e-8)
}
