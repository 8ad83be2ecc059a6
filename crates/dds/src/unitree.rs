//! Unitree's G1 (HG) over DDS.

use std::time::{Duration, Instant};

use lifelike_robot::Robot;
use lifelike_runtime::udp::packet::Received;
use lifelike_runtime::{Facts, Measurement, RuntimeError, ThreadedBus, Wire};
use lifelike_unitree::{LowCmd, LowState, Motors, command, measure};

use crate::participant::{Participant, Reader, Writer};

const STATES: (&str, &str) = ("rt/lowstate", "unitree_hg::msg::dds_::LowState_");
const COMMANDS: (&str, &str) = ("rt/lowcmd", "unitree_hg::msg::dds_::LowCmd_");
/// Unitree's domain.
const DOMAIN: u16 = 0;
/// Longest wait for the first state, and time in which states are counted.
const PATIENCE: Duration = Duration::from_secs(3);
const COUNTING: Duration = Duration::from_secs(1);
/// Most commands per second that the robot takes (Hz), as Unitree's own state machine sends them.
const COMMAND_HZ: f64 = 1000.0;

/// Connects to a G1 on a network interface (a name or an address), and describes it for the handshake.
///
/// `mode_machine` is the hardware revision that the controller was made for. Without it a robot of 29 joints is expected to say
/// 5, and one of 23 joints 4 (`g1_description` of the repository `unitree_ros`). Gains and limits are sent with every command,
/// or are not told by the robot: they are taken from `robot`.
///
/// # Errors
/// There is no such interface; no state with a right checksum arrives within 3 s; a joint is none of the G1's.
pub fn unitree(interface: &str, mode_machine: Option<u8>, robot: &Robot) -> Result<ThreadedBus, RuntimeError> {
    let bus = format!("unitree:{interface}");
    let fails = |expected: &str, got: String| RuntimeError::Bus { bus: bus.clone(), expected: expected.into(), got };
    let motors = Motors::of(&robot.layout.joints);
    let motors = motors.map_err(|error| fails("a robot with the joints of the G1", error.to_string()))?;
    let participant = Participant::join(&bus, DOMAIN, interface)?;
    let mut states = participant.read(STATES.0, STATES.1)?;
    let failed = |error: std::io::Error| fails("states on rt/lowstate", error.to_string());
    let (begin, mut first, mut last): (_, _, Option<LowState>) = (Instant::now(), None, None);
    let (mut count, mut damaged, mut tick_step) = (0u32, 0u32, u32::MAX);
    loop {
        while let Some(bytes) = states.next().map_err(failed)? {
            match LowState::read(&bytes) {
                Ok(state) => {
                    // States come every second millisecond, and their count is one of milliseconds. Some are lost.
                    let step = last.as_ref().map_or(0, |last| state.tick.wrapping_sub(last.tick));
                    tick_step = if step > 0 { tick_step.min(step) } else { tick_step };
                    (last, count) = (Some(state), count + 1);
                }
                Err(_) => damaged += 1,
            }
            first = first.or_else(|| last.as_ref().map(|_| Instant::now()));
        }
        if begin.elapsed() > PATIENCE && last.is_none() {
            let got = if damaged > 0 { format!("{damaged} damaged messages") } else { "none".into() };
            return Err(fails("a state on rt/lowstate within 3 s: start the robot, or check the interface", got));
        }
        if first.is_some_and(|time| time.elapsed() > COUNTING) {
            break;
        }
        std::thread::sleep(Duration::from_millis(1));
    }
    let (Some(state), Some(time)) = (last, first) else { return Err(fails("states", "none".into())) };
    let mut facts = Facts::of(robot, f64::from(count) / time.elapsed().as_secs_f64(), COMMAND_HZ);
    let expected = mode_machine.unwrap_or(if robot.joints() == 23 { 4 } else { 5 });
    if state.mode_machine != expected {
        facts.robot = format!("a G1 of mode_machine {} in place of {expected}", state.mode_machine);
    }
    facts.motors = motors.healthy(&state);
    if participant.is_written(COMMANDS.0) {
        facts.mode = "that of another program, which sends rt/lowcmd (release it by the motion switcher)".into();
    }
    let commands = participant.write(COMMANDS.0, COMMANDS.1)?;
    let wire = G1 {
        motors,
        mode_machine: state.mode_machine,
        tick_step,
        states,
        commands,
        low: LowCmd::default(),
        _participant: participant,
    };
    Ok(ThreadedBus::start(facts, wire))
}

/// The topics of a G1.
struct G1 {
    motors: Motors,
    mode_machine: u8,
    /// Milliseconds between two states.
    tick_step: u32,
    states: Reader,
    commands: Writer,
    low: LowCmd,
    _participant: Participant,
}

impl Wire for G1 {
    fn receive(&mut self, into: &mut Measurement) -> std::io::Result<bool> {
        while let Some(bytes) = self.states.next()? {
            // A damaged message is a lost one. One of another revision is not the robot of the handshake.
            if let Ok(state) = LowState::read(&bytes)
                && state.mode_machine == self.mode_machine
            {
                measure(&state, &self.motors, self.tick_step, into);
                return Ok(true);
            }
        }
        Ok(false)
    }

    fn send(&mut self, safe: &Received) -> std::io::Result<()> {
        command(safe, &self.motors, self.mode_machine, &mut self.low);
        let mut bytes = Vec::new();
        self.low.write(&mut bytes);
        self.commands.send(bytes)
    }
}
