//! `--bus`: connections to machines by name.

use std::path::Path;

use lifelike_dynamixel::{DynamixelOptions, ServoFile, dynamixel};
use lifelike_robot::Robot;
use lifelike_runtime::record::Record;
use lifelike_runtime::replay::ReplayBus;
use lifelike_runtime::udp::UdpBus;
use lifelike_runtime::{Bus, Clock, Config, MonotonicClock};

use crate::error::CliError;

/// Buses as they are named.
const EXPECTED: &str = "sim:HOST:PORT, replay:FILE, dynamixel:PORT[,servos=FILE][,imu=HOST:PORT], \
    unitree:INTERFACE[,mode_machine=N] or ros2:DOMAIN[,interface=NAME][,states=TOPIC][,imu=TOPIC][,commands=TOPIC]";

/// A machine, and the clock of its loop.
pub(super) struct Connection {
    pub(super) bus: Box<dyn Bus>,
    pub(super) clock: Box<dyn Clock>,
}

impl Connection {
    fn now(bus: impl Bus + 'static) -> Self {
        Self { bus: Box::new(bus), clock: Box::new(MonotonicClock::start()) }
    }
}

/// Opens a bus by its name.
///
/// # Errors
/// The name is none of a bus; this build lacks it; the machine does not answer.
pub(super) fn connect(name: &str, robot: &Robot, config: &Config) -> Result<Connection, CliError> {
    match name.split_once(':') {
        Some(("sim", address)) => Ok(Connection::now(UdpBus::connect(address)?)),
        Some(("replay", file)) => {
            let bus = ReplayBus::new(&Record::read(Path::new(file))?)?;
            Ok(Connection { clock: Box::new(bus.clock()), bus: Box::new(bus) })
        }
        Some(("dynamixel", rest)) => {
            let (options, file) = servos(name, rest)?;
            Ok(Connection::now(dynamixel(&options, &file, robot, config.command_hz)?))
        }
        Some((kind @ ("unitree" | "ros2"), rest)) => over_dds(name, kind, rest, robot, config),
        _ => Err(wrong(name)),
    }
}

/// Returns the rate of commands that suits a bus where the user sets none (Hz); none where the default does.
///
/// # Errors
/// The name is none of a bus; the file of its servos is wrong.
pub(super) fn command_hz(name: &str, robot: &Robot) -> Result<Option<f64>, CliError> {
    match name.split_once(':') {
        Some(("dynamixel", rest)) => Ok(Some(servos(name, rest)?.1.command_hz(robot.control_hz))),
        _ => Ok(None),
    }
}

/// Reads the options of a bus of servos, and their file.
fn servos(name: &str, rest: &str) -> Result<(DynamixelOptions, ServoFile), CliError> {
    let mut parts = rest.split(',');
    let port = parts.next().filter(|port| !port.is_empty()).ok_or_else(|| wrong(name))?;
    let mut options = DynamixelOptions { port: port.into(), imu: String::new() };
    let mut file = "servos.toml";
    for part in parts {
        match part.split_once('=') {
            Some(("servos", path)) => file = path,
            Some(("imu", address)) => options.imu = address.into(),
            _ => return Err(wrong(name)),
        }
    }
    Ok((options, ServoFile::read(Path::new(file))?))
}

fn wrong(name: &str) -> CliError {
    CliError::Usage(format!("--bus: expected {EXPECTED}, got '{name}'"))
}

#[cfg(feature = "dds")]
fn over_dds(name: &str, kind: &str, rest: &str, robot: &Robot, config: &Config) -> Result<Connection, CliError> {
    let mut parts = rest.split(',');
    let first = parts.next().unwrap_or_default();
    let pairs = parts.map(|part| part.split_once('=').ok_or_else(|| wrong(name))).collect::<Result<Vec<_>, _>>()?;
    if kind == "unitree" {
        let mut mode_machine = None;
        for (key, value) in pairs {
            let number = value.parse().ok().filter(|_| key == "mode_machine");
            mode_machine = Some(number.ok_or_else(|| wrong(name))?);
        }
        return Ok(Connection::now(lifelike_dds::unitree(first, mode_machine, robot)?));
    }
    let domain = first.parse().map_err(|_| wrong(name))?;
    let mut options = lifelike_dds::Ros2Options { domain, ..Default::default() };
    for (key, value) in pairs {
        let option = match key {
            "interface" => &mut options.interface,
            "states" => &mut options.states,
            "imu" => &mut options.imu,
            "commands" => &mut options.commands,
            _ => return Err(wrong(name)),
        };
        *option = value.into();
    }
    Ok(Connection::now(lifelike_dds::ros2(&options, robot, config.command_hz)?))
}

#[cfg(not(feature = "dds"))]
fn over_dds(name: &str, _: &str, _: &str, _: &Robot, _: &Config) -> Result<Connection, CliError> {
    Err(CliError::Unavailable(format!(
        "--bus {name}: this build has no DDS; build it with: cargo build --release -p lifelike --features dds"
    )))
}
