//! Time of the loop: the machine's monotonic clock, a virtual one, or that of a record.

/// A clock that can be waited on. Times are nanoseconds since the loop's start.
pub trait Clock {
    /// Returns the present time (ns).
    fn now(&mut self) -> u64;

    /// Waits until a time (ns) and returns the time at which it woke up (ns).
    fn wait_until(&mut self, deadline: u64) -> u64;
}

/// The monotonic clock. Deadlines are absolute, so a late tick does not move those after it.
#[derive(Debug, Clone, Copy)]
pub struct MonotonicClock {
    start: std::time::Instant,
    #[cfg(target_os = "linux")]
    origin: rustix::time::Timespec,
}

impl MonotonicClock {
    /// A clock that begins at 0 now.
    pub fn start() -> Self {
        Self {
            #[cfg(target_os = "linux")]
            origin: rustix::time::clock_gettime(rustix::time::ClockId::Monotonic),
            start: std::time::Instant::now(),
        }
    }

    #[cfg(target_os = "linux")]
    fn sleep_until(&self, deadline: u64) {
        use rustix::thread::{ClockId, Timespec, clock_nanosleep_absolute};
        let nanoseconds = self.origin.tv_nsec as i128 + i128::from(deadline);
        let at = Timespec {
            tv_sec: self.origin.tv_sec + (nanoseconds / 1_000_000_000) as i64,
            tv_nsec: (nanoseconds % 1_000_000_000) as _,
        };
        // A signal ends the sleep early: the loop looks at its stop flag, and sleeps again.
        let _ = clock_nanosleep_absolute(ClockId::Monotonic, &at);
    }

    #[cfg(not(target_os = "linux"))]
    fn sleep_until(&self, deadline: u64) {
        let elapsed = self.start.elapsed();
        std::thread::sleep(std::time::Duration::from_nanos(deadline).saturating_sub(elapsed));
    }
}

impl Clock for MonotonicClock {
    fn now(&mut self) -> u64 {
        self.start.elapsed().as_nanos() as u64
    }

    fn wait_until(&mut self, deadline: u64) -> u64 {
        while self.now() < deadline {
            self.sleep_until(deadline);
        }
        self.now()
    }
}

/// A clock that is exactly where it is asked to be: for tests and evaluation, faster than real time.
#[derive(Debug, Clone, Copy, Default)]
pub struct VirtualClock {
    now: u64,
}

impl Clock for VirtualClock {
    fn now(&mut self) -> u64 {
        self.now
    }

    fn wait_until(&mut self, deadline: u64) -> u64 {
        self.now = self.now.max(deadline);
        self.now
    }
}

/// The clock of a record: it is where its ticks were, one after the other, as fast as the loop asks. After the last it goes on
/// as a [`VirtualClock`].
#[derive(Debug, Clone)]
pub struct RecordedClock {
    ticks: std::vec::IntoIter<u64>,
    clock: VirtualClock,
}

impl RecordedClock {
    /// A clock of ticks (ns), in the order of time.
    pub fn new(ticks: Vec<u64>) -> Self {
        let now = ticks.first().copied().unwrap_or(0);
        Self { ticks: ticks.into_iter(), clock: VirtualClock { now } }
    }
}

impl Clock for RecordedClock {
    fn now(&mut self) -> u64 {
        self.clock.now()
    }

    fn wait_until(&mut self, deadline: u64) -> u64 {
        let tick = self.ticks.next().unwrap_or(deadline);
        self.clock.wait_until(tick)
    }
}
