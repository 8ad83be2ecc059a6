//! Extent of an evaluation.

/// Extent of an evaluation.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct EvaluationOptions {
    /// Longest episode (s). Cyclic clips are repeated to last that long; episodes of others end with their clip.
    pub seconds: f64,
    /// Episodes per clip, from start frames spread evenly.
    pub starts: usize,
    /// Rollouts of each clip that are kept to be looked at; the first that fell is always kept.
    pub keep: usize,
    /// Time for which a fall is recorded (s).
    pub after_fall: f64,
    /// Seed by which the motion prior's codes are given to other frames: a policy that does as well with them does not use them.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub permute_codes: Option<u64>,
}

impl Default for EvaluationOptions {
    fn default() -> Self {
        Self { seconds: 10.0, starts: 5, keep: 1, after_fall: 1.0, permute_codes: None }
    }
}
