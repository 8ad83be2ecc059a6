//! Attribute values: what an element says, over what its default class says.

use crate::error::{CharacterError, Location};
use crate::mjcf::document::Element;

/// The attributes in force for one element.
#[derive(Debug, Clone)]
pub(crate) struct Attributes {
    pub at: Location,
    values: Vec<(String, String)>,
}

/// `true`, `false` or `auto`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Tristate {
    True,
    False,
    Auto,
}

/// Different ways to say one orientation: one of them displaces an inherited other.
pub(crate) const ORIENTATIONS: [&str; 5] = ["quat", "axisangle", "xyaxes", "zaxis", "euler"];
/// Vectors of which a model may give only the first numbers; the rest stays as inherited.
const PARTIAL: [&str; 6] = ["friction", "solref", "solimp", "size", "gear", "solreffriction"];

impl Attributes {
    /// Returns the element's own attributes, nothing inherited.
    pub fn own(element: &Element) -> Self {
        Self { at: element.at.clone(), values: element.attributes.clone() }
    }

    /// Returns the element's own attributes over inherited ones.
    pub fn over(inherited: &[(String, String)], element: &Element) -> Self {
        Self { at: element.at.clone(), values: overlay(inherited, &element.attributes) }
    }

    /// Refuses attributes that are not in the list.
    pub fn only(&self, known: &[&str]) -> Result<(), CharacterError> {
        match self.values.iter().find(|(name, _)| !known.contains(&name.as_str())) {
            None => Ok(()),
            Some((name, _)) => {
                Err(CharacterError::Unsupported { at: self.at.clone(), what: format!("attribute '{name}'") })
            }
        }
    }

    /// Returns the error "expected this, got that" at this element.
    pub fn invalid(&self, expected: impl Into<String>, got: impl Into<String>) -> CharacterError {
        CharacterError::Invalid { at: self.at.clone(), expected: expected.into(), got: got.into() }
    }

    /// Returns the error "unsupported" at this element.
    pub fn unsupported(&self, what: impl Into<String>) -> CharacterError {
        CharacterError::Unsupported { at: self.at.clone(), what: what.into() }
    }

    /// Returns the value as written.
    pub fn text(&self, name: &str) -> Option<&str> {
        self.values.iter().find(|(n, _)| n == name).map(|(_, v)| v.as_str())
    }

    /// Returns the value, or an error that asks for it.
    pub fn required(&self, name: &str) -> Result<&str, CharacterError> {
        self.text(name).ok_or_else(|| self.invalid(format!("attribute '{name}'"), "none"))
    }

    /// Reads all numbers of a value, between `least` and `most` of them, every one finite.
    fn list(&self, name: &str, least: usize, most: usize) -> Result<Option<Vec<f64>>, CharacterError> {
        let Some(text) = self.text(name) else { return Ok(None) };
        let wanted = || {
            let count = if least == most { least.to_string() } else { format!("{least} to {most}") };
            format!("{count} number{} for '{name}'", if most == 1 { "" } else { "s" })
        };
        let mut numbers = Vec::with_capacity(most);
        for word in text.split_whitespace() {
            match word.parse::<f64>() {
                Ok(number) if number.is_finite() && numbers.len() < most => numbers.push(number),
                _ => return Err(self.invalid(wanted(), format!("'{text}'"))),
            }
        }
        if numbers.len() < least {
            return Err(self.invalid(wanted(), format!("'{text}'")));
        }
        Ok(Some(numbers))
    }

    /// Reads exactly `N` numbers.
    pub fn numbers<const N: usize>(&self, name: &str) -> Result<Option<[f64; N]>, CharacterError> {
        Ok(self.list(name, N, N)?.and_then(|list| list.try_into().ok()))
    }

    /// Reads up to `N` numbers over the given ones.
    pub fn prefix<const N: usize>(&self, name: &str, mut otherwise: [f64; N]) -> Result<[f64; N], CharacterError> {
        if let Some(list) = self.list(name, 1, N)? {
            otherwise[..list.len()].copy_from_slice(&list);
        }
        Ok(otherwise)
    }

    /// Reads one number.
    pub fn number(&self, name: &str) -> Result<Option<f64>, CharacterError> {
        Ok(self.numbers::<1>(name)?.map(|[x]| x))
    }

    /// Returns a whole number in a range.
    pub fn integer(&self, name: &str, otherwise: i64, range: std::ops::Range<i64>) -> Result<i64, CharacterError> {
        let Some(text) = self.text(name) else { return Ok(otherwise) };
        match text.trim().parse::<i64>() {
            Ok(value) if range.contains(&value) => Ok(value),
            _ => Err(self.invalid(
                format!("a whole number from {} to {} for '{name}'", range.start, range.end - 1),
                format!("'{text}'"),
            )),
        }
    }

    /// Reads `true` or `false`.
    pub fn boolean(&self, name: &str, otherwise: bool) -> Result<bool, CharacterError> {
        match self.text(name) {
            None => Ok(otherwise),
            Some("true") => Ok(true),
            Some("false") => Ok(false),
            Some(other) => Err(self.invalid(format!("'true' or 'false' for '{name}'"), format!("'{other}'"))),
        }
    }

    /// Reads `true`, `false` or `auto`.
    pub fn tristate(&self, name: &str) -> Result<Tristate, CharacterError> {
        match self.text(name) {
            None | Some("auto") => Ok(Tristate::Auto),
            Some("true") => Ok(Tristate::True),
            Some("false") => Ok(Tristate::False),
            Some(other) => Err(self.invalid(format!("'true', 'false' or 'auto' for '{name}'"), format!("'{other}'"))),
        }
    }

    /// Returns a range and whether it is in force, by MuJoCo's `autolimits` rule. One from `-inf` to `inf` limits nothing.
    pub fn limits(&self, range: &str, limited: &str, autolimits: bool) -> Result<Option<(f64, f64)>, CharacterError> {
        if self.text(range).is_some_and(|text| text.to_ascii_lowercase().split_whitespace().eq(["-inf", "inf"])) {
            return Ok(None);
        }
        let given = self.numbers::<2>(range)?;
        let [low, high] = given.unwrap_or([0.0, 0.0]);
        match self.tristate(limited)? {
            Tristate::False => Ok(None),
            Tristate::True if low < high => Ok(Some((low, high))),
            Tristate::True => {
                Err(self.invalid(format!("'{range}' that grows, as '{limited}' is true"), format!("{low} {high}")))
            }
            Tristate::Auto if given.is_none() || (low == 0.0 && high == 0.0) => Ok(None),
            Tristate::Auto if !autolimits => {
                Err(self.invalid(format!("attribute '{limited}' beside '{range}', as 'autolimits' is false"), "none"))
            }
            Tristate::Auto if low < high => Ok(Some((low, high))),
            Tristate::Auto => Err(self.invalid(format!("a range for '{range}' that grows"), format!("{low} {high}"))),
        }
    }
}

/// Puts `own` over `inherited`, attribute by attribute.
pub(crate) fn overlay(inherited: &[(String, String)], own: &[(String, String)]) -> Vec<(String, String)> {
    let mut values = inherited.to_vec();
    if own.iter().any(|(name, _)| ORIENTATIONS.contains(&name.as_str())) {
        values.retain(|(name, _)| !ORIENTATIONS.contains(&name.as_str()));
    }
    for (name, value) in own {
        match values.iter_mut().find(|(n, _)| n == name) {
            None => values.push((name.clone(), value.clone())),
            Some((_, old)) if PARTIAL.contains(&name.as_str()) => {
                let given = value.split_whitespace().count();
                let rest = old.split_whitespace().skip(given);
                *old = value.split_whitespace().chain(rest).collect::<Vec<_>>().join(" ");
            }
            Some((_, old)) => *old = value.clone(),
        }
    }
    values
}
