//! What can go wrong in a simulation.

/// Everything that making or stepping a simulation can fail with.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SimError {
    /// The engine refused the model.
    #[error("{engine} refuses '{character}': {message}")]
    Model {
        /// The engine.
        engine: &'static str,
        /// The character.
        character: String,
        /// What it said.
        message: String,
    },
    /// An array has the wrong length.
    #[error("{what}: expected {expected} numbers, got {got}")]
    Length {
        /// Which array.
        what: &'static str,
        /// The right length.
        expected: usize,
        /// The length it has.
        got: usize,
    },
    /// A saved state does not belong to this simulation.
    #[error("saved state: expected {expected}, got {got}")]
    State {
        /// What should be there.
        expected: String,
        /// What is there.
        got: String,
    },
    /// Ground that cannot be.
    #[error("terrain: expected {expected}, got {got}")]
    Terrain {
        /// What should be there.
        expected: String,
        /// What is there.
        got: String,
    },
    /// No engine of this name in this build.
    #[error("no engine '{name}' in this build: {hint}")]
    Engine {
        /// The name.
        name: String,
        /// What to do.
        hint: &'static str,
    },
}
