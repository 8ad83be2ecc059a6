//! How far long work is, and when it will be done.

use std::time::Duration;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use crate::output::Output;

/// A bar on standard error: `what`, done of `total`, rate, time left, and a message. Draws nothing where nobody looks.
pub fn bar(output: &Output, what: &'static str, total: u64) -> ProgressBar {
    if !output.shows_progress() {
        return ProgressBar::with_draw_target(Some(total), ProgressDrawTarget::hidden());
    }
    let bar = ProgressBar::new(total);
    let template = "{prefix} {wide_bar} {pos}/{len}  {per_sec}  {elapsed} gone, {eta} left  {msg}";
    // The template is constant; should it ever be wrong, the default bar is as good.
    if let Ok(style) = ProgressStyle::with_template(template) {
        bar.set_style(style);
    }
    bar.set_prefix(what);
    bar.enable_steady_tick(Duration::from_millis(500));
    bar
}
