//! MuJoCo's messages: to standard error, not into a log file in the current folder.

use std::sync::Once;

use mujoco_rs::prelude::{MjLogMessage, MjtLogLevel, set_log_handler};

static INSTALLED: Once = Once::new();

/// Takes over MuJoCo's messages, once per process.
pub(super) fn install() {
    INSTALLED.call_once(|| {
        // SAFETY: this comes before anything else that this crate does with MuJoCo, and other threads that get here
        // wait until it is done.
        unsafe { set_log_handler(handle) };
    });
}

fn handle(message: &MjLogMessage) {
    let subject = message.subject();
    // Divergence is reported per environment (`BatchState::diverged`); information is not of interest.
    let known = subject.starts_with("Nan, Inf or huge value");
    let (warning, error) = (MjtLogLevel::mjLOG_WARNING, MjtLogLevel::mjLOG_ERROR);
    if message.level() == error || (message.level() == warning && !known) {
        eprintln!("MuJoCo: {subject}");
    }
}
