//! Progress of long work with its remaining time: a bar for people at a terminal, a line now and then for log files.

use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use crate::output::Output;

/// Time between two lines where there is no terminal.
const LINE_EVERY: Duration = Duration::from_secs(15);
/// A bar of fixed width, then the rest of the line for the message, cut where it does not fit.
const TEMPLATE: &str = "{prefix} {bar:20} {percent:>3}%  {wide_msg}";
/// Parts of a bar that goes by time.
const PARTS: u64 = 1000;

/// Progress of one piece of work, on standard error.
pub struct Progress {
    bar: ProgressBar,
    what: &'static str,
    lines: bool,
    began: Instant,
    last: Instant,
}

impl Progress {
    /// Begins: `what` is done, `total` pieces of it.
    pub fn new(output: &Output, what: &'static str, total: u64) -> Self {
        let now = Instant::now();
        let (bar, lines) = if output.shows_progress() {
            let bar = ProgressBar::new(total);
            let lines = bar.is_hidden();
            (bar, lines)
        } else {
            (ProgressBar::with_draw_target(Some(total), ProgressDrawTarget::hidden()), false)
        };
        // The template is constant; should it ever be wrong, the default bar is as good.
        if let Ok(style) = ProgressStyle::with_template(TEMPLATE) {
            bar.set_style(style);
        }
        bar.set_prefix(what);
        if !bar.is_hidden() {
            bar.enable_steady_tick(Duration::from_millis(500));
        }
        Self { bar, what, lines, began: now, last: now }
    }

    /// A handle for several threads that each finish pieces.
    pub fn shared(&self) -> ProgressBar {
        self.bar.clone()
    }

    /// `done` pieces are done of `total`; `message` says how it goes.
    pub fn update(&mut self, done: u64, total: u64, message: impl FnOnce() -> String) {
        self.bar.set_length(total);
        self.bar.set_position(done);
        let rate = self.began.elapsed().as_secs_f64() / done.max(1) as f64;
        self.tell(rate * total.saturating_sub(done) as f64, || format!("{done}/{total}  {}", message()));
    }

    /// This share of the time is over, and so many seconds are left: for work that has several ends.
    pub fn update_time(&mut self, share: f64, left: f64, message: impl FnOnce() -> String) {
        self.bar.set_length(PARTS);
        self.bar.set_position((share.clamp(0.0, 1.0) * PARTS as f64) as u64);
        self.tell(left, message);
    }

    fn tell(&mut self, left: f64, message: impl FnOnce() -> String) {
        if self.lines {
            if self.last.elapsed() >= LINE_EVERY {
                self.last = Instant::now();
                tracing::info!("{} {} left  {}", self.what, duration(left), message());
            }
        } else if !self.bar.is_hidden() {
            self.bar.set_message(format!("{} left  {}", duration(left), message()));
        }
    }

    /// Done: the bar goes away.
    pub fn finish(self) {
        self.bar.finish_and_clear();
    }
}

/// Returns a duration (s) in at most two units.
pub fn duration(seconds: f64) -> String {
    let whole = seconds.round().max(0.0) as u64;
    match whole {
        0..60 => format!("{whole} s"),
        60..3600 => format!("{} min {} s", whole / 60, whole % 60),
        _ => format!("{} h {} min", whole / 3600, whole % 3600 / 60),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use std::io::Result;
    use std::sync::{Arc, Mutex};

    /// Text on a terminal of a width (columns), whose lines can be cleared.
    #[derive(Debug, Clone)]
    struct Screen(Arc<Mutex<String>>, u16);

    impl Screen {
        fn change(&self, change: impl FnOnce(&mut String)) -> Result<()> {
            change(&mut self.0.lock().unwrap());
            Ok(())
        }
    }

    #[rustfmt::skip]
    impl indicatif::TermLike for Screen {
        fn width(&self) -> u16 { self.1 }
        fn move_cursor_up(&self, _: usize) -> Result<()> { Ok(()) }
        fn move_cursor_down(&self, _: usize) -> Result<()> { Ok(()) }
        fn move_cursor_right(&self, _: usize) -> Result<()> { Ok(()) }
        fn move_cursor_left(&self, _: usize) -> Result<()> { Ok(()) }
        fn write_line(&self, text: &str) -> Result<()> { self.change(|all| *all += &format!("{text}\n")) }
        fn write_str(&self, text: &str) -> Result<()> { self.change(|all| all.push_str(text)) }
        fn clear_line(&self) -> Result<()> { self.change(|all| all.truncate(all.rfind('\n').map_or(0, |at| at + 1))) }
        fn flush(&self) -> Result<()> { Ok(()) }
    }

    #[test]
    fn durations_have_at_most_two_units() {
        assert_eq!([0.4, 59.4, 61.0, 3725.0].map(duration), ["0 s", "59 s", "1 min 1 s", "1 h 2 min"]);
    }

    #[test]
    fn the_bar_stays_at_80_columns_and_is_one_line() {
        use indicatif::ProgressDrawTarget;
        for columns in [80, 100, 160] {
            let terminal = Screen(Arc::default(), columns);
            let now = Instant::now();
            let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::term_like(Box::new(terminal.clone())));
            bar.set_style(ProgressStyle::with_template(TEMPLATE).unwrap_or_else(|_| ProgressStyle::default_bar()));
            bar.set_prefix("training");
            let mut progress = Progress { bar, what: "training", lines: false, began: now, last: now };
            progress.update_time(0.5, 61.0, || {
                "survival 93%  26000 steps/s  iteration 1234  episode 8.2 s  reward 0.81 and more".into()
            });
            let shown = terminal.0.lock().unwrap().clone();
            assert_eq!(shown.lines().count(), 1, "{shown}");
            assert!(
                shown.starts_with("training ██████████") && shown.contains("50%  1 min 1 s left  survival 93%"),
                "{shown}"
            );
        }
    }
}
