//! Ctrl-C: the first one asks to save and stop, the second one stops at once.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use crate::error::CliError;

/// The one flag of this process: a study trains many times.
static FLAG: OnceLock<Arc<AtomicBool>> = OnceLock::new();
/// Held while the handler is installed: two threads may ask at once.
static INSTALLING: Mutex<()> = Mutex::new(());

/// Installs the handler, if it is not there yet, and returns the flag that it sets.
///
/// # Errors
/// When the system has no place for a handler.
pub fn flag() -> Result<Arc<AtomicBool>, CliError> {
    let _installing = INSTALLING.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(flag) = FLAG.get() {
        return Ok(Arc::clone(flag));
    }
    let flag = Arc::new(AtomicBool::new(false));
    let seen = Arc::clone(&flag);
    let handler = move || {
        if seen.swap(true, Ordering::SeqCst) {
            std::process::exit(130);
        }
        eprintln!("\nsaving; press Ctrl-C again to stop at once");
    };
    ctrlc::set_handler(handler).map_err(|e| CliError::Failed(format!("cannot listen for Ctrl-C: {e}")))?;
    Ok(Arc::clone(FLAG.get_or_init(|| flag)))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn whoever_asks_gets_the_same_flag() {
        let (first, second) = (flag().unwrap(), flag().unwrap());
        first.store(true, Ordering::SeqCst);
        assert!(second.load(Ordering::SeqCst));
    }
}
