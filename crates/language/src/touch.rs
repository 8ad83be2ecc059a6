//! Places of the body that hands touch, and motion whose hands come to rest on them.
//!
//! A keyframed figure's hand on its brow is beside the brow of a robot with other proportions. [`Touching::reached`]
//! moves the hand there by inverse kinematics, and keeps what it does there: a scratch stays a scratch.

use std::collections::BTreeMap;

use lifelike_character::anatomy::Place;
use lifelike_character::{Anatomy, Character, Geom, GeomShape, Kinematics, Role, Vec3};
use lifelike_motion::MotionClip;
use lifelike_motion::edit::{Compose, Key, Length, Target, compose, joints_of, place};
use lifelike_motion::retarget::RetargetOptions;
use serde::{Deserialize, Serialize};

use crate::error::LanguageError;
use crate::facts::Side;

/// Longest way to a touch and back (s).
const WAY: f64 = 0.45;
/// Share of a gap's range in which a hand is there.
const NEAR: f64 = 0.15;
/// Longest stay that is one touch (s); what stays longer has a begin and an end.
const TAP: f64 = 0.3;

/// Height of a head above the shoulders (shares of a leg), where it has no body of its own.
const HEAD: f64 = 0.3;
/// Way of a root that comes along with a hand at most (shares of a leg).
const FARTHEST: f64 = 0.1;
/// The same of a root that sinks with hands that reach for the toes: further down `lima` sits on its heels.
const LOWEST: f64 = 0.12;
/// Passes of placing.
const PASSES: usize = 3;
/// Steps of hands that reach for the toes, each a share of the way that is left.
const STEPS: (usize, f64) = (8, 0.25);

/// Leg of the keyframed figure from hip to ankle (m).
pub const LEG: f64 = 0.82;

/// A place that a hand touches. Of a pair of places it is the one on the hand's own side, unless said otherwise.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Touch {
    /// The other hand.
    Hands,
    /// The top of the head.
    Crown,
    /// The back of the head.
    Nape,
    /// Above the eye.
    Brow,
    /// The eyes.
    Eyes,
    /// The mouth.
    Mouth,
    /// The tip of the nose.
    Nose,
    /// The ear.
    Ear,
    /// The left side of the chest.
    Heart,
    /// The chest.
    Chest,
    /// The belly.
    Belly,
    /// The small of the back.
    Back,
    /// The hip.
    Hip,
    /// The shoulder of the other side.
    Shoulder,
    /// The shoulder of the hand's own side.
    OwnShoulder,
    /// The forearm of the other side.
    Forearm,
    /// The knee.
    Knee,
    /// The knee of the other side.
    OtherKnee,
    /// The toes.
    Toes,
}

impl Touch {
    /// Every place.
    pub const ALL: [Self; 19] = [
        Self::Hands,
        Self::Crown,
        Self::Nape,
        Self::Brow,
        Self::Eyes,
        Self::Mouth,
        Self::Nose,
        Self::Ear,
        Self::Heart,
        Self::Chest,
        Self::Belly,
        Self::Back,
        Self::Hip,
        Self::Shoulder,
        Self::OwnShoulder,
        Self::Forearm,
        Self::Knee,
        Self::OtherKnee,
        Self::Toes,
    ];

    /// Returns the words.
    pub fn words(self) -> &'static str {
        match self {
            Self::Hands => "other hand",
            Self::Crown => "top of the head",
            Self::Nape => "back of the head",
            Self::Brow => "brow",
            Self::Eyes => "eyes",
            Self::Mouth => "mouth",
            Self::Nose => "nose",
            Self::Ear => "ear",
            Self::Heart => "heart",
            Self::Chest => "chest",
            Self::Belly => "belly",
            Self::Back => "back",
            Self::Hip => "hip",
            Self::Shoulder => "other shoulder",
            Self::OwnShoulder => "shoulder",
            Self::Forearm => "other forearm",
            Self::Knee => "knee",
            Self::OtherKnee => "other knee",
            Self::Toes => "toes",
        }
    }

    /// Returns the part that is touched, and the direction from its place to where (x ahead, y left, z up).
    /// `side` is 0 for the left hand.
    fn spot(self, side: usize) -> (Role, Vec3) {
        let out = if side == 0 { 1.0 } else { -1.0 };
        let same_side = |left: Role, right: Role| if side == 0 { left } else { right };
        match self {
            Self::Hands => (same_side(Role::RightHand, Role::LeftHand), Vec3::zeros()),
            Self::Crown => (Role::Head, Vec3::new(0.0, 0.3 * out, 1.0)),
            Self::Nape => (Role::Head, Vec3::new(-1.0, 0.4 * out, 0.3)),
            Self::Brow => (Role::Head, Vec3::new(1.0, 0.55 * out, 0.55)),
            Self::Eyes => (Role::Head, Vec3::new(1.0, 0.35 * out, 0.15)),
            Self::Mouth => (Role::Head, Vec3::new(1.0, 0.15 * out, -0.45)),
            Self::Nose => (Role::Head, Vec3::new(1.0, 0.05 * out, -0.1)),
            Self::Ear => (Role::Head, Vec3::new(0.15, out, 0.0)),
            Self::Heart => (Role::Chest, Vec3::new(1.0, 0.35, 0.0)),
            Self::Chest => (Role::Chest, Vec3::new(1.0, 0.35 * out, 0.0)),
            Self::Belly => (Role::Pelvis, Vec3::new(1.0, 0.1 * out, 0.0)),
            Self::Back => (Role::Pelvis, Vec3::new(-1.0, 0.2 * out, 0.0)),
            Self::Hip => (Role::Pelvis, Vec3::new(0.15, out, 0.0)),
            Self::Shoulder => (same_side(Role::RightUpperArm, Role::LeftUpperArm), Vec3::new(1.0, 0.9 * out, 0.1)),
            Self::OwnShoulder => (same_side(Role::LeftUpperArm, Role::RightUpperArm), Vec3::new(0.6, 0.0, 1.0)),
            Self::Forearm => (same_side(Role::RightForearm, Role::LeftForearm), Vec3::new(1.0, 0.0, 0.0)),
            Self::Knee => (same_side(Role::LeftShank, Role::RightShank), Vec3::new(1.0, 0.0, 0.0)),
            Self::OtherKnee => (same_side(Role::RightShank, Role::LeftShank), Vec3::new(1.0, 0.0, 0.0)),
            Self::Toes => (same_side(Role::LeftFoot, Role::RightFoot), Vec3::new(1.0, 0.0, 0.3)),
        }
    }

    /// Returns the largest gap that counts as a touch (shares of a leg).
    pub fn tolerance(self) -> f64 {
        if self == Self::Hands { 0.06 } else { 0.14 }
    }
}

/// A robot's hands, and where they are when they touch.
#[derive(Debug, Clone)]
pub struct Touching {
    /// Left and right hand: body, point, radius (m).
    hands: [(usize, Vec3, f64); 2],
    /// By place and hand, the body and the point at which the hand's middle is (m).
    places: BTreeMap<(Touch, usize), (usize, Vec3)>,
}

impl Touching {
    /// Finds the places on a robot; none without two hands. Parts that it lacks have no place.
    pub fn of(character: &Character, anatomy: &Anatomy) -> Option<Self> {
        let mut rest = Kinematics::new(character);
        rest.update(character, &character.reference_position());
        let leg = leg_length(character, anatomy);
        let hand = |role: Role| {
            let place = anatomy.places.get(&role)?;
            Some((place.body, place.point, thickness(character, place.body).unwrap_or(0.06 * leg)))
        };
        let hands = [hand(Role::LeftHand)?, hand(Role::RightHand)?];
        let mut places = BTreeMap::new();
        for touch in Touch::ALL {
            for (side, (_, _, radius)) in hands.iter().enumerate() {
                let (role, way) = touch.spot(side);
                let Some(place) = place_of(role, anatomy, &rest, leg) else { continue };
                let turned = rest.body_orientation[place.body].inverse();
                let mut point = place.point + turned * from_centre(touch, &rest, anatomy);
                if let Some(way) = (turned * way).try_normalize(1e-9) {
                    let deep = depth(character, place.body, &point, &way).unwrap_or(usual(role) * leg);
                    point += way * (deep + radius);
                }
                places.insert((touch, side), (place.body, point));
            }
        }
        Some(Self { hands, places })
    }

    /// Returns how far a hand is from touching, as a vector in the world (m). For the other hand, from its surface.
    fn way(&self, kinematics: &Kinematics, touch: Touch, side: usize) -> Option<Vec3> {
        let (body, point) = self.places.get(&(touch, side))?;
        let (hand, middle, radius) = &self.hands[side];
        let way = kinematics.point(*body, point) - kinematics.point(*hand, middle);
        if touch != Touch::Hands {
            return Some(way);
        }
        let apart = (way.norm() - radius - self.hands[1 - side].2).max(0.0);
        Some(way.try_normalize(1e-9).unwrap_or_else(Vec3::zeros) * apart)
    }

    /// Returns the gaps between each hand and a place in one pose (m); none where the robot lacks the place.
    pub fn gaps(&self, kinematics: &Kinematics, touch: Touch) -> Option<[f64; 2]> {
        Some([self.way(kinematics, touch, 0)?.norm(), self.way(kinematics, touch, 1)?.norm()])
    }

    /// Returns the clip with its hands at the place wherever they come near to it. Out of reach, they come as near as
    /// the arm can. The body gives way a little and the place with it, so it takes some passes.
    ///
    /// # Errors
    /// As placing and kinematics.
    pub fn reached(
        &self,
        clip: &MotionClip,
        robot: (&Character, &Anatomy),
        touch: (Touch, Side),
        options: &RetargetOptions,
    ) -> Result<MotionClip, LanguageError> {
        let mut reached = clip.clone();
        if touch.0 == Touch::Toes {
            for _ in 0..STEPS.0 {
                let lower = self.nearer(&reached, robot, touch, options, Reach { is_still: false, share: STEPS.1 })?;
                if moved(clip, &lower) > LOWEST * leg_length(robot.0, robot.1) {
                    break;
                }
                reached = lower;
            }
            return Ok(reached);
        }
        for _ in 0..PASSES {
            reached = self.nearer(&reached, robot, touch, options, Reach { is_still: false, share: 1.0 })?;
        }
        // A place out of reach goes away with the trunk that leans after it: then the arm alone reaches.
        let is_of_trunk = !matches!(touch.0, Touch::Knee | Touch::OtherKnee);
        if is_of_trunk && moved(clip, &reached) > FARTHEST * leg_length(robot.0, robot.1) {
            reached = clip.clone();
            for _ in 0..PASSES {
                reached = self.nearer(&reached, robot, touch, options, Reach { is_still: true, share: 1.0 })?;
            }
        }
        Ok(reached)
    }

    /// Returns the clip after one pass.
    fn nearer(
        &self,
        clip: &MotionClip,
        (character, anatomy): (&Character, &Anatomy),
        (touch, side): (Touch, Side),
        options: &RetargetOptions,
        reach: Reach,
    ) -> Result<MotionClip, LanguageError> {
        let columns = clip.columns_for(character)?;
        let mut kinematics = Kinematics::new(character);
        let mut q = character.reference_position();
        let mut ways: [Vec<Vec3>; 2] = [Vec::new(), Vec::new()];
        for frame in 0..clip.len() {
            clip.write_position(character, &columns, frame, &mut q);
            kinematics.update(character, &q);
            for (hand, ways) in ways.iter_mut().enumerate() {
                let Some(way) = self.way(&kinematics, touch, hand) else { return Ok(clip.clone()) };
                ways.push(way);
            }
        }
        let mut keys = Vec::new();
        for (hand, ways) in ways.iter().enumerate() {
            let acts = match side {
                Side::Left => hand == 0,
                Side::Right => hand == 1,
                Side::Both => true,
            };
            // Both hands go half of the way to each other.
            let share = if touch == Touch::Hands && side == Side::Both { 0.5 } else { reach.share };
            if acts {
                let name = if hand == 0 { "left_hand" } else { "right_hand" };
                let of_hand = keys_of(name, ways, share, clip.fps);
                let still = |key: &Key| Key { body: "chest".into(), target: Target::By(Vec3::zeros()), ..key.clone() };
                if reach.is_still {
                    let is_new =
                        |key: &&Key| keys.iter().all(|other: &Key| (other.time - key.time).abs() > 0.5 / clip.fps);
                    let chest: Vec<Key> = of_hand.iter().filter(is_new).map(still).collect();
                    keys.extend(chest);
                }
                keys.extend(of_hand);
            }
        }
        if keys.is_empty() {
            return Ok(clip.clone());
        }
        let (placed, _) = place(clip, character, anatomy, &keys, options)?;
        let placed = match reach.is_still {
            false => placed,
            // The arms alone: what else moved to reach farther stays where it was.
            true => {
                let joints = joints_of(character, anatomy, &["arms".into()])?;
                compose(clip, &placed, &Compose { joints, offset: 0.0, length: Length::Return, fade: 0.0 })?
            }
        };
        Ok(MotionClip { name: clip.name.clone(), provenance: clip.provenance.clone(), ..placed })
    }
}

/// Returns how far the root of a clip is from that of another at most (m).
fn moved(clip: &MotionClip, other: &MotionClip) -> f64 {
    let pairs = clip.root_position.iter().zip(&other.root_position);
    pairs.map(|(a, b)| (a - b).norm()).fold(0.0, f64::max)
}

/// One pass of placing.
#[derive(Debug, Clone, Copy)]
struct Reach {
    /// True where the trunk stays, and the arm alone reaches.
    is_still: bool,
    /// Share of the way.
    share: f64,
}

/// Returns the keys of one hand: one for a tap, two for a stay.
fn keys_of(name: &str, ways: &[Vec3], share: f64, fps: f64) -> Vec<Key> {
    let gaps: Vec<f64> = ways.iter().map(|way| way.norm()).collect();
    let low = gaps.iter().copied().fold(f64::INFINITY, f64::min);
    let high = gaps.iter().copied().fold(0.0, f64::max);
    let is_near = |frame: &usize| gaps[*frame] <= low + NEAR * (high - low);
    let near: Vec<usize> = (0..gaps.len()).filter(is_near).collect();
    let stays: Vec<&[usize]> = near.chunk_by(|a, b| *b == a + 1).collect();
    let mut keys = Vec::new();
    for (number, stay) in stays.iter().enumerate() {
        let (first, last) = (stay[0], stay[stay.len() - 1]);
        let before = number.checked_sub(1).map_or(first, |b| (first - stays[b][stays[b].len() - 1]) / 2);
        let after = stays.get(number + 1).map_or(gaps.len() - 1 - last, |next| (next[0] - last) / 2);
        let key = |frame: usize, by: Vec3, (before, after): (f64, f64)| Key {
            body: name.into(),
            point: None,
            time: frame as f64 / fps,
            target: Target::By(by * share),
            before: before.max(1.0 / fps),
            after: after.max(1.0 / fps),
        };
        let windows = [before, after].map(|frames| (frames as f64 / fps).min(WAY));
        if (last - first) as f64 / fps <= TAP {
            let nearest = stay.iter().copied().min_by(|a, b| gaps[*a].total_cmp(&gaps[*b])).unwrap_or(first);
            let [before, after] = windows;
            let wider = [(nearest - first) as f64 / fps, (last - nearest) as f64 / fps];
            keys.push(key(nearest, ways[nearest], (before + wider[0], after + wider[1])));
        } else {
            // The mean way: what the hand does there stays.
            let mean = stay.iter().map(|frame| ways[*frame]).sum::<Vec3>() / stay.len() as f64;
            let long = (last - first) as f64 / fps;
            keys.push(key(first, mean, (windows[0], long)));
            keys.push(key(last, mean, (long, windows[1])));
        }
    }
    keys
}

/// Returns a part's place. A head that is one with the chest is above the shoulders.
fn place_of(role: Role, anatomy: &Anatomy, rest: &Kinematics, leg: f64) -> Option<Place> {
    if let (Role::Head, None) = (role, anatomy.places.get(&role)) {
        let chest = anatomy.places.get(&Role::Chest)?;
        let up = rest.body_orientation[chest.body].inverse() * Vec3::new(0.0, 0.0, HEAD * leg);
        return Some(Place { body: chest.body, point: chest.point + up });
    }
    anatomy.places.get(&role).cloned()
}

/// Returns where a place is measured from, seen from its part's own place (m, world at rest).
fn from_centre(touch: Touch, rest: &Kinematics, anatomy: &Anatomy) -> Vec3 {
    let place_at = |role: Role| anatomy.places.get(&role).map(|place| rest.point(place.body, &place.point));
    let between = |a: Role, b: Role| place_at(a).zip(place_at(b)).map_or_else(Vec3::zeros, |(a, b)| b - a);
    match touch {
        Touch::Belly | Touch::Hip | Touch::Back => between(Role::Pelvis, Role::Chest) * 0.35,
        Touch::Heart | Touch::Chest => between(Role::Chest, Role::Pelvis) * 0.2,
        Touch::Forearm => between(Role::LeftForearm, Role::LeftHand) * 0.6,
        _ => Vec3::zeros(),
    }
}

/// Returns the usual half thickness of a part (shares of a leg), where its shapes are meshes.
fn usual(role: Role) -> f64 {
    match role {
        Role::Head => 0.14,
        Role::Chest | Role::Pelvis => 0.17,
        Role::LeftFoot | Role::RightFoot => 0.2,
        _ => 0.07,
    }
}

/// Returns the distance from a point to the outside of a body's simple shapes along a direction (m).
fn depth(character: &Character, body: usize, from: &Vec3, way: &Vec3) -> Option<f64> {
    let of_body = character.geoms.iter().filter(|geom| geom.body == body);
    of_body.filter_map(|geom| support(geom, way).map(|far| far - from.dot(way))).reduce(f64::max)
}

/// Returns how far a shape reaches in a direction of its body's frame (m).
fn support(geom: &Geom, way: &Vec3) -> Option<f64> {
    let local = geom.orientation.inverse() * way;
    let far = match &geom.shape {
        GeomShape::Sphere(r) => *r,
        GeomShape::Capsule(r, half) => r + half * local.z.abs(),
        GeomShape::Cylinder(r, half) => r * local.x.hypot(local.y) + half * local.z.abs(),
        GeomShape::Box(half) => half.dot(&local.abs()),
        GeomShape::Ellipsoid(half) => half.component_mul(&local).norm(),
        GeomShape::Plane | GeomShape::Mesh(_) | GeomShape::HeightField(_) => return None,
    };
    Some(geom.position.dot(way) + far)
}

/// Returns half the thickness of a body's thinnest simple shape (m).
fn thickness(character: &Character, body: usize) -> Option<f64> {
    let half = |geom: &Geom| match geom.shape {
        GeomShape::Sphere(r) | GeomShape::Capsule(r, _) | GeomShape::Cylinder(r, _) => Some(r),
        GeomShape::Box(half) | GeomShape::Ellipsoid(half) => Some(half.min()),
        _ => None,
    };
    character.geoms.iter().filter(|geom| geom.body == body).filter_map(half).reduce(f64::min)
}

/// Returns the length of a leg from hip to ankle (m); that of a person's where the robot has none.
pub fn leg_length(character: &Character, anatomy: &Anatomy) -> f64 {
    let mut kinematics = Kinematics::new(character);
    kinematics.update(character, &character.reference_position());
    let place = |role: Role| anatomy.places.get(&role).map(|place| kinematics.point(place.body, &place.point));
    match [Role::LeftThigh, Role::LeftShank, Role::LeftFoot].map(place) {
        [Some(hip), Some(knee), Some(ankle)] => (hip - knee).norm() + (knee - ankle).norm(),
        _ => LEG,
    }
}
