//! A machine behind a bus in memory, on a virtual clock.

use lifelike_runtime::udp::packet::Received;
use lifelike_runtime::{Bus, Facts, Measurement, RuntimeError, SafeCommand};

use super::SimulatedRobot;

/// A machine that makes its physics steps as commands come in: each command is one tick of the runtime.
pub struct MemoryBus {
    machine: SimulatedRobot,
    command: Received,
    /// Time of a tick, and time since the last physics step (ns).
    tick: u64,
    since: u64,
    waiting: Vec<Measurement>,
    is_broken: bool,
}

impl MemoryBus {
    /// A bus for ticks at a rate (Hz).
    pub fn new(machine: SimulatedRobot, command_hz: f64) -> Self {
        let joints = machine.facts().joints.len();
        let (tick, since) = ((1e9 / command_hz).round() as u64, 0);
        let mut bus =
            Self { machine, command: Received::new(joints), tick, since, waiting: Vec::new(), is_broken: false };
        bus.measure();
        bus
    }

    /// Returns the robot.
    pub fn robot(&mut self) -> &mut SimulatedRobot {
        &mut self.machine
    }

    /// Measures a few times without time going on: a runtime believes nothing before that.
    pub fn settle(&mut self) {
        (0..8).for_each(|_| self.measure());
    }

    fn measure(&mut self) {
        let mut packet = Measurement::new(self.command.position.len());
        if self.machine.measure(&mut packet) {
            self.waiting.push(packet);
        }
    }
}

impl Bus for MemoryBus {
    fn facts(&mut self) -> Result<Facts, RuntimeError> {
        Ok(self.machine.facts().clone())
    }

    fn receive(&mut self, into: &mut Measurement) -> std::io::Result<bool> {
        if self.waiting.is_empty() {
            return Ok(false);
        }
        into.copy_from(&self.waiting.remove(0));
        Ok(true)
    }

    fn send(&mut self, command: &SafeCommand) -> std::io::Result<()> {
        self.command.copy_from(command);
        self.machine.command(&self.command);
        self.since += self.tick;
        while self.since >= self.machine.step_ns() && !self.is_broken {
            self.since -= self.machine.step_ns();
            self.is_broken = self.machine.advance().is_err();
            self.measure();
        }
        Ok(())
    }
}
