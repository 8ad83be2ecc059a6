//! Bounds on the values of a plan.

/// A plan asks for something impossible.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("plan: {key}: expected {expected}, got {got}")]
pub struct PlanError {
    /// The key.
    pub key: String,
    /// The range or the choices.
    pub expected: String,
    /// The value in the plan.
    pub got: String,
}

/// Returns the error of a value that is not what it should be.
pub fn wrong(key: &str, expected: &str, got: impl std::fmt::Display) -> PlanError {
    PlanError { key: key.into(), expected: expected.into(), got: got.to_string() }
}

/// Checks a number against bounds, both included.
///
/// # Errors
/// The number is outside of them, or not finite.
pub fn range(key: &str, value: f64, low: f64, high: f64) -> Result<(), PlanError> {
    if value.is_finite() && (low..=high).contains(&value) {
        return Ok(());
    }
    Err(wrong(key, &format!("a number from {low} to {high}"), value))
}

/// Checks a whole number against bounds, both included.
///
/// # Errors
/// The number is outside of them.
pub fn whole(key: &str, value: u64, low: u64, high: u64) -> Result<(), PlanError> {
    if (low..=high).contains(&value) {
        return Ok(());
    }
    let expected = if high == u64::MAX { format!("{low} or more") } else { format!("{low} to {high}") };
    Err(wrong(key, &expected, value))
}
