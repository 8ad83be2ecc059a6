//! A coordinate axis with its sign, as `--up` and `--forward` name it.

use std::fmt;
use std::str::FromStr;

use lifelike_character::Vec3;

/// A signed coordinate axis of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Axis {
    /// 0 = x, 1 = y, 2 = z.
    index: usize,
    negative: bool,
}

impl Axis {
    /// Returns the axis nearest to a direction, and the angle between the two (rad).
    pub(crate) fn nearest(direction: &Vec3) -> Option<(Self, f64)> {
        let index = direction.iamax();
        let axis = Self { index, negative: direction[index] < 0.0 };
        let unit = direction.try_normalize(1e-9)?;
        Some((axis, unit.angle(&axis.unit())))
    }

    /// Returns the unit vector.
    pub(crate) fn unit(self) -> Vec3 {
        let mut unit = Vec3::zeros();
        unit[self.index] = if self.negative { -1.0 } else { 1.0 };
        unit
    }

    /// Returns whether two axes lie on one line.
    pub(crate) fn is_parallel(self, other: Self) -> bool {
        self.index == other.index
    }
}

impl fmt::Display for Axis {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let sign = if self.negative { "-" } else { "" };
        write!(f, "{sign}{}", ["x", "y", "z"][self.index])
    }
}

impl FromStr for Axis {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (negative, name) = match text.strip_prefix('-') {
            Some(name) => (true, name),
            None => (false, text.strip_prefix('+').unwrap_or(text)),
        };
        let index = ["x", "y", "z"].iter().position(|axis| name.eq_ignore_ascii_case(axis));
        index
            .map(|index| Self { index, negative })
            .ok_or_else(|| format!("expected x, -x, y, -y, z or -z, got '{text}'"))
    }
}
