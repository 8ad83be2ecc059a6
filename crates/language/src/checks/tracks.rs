//! A clip as the paths that checks look at: hands, feet and head seen from the pelvis, and the way of the root.

use std::collections::BTreeMap;

use lifelike_character::rotation::heading_angle;
use lifelike_character::{Anatomy, Character, Kinematics, Quat, Role, Vec3};
use lifelike_motion::MotionClip;
use serde::Deserialize;

use crate::error::LanguageError;
use crate::facts::Side;
use crate::touch::{Touch, Touching, leg_length};

/// A signal of a motion, one number per frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SignalName {
    /// The hand outward (m), while it is raised.
    HandSide,
    /// The hand outward (m), always.
    HandSideLow,
    /// The hand inward (m), while it is raised.
    HandIn,
    /// The hand ahead (m), while it is raised.
    HandForward,
    /// The hand back (m), while it is raised.
    HandBack,
    /// The hand's height (m).
    HandUp,
    /// Nearness of the hands to each other (m, negative), while they are raised.
    HandsClose,
    /// Height of one hand over the other (m), either of them, while one is raised: two peaks
    /// where they take turns.
    HandsUneven,
    /// The head's pitch (rad, down is positive).
    HeadPitch,
    /// The head's yaw relative to the pelvis (rad).
    HeadYaw,
    /// The pelvis' depth (m).
    RootDown,
    /// The pelvis' yaw (rad).
    RootYaw,
    /// The pelvis' pitch (rad, forward is positive).
    RootPitch,
    /// The foot's height (m).
    FootUp,
    /// The foot ahead of the pelvis (m).
    FootForward,
    /// The foot behind the pelvis (m).
    FootBack,
    /// The foot outward (m).
    FootSide,
    /// The pelvis to the left (m).
    RootLeft,
    /// Times without any foot on the ground.
    Flights,
    /// Steps of both feet.
    Steps,
    /// Steps of one foot, the other one being brought beside it.
    PairsOfSteps,
}

/// Lift of a foot that swings in motion without physics, whose standing feet are exact.
pub const KEYFRAMED: f64 = 0.005;
/// Lift of a foot that swings in physics, where soles rock on the ground: 1.4 cm of `lima`, some 2 cm of the G1. People see a step
/// from 2 and 3 cm on (docs/results/language.md).
pub const SIMULATED: f64 = 0.035;

/// Paths of a clip, one element per frame.
#[derive(Debug, Clone)]
pub struct Tracks {
    /// Frames per second.
    pub fps: f64,
    /// Length of a leg (m): the scale of distances.
    pub leg: f64,
    /// Height above its lowest point from which a foot swings (shares of a leg): [`KEYFRAMED`] or [`SIMULATED`].
    pub lift: f64,
    /// Root positions (m, world).
    pub root: Vec<Vec3>,
    /// Heading of the root, unwrapped (rad).
    pub yaw: Vec<f64>,
    /// Pitch of the root (rad, forward is positive).
    pub pitch: Vec<f64>,
    /// Lean of the root to the left (rad).
    pub lean: Vec<f64>,
    /// Left and right hand in the pelvis' heading frame (m); empty without hands.
    pub hands: [Vec<Vec3>; 2],
    /// Each shoulder in the same frame (m).
    pub shoulders: [Vec<Vec3>; 2],
    /// Left and right foot (m, world).
    pub feet: [Vec<Vec3>; 2],
    /// Pitch (down is positive) and yaw of the head relative to the pelvis' heading (rad); empty without head.
    pub head: Vec<[f64; 2]>,
    /// Pitch of the chest (rad, forward is positive); empty without chest.
    pub chest: Vec<f64>,
    /// Lean of the chest to its right (rad); empty without chest.
    pub chest_lean: Vec<f64>,
    /// Gaps between the left and the right hand and what they can touch (m).
    pub gaps: BTreeMap<Touch, Vec<[f64; 2]>>,
}

impl Tracks {
    /// Computes the paths by forward kinematics.
    ///
    /// # Errors
    /// [`LanguageError::Motion`] when the clip's joints are not the character's.
    pub fn of(clip: &MotionClip, character: &Character, anatomy: &Anatomy) -> Result<Self, LanguageError> {
        let columns = clip.columns_for(character)?;
        let mut kinematics = Kinematics::new(character);
        let mut q = character.reference_position();
        // How the head looks when nothing is turned: its frame need not look ahead.
        kinematics.update(character, &q);
        let head = anatomy
            .places
            .get(&Role::Head)
            .filter(|place| anatomy.places.get(&Role::Pelvis).is_none_or(|pelvis| pelvis.body != place.body));
        let at_rest = head.map(|place| kinematics.body_orientation[place.body]).unwrap_or_else(Quat::identity);
        let place = |role: Role| anatomy.places.get(&role);
        let chest = place(Role::Chest);
        let chest_at_rest = chest.map_or_else(Quat::identity, |place| kinematics.body_orientation[place.body]);
        let leg = leg_length(character, anatomy);
        let touching = Touching::of(character, anatomy);
        let n = clip.len();
        let mut tracks = Self {
            fps: clip.fps,
            leg,
            lift: KEYFRAMED,
            root: clip.root_position.clone(),
            yaw: Vec::with_capacity(n),
            pitch: Vec::with_capacity(n),
            lean: Vec::with_capacity(n),
            hands: [Vec::new(), Vec::new()],
            shoulders: [Vec::new(), Vec::new()],
            feet: [Vec::new(), Vec::new()],
            head: Vec::new(),
            chest: Vec::new(),
            chest_lean: Vec::new(),
            gaps: BTreeMap::new(),
        };
        let sides = [
            (Role::LeftHand, Role::LeftUpperArm, Role::LeftFoot),
            (Role::RightHand, Role::RightUpperArm, Role::RightFoot),
        ];
        for frame in 0..n {
            clip.write_position(character, &columns, frame, &mut q);
            kinematics.update(character, &q);
            let turn = clip.root_orientation[frame];
            let raw = heading_angle(&turn);
            let last = tracks.yaw.last().copied().unwrap_or(raw);
            tracks.yaw.push(raw + ((last - raw) / std::f64::consts::TAU).round() * std::f64::consts::TAU);
            let level = Quat::from_axis_angle(&Vec3::z_axis(), raw).inverse();
            let root = clip.root_position[frame];
            tracks.pitch.push(down(&(level * turn * Vec3::x())));
            let left = level * turn * Vec3::y();
            tracks.lean.push(down(&left));
            for (side, (hand, shoulder, foot)) in sides.iter().enumerate() {
                if let (Some(hand), Some(shoulder)) = (place(*hand), place(*shoulder)) {
                    tracks.hands[side].push(level * (kinematics.point(hand.body, &hand.point) - root));
                    tracks.shoulders[side].push(level * (kinematics.point(shoulder.body, &shoulder.point) - root));
                }
                if let Some(foot) = place(*foot) {
                    tracks.feet[side].push(kinematics.point(foot.body, &foot.point));
                }
            }
            for touch in touching.iter().flat_map(|_| Touch::ALL) {
                if let Some(gaps) = touching.as_ref().and_then(|touching| touching.gaps(&kinematics, touch)) {
                    tracks.gaps.entry(touch).or_default().push(gaps);
                }
            }
            if let Some(place) = chest {
                let turn = level * kinematics.body_orientation[place.body] * chest_at_rest.inverse();
                tracks.chest.push(down(&(turn * Vec3::x())));
                tracks.chest_lean.push(-down(&(turn * Vec3::y())));
            }
            if let Some(place) = head {
                let ahead = level * kinematics.body_orientation[place.body] * at_rest.inverse() * Vec3::x();
                tracks.head.push([down(&ahead), ahead.y.atan2(ahead.x)]);
            }
        }
        Ok(tracks)
    }

    /// Returns the number of frames.
    pub fn len(&self) -> usize {
        self.root.len()
    }

    /// Returns whether there is no frame.
    pub fn is_empty(&self) -> bool {
        self.root.is_empty()
    }

    /// Returns the frames of a range.
    #[must_use]
    pub fn part(&self, range: std::ops::Range<usize>) -> Self {
        let points = |v: &Vec<Vec3>| if v.is_empty() { vec![] } else { v[range.clone()].to_vec() };
        let numbers = |v: &Vec<f64>| if v.is_empty() { vec![] } else { v[range.clone()].to_vec() };
        Self {
            fps: self.fps,
            leg: self.leg,
            lift: self.lift,
            root: points(&self.root),
            yaw: numbers(&self.yaw),
            pitch: numbers(&self.pitch),
            lean: numbers(&self.lean),
            hands: [points(&self.hands[0]), points(&self.hands[1])],
            shoulders: [points(&self.shoulders[0]), points(&self.shoulders[1])],
            feet: [points(&self.feet[0]), points(&self.feet[1])],
            head: if self.head.is_empty() { vec![] } else { self.head[range.clone()].to_vec() },
            chest: numbers(&self.chest),
            chest_lean: numbers(&self.chest_lean),
            gaps: self.gaps.iter().map(|(touch, gaps)| (*touch, gaps[range.clone()].to_vec())).collect(),
        }
    }

    /// Returns a signal and the frames in which it counts; none where the robot lacks the limb.
    pub fn signal(&self, name: SignalName, side: Option<Side>) -> Option<(Vec<f64>, Vec<bool>)> {
        use SignalName as S;
        let n = self.len();
        let always = vec![true; n];
        match name {
            S::HeadPitch => Some((self.head_at(0)?, always)),
            S::HeadYaw => Some((self.head_at(1)?, always)),
            S::RootDown => Some((self.root.iter().map(|p| -p.z).collect(), always)),
            S::RootYaw => Some((self.yaw.clone(), always)),
            S::RootPitch => Some((self.pitch.clone(), always)),
            S::HandsUneven => {
                let pairs = self.hands[0].iter().zip(&self.hands[1]);
                let apart: Vec<f64> = pairs.map(|(a, b)| (a.z - b.z).abs()).collect();
                let raised = self.raised(0)?.into_iter().zip(self.raised(1)?).map(|(a, b)| a || b).collect();
                Some((apart, raised))
            }
            S::RootLeft => Some((self.aside(), always)),
            S::FootUp | S::FootForward | S::FootBack | S::FootSide => {
                let values = match side {
                    Some(Side::Left) => self.foot(name, 0)?,
                    Some(Side::Right) => self.foot(name, 1)?,
                    _ => self.foot(name, 0)?.iter().zip(self.foot(name, 1)?).map(|(a, b)| 0.5 * (a + b)).collect(),
                };
                Some((values, always))
            }
            S::Steps | S::PairsOfSteps | S::Flights => None,
            S::HandsClose => {
                let raised = self.raised(0)?.into_iter().zip(self.raised(1)?).map(|(a, b)| a && b).collect();
                let near = self.hands[0].iter().zip(&self.hands[1]).map(|(a, b)| -(a - b).norm()).collect();
                Some((near, raised))
            }
            _ => {
                let of = |hand: usize| -> Option<(Vec<f64>, Vec<bool>)> {
                    let path = &self.hands[hand];
                    let outward = if hand == 0 { 1.0 } else { -1.0 };
                    let value = |p: &Vec3| match name {
                        S::HandSide | S::HandSideLow => outward * p.y,
                        S::HandIn => -outward * p.y,
                        S::HandForward => p.x,
                        S::HandBack => -p.x,
                        _ => p.z,
                    };
                    let gate = match name {
                        S::HandUp | S::HandSideLow => vec![true; n],
                        _ => self.raised(hand)?,
                    };
                    (!path.is_empty()).then(|| (path.iter().map(value).collect(), gate))
                };
                match side {
                    Some(Side::Left) => of(0),
                    Some(Side::Right) => of(1),
                    _ => {
                        let ((a, ga), (b, gb)) = (of(0)?, of(1)?);
                        let mean = a.iter().zip(&b).map(|(a, b)| 0.5 * (a + b)).collect();
                        Some((mean, ga.iter().zip(&gb).map(|(a, b)| *a && *b).collect()))
                    }
                }
            }
        }
    }

    /// Returns a foot's way as one of its signals has it, seen from the pelvis.
    fn foot(&self, name: SignalName, foot: usize) -> Option<Vec<f64>> {
        let outward = if foot == 0 { 1.0 } else { -1.0 };
        let seen = |frame: usize, p: &Vec3| {
            let way = p - self.root[frame];
            let (sin, cos) = self.yaw[frame].sin_cos();
            match name {
                SignalName::FootForward => cos * way.x + sin * way.y,
                SignalName::FootBack => -(cos * way.x + sin * way.y),
                SignalName::FootSide => outward * (cos * way.y - sin * way.x),
                _ => p.z,
            }
        };
        let path = &self.feet[foot];
        (!path.is_empty()).then(|| path.iter().enumerate().map(|(frame, p)| seen(frame, p)).collect())
    }

    /// Returns the pelvis' way to the left of where it looked first (m).
    fn aside(&self) -> Vec<f64> {
        let (sin, cos) = self.yaw.first().copied().unwrap_or(0.0).sin_cos();
        self.root.iter().map(|p| cos * p.y - sin * p.x).collect()
    }

    fn head_at(&self, which: usize) -> Option<Vec<f64>> {
        (!self.head.is_empty()).then(|| self.head.iter().map(|h| h[which]).collect())
    }

    /// Returns the frames in which a hand is above the middle of its range.
    fn raised(&self, hand: usize) -> Option<Vec<bool>> {
        let heights: Vec<f64> = self.hands[hand].iter().map(|p| p.z).collect();
        let (low, high) = range(&heights)?;
        Some(heights.iter().map(|z| *z > 0.5 * (low + high)).collect())
    }
}

/// Returns the pitch (rad, down is positive) of a direction.
fn down(v: &Vec3) -> f64 {
    (-v.z).atan2(v.x.hypot(v.y))
}

/// Returns the least and the greatest.
pub(super) fn range(values: &[f64]) -> Option<(f64, f64)> {
    let fold = values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(*v), b.max(*v)));
    (!values.is_empty()).then_some(fold)
}
