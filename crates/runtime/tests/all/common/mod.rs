//! A plant for tests: joints of lima with inertia and friction on a fixed root, behind a bus that obeys the test.
#![allow(dead_code, clippy::unwrap_used, clippy::expect_used)]

use std::collections::VecDeque;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use lifelike_checkpoint::rng::stream;
use lifelike_robot::{Controller, Robot};
use lifelike_runtime::{Bus, Config, Facts, Measurement, Mode, Playlist, RuntimeError, SafeCommand, Supervisor};
use rand::Rng;

pub const TICK: f64 = 1e-3;

pub fn asset(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets").join(name)
}

pub fn lima() -> Arc<Robot> {
    Arc::new(Robot::load("lima").unwrap())
}

/// The policy that needs only a robot's own sensors.
pub fn controller() -> Arc<Controller> {
    let file = asset("lima-blind.controller.safetensors");
    Arc::new(Controller::load(&file, lima()).unwrap())
}

/// A short run: standing for a second.
pub fn supervisor(controller: &Arc<Controller>, change: impl FnOnce(&mut Config)) -> Supervisor {
    let mut config = Config::default();
    (config.durations.stand, config.durations.damp) = (0.2, 0.1);
    change(&mut config);
    let motions = Playlist::new(controller, &[], 0.5).unwrap();
    Supervisor::new(Arc::clone(controller), motions, config).unwrap()
}

/// A fault of the bus or the machine, from a tick on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Fault {
    None,
    /// Packets are lost with this probability.
    Drop(f64),
    /// Delay of the packets (ticks).
    Delay(usize),
    /// Every packet comes twice.
    Duplicate,
    /// Neighbours change places.
    Reorder,
    /// A joint's position is no number.
    NotANumber(usize),
    /// An encoder repeats itself.
    Frozen(usize),
    /// Two joints' readings are exchanged.
    Swapped(usize, usize),
    /// Nothing comes and nothing goes.
    Kill,
    /// Jump of the robot's clock (s).
    ClockJump(f64),
    /// A motor gets hotter by 50 degrees per second.
    Hot(usize),
    /// The stop button.
    Button,
    /// The robot begins again with its sequence.
    Reboot,
    /// The root turns over at 2 rad/s.
    Topple,
    /// The battery runs empty.
    Battery,
    /// A motor does nothing.
    Dead(usize),
}

pub struct Plant {
    pub robot: Arc<Robot>,
    pub fault: Fault,
    pub from: usize,
    pub tick: usize,
    pub q: Vec<f64>,
    pub v: Vec<f64>,
    torque: Vec<f64>,
    temperature: Vec<f32>,
    held: Option<Measurement>,
    sequence: u32,
    queue: VecDeque<(usize, Measurement)>,
    seed: u64,
    pub noise: f32,
    /// Mode of every command, the newest last; gains and targets of the newest.
    pub modes: Vec<Mode>,
    /// Watches every command with the true state.
    pub watch: fn(&Plant, &SafeCommand),
}

impl Plant {
    pub fn new(seed: u64) -> Self {
        let robot = lima();
        let joints = robot.joints();
        let mut plant = Self {
            fault: Fault::None,
            from: 0,
            tick: 0,
            q: robot.default_pose.clone(),
            v: vec![0.0; joints],
            torque: vec![0.0; joints],
            temperature: vec![30.0; joints],
            held: None,
            sequence: 0,
            queue: VecDeque::new(),
            seed,
            noise: 1e-4,
            modes: Vec::with_capacity(100_000),
            watch: |_, _| {},
            robot,
        };
        for _ in 0..8 {
            plant.measure();
        }
        plant
    }

    fn is_on(&self) -> bool {
        self.tick >= self.from
    }

    fn measure(&mut self) {
        let mut rng = stream(self.seed, "plant", 0, self.tick as u64);
        let mut noisy = |x: f64, size: f32| x as f32 + size * rng.random_range(-1.0f32..=1.0);
        let mut packet = Measurement::new(self.q.len());
        self.sequence = self.sequence.wrapping_add(1);
        (packet.sequence, packet.clock) = (self.sequence, self.tick as u64 * 1_000_000);
        packet.battery = 24.0;
        for j in 0..self.q.len() {
            packet.position[j] = noisy(self.q[j], self.noise);
            packet.velocity[j] = noisy(self.v[j], 10.0 * self.noise);
            packet.torque[j] = self.torque[j] as f32;
        }
        let mut delay = 0;
        if self.is_on() {
            let since = (self.tick - self.from) as f64 * TICK;
            match self.fault {
                Fault::Drop(share) if rng.random_bool(share) => return,
                Fault::Delay(ticks) => delay = ticks,
                Fault::NotANumber(joint) => packet.position[joint] = f32::NAN,
                Fault::Frozen(joint) => {
                    if let Some(held) = &self.held {
                        packet.position[joint] = held.position[joint];
                    }
                    self.held = Some(packet.clone());
                }
                Fault::Swapped(a, b) => {
                    packet.position.swap(a, b);
                    packet.velocity.swap(a, b);
                }
                Fault::Kill => return,
                Fault::ClockJump(seconds) => packet.clock = packet.clock.saturating_add_signed((seconds * 1e9) as i64),
                Fault::Hot(joint) => self.temperature[joint] += 0.05,
                Fault::Button => packet.stop = true,
                Fault::Reboot => packet.sequence -= self.from as u32,
                Fault::Topple => {
                    let (s, c) = (since as f32).sin_cos();
                    packet.orientation = [c, s, 0.0, 0.0];
                }
                Fault::Battery => packet.battery = 24.0 - 10.0 * since as f32,
                _ => {}
            }
        }
        packet.temperature.copy_from_slice(&self.temperature);
        let at = self.tick + delay;
        match self.fault {
            Fault::Duplicate if self.is_on() => {
                self.queue.push_back((at, packet.clone()));
                self.queue.push_back((at, packet));
            }
            Fault::Reorder if self.is_on() && self.tick % 4 == 3 => {
                let last = self.queue.pop_back();
                self.queue.push_back((at, packet));
                self.queue.extend(last);
            }
            _ => self.queue.push_back((at, packet)),
        }
    }
}

impl Bus for Plant {
    fn facts(&mut self) -> Result<Facts, RuntimeError> {
        Ok(Facts::of(&self.robot, 1000.0, 1000.0))
    }

    fn receive(&mut self, into: &mut Measurement) -> std::io::Result<bool> {
        // Neighbours that change places must wait for each other.
        let waits = matches!(self.fault, Fault::Reorder) && self.queue.len() < 3;
        if waits || self.queue.front().is_none_or(|(at, _)| *at > self.tick) {
            return Ok(false);
        }
        if let Some((_, packet)) = self.queue.pop_front() {
            into.copy_from(&packet);
        }
        Ok(true)
    }

    fn send(&mut self, command: &SafeCommand) -> std::io::Result<()> {
        (self.watch)(self, command);
        self.modes.push(command.mode());
        for j in 0..self.q.len() {
            let actuator = &self.robot.actuators.parameters[j];
            let asked = f64::from(command.torque(j, self.q[j] as f32, self.v[j] as f32));
            let is_dead = self.is_on() && self.fault == Fault::Dead(j);
            let asked = if is_dead { 0.0 } else { asked };
            self.torque[j] = asked.clamp(-actuator.torque_max, actuator.torque_max);
            let inertia = 0.002 * actuator.torque_max;
            self.v[j] = (self.v[j] + TICK * self.torque[j] / inertia) / (1.0 + 2.0 * TICK);
            self.q[j] += TICK * self.v[j];
        }
        self.tick += 1;
        self.measure();
        if self.is_on() && self.fault == Fault::Kill {
            return Err(std::io::Error::from(std::io::ErrorKind::ConnectionRefused));
        }
        Ok(())
    }
}
