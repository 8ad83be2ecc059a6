//! Packets of protocol 2.0.
//!
//! ```text
//! FF FF FD 00 | id | length (u16) | instruction, parameters, with FD after each FF FF FD | CRC-16 (u16)
//! ```
//! Equation and layout: ROBOTIS e-Manual, "Protocol 2.0". Packets are held to the package `dynamixel-sdk` byte for byte
//! (`peers/dynamixel/fixtures.py`).

/// Identifier of all servos of a bus.
pub const BROADCAST: u8 = 0xFE;

/// Instruction of a packet.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum Instruction {
    /// Is the servo there?
    Ping = 0x01,
    /// Read of one servo.
    Read = 0x02,
    /// Write to one servo.
    Write = 0x03,
    /// Answer of a servo; its first parameter is an error.
    Status = 0x55,
    /// Read of several servos at one address.
    SyncRead = 0x82,
    /// Write to several servos at one address.
    SyncWrite = 0x83,
}

pub(crate) const HEADER: [u8; 4] = [0xFF, 0xFF, 0xFD, 0x00];

/// Writes a packet in place of what is in the buffer. Allocates nothing when `out` has room.
pub fn write_packet(id: u8, instruction: Instruction, parameters: impl IntoIterator<Item = u8>, out: &mut Vec<u8>) {
    out.clear();
    out.extend_from_slice(&HEADER);
    out.extend_from_slice(&[id, 0, 0]);
    let begin = out.len();
    for byte in std::iter::once(instruction as u8).chain(parameters) {
        out.push(byte);
        // Nothing within a packet looks like a header.
        if out[begin..].ends_with(&HEADER[..3]) {
            out.push(0xFD);
        }
    }
    let length = (out.len() - begin + 2) as u16;
    out[begin - 2..begin].copy_from_slice(&length.to_le_bytes());
    let crc = crc(out);
    out.extend_from_slice(&crc.to_le_bytes());
}

/// Writes a request for `length` bytes at an address of each servo; they answer one after the other.
pub fn sync_read(address: u16, length: u16, ids: &[u8], out: &mut Vec<u8>) {
    let [[a, b], [c, d]] = [address.to_le_bytes(), length.to_le_bytes()];
    write_packet(BROADCAST, Instruction::SyncRead, [a, b, c, d].into_iter().chain(ids.iter().copied()), out);
}

/// Writes a value of `N` bytes, such as a goal position, to an address of each servo.
pub fn sync_write<const N: usize>(address: u16, values: impl IntoIterator<Item = (u8, [u8; N])>, out: &mut Vec<u8>) {
    let [[a, b], [c, d]] = [address.to_le_bytes(), (N as u16).to_le_bytes()];
    let values = values.into_iter().flat_map(|(id, value)| std::iter::once(id).chain(value));
    write_packet(BROADCAST, Instruction::SyncWrite, [a, b, c, d].into_iter().chain(values), out);
}

/// Returns the CRC-16 with polynomial 0x8005, most significant bit first, from zero.
pub(crate) fn crc(bytes: &[u8]) -> u16 {
    bytes.iter().fold(0, |crc, byte| {
        (0..8).fold(crc ^ u16::from(*byte) << 8, |crc, _| {
            let carry = if crc & 0x8000 != 0 { 0x8005 } else { 0 };
            crc << 1 ^ carry
        })
    })
}
