//! Ctrl-C: the first one asks to save and stop, the second one stops at once.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::error::CliError;

/// Installs the handler and returns the flag that it sets. Call once per process.
///
/// # Errors
/// When the system has no place for a handler.
pub fn flag() -> Result<Arc<AtomicBool>, CliError> {
    let flag = Arc::new(AtomicBool::new(false));
    let seen = Arc::clone(&flag);
    let handler = move || {
        if seen.swap(true, Ordering::SeqCst) {
            std::process::exit(130);
        }
        eprintln!("\nsaving; press Ctrl-C again to stop at once");
    };
    ctrlc::set_handler(handler).map_err(|e| CliError::Failed(format!("cannot listen for Ctrl-C: {e}")))?;
    Ok(flag)
}
