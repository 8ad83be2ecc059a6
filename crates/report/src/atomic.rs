//! Files that are there whole or not at all, with the errors of this crate.

use std::path::Path;

pub(crate) use lifelike_checkpoint::PARTIAL;

use crate::{FromInput, ReportError};

/// Writes a file as [`lifelike_checkpoint::write_file`] does: whole or not at all.
///
/// # Errors
/// [`ReportError::Input`] with the file that failed.
pub fn write_atomically(path: &Path, bytes: &[u8]) -> Result<(), ReportError> {
    lifelike_checkpoint::write_file(path, bytes).map_err(ReportError::io(path))
}
