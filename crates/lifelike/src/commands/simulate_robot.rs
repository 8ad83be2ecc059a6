//! `lifelike simulate-robot`: physics behind the wires of a robot.

use std::net::{SocketAddr, UdpSocket};
use std::sync::Arc;
use std::sync::atomic::Ordering;

use lifelike_robot::Robot;
use lifelike_runtime::udp::packet::{self, Kind, Received};
use lifelike_runtime::{Clock, Measurement, Mode, MonotonicClock, scheduling};
use serde_json::json;

use crate::commands::physics::{self, Physics};
use crate::error::CliError;
use crate::output::Output;
use crate::simulated_robot::{Link, Scheduled, SensorOptions, SimulatedRobot, stepwise};

/// Simulate a robot in real time behind UDP, for `lifelike run --bus sim:HOST:PORT`.
///
/// The robot stands in its default pose on a gantry until it is driven. Motors get hot, the battery sags, and without
/// commands for 0.1 s it brakes. Packets may be late, overtake each other and get lost, in both directions.
/// Motors, sensors, wires and faults are the same in both engines. docs/runtime.md describes the packets, so that other programs can take either end.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  lifelike simulate-robot lima
  lifelike simulate-robot lima --delay 4 --jitter 3 --loss 0.02 --noise 0.002
  lifelike simulate-robot lima --twin 7                 # motors, friction and delays of a twin
  lifelike simulate-robot lima --engine mujoco          # in MuJoCo; once: lifelike fetch mujoco
  lifelike simulate-robot lima --fault hot@5:left_knee  # from 5 s on
  lifelike simulate-robot lima --external               # with motion capture

Faults: frozen, swapped, nan, hot, dead (of a joint); silent, clock, button, battery, push.")]
pub struct Args {
    /// The robot: a name, or an MJCF or URDF file.
    pub robot: String,
    /// Address that it listens on.
    #[arg(long, default_value = "127.0.0.1:9870")]
    pub listen: SocketAddr,
    /// Delay of packets in each direction (ms).
    #[arg(long, default_value_t = 0.0)]
    pub delay: f64,
    /// Largest delay beyond that, drawn for each packet (ms).
    #[arg(long, default_value_t = 0.0)]
    pub jitter: f64,
    /// Share of packets that are lost in each direction.
    #[arg(long, default_value_t = 0.0)]
    pub loss: f64,
    /// Standard deviation of joint positions (rad); other sensors in proportion.
    #[arg(long, default_value_t = 0.0)]
    pub noise: f32,
    /// Bias of the gyroscope's axes (rad/s); the accelerometer has ten times (m/s²).
    #[arg(long, default_value_t = 0.0)]
    pub imu_bias: f32,
    /// Random seed of noise, jitter and loss.
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Voltage of the battery without load (V).
    #[arg(long, default_value_t = 24.0)]
    pub battery: f32,
    /// Hold the root for this time after the robot is first driven (s).
    #[arg(long, default_value_t = 2.2)]
    pub gantry: f64,
    /// Send the root's position and velocity as motion capture would.
    #[arg(long)]
    pub external: bool,
    /// Fault from a time after the first drive: KIND@SECONDS or KIND@SECONDS:JOINT; may be repeated.
    #[arg(long, value_name = "FAULT")]
    pub fault: Vec<Scheduled>,
    /// End after this time (s); not before Ctrl-C if not given.
    #[arg(long)]
    pub seconds: Option<f64>,
    /// End when the runtime has turned motors off.
    #[arg(long)]
    pub once: bool,
    /// Engine and threads.
    #[command(flatten)]
    pub physics: Physics,
}

/// Runs the command.
///
/// # Errors
/// The address is taken, an option is out of range, or the physics fails.
pub fn run(args: &Args, output: &Output) -> Result<(), CliError> {
    physics::available(&args.physics.engine)?;
    let within = |name: &str, value: f64, most: f64| match (0.0..=most).contains(&value) {
        true => Ok(()),
        false => Err(CliError::Usage(format!("--{name}: expected 0 to {most}, got {value}"))),
    };
    within("delay", args.delay, 10_000.0)?;
    within("jitter", args.jitter, 10_000.0)?;
    within("loss", args.loss, 1.0)?;
    within("noise", f64::from(args.noise), 1.0)?;
    within("imu-bias", f64::from(args.imu_bias), 1.0)?;
    within("gantry", args.gantry, 1e6)?;
    let robot = Robot::load(&args.robot)?;
    let faults = args.fault.iter().cloned().map(|fault| fault.of(&robot)).collect::<Result<Vec<_>, _>>();
    let faults = faults.map_err(CliError::Usage)?;
    let fine = Arc::new(stepwise(&robot)?);
    args.physics.require_ready(&fine)?;
    let options = SensorOptions {
        noise: args.noise,
        bias: args.imu_bias,
        seed: args.seed,
        battery: args.battery,
        has_external: args.external,
        gantry: args.gantry,
    };
    let machine = SimulatedRobot::new(&robot, args.physics.simulate(None, &fine, 1)?, options).with_faults(faults);
    let failed = |error: std::io::Error| CliError::Failed(format!("{}: {error}", args.listen));
    let socket = UdpSocket::bind(args.listen).map_err(failed)?;
    socket.set_nonblocking(true).map_err(failed)?;
    let address = socket.local_addr().map_err(failed)?;
    if output.shows_progress() {
        eprintln!("{} listens; drive it: lifelike run CONTROLLER --bus sim:{address}", robot.name);
    }
    let (delay, jitter) = (1e-3 * args.delay, 1e-3 * args.jitter);
    let states = Link::new(delay, jitter, args.loss, args.seed, "states");
    let commands = Link::new(delay, jitter, args.loss, args.seed, "commands");
    let end = args.seconds.map_or(u64::MAX, |seconds| (seconds * 1e9) as u64);
    let mut wires = Wires { socket, machine, states, commands, peer: None, counts: [0; 3], lowest: f32::MAX };
    wires.serve(end, args.once)?;
    let [sent, received, ignored] = wires.counts;
    let lowest = wires.lowest;
    let value = json!({ "sent": sent, "received": received, "ignored": ignored, "lowest_root_height": lowest });
    output.result(&value, || {
        format!(
            "{sent} states sent, {received} commands received, {ignored} packets ignored; lowest root {lowest:.2} m\n"
        )
    })
}

/// A machine, its wires, and who is at the other end.
struct Wires {
    socket: UdpSocket,
    machine: SimulatedRobot,
    states: Link<Vec<u8>>,
    commands: Link<Received>,
    peer: Option<SocketAddr>,
    /// Sent, received, ignored.
    counts: [u64; 3],
    /// Least height of the root since it was let go (m).
    lowest: f32,
}

impl Wires {
    /// Runs in real time until a time (ns), Ctrl-C, or with `once` until motors were driven and are off.
    fn serve(&mut self, end: u64, once: bool) -> Result<(), CliError> {
        let stop = crate::interrupt::flag()?;
        let joints = self.machine.facts().joints.len();
        let (mut state, mut bytes) = (Measurement::new(joints), Vec::new());
        // A robot's own boards are not delayed by other programs.
        scheduling::real_time().iter().for_each(|line| tracing::debug!("{line}"));
        let mut clock = MonotonicClock::start();
        let (step, mut next) = (self.machine.step_ns(), 0);
        let mut newest: Option<u32> = None;
        // Wires are looked at more often than physics steps.
        let glance = (step / 5).max(200_000);
        while clock.now() < end && !stop.load(Ordering::Relaxed) {
            let deadline = (clock.now() + glance).min(next);
            let now = clock.wait_until(deadline);
            self.read(now, joints);
            while let Some(command) = self.commands.receive(now) {
                let is_newer = newest.is_none_or(|newest| command.sequence.wrapping_sub(newest) < 1 << 31);
                // A command that was overtaken is of the past; a new runtime begins again.
                if is_newer || command.sequence < 10 {
                    newest = Some(command.sequence);
                    self.machine.command(&command);
                    if once && command.mode == Mode::Off && self.machine.seconds().is_some() {
                        return Ok(());
                    }
                }
            }
            if now >= next {
                next += step;
                self.machine.advance()?;
                if self.machine.measure(&mut state) {
                    packet::write_state(&state, &mut bytes);
                    self.states.send(now, bytes.clone());
                }
                if self.machine.seconds().is_some() {
                    self.lowest = self.lowest.min(self.machine.simulation().state().root_position[2]);
                }
            }
            while let Some(bytes) = self.states.receive(now) {
                let Some(peer) = self.peer else { continue };
                self.counts[0] += u64::from(self.socket.send_to(&bytes, peer).is_ok());
            }
        }
        Ok(())
    }

    /// Reads all packets that have arrived.
    fn read(&mut self, now: u64, joints: usize) {
        let (mut buffer, mut answer) = ([0; 2048], Vec::new());
        let mut command = Received::new(joints);
        while let Ok((length, peer)) = self.socket.recv_from(&mut buffer) {
            let bytes = &buffer[..length];
            match packet::kind(bytes) {
                Some(Kind::Question) => {
                    self.peer = Some(peer);
                    packet::write_facts(self.machine.facts(), &mut answer);
                    let _ = self.socket.send_to(&answer, peer);
                }
                Some(Kind::Command) if packet::read_command(bytes, &mut command) => {
                    self.peer = Some(peer);
                    self.counts[1] += 1;
                    self.commands.send(now, command.clone());
                }
                _ => self.counts[2] += 1,
            }
        }
    }
}
