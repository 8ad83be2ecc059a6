//! Packets of a robot over UDP, little-endian, at most [`MAX_BYTES`] long.
//!
//! | bytes | type | content |
//! | --- | --- | --- |
//! | 0 | u32 | `0x424F524C`, "LROB" |
//! | 4 | u16 | [`VERSION`] |
//! | 6 | u16 | kind: 1 question, 2 facts, 3 state, 4 command |
//! | 8 | u32 | sequence |
//! | 12 | u16 | joints J |
//! | 14 | u16 | flags: of a state 1 stop button, 2 external root state; of a command the mode (0 off, 1 damp, 2 position) |
//! | 16 | u64 | time of the sender's clock (ns) |
//! | 24 | | content |
//! | last 4 | u32 | CRC-32 (IEEE) of everything before |
//!
//! A question has no content. Facts are JSON ([`Facts`]). A state is f32: orientation `wxyz`, gyroscope, accelerometer,
//! battery (V), root position, root velocity, then position, velocity, torque and temperature of each joint. A command is f32: target, kp and
//! kd of each joint. Fields that are not measured are NaN.

use crate::bus::{External, Facts, Measurement};
use crate::gate::{Mode, SafeCommand};

/// Version of the layout.
pub const VERSION: u16 = 2;
/// Largest packet (bytes).
pub const MAX_BYTES: usize = 32 * 1024;
const MAGIC: u32 = 0x424F_524C;
const HEADER: usize = 24;
const CRC: usize = 4;
const STATE_NUMBERS: usize = 17;
const STOP: u16 = 1;
const EXTERNAL: u16 = 2;

/// Kind of a packet.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// A question for facts.
    Question,
    /// Facts of the robot.
    Facts,
    /// A measurement.
    State,
    /// A command.
    Command,
}

/// A command as the robot's side reads it.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Received {
    /// Number of the command.
    pub sequence: u32,
    /// Control mode.
    pub mode: Mode,
    /// Joint targets, `[J]` (rad).
    pub position: Vec<f32>,
    /// Proportional gains, `[J]` (N m/rad).
    pub kp: Vec<f32>,
    /// Derivative gains, `[J]` (N m s/rad).
    pub kd: Vec<f32>,
}

impl Received {
    /// A command that turns motors off.
    pub fn new(joints: usize) -> Self {
        let zeros = || vec![0.0; joints];
        Self { sequence: 0, mode: Mode::Off, position: zeros(), kp: zeros(), kd: zeros() }
    }

    /// Copies a command that passed the gate.
    pub fn copy_from(&mut self, command: &SafeCommand) {
        (self.sequence, self.mode) = (command.sequence(), command.mode());
        self.position.copy_from_slice(command.position());
        self.kp.copy_from_slice(command.kp());
        self.kd.copy_from_slice(command.kd());
    }
}

fn begin(out: &mut Vec<u8>, kind: u16, sequence: u32, joints: usize, flags: u16, time: u64) {
    out.clear();
    out.extend_from_slice(&MAGIC.to_le_bytes());
    out.extend_from_slice(&VERSION.to_le_bytes());
    out.extend_from_slice(&kind.to_le_bytes());
    out.extend_from_slice(&sequence.to_le_bytes());
    out.extend_from_slice(&(joints as u16).to_le_bytes());
    out.extend_from_slice(&flags.to_le_bytes());
    out.extend_from_slice(&time.to_le_bytes());
}

fn end(out: &mut Vec<u8>) {
    let crc = crc32fast::hash(out);
    out.extend_from_slice(&crc.to_le_bytes());
}

fn put(out: &mut Vec<u8>, numbers: &[f32]) {
    numbers.iter().for_each(|x| out.extend_from_slice(&x.to_le_bytes()));
}

/// Writes a question for facts.
pub fn write_question(out: &mut Vec<u8>) {
    begin(out, 1, 0, 0, 0, 0);
    end(out);
}

/// Writes facts.
pub fn write_facts(facts: &Facts, out: &mut Vec<u8>) {
    begin(out, 2, 0, facts.joints.len(), 0, 0);
    // A description of strings and numbers is always JSON.
    out.extend(serde_json::to_vec(facts).unwrap_or_default());
    end(out);
}

/// Writes a measurement. Allocates nothing when `out` has room.
pub fn write_state(state: &Measurement, out: &mut Vec<u8>) {
    let flags = u16::from(state.stop) * STOP + u16::from(state.external.is_some()) * EXTERNAL;
    begin(out, 3, state.sequence, state.position.len(), flags, state.clock);
    put(out, &state.orientation);
    put(out, &state.gyroscope_b);
    put(out, &state.accelerometer_b);
    put(out, &[state.battery]);
    let external = state.external.unwrap_or(External { position: [f32::NAN; 3], linear_velocity_w: [f32::NAN; 3] });
    put(out, &external.position);
    put(out, &external.linear_velocity_w);
    for j in 0..state.position.len() {
        put(out, &[state.position[j], state.velocity[j], state.torque[j], state.temperature[j]]);
    }
    end(out);
}

/// Writes a command. Allocates nothing when `out` has room.
pub fn write_command(command: &SafeCommand, time: u64, out: &mut Vec<u8>) {
    begin(out, 4, command.sequence(), command.position().len(), command.mode() as u16, time);
    for j in 0..command.position().len() {
        put(out, &[command.position()[j], command.kp()[j], command.kd()[j]]);
    }
    end(out);
}

/// Returns the kind of a packet that is whole; none for anything else.
pub fn kind(bytes: &[u8]) -> Option<Kind> {
    if bytes.len() < HEADER + CRC || u32_at(bytes, 0)? != MAGIC || u16_at(bytes, 4)? != VERSION {
        return None;
    }
    let body = bytes.len() - CRC;
    if u32_at(bytes, body)? != crc32fast::hash(&bytes[..body]) {
        return None;
    }
    match u16_at(bytes, 6)? {
        1 => Some(Kind::Question),
        2 => Some(Kind::Facts),
        3 => Some(Kind::State),
        4 => Some(Kind::Command),
        _ => None,
    }
}

/// Reads facts.
pub fn read_facts(bytes: &[u8]) -> Option<Facts> {
    (kind(bytes)? == Kind::Facts).then(|| serde_json::from_slice(&bytes[HEADER..bytes.len() - CRC]).ok())?
}

/// Reads a measurement; returns false, and leaves it half written at worst, for anything else. Allocates nothing.
pub fn read_state(bytes: &[u8], into: &mut Measurement) -> bool {
    let joints = into.position.len();
    if !is(bytes, Kind::State, joints, STATE_NUMBERS + 4 * joints) {
        return false;
    }
    let x = |i: usize| f32_at(bytes, HEADER + 4 * i);
    into.sequence = u32_at(bytes, 8).unwrap_or_default();
    into.clock = u64_at(bytes, 16).unwrap_or_default();
    let flags = u16_at(bytes, 14).unwrap_or_default();
    into.stop = flags & STOP != 0;
    into.orientation = [x(0), x(1), x(2), x(3)];
    into.gyroscope_b = [x(4), x(5), x(6)];
    into.accelerometer_b = [x(7), x(8), x(9)];
    into.battery = x(10);
    let external = External { position: [x(11), x(12), x(13)], linear_velocity_w: [x(14), x(15), x(16)] };
    into.external = (flags & EXTERNAL != 0).then_some(external);
    for j in 0..joints {
        let at = STATE_NUMBERS + 4 * j;
        (into.position[j], into.velocity[j], into.torque[j], into.temperature[j]) =
            (x(at), x(at + 1), x(at + 2), x(at + 3));
    }
    true
}

/// Reads a command; returns false for anything else. Allocates nothing.
pub fn read_command(bytes: &[u8], into: &mut Received) -> bool {
    let joints = into.position.len();
    if !is(bytes, Kind::Command, joints, 3 * joints) {
        return false;
    }
    into.sequence = u32_at(bytes, 8).unwrap_or_default();
    into.mode = match u16_at(bytes, 14) {
        Some(1) => Mode::Damp,
        Some(2) => Mode::Position,
        _ => Mode::Off,
    };
    for j in 0..joints {
        let at = HEADER + 12 * j;
        (into.position[j], into.kp[j], into.kd[j]) = (f32_at(bytes, at), f32_at(bytes, at + 4), f32_at(bytes, at + 8));
    }
    true
}

fn is(bytes: &[u8], wanted: Kind, joints: usize, numbers: usize) -> bool {
    let fits = bytes.len() == HEADER + 4 * numbers + CRC && u16_at(bytes, 12) == Some(joints as u16);
    fits && kind(bytes) == Some(wanted)
}

fn array_at<const N: usize>(bytes: &[u8], at: usize) -> Option<[u8; N]> {
    bytes.get(at..at + N)?.try_into().ok()
}

fn u16_at(bytes: &[u8], at: usize) -> Option<u16> {
    array_at(bytes, at).map(u16::from_le_bytes)
}

fn u32_at(bytes: &[u8], at: usize) -> Option<u32> {
    array_at(bytes, at).map(u32::from_le_bytes)
}

fn u64_at(bytes: &[u8], at: usize) -> Option<u64> {
    array_at(bytes, at).map(u64::from_le_bytes)
}

fn f32_at(bytes: &[u8], at: usize) -> f32 {
    array_at(bytes, at).map_or(f32::NAN, f32::from_le_bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn state() -> Measurement {
        let mut state = Measurement::new(3);
        (state.sequence, state.clock, state.stop) = (7, 123_456_789_012, true);
        state.orientation = [0.5, -0.5, 0.5, 0.5];
        state.external = Some(External { position: [1.0, 2.0, 3.0], linear_velocity_w: [4.0, 5.0, 6.0] });
        (state.battery, state.gyroscope_b, state.accelerometer_b) = (24.5, [0.1, 0.2, 0.3], [0.5, -0.5, 9.75]);
        state.position = vec![0.25, -1.0, 2.0];
        (state.velocity, state.torque, state.temperature) = (vec![1.0; 3], vec![2.0; 3], vec![40.0; 3]);
        state
    }

    #[test]
    fn a_state_is_read_as_it_was_written() {
        let (mut bytes, mut read) = (Vec::new(), Measurement::new(3));
        write_state(&state(), &mut bytes);
        // The header by hand.
        assert_eq!(bytes[..16], *b"LROB\x02\x00\x03\x00\x07\x00\x00\x00\x03\x00\x03\x00");
        assert_eq!(bytes.len(), 24 + 4 * (17 + 12) + 4);
        assert_eq!(bytes[24..28], 0.5f32.to_le_bytes());
        assert!(read_state(&bytes, &mut read));
        assert_eq!(read, state());
        assert!(!read_state(&bytes, &mut Measurement::new(2)), "another number of joints");
    }

    #[test]
    fn a_packet_with_any_bit_turned_is_refused() {
        let mut bytes = Vec::new();
        write_state(&state(), &mut bytes);
        for bit in 0..8 * bytes.len() {
            let mut damaged = bytes.clone();
            damaged[bit / 8] ^= 1 << (bit % 8);
            assert_eq!(kind(&damaged), None, "bit {bit}");
        }
        (0..bytes.len()).for_each(|length| assert_eq!(kind(&bytes[..length]), None));
    }
}
