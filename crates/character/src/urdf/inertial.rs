//! `<inertial>`: mass and moments of a link, and what stands in for moments that no body can have.
//!
//! Files that CAD programs and people write have such moments for covers, cameras and virtual links, and programs that only
//! do kinematics never look. A simulation cannot go on with them.

use super::{child, element, pose};
use crate::error::CharacterError;
use crate::inertia;
use crate::mjcf::attributes::Attributes;
use crate::mjcf::document::{Element, numbers};
use crate::rotation::{Mat3, Quat, Vec3, to_wxyz};

/// Mass (kg) and moments (kg m²) of a link that moves, weighs nothing and carries others. Small beside any robot's, and
/// not so small that numbers suffer.
const NOTHING: (f64, f64) = (1e-5, 1e-8);
/// Moments below this are zeros that were computed (kg m²).
const ROUNDING: f64 = 1e-15;
/// Radius (m) of the ball that a mass without moments is taken for.
const POINT: f64 = 0.01;

/// Returns the mass (kg) that a link says; 0 where it says none.
pub(super) fn mass(link: &Element) -> f64 {
    let value = child(link, "inertial").and_then(|inertial| child(inertial, "mass")?.attribute("value"));
    value.and_then(|value| value.trim().parse::<f64>().ok()).filter(|mass| mass.is_finite()).unwrap_or(0.0)
}

/// Returns the `<inertial>` of a link that weighs next to nothing.
pub(super) fn nothing(link: &Element) -> Element {
    let (mass, moment) = NOTHING;
    mjcf(link, Vec3::zeros(), Quat::identity(), mass, Vec3::repeat(moment))
}

/// Translates an `<inertial>`; `true` where its moments were impossible and others stand there now: their mean in all directions,
/// as MuJoCo's `balanceinertia` has it, or those of a ball of [`POINT`] where a mass has none.
pub(super) fn translate(inertial: &Element) -> Result<(Element, bool), CharacterError> {
    let mass = child(inertial, "mass").ok_or_else(|| inertial.invalid("<mass>", "none"))?;
    let b = Attributes::own(mass);
    let mass = b.number("value")?.ok_or_else(|| b.invalid("attribute 'value'", "none"))?;
    let moments = child(inertial, "inertia").ok_or_else(|| inertial.invalid("<inertia>", "none"))?;
    let a = Attributes::own(moments);
    let get = |name: &str| a.number(name)?.ok_or_else(|| a.invalid(format!("attribute '{name}'"), "none"));
    let (xx, yy, zz) = (get("ixx")?, get("iyy")?, get("izz")?);
    let cross = |name: &str| Ok::<f64, CharacterError>(a.number(name)?.unwrap_or(0.0));
    let (xy, xz, yz) = (cross("ixy")?, cross("ixz")?, cross("iyz")?);
    let local = Mat3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
    let (position, rpy) = pose(inertial)?;
    let turn = Quat::from_euler_angles(rpy.x, rpy.y, rpy.z).to_rotation_matrix().into_inner();
    let (orientation, diagonal) = inertia::principal(&(turn * local * turn.transpose()));
    let diagonal = diagonal.map(|x| if x.abs() <= ROUNDING { 0.0 } else { x });
    if diagonal == Vec3::zeros() {
        let ball = Vec3::repeat(0.4 * mass.max(0.0) * POINT * POINT);
        return Ok((mjcf(inertial, position, orientation, mass, ball), mass > 0.0));
    }
    let possible = diagonal.min() >= -1e-12 * diagonal.max() && inertia::balanced(&diagonal);
    if !possible && diagonal.sum() <= 0.0 {
        return Err(
            a.invalid("a positive definite inertia", format!("moments {} {} {}", diagonal.x, diagonal.y, diagonal.z))
        );
    }
    let diagonal = if possible { diagonal.map(|x| x.max(0.0)) } else { Vec3::repeat(diagonal.sum() / 3.0) };
    Ok((mjcf(inertial, position, orientation, mass, diagonal), !possible))
}

fn mjcf(source: &Element, position: Vec3, orientation: Quat, mass: f64, diagonal: Vec3) -> Element {
    element(
        source,
        "inertial",
        &[
            ("pos", numbers(position.as_slice())),
            ("quat", numbers(&to_wxyz(&orientation))),
            ("mass", numbers(&[mass])),
            ("diaginertia", numbers(diagonal.as_slice())),
        ],
    )
}
