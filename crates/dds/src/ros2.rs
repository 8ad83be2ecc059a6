//! A robot under ROS 2: `JointState` and `Imu` in, `JointTrajectory` out, as the controllers of `ros2_control` have them.

use std::time::{Duration, Instant};

use lifelike_robot::Robot;
use lifelike_runtime::udp::packet::Received;
use lifelike_runtime::{Facts, Measurement, Mode, RuntimeError, ThreadedBus, Wire};

use crate::participant::{Participant, Reader, Writer};
use crate::ros2_messages::{Imu, JointState, JointTrajectory};

/// Longest wait for all topics, and time in which states are counted.
const PATIENCE: Duration = Duration::from_secs(3);
const COUNTING: Duration = Duration::from_secs(1);
/// Age at which an IMU's reading does not count any more.
const STALE: Duration = Duration::from_millis(50);

/// Address of a robot under ROS 2.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Ros2Options {
    /// ROS_DOMAIN_ID.
    pub domain: u16,
    /// Network interface, by name or address; empty for all.
    pub interface: String,
    /// Topic of `sensor_msgs/JointState`.
    pub states: String,
    /// Topic of `sensor_msgs/Imu`.
    pub imu: String,
    /// Topic of `trajectory_msgs/JointTrajectory`.
    pub commands: String,
}

impl Default for Ros2Options {
    fn default() -> Self {
        Self {
            domain: 0,
            interface: String::new(),
            states: "/joint_states".into(),
            imu: "/imu/data".into(),
            commands: "/joint_trajectory_controller/joint_trajectory".into(),
        }
    }
}

/// Connects to a robot under ROS 2, and describes it for the handshake. Commands come at `command_hz` (Hz).
///
/// Joints are found by name, in any order and among others. ROS tells neither gains nor limits: they are taken from `robot`.
/// Positions alone are sent. A robot that should brake holds the pose in which it is.
///
/// # Errors
/// There is no such interface; a topic lacks its other end for 3 s.
pub fn ros2(options: &Ros2Options, robot: &Robot, command_hz: f64) -> Result<ThreadedBus, RuntimeError> {
    let bus = format!("ros2:{}", options.domain);
    let fails = |expected: String, got: &str| RuntimeError::Bus { bus: bus.clone(), expected, got: got.into() };
    let participant = Participant::join(&bus, options.domain, &options.interface)?;
    let mut states = participant.read(&topic(&options.states), "sensor_msgs::msg::dds_::JointState_")?;
    let mut imus = participant.read(&topic(&options.imu), "sensor_msgs::msg::dds_::Imu_")?;
    let commands = participant.write(&topic(&options.commands), "trajectory_msgs::msg::dds_::JointTrajectory_")?;
    let failed = |error: std::io::Error| fails("messages".into(), &error.to_string());
    let (begin, mut first, mut last, mut count) = (Instant::now(), None, None, 0u32);
    let (mut has_imu, mut is_read) = (false, false);
    loop {
        while let Some(bytes) = states.next().map_err(failed)? {
            if let Some(state) = JointState::read(&bytes) {
                (last, count) = (Some(state), count + 1);
                first = first.or(Some(Instant::now()));
            }
        }
        while let Some(bytes) = imus.next().map_err(failed)? {
            has_imu |= Imu::read(&bytes).is_some();
        }
        is_read = is_read || participant.is_read(&topic(&options.commands));
        let is_counted = first.is_some_and(|time| time.elapsed() > COUNTING);
        if is_counted && has_imu && is_read {
            break;
        }
        if begin.elapsed() > PATIENCE {
            let (what, name) = match (last.is_some(), has_imu) {
                (false, _) => ("a sensor_msgs/JointState on", &options.states),
                (true, false) => ("a sensor_msgs/Imu on", &options.imu),
                (true, true) => ("a controller that reads", &options.commands),
            };
            return Err(fails(format!("{what} {name} within 3 s: start it, or name its topic"), "none"));
        }
        std::thread::sleep(Duration::from_millis(1));
    }
    let (Some(state), Some(first)) = (last, first) else { return Err(fails("states".into(), "none")) };
    let mut facts = Facts::of(robot, f64::from(count) / first.elapsed().as_secs_f64(), command_hz);
    // Other joints, such as those of hands, are not the controller's.
    if !facts.joints.iter().all(|joint| state.name.contains(joint)) {
        facts.joints = state.name;
    }
    let wire = Ros2 {
        joints: robot.layout.joints.clone(),
        held: vec![0.0; robot.joints()],
        is_driven: false,
        period: (1e9 / command_hz) as u32,
        sequence: 0,
        begin,
        imu: None,
        states,
        imus,
        commands,
        _participant: participant,
    };
    Ok(ThreadedBus::start(facts, wire))
}

/// Returns the DDS name of a topic.
fn topic(name: &str) -> String {
    format!("rt/{}", name.trim_start_matches('/'))
}

/// The topics of a robot.
struct Ros2 {
    joints: Vec<String>,
    /// Positions of the last state (rad), to hold where motors should brake.
    held: Vec<f64>,
    is_driven: bool,
    /// Time between two commands (ns).
    period: u32,
    sequence: u32,
    begin: Instant,
    imu: Option<(Instant, Imu)>,
    states: Reader,
    imus: Reader,
    commands: Writer,
    _participant: Participant,
}

impl Ros2 {
    /// Writes a state as a measurement; returns false where a joint or the IMU's reading is missing.
    fn measure(&mut self, state: &JointState, into: &mut Measurement) -> bool {
        let Some((_, imu)) = self.imu.filter(|(time, _)| time.elapsed() < STALE) else { return false };
        for (j, joint) in self.joints.iter().enumerate() {
            let Some(i) = state.name.iter().position(|name| name == joint) else { return false };
            let (Some(position), Some(velocity)) = (state.position.get(i), state.velocity.get(i)) else {
                return false;
            };
            self.held[j] = *position;
            (into.position[j], into.velocity[j]) = (*position as f32, *velocity as f32);
            into.torque[j] = state.effort.get(i).map_or(f32::NAN, |torque| *torque as f32);
        }
        into.orientation = imu.orientation.map(|x| x as f32);
        into.gyroscope_b = imu.angular_velocity.map(|x| x as f32);
        // Drivers leave at zero what they do not measure.
        let is_measured = imu.linear_acceleration != [0.0; 3];
        into.accelerometer_b = imu.linear_acceleration.map(|x| if is_measured { x as f32 } else { f32::NAN });
        self.sequence = self.sequence.wrapping_add(1);
        into.sequence = self.sequence;
        // A driver may leave its time at zero.
        into.clock = if state.stamp > 0 { state.stamp } else { self.begin.elapsed().as_nanos() as u64 };
        true
    }
}

impl Wire for Ros2 {
    fn receive(&mut self, into: &mut Measurement) -> std::io::Result<bool> {
        while let Some(bytes) = self.imus.next()? {
            self.imu = Imu::read(&bytes).map(|imu| (Instant::now(), imu)).or(self.imu);
        }
        while let Some(bytes) = self.states.next()? {
            if JointState::read(&bytes).is_some_and(|state| self.measure(&state, into)) {
                return Ok(true);
            }
        }
        Ok(false)
    }

    fn send(&mut self, safe: &Received) -> std::io::Result<()> {
        let drives = safe.mode == Mode::Position;
        let was_driven = std::mem::replace(&mut self.is_driven, drives);
        if !drives && !was_driven {
            return Ok(());
        }
        let targets = safe.position.iter().map(|x| f64::from(*x)).collect();
        let positions = if drives { targets } else { self.held.clone() };
        let message = JointTrajectory { joint_names: self.joints.clone(), positions, time_from_start: self.period };
        let mut bytes = Vec::new();
        message.write(&mut bytes);
        self.commands.send(bytes)
    }
}
