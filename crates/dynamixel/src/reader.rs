//! Packets in a stream of bytes.

use crate::packet::{HEADER, crc};

/// Longest content that is believed (bytes): no servo answers with more.
const MOST: usize = 1024;
/// Header, identifier and length.
const HEAD: usize = 7;

/// A packet with a right checksum.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Packet {
    /// The servo.
    pub id: u8,
    /// Instruction; 0x55 for an answer.
    pub instruction: u8,
    /// Parameters; the first one of an answer is its error.
    pub parameters: Vec<u8>,
}

/// Counts of what was no packet.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Defects {
    /// Bytes between packets.
    pub skipped: u64,
    /// Packets with another checksum, or too long.
    pub refused: u64,
}

/// A reader of a stream: bytes go in as they arrive, packets come out.
#[derive(Debug, Clone, Default)]
pub struct PacketReader {
    bytes: Vec<u8>,
    defects: Defects,
}

impl PacketReader {
    /// Adds bytes that have arrived.
    pub fn push(&mut self, bytes: &[u8]) {
        self.bytes.extend_from_slice(bytes);
    }

    /// Returns counts of what was no packet.
    pub fn defects(&self) -> Defects {
        self.defects
    }

    /// Returns the next whole packet; none until more bytes arrive.
    pub fn next_packet(&mut self) -> Option<Packet> {
        loop {
            let begin = self.bytes.windows(HEADER.len()).position(|window| window == HEADER);
            // The beginning of a header may be at the end.
            let skipped = begin.unwrap_or(self.bytes.len().saturating_sub(HEADER.len() - 1));
            self.bytes.drain(..skipped);
            self.defects.skipped += skipped as u64;
            begin?;
            let head = self.bytes.get(..HEAD)?;
            let length = usize::from(u16::from_le_bytes([head[5], head[6]]));
            if !(3..=MOST).contains(&length) {
                self.refuse();
                continue;
            }
            let packet = self.bytes.get(..HEAD + length)?;
            let (content, sum) = packet.split_at(packet.len() - 2);
            if crc(content).to_le_bytes() != *sum {
                self.refuse();
                continue;
            }
            let (id, body) = (content[4], unstuffed(&content[HEAD..]));
            self.bytes.drain(..HEAD + length);
            let (instruction, parameters) = body.split_first()?;
            return Some(Packet { id, instruction: *instruction, parameters: parameters.to_vec() });
        }
    }

    /// Goes on behind a header that begins no packet.
    fn refuse(&mut self) {
        self.bytes.drain(..HEADER.len());
        self.defects.refused += 1;
    }
}

/// Returns the content without the bytes that were put behind what looks like a header.
fn unstuffed(bytes: &[u8]) -> Vec<u8> {
    let mut out: Vec<u8> = Vec::with_capacity(bytes.len());
    let mut rest = bytes.iter().copied();
    while let Some(byte) = rest.next() {
        out.push(byte);
        if out.ends_with(&HEADER[..3]) {
            rest.next();
        }
    }
    out
}
