//! Replay of a record: the same controller sees the same packets at the same times, and must send the same bytes.

use crate::bus::{Bus, Facts, Measurement};
use crate::clock::RecordedClock;
use crate::gate::SafeCommand;
use crate::record::{CommandMessage, Entry, Record};
use crate::supervisor::Supervisor;
use crate::{FromInput, RuntimeError};

/// First difference between a record and its replay.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Difference {
    /// Number of the tick.
    pub tick: u64,
    /// Its time (s).
    pub seconds: f64,
    /// Subject, such as `target of joint 'left_knee'`.
    pub what: String,
    /// Content of the record.
    pub recorded: String,
    /// Content of the replay.
    pub replayed: String,
}

/// Outcome of a replay.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Replay {
    /// Ticks that were compared.
    pub ticks: u64,
    /// Packets that were seen.
    pub packets: u64,
    /// The first difference; none when all commands have the same bits.
    pub difference: Option<Difference>,
}

/// Replays a record through a supervisor that has not run yet.
pub fn replay(record: &Record, supervisor: &mut Supervisor) -> Replay {
    let joints = supervisor.controller().robot().layout.joints.clone();
    let mut outcome = Replay { ticks: 0, packets: 0, difference: None };
    for entry in &record.entries {
        match entry {
            Entry::Measured(message) => {
                supervisor.receive(message.time_ns, &message.packet());
                outcome.packets += 1;
            }
            Entry::Command(message) => {
                supervisor.tick(message.time_ns, message.request);
                if let Some((what, recorded, replayed)) = difference(message, supervisor, &joints) {
                    let seconds = message.time_ns as f64 * 1e-9;
                    let tick = outcome.ticks;
                    outcome.difference = Some(Difference { tick, seconds, what, recorded, replayed });
                    return outcome;
                }
                outcome.ticks += 1;
            }
            Entry::Policy(_) => {}
        }
    }
    outcome
}

fn difference(
    message: &CommandMessage,
    supervisor: &Supervisor,
    joints: &[String],
) -> Option<(String, String, String)> {
    let command = supervisor.gate().command();
    let differs = |what: &str, a: String, b: String| (a != b).then(|| (what.to_string(), a, b));
    let numbers = [
        ("target", &message.position, command.position()),
        ("kp", &message.kp, command.kp()),
        ("kd", &message.kd, command.kd()),
    ];
    differs("sequence", message.sequence.to_string(), command.sequence().to_string())
        .or_else(|| differs("phase", message.phase.name().into(), supervisor.phase().name().into()))
        .or_else(|| differs("mode", format!("{:?}", message.mode), format!("{:?}", command.mode())))
        .or_else(|| {
            numbers.into_iter().find_map(|(what, recorded, replayed)| {
                let j = (0..joints.len()).find(|&j| recorded[j].to_bits() != replayed[j].to_bits())?;
                let what = format!("{what} of joint '{}'", joints[j]);
                Some((what, recorded[j].to_string(), replayed[j].to_string()))
            })
        })
}

/// A bus that plays the packets of a record, one tick's after the other, and sends nothing. It belongs to [`Self::clock`]: on
/// another clock the packets would come late.
#[derive(Debug)]
pub struct ReplayBus {
    facts: Facts,
    /// Packets with the number of the tick that they belong to.
    packets: std::vec::IntoIter<(u64, Measurement)>,
    next: Option<(u64, Measurement)>,
    tick: u64,
    times: Vec<u64>,
}

impl ReplayBus {
    /// A bus of a record.
    ///
    /// # Errors
    /// The record lacks the robot's facts.
    pub fn new(record: &Record) -> Result<Self, RuntimeError> {
        let facts = record.meta("facts")?;
        let facts = serde_json::from_str(facts)
            .map_err(|error| RuntimeError::format(record.path.display(), "facts of a robot", error))?;
        let (mut times, mut packets) = (Vec::new(), Vec::new());
        for entry in &record.entries {
            match entry {
                Entry::Measured(message) => packets.push((times.len() as u64, message.packet())),
                Entry::Command(message) => times.push(message.time_ns),
                Entry::Policy(_) => {}
            }
        }
        let mut packets = packets.into_iter();
        Ok(Self { facts, next: packets.next(), packets, tick: 0, times })
    }

    /// Returns the clock of its ticks.
    pub fn clock(&self) -> RecordedClock {
        RecordedClock::new(self.times.clone())
    }
}

impl Bus for ReplayBus {
    fn facts(&mut self) -> Result<Facts, RuntimeError> {
        Ok(self.facts.clone())
    }

    fn receive(&mut self, into: &mut Measurement) -> std::io::Result<bool> {
        let Some((_, packet)) = self.next.as_ref().filter(|(tick, _)| *tick <= self.tick) else { return Ok(false) };
        into.copy_from(packet);
        self.next = self.packets.next();
        Ok(true)
    }

    fn send(&mut self, _: &SafeCommand) -> std::io::Result<()> {
        self.tick += 1;
        Ok(())
    }
}
