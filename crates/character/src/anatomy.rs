//! Roles of bodies (pelvis, left foot, ...): guessed from names and geometry, overridable by text.
//!
//! `words` reads names, `limbs` finds legs and arms and the centres of their joints, `sole` finds what touches the ground.

pub(crate) mod limbs;
mod sole;
pub(crate) mod words;

use std::collections::{BTreeMap, BTreeSet};

use crate::error::CharacterError;
use crate::kinematics::Kinematics;
use crate::model::{Character, GeomShape, welded};
use crate::rotation::Vec3;

pub use crate::outline::outline;
pub use sole::lowest;

use limbs::{Finder, Kind, Limb};
use words::Side;

/// A part of a humanoid, whatever the robot calls it.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, serde::Serialize, serde::Deserialize, schemars::JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub enum Role {
    /// The body that carries the hips; mostly the floating base.
    Pelvis,
    /// The body that carries the shoulders (may be the pelvis itself).
    Chest,
    /// The head.
    Head,
    /// Upper leg, left.
    LeftThigh,
    /// Lower leg, left.
    LeftShank,
    /// Foot, left.
    LeftFoot,
    /// Upper leg, right.
    RightThigh,
    /// Lower leg, right.
    RightShank,
    /// Foot, right.
    RightFoot,
    /// Upper arm, left.
    LeftUpperArm,
    /// Lower arm, left.
    LeftForearm,
    /// Hand, left: a body, or a place on the forearm.
    LeftHand,
    /// Upper arm, right.
    RightUpperArm,
    /// Lower arm, right.
    RightForearm,
    /// Hand, right: a body, or a place on the forearm.
    RightHand,
}

/// A place on a body that plays a role.
#[derive(Debug, Clone, PartialEq)]
pub struct Place {
    /// The body.
    pub body: usize,
    /// The point in its frame (m): the joint centre of a limb segment (hip, knee, ankle, shoulder, elbow), or the
    /// middle of a hand or head. For the pelvis it is the middle between the hips, for the chest between the
    /// shoulders.
    pub point: Vec3,
}

/// The sole of one foot: what touches the ground.
#[derive(Debug, Clone, PartialEq)]
pub struct Sole {
    /// The foot's body.
    pub body: usize,
    /// Corners of the contact patch in the body frame (m); the lowest points of the foot's collision geoms.
    pub corners: Vec<Vec3>,
}

impl Sole {
    /// Returns the middle of its corners in the body frame (m).
    pub fn middle(&self) -> Vec3 {
        self.corners.iter().sum::<Vec3>() / self.corners.len().max(1) as f64
    }
}

/// The parts of a character. Robots without arms or head simply lack those roles.
#[derive(Debug, Clone, PartialEq)]
pub struct Anatomy {
    /// Body and point of each role.
    pub places: BTreeMap<Role, Place>,
    /// Left and right sole, as far as there are feet.
    pub soles: BTreeMap<Role, Sole>,
}

/// Overrides of the guess, as text: role = body or site name.
pub type Overrides = BTreeMap<Role, String>;

const LEGS: [(Side, [Role; 3]); 2] = [
    (Side::Left, [Role::LeftThigh, Role::LeftShank, Role::LeftFoot]),
    (Side::Right, [Role::RightThigh, Role::RightShank, Role::RightFoot]),
];
const ARMS: [(Side, [Role; 3]); 2] = [
    (Side::Left, [Role::LeftUpperArm, Role::LeftForearm, Role::LeftHand]),
    (Side::Right, [Role::RightUpperArm, Role::RightForearm, Role::RightHand]),
];

/// Share of the height within which a body is near the ground.
const NEAR_GROUND: f64 = 0.15;

impl Anatomy {
    /// Returns the foot, as an index into [`Self::soles`], that a body is or hangs from.
    pub fn foot_of(&self, character: &Character, mut body: usize) -> Option<usize> {
        while body != 0 {
            if let Some(foot) = self.soles.values().position(|sole| sole.body == body) {
                return Some(foot);
            }
            body = character.bodies[body].parent;
        }
        None
    }

    /// Guesses from names and geometry at the reference position, then applies the overrides. Parts that it cannot
    /// find are absent.
    ///
    /// # Errors
    /// [`CharacterError::UnknownName`] for an override that names neither a body nor a site.
    pub fn guess(character: &Character, overrides: &Overrides) -> Result<Self, CharacterError> {
        let kinematics = Kinematics::new(character);
        let finder = Finder::new(character, &kinematics);
        let mut anatomy = Self { places: BTreeMap::new(), soles: BTreeMap::new() };
        let mut hips = Vec::new();
        for (side, roles) in LEGS {
            if let Some(leg) = finder.limb(Kind::Leg, side) {
                anatomy.put(&finder, roles[0], leg.upper);
                anatomy.put(&finder, roles[1], leg.lower);
                if let Some(foot) = leg.end.or_else(|| fixed_foot(&finder, &leg, side)) {
                    anatomy.put(&finder, roles[2], foot);
                }
                hips.push(leg.upper);
            }
        }
        let mut shoulders = Vec::new();
        for (side, roles) in ARMS {
            if let Some(arm) = finder.limb(Kind::Arm, side) {
                anatomy.put(&finder, roles[0], arm.upper);
                anatomy.put(&finder, roles[1], arm.lower);
                anatomy.put(&finder, roles[2], hand(&finder, &arm, side));
                shoulders.push(arm.upper);
            }
        }
        anatomy.trunk(&finder, &hips, &shoulders);
        if let Some(place) = head(&finder) {
            anatomy.put(&finder, Role::Head, place);
        }
        anatomy.override_by(&finder, overrides)?;
        for foot in [Role::LeftFoot, Role::RightFoot] {
            if let Some(place) = anatomy.places.get(&foot) {
                let corners = sole::corners(character, &kinematics, place.body);
                anatomy.soles.insert(foot, Sole { body: place.body, corners });
            }
        }
        Ok(anatomy)
    }

    fn put(&mut self, finder: &Finder<'_>, role: Role, (body, point_w): (usize, Vec3)) {
        self.places.insert(role, Place { body, point: finder.local(body, &point_w) });
    }

    /// Returns the number of legs: limbs that hang on the root, have two joints or more, and end near the lowest body.
    pub fn legs(character: &Character) -> usize {
        let kinematics = Kinematics::new(character);
        let z = |body: usize| kinematics.body_position[body].z;
        let bodies = 1..character.bodies.len();
        let (low, high) = bodies.clone().fold((f64::MAX, f64::MIN), |(low, high), b| (low.min(z(b)), high.max(z(b))));
        let trunk = welded(&character.bodies, character.root_body());
        // Joints on the way from the trunk to a body, and the body of the limb that hangs on the trunk.
        let way = |mut body: usize| {
            let mut joints = 0;
            while body != 0 && !trunk[body] {
                joints += character.bodies[body].joints.len();
                if trunk[character.bodies[body].parent] {
                    return Some((body, joints));
                }
                body = character.bodies[body].parent;
            }
            None
        };
        let near = bodies.filter(|b| z(*b) - low <= NEAR_GROUND * (high - low)).filter_map(way);
        near.filter(|(_, joints)| *joints >= 2).map(|(limb, _)| limb).collect::<BTreeSet<usize>>().len()
    }

    /// Finds the trunk: the pelvis carries both hips, the chest both shoulders.
    fn trunk(&mut self, finder: &Finder<'_>, hips: &[(usize, Vec3)], shoulders: &[(usize, Vec3)]) {
        let character = finder.character;
        let root = character.root_joint().map(|j| j.body).or((character.bodies.len() > 1).then_some(1));
        let Some(root) = root else { return };
        let carrier = |limbs: &[(usize, Vec3)]| match limbs {
            [left, right] => {
                let body = finder.common(character.bodies[left.0].parent, character.bodies[right.0].parent);
                // Limbs that hang on the world share no body.
                Some((if body == 0 { root } else { body }, (left.1 + right.1) * 0.5))
            }
            _ => None,
        };
        let origin = |body: usize| (body, finder.kinematics.body_position[body]);
        let pelvis = carrier(hips).unwrap_or_else(|| origin(root));
        let chest = carrier(shoulders).unwrap_or_else(|| {
            let named = |b: &usize| words::has(&character.bodies[*b].name, &["chest", "torso", "thorax", "trunk"]);
            origin((1..character.bodies.len()).find(named).unwrap_or(pelvis.0))
        });
        self.put(finder, Role::Pelvis, pelvis);
        self.put(finder, Role::Chest, chest);
    }

    fn override_by(&mut self, finder: &Finder<'_>, overrides: &Overrides) -> Result<(), CharacterError> {
        let character = finder.character;
        for (role, name) in overrides {
            if let Ok(site) = character.site(name) {
                let site = &character.sites[site];
                self.places.insert(*role, Place { body: site.body, point: site.position });
                continue;
            }
            let body = character.body(name)?;
            let joints: Vec<_> = character.bodies[body].joints.clone().map(|j| &character.joints[j]).collect();
            let point_w = if joints.is_empty() || matches!(role, Role::Pelvis | Role::Chest | Role::Head) {
                finder.kinematics.body_position[body]
            } else {
                finder.centre(&joints)
            };
            self.put(finder, *role, (body, point_w));
        }
        Ok(())
    }
}

/// Returns a body named for the foot that is fixed to the shank, as Gymnasium's humanoid has it, and its origin.
fn fixed_foot(finder: &Finder<'_>, leg: &Limb, side: Side) -> Option<(usize, Vec3)> {
    let bodies = &finder.character.bodies;
    let hangs = |body: &usize| bodies[*body].parent == leg.lower.0 && finder.side(*body) == Some(side);
    let named = (1..bodies.len()).filter(hangs).find(|body| words::has(&bodies[*body].name, &words::FOOT))?;
    Some((named, finder.kinematics.body_position[named]))
}

/// Returns a site named for the hand, else a body named for it, else the far end of the arm's last shape.
fn hand(finder: &Finder<'_>, arm: &Limb, side: Side) -> (usize, Vec3) {
    let character = finder.character;
    let beyond = |body: usize| {
        let mut at = body;
        while at != 0 && at != arm.lower.0 {
            at = character.bodies[at].parent;
        }
        at != 0 && finder.side(body) == Some(side)
    };
    let site = character.sites.iter().filter(|s| beyond(s.body) && words::has(&s.name, &words::HAND));
    // `hand` before `hand_touch`.
    if let Some(site) = site.min_by_key(|s| s.name.len()) {
        return (site.body, finder.kinematics.point(site.body, &site.position));
    }
    let bodies = (1..character.bodies.len()).filter(|b| beyond(*b) && *b != arm.lower.0);
    let named = bodies.filter(|b| words::has(&character.bodies[*b].name, &words::HAND)).min();
    if let Some(body) = named {
        return (body, middle_of(finder, body));
    }
    let last = arm.end.map_or(arm.lower.0, |end| end.0);
    let from = arm.lower.1;
    let far = character.geoms.iter().filter(|g| g.body == last).flat_map(|g| {
        let half = match g.shape {
            GeomShape::Capsule(_, half) | GeomShape::Cylinder(_, half) => half,
            _ => 0.0,
        };
        [half, -half].map(|z| finder.kinematics.point(last, &(g.position + g.orientation * Vec3::new(0.0, 0.0, z))))
    });
    let tip = far.max_by(|a, b| (a - from).norm().total_cmp(&(b - from).norm()));
    (last, tip.unwrap_or_else(|| finder.kinematics.point(last, &character.bodies[last].inertial.com)))
}

/// Returns a site or body named for the head.
fn head(finder: &Finder<'_>) -> Option<(usize, Vec3)> {
    let character = finder.character;
    let exact = |name: &str| name.eq_ignore_ascii_case("head");
    if let Some(site) = character.sites.iter().find(|s| exact(&s.name)) {
        return Some((site.body, finder.kinematics.point(site.body, &site.position)));
    }
    let bodies = 1..character.bodies.len();
    let name = |b: &usize| character.bodies[*b].name.as_str();
    let named = bodies.clone().find(|b| exact(name(b)));
    // Of several (`head_pitch`, `head_yaw`) the last carries the head.
    let body = named.or_else(|| bodies.rev().find(|b| finder.side(*b).is_none() && words::has(name(b), &["head"])));
    body.map(|b| (b, middle_of(finder, b)))
}

/// Returns the centre of mass of a body, or its origin where it has no mass.
fn middle_of(finder: &Finder<'_>, body: usize) -> Vec3 {
    let inertial = &finder.character.bodies[body].inertial;
    let local = if inertial.mass > 0.0 { inertial.com } else { Vec3::zeros() };
    finder.kinematics.point(body, &local)
}
