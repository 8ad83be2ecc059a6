//! Errors of checkpoints.

use std::path::PathBuf;

/// Why a checkpoint could not be written, read or applied.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CheckpointError {
    /// The file cannot be read or written.
    #[error(transparent)]
    Input(#[from] crate::InputError),
    /// The file ends before, or goes on after, what its header announces.
    #[error("{path}: expected {expected} bytes, got {got} (the file is damaged or was cut off)")]
    Length {
        /// The file.
        path: PathBuf,
        /// Bytes that the header announces.
        expected: u64,
        /// Bytes that are there.
        got: u64,
    },
    /// The file is not a safetensors file of ours.
    #[error("{path}: not a checkpoint: {why}")]
    Format {
        /// The file.
        path: PathBuf,
        /// The reason.
        why: String,
    },
    /// The contents are not what was written.
    #[error("{path}: digest mismatch: the file says {expected}, its contents give {got}")]
    Digest {
        /// The file.
        path: PathBuf,
        /// Digest in the file.
        expected: String,
        /// Digest of the contents.
        got: String,
    },
    /// Entries that should be there are not.
    #[error("{path}: missing {names:?}")]
    Missing {
        /// The checkpoint it was looked for in.
        path: String,
        /// The names.
        names: Vec<String>,
    },
    /// Entries that nobody asked for.
    #[error("{path}: unexpected {names:?}")]
    Unexpected {
        /// The checkpoint they are in.
        path: String,
        /// The names.
        names: Vec<String>,
    },
    /// Two entries of one name.
    #[error("two entries are named {name:?}")]
    Duplicate {
        /// The name.
        name: String,
    },
    /// An entry has another shape or type than asked for.
    #[error("{path}: {name}: expected {expected}, got {got}")]
    Mismatch {
        /// The checkpoint.
        path: String,
        /// The entry.
        name: String,
        /// The expected shape or type.
        expected: String,
        /// The shape or type found.
        got: String,
    },
    /// A metadata value is missing or has another form.
    #[error("{path}: metadata {key:?}: {why}")]
    Metadata {
        /// The checkpoint.
        path: String,
        /// The key.
        key: String,
        /// The reason.
        why: String,
    },
}
