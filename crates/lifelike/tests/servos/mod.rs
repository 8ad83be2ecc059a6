//! Simulated Dynamixel servos on a pseudo terminal: control tables in front of our physics, in real time.

use std::net::UdpSocket;
use std::os::fd::AsRawFd;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use lifelike::simulated_robot::{SensorOptions, SimulatedRobot, stepwise};
use lifelike_dynamixel::{BROADCAST, Instruction, Packet, PacketReader, write_packet};
use lifelike_robot::Robot;
use lifelike_runtime::udp::packet::{self, Received};
use lifelike_runtime::{Measurement, Mode};
use lifelike_sim::SimulationSpec;
use serial2::SerialPort;

/// Numbers of XH540-W150 and XM430-W350, and units: turns a minute, amperes.
const LEG: u16 = 1110;
const ARM: u16 = 1020;
const VELOCITY: f32 = 0.229 * std::f32::consts::TAU / 60.0;
const CURRENT: f32 = 2.69e-3;
/// Torque constant of the file (N m/A), and firmware's gains.
const TORQUE_CONSTANT: f32 = 2.0;
const GAINS: (u16, u16) = (800, 400);

/// Fault of one servo, by its place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Fault {
    /// It does not answer.
    Silent(usize),
    /// The checksums of its answers are wrong.
    Checksum(usize),
    /// It reports hardware errors, and turns its torque off.
    Hardware(usize, u8),
    /// It is of another model.
    Model(usize, u16),
    /// Two servos have each other's identifiers.
    Swapped(usize, usize),
    /// The supply has this voltage (V).
    Voltage(f32),
    /// It is this hot (degrees Celsius).
    Hot(usize, u8),
    /// It was mounted the other way round.
    Reversed(usize),
    /// The IMU stops.
    NoImu,
}

/// Faults, each from a time (s) after motors were first turned on; those before it always hold.
pub type Faults = Vec<(f64, Fault)>;

/// State of the robot at the end.
#[derive(Debug, Clone, Default)]
pub struct Account {
    /// Least height of the root while all servos held a position (m).
    pub lowest: f32,
    /// Servos with torque, goal writes that were seen, and servos with a watchdog while they were driven.
    pub enabled: usize,
    pub goals: usize,
    pub watched: usize,
}

/// Servos in a thread.
pub struct Servos {
    pub port: String,
    pub imu: String,
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<Account>>,
    _slave: SerialPort,
}

impl Servos {
    /// Starts lima's servos. The root is held for `gantry` (s) after motors were first turned on.
    pub fn start(faults: Faults, gantry: f64) -> Self {
        let (master, slave) = SerialPort::pair().unwrap();
        let port = std::fs::read_link(format!("/proc/self/fd/{}", slave.as_raw_fd())).unwrap().display().to_string();
        let imu = UdpSocket::bind("127.0.0.1:0").unwrap().local_addr().unwrap().to_string();
        let stop = Arc::new(AtomicBool::new(false));
        let (stopped, address) = (Arc::clone(&stop), imu.clone());
        let thread = std::thread::spawn(move || Chain::new(master, faults, gantry).serve(&address, &stopped));
        Self { port, imu, stop, thread: Some(thread), _slave: slave }
    }

    /// Ends the robot.
    pub fn end(mut self) -> Account {
        // It reads what was sent last.
        std::thread::sleep(Duration::from_millis(100));
        self.stop.store(true, Ordering::Relaxed);
        self.thread.take().unwrap().join().unwrap()
    }
}

impl Drop for Servos {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
    }
}

/// The file of lima's servos: legs and arms of two models, right joints turned and shifted.
pub fn file(robot: &Robot) -> String {
    let mut text = String::from("baud = 4000000\n");
    for (j, joint) in robot.layout.joints.iter().enumerate() {
        let parameters = &robot.actuators.parameters[j];
        let (sign, zero) = mounting(joint);
        let model = if is_leg(joint) { "XH540-W150" } else { "XM430-W350" };
        text += &format!(
            "[[servo]]\njoint = '{joint}'\nid = {}\nmodel = '{model}'\nsign = {sign}\nzero_offset = {zero:?}\n\
             mode = 'position'\np_gain = {}\nd_gain = {}\nkp = {:?}\nkd = {:?}\ntorque_max = {:?}\ntorque_constant = {TORQUE_CONSTANT:?}\n",
            j + 1,
            GAINS.0,
            GAINS.1,
            parameters.kp,
            parameters.kd,
            parameters.torque_max,
        );
    }
    text
}

fn is_leg(joint: &str) -> bool {
    ["hip", "knee", "ankle"].iter().any(|part| joint.contains(part))
}

/// Sign and offset (rad) of a joint's servo.
fn mounting(joint: &str) -> (f32, f32) {
    if joint.starts_with("right") { (-1.0, 0.1) } else { (1.0, 0.0) }
}

/// A servo's control table.
struct Servo {
    id: u8,
    table: [u8; 256],
    sign: f32,
    zero: f32,
    kp: f32,
    kd: f32,
}

impl Servo {
    fn put(&mut self, at: usize, bytes: &[u8]) {
        self.table[at..at + bytes.len()].copy_from_slice(bytes);
    }

    fn word(&self, at: usize) -> u16 {
        u16::from_le_bytes([self.table[at], self.table[at + 1]])
    }

    fn goal(&self) -> f32 {
        let units = i32::from_le_bytes(self.table[116..120].try_into().unwrap());
        self.zero + self.sign * (units - 2048) as f32 * std::f32::consts::TAU / 4096.0
    }
}

/// Servos on one line, and the physics behind them.
struct Chain {
    line: SerialPort,
    reader: PacketReader,
    servos: Vec<Servo>,
    machine: SimulatedRobot,
    state: Measurement,
    faults: Faults,
    /// Time at which motors were first turned on.
    driven: Option<Instant>,
    account: Account,
}

impl Chain {
    fn new(mut line: SerialPort, faults: Faults, gantry: f64) -> Self {
        line.set_read_timeout(Duration::from_millis(1)).unwrap();
        let robot = Robot::load("lima").unwrap();
        let fine = Arc::new(stepwise(&robot).unwrap());
        let options = SensorOptions { noise: 0.0, bias: 0.0, seed: 1, battery: 12.0, has_external: false, gantry };
        // Other threads of the physics would wait for each other on a busy machine.
        let spec = SimulationSpec { threads: 1, ..SimulationSpec::new(1) };
        let simulation = spec.build(fine).unwrap();
        let machine = SimulatedRobot::new(&robot, simulation, options);
        let servo = |(j, joint): (usize, &String)| {
            let (sign, zero) = mounting(joint);
            let parameters = &robot.actuators.parameters[j];
            let (kp, kd) = (parameters.kp as f32, parameters.kd as f32);
            let mut servo = Servo { id: j as u8 + 1, table: [0; 256], sign, zero, kp, kd };
            let number = if is_leg(joint) { LEG } else { ARM };
            servo.put(0, &number.to_le_bytes());
            // A new servo: 0.5 ms of delay, current-based position, all of a turn.
            (servo.table[9], servo.table[11]) = (250, 5);
            servo.put(48, &4095u32.to_le_bytes());
            servo
        };
        let servos = robot.layout.joints.iter().enumerate().map(servo).collect();
        let state = Measurement::new(robot.joints());
        let account = Account { lowest: f32::MAX, ..Account::default() };
        Self { line, reader: PacketReader::default(), servos, machine, state, faults, driven: None, account }
    }

    /// Returns the faults of now.
    fn now(&self) -> Vec<Fault> {
        let seconds = self.driven.map_or(0.0, |driven| driven.elapsed().as_secs_f64());
        self.faults.iter().filter(|(from, _)| *from <= seconds).map(|(_, fault)| *fault).collect()
    }

    fn serve(mut self, imu: &str, stop: &AtomicBool) -> Account {
        for fault in self.now() {
            match fault {
                Fault::Model(j, number) => self.servos[j].put(0, &number.to_le_bytes()),
                Fault::Swapped(a, b) => (self.servos[a].id, self.servos[b].id) = (self.servos[b].id, self.servos[a].id),
                Fault::Reversed(j) => self.servos[j].sign *= -1.0,
                _ => {}
            }
        }
        let socket = UdpSocket::bind("127.0.0.1:0").unwrap();
        let (begin, step) = (Instant::now(), self.machine.step_ns());
        let (mut next, mut buffer, mut bytes) = (0, [0; 2048], Vec::new());
        self.measure();
        while !stop.load(Ordering::Relaxed) {
            if let Ok(length) = self.line.read(&mut buffer) {
                self.reader.push(&buffer[..length]);
            }
            while let Some(packet) = self.reader.next_packet() {
                let answer = self.hear(&packet);
                let _ = self.line.write_all(&answer);
            }
            let now = begin.elapsed().as_nanos() as u64;
            // A thread that was not run does not catch up for longer than a moment.
            next = next.max(now.saturating_sub(20_000_000));
            while next <= now {
                next += step;
                self.drive();
                self.machine.advance().unwrap();
                self.measure();
                if !self.now().contains(&Fault::NoImu) {
                    let mut root = Measurement::new(0);
                    (root.sequence, root.clock) = (self.state.sequence, self.state.clock);
                    (root.orientation, root.gyroscope_b) = (self.state.orientation, self.state.gyroscope_b);
                    root.accelerometer_b = self.state.accelerometer_b;
                    packet::write_state(&root, &mut bytes);
                    let _ = socket.send_to(&bytes, imu);
                }
            }
        }
        self.account.enabled = self.servos.iter().filter(|servo| servo.table[64] == 1).count();
        self.account
    }

    /// Gives the physics what the servos would do.
    fn drive(&mut self) {
        let mut command = Received::new(self.servos.len());
        for (j, servo) in self.servos.iter().enumerate() {
            if servo.table[64] == 1 {
                command.mode = Mode::Position;
                command.position[j] = servo.goal();
                command.kp[j] = servo.kp * f32::from(servo.word(84)) / f32::from(GAINS.0);
                command.kd[j] = servo.kd * f32::from(servo.word(80)) / f32::from(GAINS.1);
            }
        }
        if command.mode == Mode::Position {
            self.driven.get_or_insert(Instant::now());
            self.account.watched = self.servos.iter().filter(|servo| servo.table[98] == 5).count();
        }
        self.machine.command(&command);
    }

    /// Writes the physics' state into the control tables.
    fn measure(&mut self) {
        self.machine.measure(&mut self.state);
        let faults = self.now();
        if self.servos.iter().all(|servo| servo.table[64] == 1 && servo.word(84) > 0) {
            self.account.lowest = self.account.lowest.min(self.machine.simulation().state().root_position[2]);
        }
        for (j, servo) in self.servos.iter_mut().enumerate() {
            let (q, v, torque) = (self.state.position[j], self.state.velocity[j], self.state.torque[j]);
            let units = 2048 + (servo.sign * (q - servo.zero) * 4096.0 / std::f32::consts::TAU).round() as i32;
            servo.put(132, &units.to_le_bytes());
            servo.put(128, &((servo.sign * v / VELOCITY).round() as i32).to_le_bytes());
            let current = (servo.sign * torque.clamp(-20.0, 20.0) / TORQUE_CONSTANT / CURRENT).round() as i16;
            servo.put(126, &current.to_le_bytes());
            let voltage =
                faults.iter().find_map(|fault| if let Fault::Voltage(volts) = fault { Some(*volts) } else { None });
            servo.put(144, &((10.0 * voltage.unwrap_or(self.state.battery)).round() as u16).to_le_bytes());
            servo.table[146] = self.state.temperature[j].round() as u8;
        }
        for fault in faults {
            match fault {
                Fault::Hot(j, temperature) => self.servos[j].table[146] = temperature,
                Fault::Hardware(j, errors) => (self.servos[j].table[70], self.servos[j].table[64]) = (errors, 0),
                _ => {}
            }
        }
    }

    /// Returns the bytes that servos answer to a packet.
    fn hear(&mut self, packet: &Packet) -> Vec<u8> {
        let Packet { id, instruction, parameters: p } = packet;
        let address = |p: &[u8]| usize::from(u16::from_le_bytes([p[0], p[1]]));
        let place = |servos: &[Servo], id: u8| servos.iter().position(|servo| servo.id == id);
        let mut line = Vec::new();
        if *id == BROADCAST {
            let (at, length) = (address(p), address(&p[2..]));
            if *instruction == Instruction::SyncRead as u8 {
                for id in &p[4..] {
                    let Some(j) = place(&self.servos, *id) else { continue };
                    let content = self.servos[j].table[at..at + length].to_vec();
                    line.extend(self.status(j, &content));
                }
            } else if *instruction == Instruction::SyncWrite as u8 {
                self.account.goals += usize::from(at == 116);
                for item in p[4..].chunks_exact(length + 1) {
                    let Some(j) = place(&self.servos, item[0]) else { continue };
                    self.servos[j].put(at, &item[1..]);
                }
            }
            return line;
        }
        let Some(j) = place(&self.servos, *id) else { return line };
        let content = if *instruction == Instruction::Ping as u8 {
            vec![self.servos[j].table[0], self.servos[j].table[1], 45]
        } else if *instruction == Instruction::Read as u8 {
            self.servos[j].table[address(p)..address(p) + address(&p[2..])].to_vec()
        } else {
            self.servos[j].put(address(p), &p[2..]);
            Vec::new()
        };
        self.status(j, &content)
    }

    /// Returns the answer of a servo.
    fn status(&self, j: usize, content: &[u8]) -> Vec<u8> {
        let error = if self.servos[j].table[70] != 0 { 0x80 } else { 0 };
        let mut bytes = Vec::new();
        write_packet(
            self.servos[j].id,
            Instruction::Status,
            std::iter::once(error).chain(content.iter().copied()),
            &mut bytes,
        );
        let faults = self.now();
        if faults.contains(&Fault::Silent(j)) {
            bytes.clear();
        } else if faults.contains(&Fault::Checksum(j)) {
            let last = bytes.len() - 1;
            bytes[last] ^= 0x10;
        }
        bytes
    }
}
