//! The left-right symmetry of a character: derived from names and geometry, then checked.

/// Which joint mirrors which, and with which sign.
#[derive(Debug, Clone, PartialEq)]
pub struct Symmetry {
    /// For each scalar joint (in the order of `Character::scalar_joints`), the index of its mirror image.
    pub joint: Vec<usize>,
    /// For each scalar joint, the sign that its mirror image's angle takes.
    pub sign: Vec<f64>,
    /// For each body, the index of its mirror image.
    pub body: Vec<usize>,
}
