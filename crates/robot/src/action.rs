//! What a policy's output means: joint targets.

/// How the network's output `y` (one number per joint) becomes a joint target (rad).
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields, tag = "base", rename_all = "snake_case")]
pub enum ActionSpec {
    /// `target = y`, clamped to the joint's limits and a margin: the thesis' form (eq. 4.9's a_t).
    Absolute,
    /// `target = default pose + scale · y`.
    DefaultPose {
        /// rad per unit of output.
        scale: f64,
    },
    /// `target = reference(t+1) + scale · y`: the policy only corrects.
    Reference {
        /// rad per unit of output.
        scale: f64,
    },
}
