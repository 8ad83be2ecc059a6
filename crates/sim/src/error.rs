//! Errors of simulations.

/// An error of making or stepping a simulation.
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
        /// Its reason.
        message: String,
    },
    /// An array has the wrong length.
    #[error("{what}: expected {expected} numbers, got {got}")]
    Length {
        /// The array.
        what: &'static str,
        /// The right length.
        expected: usize,
        /// The length it has.
        got: usize,
    },
    /// A value that a simulation does not take: a saved state of another one, a body that does not exist.
    #[error("expected {expected}, got {got}")]
    State {
        /// The expected value or property.
        expected: String,
        /// The value found.
        got: String,
    },
    /// A file of ours that cannot be read or written.
    #[error(transparent)]
    Checkpoint(#[from] lifelike_checkpoint::CheckpointError),
    /// Terrain that cannot be made.
    #[error("terrain: expected {expected}, got {got}")]
    Terrain {
        /// The expected value or property.
        expected: String,
        /// The value found.
        got: String,
    },
    /// No engine of this name.
    #[error("no engine '{name}'; there are: {known}")]
    UnknownEngine {
        /// The name.
        name: String,
        /// Names of all engines.
        known: String,
    },
    /// An engine whose library is missing.
    #[error("engine '{name}' is not available: {hint}")]
    EngineUnavailable {
        /// The name.
        name: &'static str,
        /// The missing file, and the way to get it.
        hint: String,
    },
}
