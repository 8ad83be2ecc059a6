//! The time that a run has been training, all sittings together.

use std::time::Instant;

/// A clock that can be stopped.
#[derive(Debug)]
pub struct Clock {
    before: f64,
    since: Option<Instant>,
}

impl Clock {
    /// Starts a clock that shows so many seconds.
    pub fn after(seconds: f64) -> Self {
        Self { before: seconds, since: Some(Instant::now()) }
    }

    /// Returns the time it shows (s).
    pub fn seconds(&self) -> f64 {
        self.before + self.since.map_or(0.0, |since| since.elapsed().as_secs_f64())
    }

    /// Stops it.
    pub fn stop(&mut self) {
        (self.before, self.since) = (self.seconds(), None);
    }

    /// Lets it run again.
    pub fn go_on(&mut self) {
        self.since = Some(Instant::now());
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    #[test]
    fn a_stopped_clock_shows_the_same_time() {
        let mut clock = Clock::after(100.0);
        std::thread::sleep(Duration::from_millis(2));
        clock.stop();
        let shown = clock.seconds();
        std::thread::sleep(Duration::from_millis(2));
        assert!(shown > 100.0 && clock.seconds() == shown);
        clock.go_on();
        std::thread::sleep(Duration::from_millis(2));
        assert!(clock.seconds() > shown);
    }
}
