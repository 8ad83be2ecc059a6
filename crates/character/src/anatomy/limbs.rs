//! Legs and arms: the chains of joints on either side, and the centres of their joints.

use nalgebra::Matrix3;

use crate::anatomy::words::{self, Side};
use crate::kinematics::Kinematics;
use crate::model::{Character, Joint, JointKind};
use crate::rotation::Vec3;

/// An axis is along a limb if the joint above is this share as far from it as from the anchor along it (16 degrees).
const TWIST: f64 = 0.3;

/// A limb: three bodies that hang on one another, and where they are joined (m, world, at the reference position).
#[derive(Debug, Clone)]
pub(crate) struct Limb {
    /// Thigh or upper arm, and its joint centre.
    pub upper: (usize, Vec3),
    /// Shank or forearm.
    pub lower: (usize, Vec3),
    /// Foot, or what is beyond the forearm, if the limb has joints there.
    pub end: Option<(usize, Vec3)>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    Leg,
    Arm,
}

/// Looks for limbs in one character at its reference position.
pub(crate) struct Finder<'a> {
    pub character: &'a Character,
    pub kinematics: &'a Kinematics,
    sides: Vec<Option<Side>>,
}

impl<'a> Finder<'a> {
    pub fn new(character: &'a Character, kinematics: &'a Kinematics) -> Self {
        let mut finder = Self { character, kinematics, sides: vec![None; character.bodies.len()] };
        let named = finder.tell_sides(|name, _| words::side(name));
        if !named {
            // No name tells: those further left than a twentieth of the height are left.
            let height = kinematics.body_position.iter().map(|p| p.z).fold(f64::MIN, f64::max).abs().max(1e-3);
            finder.tell_sides(|_, y| match y / height {
                y if y > 0.05 => Some(Side::Left),
                y if y < -0.05 => Some(Side::Right),
                _ => None,
            });
        }
        finder
    }

    /// Gives each body the side of its joints' names, else of its own, else of its parent. False: no side anywhere.
    fn tell_sides(&mut self, tell: impl Fn(&str, f64) -> Option<Side>) -> bool {
        for (i, body) in self.character.bodies.iter().enumerate().skip(1) {
            let y = self.kinematics.body_position[i].y;
            let joints = body.joints.clone().filter(|j| self.character.joints[*j].kind != JointKind::Free);
            let told = joints.filter_map(|j| tell(&self.character.joints[j].name, y)).next();
            self.sides[i] = told.or_else(|| tell(&body.name, y)).or(self.sides[body.parent]);
        }
        self.sides.iter().any(Option::is_some)
    }

    /// Returns the side of a body.
    pub fn side(&self, body: usize) -> Option<Side> {
        self.sides[body]
    }

    /// Returns the leg or arm on one side.
    pub fn limb(&self, kind: Kind, side: Side) -> Option<Limb> {
        let mut has_child = vec![false; self.character.bodies.len()];
        for body in self.character.bodies.iter().skip(1) {
            has_child[body.parent] = true;
        }
        let tips = (1..has_child.len()).filter(|b| !has_child[*b] && self.sides[*b] == Some(side));
        let best = tips
            .map(|tip| self.chain(tip, side))
            .filter(|c| self.joints(c).len() >= 2 && self.kind(c) == Some(kind))
            // The longest chain is the limb itself; gears and covers hang on it by less.
            .max_by_key(|c| (self.joints(c).len(), std::cmp::Reverse(c.last().copied())))?;
        self.split(kind, &best)
    }

    /// Returns the bodies of this side on the way from the root to the tip.
    fn chain(&self, tip: usize, side: Side) -> Vec<usize> {
        let mut chain = Vec::new();
        let mut at = tip;
        while at != 0 && self.sides[at] == Some(side) {
            chain.push(at);
            at = self.character.bodies[at].parent;
        }
        chain.reverse();
        chain
    }

    fn joints(&self, chain: &[usize]) -> Vec<usize> {
        let joints = chain.iter().flat_map(|b| self.character.bodies[*b].joints.clone());
        joints.filter(|j| matches!(self.character.joints[*j].kind, JointKind::Hinge | JointKind::Ball)).collect()
    }

    /// Finds the kind by the words in its names; where they say nothing, a limb that ends near the lowest body is a
    /// leg.
    fn kind(&self, chain: &[usize]) -> Option<Kind> {
        let (mut leg, mut arm) = (0, 0);
        for body in chain {
            let joints = self.character.bodies[*body].joints.clone();
            let names = joints.map(|j| &self.character.joints[j].name).chain([&self.character.bodies[*body].name]);
            for name in names {
                leg += usize::from(words::has(name, &words::LEG));
                arm += usize::from(words::has(name, &words::ARM));
            }
        }
        match leg.cmp(&arm) {
            std::cmp::Ordering::Greater => return Some(Kind::Leg),
            std::cmp::Ordering::Less => return Some(Kind::Arm),
            std::cmp::Ordering::Equal => {}
        }
        let z = |body: usize| self.kinematics.body_position[body].z;
        let (first, last) = (*chain.first()?, *chain.last()?);
        let bodies = 1..self.character.bodies.len();
        let lowest = bodies.clone().map(z).fold(f64::MAX, f64::min);
        let highest = bodies.map(z).fold(f64::MIN, f64::max);
        let near_ground = z(last) - lowest < 0.15 * (highest - lowest);
        Some(if near_ground && z(first) > z(last) { Kind::Leg } else { Kind::Arm })
    }

    /// Finds knee and ankle, or elbow and wrist, in a chain.
    fn split(&self, kind: Kind, chain: &[usize]) -> Option<Limb> {
        let joints = self.joints(chain);
        let middle = self.middle(kind, &joints)?;
        let character = self.character;
        let joint = |i: usize| &character.joints[joints[i]];
        // A hip or shoulder has three joints at most; what lies before belongs to the girdle.
        let upper: Vec<&Joint> = (middle.saturating_sub(3)..middle).map(joint).collect();
        let upper_body = upper.last()?.body;
        let upper_centre = self.centre(&upper);
        let lower = joint(middle);
        let lower_centre = self.hinge_centre(lower, &upper_centre);
        let length = (lower_centre - upper_centre).norm();
        let mut end: Vec<&Joint> = Vec::new();
        for j in (middle + 1..joints.len()).map(joint) {
            let name = &character.bodies[j.body].name;
            let beyond =
                words::has(&j.name, &["toe", "finger", "thumb"]) || words::has(name, &["toe", "finger", "thumb"]);
            let same_place = end.first().is_none_or(|f| self.apart(f, j) < 0.4 * length);
            if beyond || !same_place || (kind == Kind::Leg && end.len() == 3) {
                break;
            }
            end.push(j);
        }
        let end = match end[..] {
            [] => None,
            [one] => Some((one.body, self.hinge_centre(one, &lower_centre))),
            [.., last] => Some((last.body, self.centre(&end))),
        };
        Some(Limb { upper: (upper_body, upper_centre), lower: (lower.body, lower_centre), end })
    }

    /// Finds the knee or elbow among the joints: by name, else the hinge nearest to half of the way.
    fn middle(&self, kind: Kind, joints: &[usize]) -> Option<usize> {
        let wanted = if kind == Kind::Leg { &words::SHANK[..] } else { &words::FOREARM[..] };
        let name = |i: usize| &self.character.joints[joints[i]].name;
        let body = |i: usize| &self.character.bodies[self.character.joints[joints[i]].body].name;
        let by_joint = (1..joints.len()).find(|i| words::has(name(*i), wanted));
        let by_body = || (1..joints.len()).find(|i| words::has(body(*i), wanted));
        by_joint.or_else(by_body).or_else(|| {
            let anchor = |i: usize| self.kinematics.joint_anchor[joints[i]];
            let mut way = vec![0.0];
            for i in 1..joints.len() {
                way.push(way[i - 1] + (anchor(i) - anchor(i - 1)).norm());
            }
            let half = 0.5 * way.last()?;
            (1..joints.len()).min_by(|a, b| (way[*a] - half).abs().total_cmp(&(way[*b] - half).abs()))
        })
    }

    fn apart(&self, a: &Joint, b: &Joint) -> f64 {
        (self.anchor(a) - self.anchor(b)).norm()
    }

    fn anchor(&self, joint: &Joint) -> Vec3 {
        self.kinematics.point(joint.body, &joint.position)
    }

    fn axis(&self, joint: &Joint) -> Vec3 {
        self.kinematics.body_orientation[joint.body] * joint.axis
    }

    /// Returns the point closest to all axes, in the least-squares sense; along what they leave open, the mean of the
    /// anchors.
    pub fn centre(&self, joints: &[&Joint]) -> Vec3 {
        const TIE: f64 = 1e-3;
        let mut a = Matrix3::zeros();
        let mut b = Vec3::zeros();
        for joint in joints {
            let (anchor, axis) = (self.anchor(joint), self.axis(joint));
            let across = match joint.kind {
                JointKind::Hinge => Matrix3::identity() - axis * axis.transpose(),
                _ => Matrix3::identity(),
            };
            let weight = across + Matrix3::identity() * TIE;
            a += weight;
            b += weight * anchor;
        }
        a.try_inverse().map_or_else(Vec3::zeros, |inverse| inverse * b)
    }

    /// Returns the centre of a single hinge: its anchor, or, where that was put far out on the axis, the point
    /// nearest to the joint above it.
    fn hinge_centre(&self, joint: &Joint, upper: &Vec3) -> Vec3 {
        let (anchor, axis) = (self.anchor(joint), self.axis(joint));
        let along = (upper - anchor).dot(&axis);
        let across = (upper - anchor - axis * along).norm();
        // Thighs lean in or out a little; an anchor further to the side than a fifth of the thigh is a drawing's choice. An elbow
        // may begin with the twist of its upper arm: along that axis the nearest point is the shoulder.
        let is_twist = across < TWIST * along.abs();
        let is_far_out = along.abs() > across / 5.0;
        if joint.kind == JointKind::Hinge && is_far_out && !is_twist { anchor + axis * along } else { anchor }
    }

    /// Returns the point of a body's frame that is this world point.
    pub fn local(&self, body: usize, point_w: &Vec3) -> Vec3 {
        self.kinematics.body_orientation[body].inverse() * (point_w - self.kinematics.body_position[body])
    }

    /// Returns the deepest body that carries both.
    pub fn common(&self, a: usize, b: usize) -> usize {
        let mut above_a = vec![a];
        while let Some(last) = above_a.last().filter(|l| **l != 0) {
            above_a.push(self.character.bodies[*last].parent);
        }
        let mut at = b;
        while !above_a.contains(&at) {
            at = self.character.bodies[at].parent;
        }
        at
    }
}
