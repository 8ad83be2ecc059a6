//! `<limit>`: range, effort and velocity of a joint, and the joints that have none.

use std::collections::BTreeMap;

use super::child;
use crate::error::CharacterError;
use crate::mjcf::attributes::Attributes;
use crate::mjcf::document::{Element, numbers};

/// Limits that MJCF has no attribute for, and joints whose limits say nothing.
#[derive(Debug, Default)]
pub(super) struct Limits {
    velocities: BTreeMap<String, f64>,
    /// Joints that must have a range and have none.
    unlimited: Vec<String>,
    /// Efforts and velocities of zero or less, and their joints.
    idle: Vec<String>,
}

impl Limits {
    /// Returns the limits of a joint as attributes of MJCF.
    pub fn read(&mut self, joint: &Element) -> Result<Vec<(String, String)>, CharacterError> {
        let name = joint.attribute("name").unwrap_or_default();
        let endless = joint.attribute("type") == Some("continuous");
        let mut attributes = Vec::new();
        let Some(limit) = child(joint, "limit") else {
            if !endless {
                self.unlimited.push(name.to_string());
            }
            return Ok(attributes);
        };
        let a = Attributes::own(limit);
        let (low, high) = (a.number("lower")?.unwrap_or(0.0), a.number("upper")?.unwrap_or(0.0));
        if !endless && low > high {
            return Err(a.invalid(format!("'lower' below 'upper' for joint '{name}'"), format!("{low} and {high}")));
        }
        if !endless && low == high {
            self.unlimited.push(name.to_string());
        } else if !endless {
            attributes.push(("range".into(), numbers(&[low, high])));
        }
        let mut positive = |attribute: &str| {
            let value = a.number(attribute)?;
            if let Some(value) = value.filter(|value| *value <= 0.0) {
                self.idle.push(format!("{attribute} of {name} ({value})"));
            }
            Ok::<_, CharacterError>(value.filter(|value| *value > 0.0))
        };
        if let Some(effort) = positive("effort")? {
            attributes.push(("actuatorfrcrange".into(), numbers(&[-effort, effort])));
        }
        if let Some(velocity) = positive("velocity")? {
            self.velocities.insert(name.to_string(), velocity);
        }
        Ok(attributes)
    }

    /// Returns the largest speed of a joint (rad/s or m/s).
    pub fn velocity(&self, joint: &str) -> Option<f64> {
        self.velocities.get(joint).copied()
    }

    /// Returns a line on each kind of limit that says nothing.
    pub fn warnings(&self) -> Vec<String> {
        let line = |text: &str, names: &[String]| (!names.is_empty()).then(|| format!("{text}: {}", names.join(", ")));
        [
            line(
                "joints without a range (no <limit>, or lower = upper), which turn without end; give them lower and upper (rad)",
                &self.unlimited,
            ),
            line("limits that are not above zero, which are ignored", &self.idle),
        ]
        .into_iter()
        .flatten()
        .collect()
    }
}
