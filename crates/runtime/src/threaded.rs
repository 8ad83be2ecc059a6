//! A bus whose wire may block or allocate: the wire runs on a thread of its own.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::Duration;

use rtrb::{Consumer, Producer, RingBuffer};

use crate::bus::{Bus, Facts, Measurement};
use crate::error::RuntimeError;
use crate::gate::SafeCommand;
use crate::scheduling;
use crate::udp::packet::Received;

/// Measurements and commands that may wait; more are dropped.
const WAITING: usize = 64;
/// Longest time between two looks at an idle wire.
const GLANCE: Duration = Duration::from_micros(250);

/// A connection that is allowed to block for about a millisecond and to allocate, as DDS and serial ports do.
pub trait Wire: Send {
    /// Writes the next measurement into `into`; returns false when none is waiting.
    ///
    /// # Errors
    /// The connection is broken. It is used again.
    fn receive(&mut self, into: &mut Measurement) -> std::io::Result<bool>;

    /// Sends a command that passed the gate.
    ///
    /// # Errors
    /// The connection is broken. It is used again.
    fn send(&mut self, command: &Received) -> std::io::Result<()>;
}

/// A bus over a [`Wire`]. Its side of the loop neither blocks nor allocates.
pub struct ThreadedBus {
    facts: Facts,
    measured: Consumer<Measurement>,
    spent: Producer<Measurement>,
    commands: Producer<Received>,
    free: Consumer<Received>,
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
}

#[derive(Default)]
struct Shared {
    stop: AtomicBool,
    /// The loop has begun: what came before is old.
    listens: AtomicBool,
    broken: AtomicBool,
}

impl ThreadedBus {
    /// Starts the thread of a machine that has said what it is.
    pub fn start(facts: Facts, wire: impl Wire + 'static) -> Self {
        let joints = facts.joints.len();
        let (mut spent, empty) = RingBuffer::new(WAITING);
        let (mut used, free) = RingBuffer::new(WAITING);
        let (filled, measured) = RingBuffer::new(WAITING);
        let (commands, waiting) = RingBuffer::new(WAITING);
        while spent.push(Measurement::new(joints)).is_ok() && used.push(Received::new(joints)).is_ok() {}
        let shared = Arc::new(Shared::default());
        let ends = Ends { empty, filled, waiting, used, shared: Arc::clone(&shared) };
        let thread = std::thread::spawn(move || ends.serve(wire));
        Self { facts, measured, spent, commands, free, shared, thread: Some(thread) }
    }
}

impl Bus for ThreadedBus {
    fn facts(&mut self) -> Result<Facts, RuntimeError> {
        Ok(self.facts.clone())
    }

    fn receive(&mut self, into: &mut Measurement) -> std::io::Result<bool> {
        self.shared.listens.store(true, Ordering::Relaxed);
        let Ok(packet) = self.measured.pop() else {
            let is_broken = self.shared.broken.swap(false, Ordering::Relaxed);
            return if is_broken { Err(std::io::ErrorKind::BrokenPipe.into()) } else { Ok(false) };
        };
        into.copy_from(&packet);
        // The ring has room for all that exist.
        let _ = self.spent.push(packet);
        Ok(true)
    }

    fn send(&mut self, command: &SafeCommand) -> std::io::Result<()> {
        let Ok(mut copy) = self.free.pop() else { return Err(std::io::ErrorKind::WouldBlock.into()) };
        copy.copy_from(command);
        let _ = self.commands.push(copy);
        if let Some(thread) = &self.thread {
            thread.thread().unpark();
        }
        Ok(())
    }
}

impl Drop for ThreadedBus {
    fn drop(&mut self) {
        self.shared.stop.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            thread.thread().unpark();
            // A thread that panicked has nothing left to send.
            let _ = thread.join();
        }
    }
}

/// The wire's ends of the rings.
struct Ends {
    empty: Consumer<Measurement>,
    filled: Producer<Measurement>,
    waiting: Consumer<Received>,
    used: Producer<Received>,
    shared: Arc<Shared>,
}

impl Ends {
    /// Serves the wire until the bus is dropped and the last command is sent.
    fn serve(mut self, mut wire: impl Wire) {
        // The loop reports what is not permitted.
        let _ = scheduling::real_time();
        let mut packet = None;
        loop {
            let stops = self.shared.stop.load(Ordering::Relaxed);
            // The newest counts: a slow wire does not fall behind.
            let mut newest = None;
            while let Ok(command) = self.waiting.pop() {
                if let Some(older) = newest.replace(command) {
                    let _ = self.used.push(older);
                }
            }
            if let Some(command) = newest {
                self.note(wire.send(&command).map(|()| true));
                let _ = self.used.push(command);
            }
            if stops {
                return;
            }
            packet = packet.or_else(|| self.empty.pop().ok());
            let has_more = match packet.take() {
                Some(mut into) => {
                    let received = wire.receive(&mut into);
                    let has_more = self.note(received);
                    if has_more && self.shared.listens.load(Ordering::Relaxed) {
                        let _ = self.filled.push(into);
                    } else {
                        packet = Some(into);
                    }
                    has_more
                }
                None => false,
            };
            if !has_more {
                std::thread::park_timeout(GLANCE);
            }
        }
    }

    /// Returns a result's value; an error marks the wire as broken.
    fn note(&self, result: std::io::Result<bool>) -> bool {
        result.unwrap_or_else(|_| {
            self.shared.broken.store(true, Ordering::Relaxed);
            false
        })
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::gate::{Gate, Intent, LimitSettings, Limits, Mode};
    use std::sync::mpsc;
    use std::time::Instant;

    /// A wire that numbers its measurements, breaks at every tenth, and blocks while it sends.
    struct Slow {
        sequence: u32,
        sent: mpsc::Sender<(u32, Vec<f32>)>,
    }

    impl Wire for Slow {
        fn receive(&mut self, into: &mut Measurement) -> std::io::Result<bool> {
            self.sequence += 1;
            into.sequence = self.sequence;
            match self.sequence % 10 {
                0 => Err(std::io::ErrorKind::TimedOut.into()),
                1..4 => Ok(false),
                _ => Ok(true),
            }
        }

        fn send(&mut self, command: &Received) -> std::io::Result<()> {
            std::thread::sleep(Duration::from_millis(5));
            self.sent.send((command.sequence, command.position.clone())).map_err(std::io::Error::other)
        }
    }

    #[test]
    fn the_loop_is_not_held_up_and_a_slow_wire_sends_the_newest_command() {
        let robot = lifelike_robot::Robot::load("lima").unwrap();
        let (sender, sent) = mpsc::channel();
        let mut bus = ThreadedBus::start(Facts::of(&robot, 500.0, 500.0), Slow { sequence: 0, sent: sender });
        let mut gate = Gate::new(Limits::of(&robot, LimitSettings::default()).unwrap(), 500.0);
        let (mut packet, mut numbers, mut broken) = (Measurement::new(20), Vec::new(), 0);
        std::thread::sleep(Duration::from_millis(20));
        let mut commands = Vec::new();
        // Until enough was received, and no longer than a busy machine may take.
        for i in 0..2000 {
            if i >= 40 && broken > 0 && numbers.len() > 5 {
                break;
            }
            let begin = Instant::now();
            match bus.receive(&mut packet) {
                Ok(true) => numbers.push(packet.sequence),
                Ok(false) => {}
                Err(_) => broken += 1,
            }
            let targets = [0.0; 20];
            let intent = Intent { mode: Mode::Off, targets: &targets, rate: 1.0, reference: &[], up_b: None };
            let command = gate.pass(i * 2_000_000, intent);
            bus.send(command).unwrap();
            commands.push((command.sequence(), command.position().to_vec()));
            assert!(begin.elapsed() < Duration::from_millis(100), "a wire of 5 ms is behind the loop");
            std::thread::sleep(Duration::from_millis(1));
        }
        drop(bus);
        let sent: Vec<_> = sent.iter().collect();
        assert_eq!(sent.last(), commands.last());
        assert!(sent.len() < commands.len() && sent.iter().all(|one| commands.contains(one)), "{}", sent.len());
        assert!(sent.is_sorted_by_key(|(sequence, _)| *sequence));
        assert!(broken > 0 && numbers.len() > 5, "{broken} {numbers:?}");
        assert!(numbers.is_sorted() && numbers.iter().all(|number| number % 10 > 3), "{numbers:?}");
    }
}
