//! The order of a quaternion's numbers, found from the motion.

use std::path::Path;

use lifelike_character::anatomy::Overrides;
use lifelike_character::rotation::{from_wxyz, to_wxyz};
use lifelike_character::{Anatomy, Quat, Vec3};

use super::{Context, RobotMotion};
use crate::lint::Fit;
use crate::{FromInput, MotionError};

/// Norm from which a quaternion is none: files have six decimals, or 32-bit numbers.
pub(super) const NOT_UNIT: f64 = 1e-2;
/// Mean tilt below which a robot is upright (rad), and above which it certainly is not.
const UPRIGHT: f64 = 0.6;
const TILTED: f64 = 1.2;
/// Deviation of half an angle that only a turning robot has: no pelvis rolls by 17 degrees while it stays upright.
const TURNS: f64 = 0.15;
/// Least ratio of the turning's deviation to the rolling's.
const MORE: f64 = 3.0;
/// Share of the misfit that the better reading has at most.
const CLEARLY: f64 = 0.6;
/// Least difference of the misfits.
const LEAST_GAIN: f64 = 0.02;

/// The order of a quaternion's numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Order {
    Xyzw,
    Wxyz,
}

impl Order {
    pub(super) fn words(self) -> &'static str {
        match self {
            Self::Xyzw => "x y z w",
            Self::Wxyz => "w x y z",
        }
    }

    /// Returns the numbers of a rotation.
    pub(super) fn numbers(self, rotation: &Quat) -> [f64; 4] {
        let [w, x, y, z] = to_wxyz(rotation);
        match self {
            Self::Xyzw => [x, y, z, w],
            Self::Wxyz => [w, x, y, z],
        }
    }

    /// Returns rotations without sign flips between neighbours.
    ///
    /// # Errors
    /// [`MotionError::Input`] with the first frame whose numbers are no unit quaternion.
    pub(super) fn rotations(self, numbers: &[f64], file: &Path) -> Result<Vec<Quat>, MotionError> {
        let mut rotations = Vec::with_capacity(numbers.len() / 4);
        for (frame, &[a, b, c, d]) in numbers.as_chunks::<4>().0.iter().enumerate() {
            let wxyz = if self == Self::Wxyz { [a, b, c, d] } else { [d, a, b, c] };
            let norm = wxyz.iter().map(|c| c * c).sum::<f64>().sqrt();
            let rotation = from_wxyz(wxyz).filter(|_| (norm - 1.0).abs() < NOT_UNIT);
            let rotation = rotation.ok_or_else(|| {
                MotionError::format(
                    file.display(),
                    "unit quaternions of the root",
                    format!("norm {norm:.3} in frame {frame}"),
                )
            })?;
            rotations.push(rotation);
        }
        without_flips(&mut rotations);
        Ok(rotations)
    }
}

/// Of the two quaternions of each rotation, takes the one next to the frame before.
pub(super) fn without_flips(rotations: &mut [Quat]) {
    for at in 1..rotations.len() {
        if rotations[at - 1].coords.dot(&rotations[at].coords) < 0.0 {
            rotations[at] = Quat::new_unchecked(-rotations[at].into_inner());
        }
    }
}

/// Finds which of two readings of the same numbers is right: none where both are possible.
///
/// A robot is upright. A quaternion of a robot that faces along x is upright in the other order as well. It then faces
/// backward and has roll and turn exchanged. There a large turn decides, else the soles: they slip in the wrong
/// reading.
pub(super) fn find_order(xyzw: &RobotMotion, wxyz: &RobotMotion, context: &Context<'_>) -> Option<Order> {
    let tilts = [xyzw, wxyz].map(|motion| tilt(&motion.root_orientation));
    let by_tilt = match tilts {
        [xyzw, wxyz] if xyzw < UPRIGHT && wxyz > TILTED => Some(Order::Xyzw),
        [xyzw, wxyz] if wxyz < UPRIGHT && xyzw > TILTED => Some(Order::Wxyz),
        _ => None,
    };
    let by_soles = by_soles(xyzw, wxyz, context);
    match (by_tilt, by_soles) {
        // A robot that lies on its side is upright in the wrong order.
        (Some(tilt), Some(soles)) => (tilt == soles).then_some(tilt),
        (Some(order), None) | (None, Some(order)) => Some(order),
        (None, None) if tilts.iter().all(|tilt| *tilt < UPRIGHT) => by_turn(xyzw),
        (None, None) => None,
    }
}

/// Returns the mean angle from upright (rad).
fn tilt(rotations: &[Quat]) -> f64 {
    let angles = rotations.iter().map(|rotation| (rotation * Vec3::z()).angle(&Vec3::z()));
    angles.sum::<f64>() / rotations.len().max(1) as f64
}

/// Decides by the deviation of the first number against that of the third: the one is the turn where the other is the
/// roll.
fn by_turn(xyzw: &RobotMotion) -> Option<Order> {
    let numbers: Vec<[f64; 4]> = xyzw.root_orientation.iter().map(|q| Order::Xyzw.numbers(q)).collect();
    let deviation = |at: usize| {
        let mean = numbers.iter().map(|n| n[at]).sum::<f64>() / numbers.len().max(1) as f64;
        (numbers.iter().map(|n| (n[at] - mean).powi(2)).sum::<f64>() / numbers.len().max(1) as f64).sqrt()
    };
    let (first, third) = (deviation(0), deviation(2));
    if third > TURNS && third > MORE * first {
        return Some(Order::Xyzw);
    }
    (first > TURNS && first > MORE * third).then_some(Order::Wxyz)
}

/// Decides by the robot's misfit: height, slip, tilt.
fn by_soles(xyzw: &RobotMotion, wxyz: &RobotMotion, context: &Context<'_>) -> Option<Order> {
    let character = context.robot?;
    let anatomy = Anatomy::guess(character, &Overrides::default()).ok()?;
    let cost = |motion: &RobotMotion| {
        let clip = motion.clone().into_clip(context, 30.0);
        let columns = clip.columns_for(character).ok()?;
        Some(Fit::of(&clip, character, &anatomy, &columns).cost())
    };
    let (first, second) = (cost(xyzw)?, cost(wxyz)?);
    if (first - second).abs() < LEAST_GAIN {
        return None;
    }
    if first < CLEARLY * second {
        return Some(Order::Xyzw);
    }
    (second < CLEARLY * first).then_some(Order::Wxyz)
}
