//! Bounds on the values of a plan.

use crate::error::LearnError;

/// A value that is not what it should be.
pub(crate) fn wrong(key: &str, expected: &str, got: impl std::fmt::Display) -> LearnError {
    LearnError::Plan { key: key.into(), expected: expected.into(), got: got.to_string() }
}

/// A number within bounds, both included.
pub(crate) fn range(key: &str, value: f64, low: f64, high: f64) -> Result<(), LearnError> {
    if value.is_finite() && (low..=high).contains(&value) {
        return Ok(());
    }
    Err(wrong(key, &format!("a number from {low} to {high}"), value))
}

/// A whole number within bounds, both included.
pub(crate) fn whole(key: &str, value: u64, low: u64, high: u64) -> Result<(), LearnError> {
    if (low..=high).contains(&value) {
        return Ok(());
    }
    let expected = if high == u64::MAX { format!("{low} or more") } else { format!("{low} to {high}") };
    Err(wrong(key, &expected, value))
}
