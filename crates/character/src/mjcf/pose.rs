//! Poses: position and the five ways to write an orientation.

use crate::error::CharacterError;
use crate::mjcf::attributes::{Attributes, ORIENTATIONS};
use crate::mjcf::compiler::Compiler;
use crate::rotation::{Mat3, Quat, Vec3, from_wxyz};

/// A position and an orientation in a parent frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Pose {
    pub position: Vec3,
    pub orientation: Quat,
}

impl Pose {
    /// Returns no displacement.
    pub fn identity() -> Self {
        Self { position: Vec3::zeros(), orientation: Quat::identity() }
    }

    /// Returns `self`, then `inner` inside it.
    pub fn then(&self, inner: &Self) -> Self {
        Self {
            position: self.position + self.orientation * inner.position,
            orientation: self.orientation * inner.orientation,
        }
    }

    /// Reads `pos` and the orientation.
    pub fn read(a: &Attributes, compiler: &Compiler) -> Result<Self, CharacterError> {
        Ok(Self {
            position: a.numbers::<3>("pos")?.map_or_else(Vec3::zeros, Vec3::from),
            orientation: orientation(a, compiler)?,
        })
    }
}

/// Attribute names that [`Pose::read`] reads.
pub(crate) const POSE: [&str; 6] = ["pos", "quat", "axisangle", "xyaxes", "zaxis", "euler"];

fn orientation(a: &Attributes, compiler: &Compiler) -> Result<Quat, CharacterError> {
    let degenerate =
        |name: &str| a.invalid(format!("'{name}' that gives a direction"), format!("'{}'", a.text(name).unwrap_or("")));
    if ORIENTATIONS.iter().filter(|name| a.text(name).is_some()).count() > 1 {
        return Err(a.invalid("one way to write the orientation", "several"));
    }
    if let Some([x, y, z, angle]) = a.numbers::<4>("axisangle")? {
        let axis = unit(Vec3::new(x, y, z)).ok_or_else(|| degenerate("axisangle"))?;
        return Ok(Quat::from_scaled_axis(axis * (angle * compiler.angle)));
    }
    if let Some([x0, x1, x2, y0, y1, y2]) = a.numbers::<6>("xyaxes")? {
        let x = unit(Vec3::new(x0, x1, x2)).ok_or_else(|| degenerate("xyaxes"))?;
        let y = Vec3::new(y0, y1, y2);
        let y = unit(y - x * x.dot(&y)).ok_or_else(|| degenerate("xyaxes"))?;
        return Ok(from_axes(&x, &y));
    }
    if let Some(z) = a.numbers::<3>("zaxis")? {
        let z = unit(Vec3::from(z)).ok_or_else(|| degenerate("zaxis"))?;
        return Ok(turn_z_to(&z));
    }
    if let Some(angles) = a.numbers::<3>("euler")? {
        let mut q = Quat::identity();
        for (letter, angle) in compiler.eulerseq.into_iter().zip(angles) {
            let axis = match letter.to_ascii_lowercase() {
                'x' => Vec3::x(),
                'y' => Vec3::y(),
                _ => Vec3::z(),
            };
            let turn = Quat::from_scaled_axis(axis * (angle * compiler.angle));
            // Small letters turn with the frame, capitals about the fixed axes.
            q = if letter.is_ascii_lowercase() { q * turn } else { turn * q };
        }
        return Ok(q);
    }
    match a.numbers::<4>("quat")? {
        None => Ok(Quat::identity()),
        Some(wxyz) => from_wxyz(wxyz).ok_or_else(|| degenerate("quat")),
    }
}

fn unit(v: Vec3) -> Option<Vec3> {
    v.try_normalize(1e-14).filter(|u| u.iter().all(|c| c.is_finite()))
}

/// Returns the rotation whose first two columns are these orthonormal axes.
fn from_axes(x: &Vec3, y: &Vec3) -> Quat {
    let m = Mat3::from_columns(&[*x, *y, x.cross(y)]);
    Quat::from_rotation_matrix(&nalgebra::Rotation3::from_matrix_unchecked(m))
}

/// Returns the smallest rotation that brings the z axis to this unit vector; half a turn about x where it points down.
pub(crate) fn turn_z_to(direction: &Vec3) -> Quat {
    let axis = Vec3::z().cross(direction);
    let sine = axis.norm();
    let axis = if sine < 1e-10 { Vec3::x() } else { axis / sine };
    Quat::from_scaled_axis(axis * sine.atan2(direction.z))
}

/// Reads `fromto`: the middle, the frame whose z axis runs along it, and half the length.
pub(crate) fn from_to(a: &Attributes) -> Result<Option<(Pose, f64)>, CharacterError> {
    let Some([ax, ay, az, bx, by, bz]) = a.numbers::<6>("fromto")? else { return Ok(None) };
    let (from, to) = (Vec3::new(ax, ay, az), Vec3::new(bx, by, bz));
    let along = from - to;
    let length = along.norm();
    // Shorter than this MuJoCo, too, calls it a point.
    let direction = unit(along).filter(|_| length > 1e-14);
    let direction = direction.ok_or_else(|| a.invalid("two different points for 'fromto'", "one point twice"))?;
    Ok(Some((Pose { position: (from + to) * 0.5, orientation: turn_z_to(&direction) }, length * 0.5)))
}
