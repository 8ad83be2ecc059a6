//! Mistakes, each with its correction.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use lifelike_character::rotation::to_wxyz;
use lifelike_character::{Character, Quat, Vec3};

use super::columns::JointOrder;
use super::{Fit, Flaw};
use crate::clip::MotionClip;

/// Rates below this (frames per second) are frame times.
pub const MIN_FPS: f64 = 1.0;
/// Factors from other units of length to metres.
const UNITS: [(f64, &str); 4] = [(0.01, "centimetres"), (0.001, "millimetres"), (0.0254, "inches"), (0.3048, "feet")];
/// Soles that stay this far from the ground (m) float or sink.
const HEIGHT: f64 = 0.02;
/// Angles within this of a whole turn apart (rad) are one angle.
const NEAR_TURN: f64 = 0.6;

/// Larger angles (rad) are no angles off by whole turns, but degrees.
const MAX_TURNED: f64 = 2.5 * TAU;

/// A mistake of convention.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Mistake {
    /// Root orientations are `xyzw`.
    QuaternionOrder,
    /// Root positions and orientations are y up.
    YUp,
    /// Root positions and orientations are y down, as those of cameras.
    YDown,
    /// Root positions and orientations are z down, as those of aircraft.
    ZDown,
    /// Root positions are not in metres.
    Units {
        /// Metres per unit.
        metres: f64,
    },
    /// Joint angles are in degrees.
    Degrees,
    /// Joint angles have the other sign.
    Negated,
    /// The rate is a frame time.
    FrameTime,
    /// Joint angles differ by whole turns from angles in their range.
    WholeTurns,
    /// Columns carry the names of other joints.
    Columns(JointOrder),
    /// All heights are off by the same.
    Height {
        /// Height that is added (m).
        metres: f64,
    },
    /// Signs of root quaternions flip, which breaks linear interpolation.
    SignFlips,
}

impl Mistake {
    /// Returns what is wrong, in a few words.
    pub fn words(self) -> String {
        match self {
            Self::QuaternionOrder => "root orientations are xyzw, not wxyz".into(),
            Self::YUp => "the root moves with y up, not z up".into(),
            Self::YDown => "the root moves with y down, not z up".into(),
            Self::ZDown => "the root moves with z down, not z up".into(),
            Self::Units { metres } => {
                let unit = UNITS.iter().find(|(factor, _)| *factor == metres).map_or("other units", |(_, unit)| unit);
                format!("root positions are in {unit}, not metres")
            }
            Self::Degrees => "joint angles are in degrees, not radians".into(),
            Self::Negated => "joint angles have the other sign".into(),
            Self::FrameTime => "the rate is a frame time in seconds".into(),
            Self::WholeTurns => "joint angles are off by whole turns".into(),
            Self::Columns(JointOrder::OtherSide) => "left and right joints are exchanged".into(),
            Self::Columns(JointOrder::BreadthFirst) => {
                "joints are in breadth-first order under depth-first names".into()
            }
            Self::Columns(JointOrder::DepthFirst) => "joints are in depth-first order under breadth-first names".into(),
            Self::Columns(JointOrder::Reversed) => "joints are in reversed order".into(),
            Self::Height { metres } if metres < 0.0 => format!("it floats by {:.3} m", -metres),
            Self::Height { metres } => format!("it is sunk by {metres:.3} m"),
            Self::SignFlips => "signs of root quaternions flip".into(),
        }
    }

    /// Returns the corrected clip; none where the mistake is not one of this clip.
    pub(super) fn corrected(self, clip: &MotionClip, character: &Character, columns: &[usize]) -> Option<MotionClip> {
        let mut out = clip.clone();
        match self {
            Self::QuaternionOrder => {
                for turn in &mut out.root_orientation {
                    let [x, y, z, w] = to_wxyz(turn);
                    *turn = Quat::new_normalize(nalgebra::Quaternion::new(w, x, y, z));
                }
            }
            Self::YUp => turn_about_x(&mut out, FRAC_PI_2),
            Self::YDown => turn_about_x(&mut out, -FRAC_PI_2),
            Self::ZDown => turn_about_x(&mut out, PI),
            Self::Negated => out.joints.iter_mut().for_each(|angle| *angle = -*angle),
            Self::Units { metres } => out.root_position.iter_mut().for_each(|place| *place *= metres),
            Self::Degrees => {
                let hinges = character.scalar_joints().zip(columns).filter(|(j, _)| is_hinge(j)).map(|(_, c)| *c);
                let hinges: Vec<usize> = hinges.collect();
                for row in out.joints.chunks_exact_mut(columns.len()) {
                    hinges.iter().for_each(|&column| row[column] = row[column].to_radians());
                }
            }
            Self::Columns(order) => return order.corrected(clip, character, columns),
            Self::Height { metres } => out.root_position.iter_mut().for_each(|place| place.z += metres),
            Self::FrameTime => out.fps = 1.0 / clip.fps,
            Self::WholeTurns => unwrap_turns(&mut out, character, columns),
            Self::SignFlips => {
                let mut before = out.root_orientation.first().copied()?;
                for turn in &mut out.root_orientation {
                    if turn.coords.dot(&before.coords) < 0.0 {
                        *turn = Quat::new_unchecked(-turn.into_inner());
                    }
                    before = *turn;
                }
            }
        }
        Some(out)
    }
}

fn turn_about_x(clip: &mut MotionClip, angle: f64) {
    let upright = Quat::from_axis_angle(&Vec3::x_axis(), angle);
    clip.root_position.iter_mut().for_each(|place| *place = upright * *place);
    clip.root_orientation.iter_mut().for_each(|turn| *turn = upright * *turn);
}

fn is_hinge(joint: &lifelike_character::Joint) -> bool {
    joint.kind == lifelike_character::JointKind::Hinge
}

/// Returns the mistakes that the fit decides about.
pub(super) fn hypotheses(clip: &MotionClip, character: &Character) -> Vec<Mistake> {
    let mut all = vec![
        Mistake::QuaternionOrder,
        Mistake::YUp,
        Mistake::YDown,
        Mistake::ZDown,
        Mistake::Degrees,
        Mistake::Negated,
    ];
    all.extend(UNITS.map(|(metres, _)| Mistake::Units { metres }));
    if clip.joint_names.len() == character.scalar_joints().count() && clip.joint_names.len() > 1 {
        all.extend(JointOrder::ALL.map(Mistake::Columns));
    }
    all
}

/// Returns whether the clip begins with its back to the x axis. Motion that faces x is so when `xyzw` is read as `wxyz`.
pub(super) fn is_turned_away(clip: &MotionClip) -> bool {
    clip.root_orientation.first().is_some_and(|turn| (turn * Vec3::x()).x < -0.9)
}

/// Finds and corrects what the numbers themselves show.
pub(super) fn certain(clip: &mut MotionClip, character: &Character, columns: &[usize]) -> Vec<Flaw> {
    let mut flaws = Vec::new();
    let mut found = |clip: &mut MotionClip, mistake: Mistake, evidence: String| {
        if let Some(corrected) = mistake.corrected(clip, character, columns) {
            *clip = corrected;
            flaws.push(Flaw { mistake, evidence, confidence: 1.0 });
        }
    };
    if clip.fps < MIN_FPS {
        let evidence = format!("{} frames per second; {:.3} if it is a frame time", clip.fps, 1.0 / clip.fps);
        found(clip, Mistake::FrameTime, evidence);
    }
    let flips = clip.root_orientation.windows(2).filter(|pair| pair[0].coords.dot(&pair[1].coords) < 0.0).count();
    if flips > 0 {
        found(clip, Mistake::SignFlips, format!("{flips} flips"));
    }
    let mut turned = clip.clone();
    unwrap_turns(&mut turned, character, columns);
    let changed = turned.joints.iter().zip(&clip.joints).filter(|(a, b)| (*a - *b).abs() > PI).count();
    if changed > 0 {
        found(clip, Mistake::WholeTurns, format!("{changed} of {} angles", clip.joints.len()));
    }
    flaws
}

/// Finds and corrects a height that is off in all frames.
pub(super) fn height(clip: &mut MotionClip, fit: &Fit) -> Option<Flaw> {
    let heights = &fit.heights;
    let at = |share: f64| heights.get((share * heights.len() as f64) as usize).copied();
    // A leap leaves the ground, and returns; a sole that rolls is in the ground for a moment only.
    let (low, middle) = (at(0.05)?, at(0.5)?);
    let off = if low > HEIGHT {
        low
    } else if middle < -HEIGHT {
        middle
    } else {
        return None;
    };
    clip.root_position.iter_mut().for_each(|place| place.z -= off);
    let evidence = format!("lowest point at {low:.3} m (5% of frames are lower), median {middle:.3} m");
    Some(Flaw { mistake: Mistake::Height { metres: -off }, evidence, confidence: 0.9 })
}

/// Removes whole turns: between frames, and of a joint that is out of its range by them.
fn unwrap_turns(clip: &mut MotionClip, character: &Character, columns: &[usize]) {
    if clip.joints.iter().any(|angle| angle.abs() > MAX_TURNED) {
        return;
    }
    let width = columns.len();
    for (joint, &column) in character.scalar_joints().zip(columns) {
        if !is_hinge(joint) {
            continue;
        }
        let Some((low, high)) = joint.range.filter(|(low, high)| high - low < TAU - NEAR_TURN) else { continue };
        for row in clip.joints.chunks_exact_mut(width) {
            let turns = ((row[column] - 0.5 * (low + high)) / TAU).round();
            let back = row[column] - TAU * turns;
            if turns != 0.0 && back > low - 0.1 && back < high + 0.1 {
                row[column] = back;
            }
        }
    }
}
