//! Progress of long work with its remaining time: a bar for people at a terminal, a line now and then for log files.

use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use crate::output::Output;

/// Time between two lines where there is no terminal.
const LINE_EVERY: Duration = Duration::from_secs(15);

/// Progress of one piece of work, on standard error.
pub struct Progress {
    bar: ProgressBar,
    what: &'static str,
    lines: bool,
    last: Instant,
}

impl Progress {
    /// Begins: `what` is done, `total` pieces of it.
    pub fn new(output: &Output, what: &'static str, total: u64) -> Self {
        let last = Instant::now();
        if !output.shows_progress() {
            let bar = ProgressBar::with_draw_target(Some(total), ProgressDrawTarget::hidden());
            return Self { bar, what, lines: false, last };
        }
        let bar = ProgressBar::new(total);
        let template = "{prefix} {wide_bar} {human_pos}/{human_len}  {elapsed} gone, {eta} left  {msg}";
        // The template is constant; should it ever be wrong, the default bar is as good.
        if let Ok(style) = ProgressStyle::with_template(template) {
            bar.set_style(style);
        }
        bar.set_prefix(what);
        bar.enable_steady_tick(Duration::from_millis(500));
        let lines = bar.is_hidden();
        Self { bar, what, lines, last }
    }

    /// A handle for several threads that each finish pieces.
    pub fn shared(&self) -> ProgressBar {
        self.bar.clone()
    }

    /// `done` pieces are done of `total`; `message` says how it goes.
    pub fn update(&mut self, done: u64, total: u64, message: impl FnOnce() -> String) {
        self.bar.set_length(total);
        self.bar.set_position(done);
        if self.lines {
            if self.last.elapsed() >= LINE_EVERY {
                self.last = Instant::now();
                tracing::info!("{} {done}/{total}, {} s left  {}", self.what, self.bar.eta().as_secs(), message());
            }
        } else if !self.bar.is_hidden() {
            self.bar.set_message(message());
        }
    }

    /// Done: the bar goes away.
    pub fn finish(self) {
        self.bar.finish_and_clear();
    }
}
