//! Requests and answers on a serial port.

use std::io::ErrorKind;
use std::time::{Duration, Instant};

use serial2::SerialPort;

use crate::packet::{Instruction, write_packet};
use crate::reader::{Packet, PacketReader};

/// Longest wait for an answer beyond the time of its bytes: the adapter's own delay, and a scheduler's.
pub(crate) const SLACK: Duration = Duration::from_millis(4);
/// The same before the first command, where nothing is late.
const PATIENCE: Duration = Duration::from_millis(30);
/// Requests to one servo before it counts as silent.
const TRIES: usize = 3;
/// Bytes of an answer to one servo's request, at most.
const ANSWER: usize = 32;
/// Bit of an answer's error that says that the servo has a hardware error.
pub(crate) const ALERT: u8 = 0x80;

/// A serial port with servos.
pub(crate) struct Line {
    port: SerialPort,
    reader: PacketReader,
    baud: u32,
    /// The packet that is sent next.
    pub(crate) out: Vec<u8>,
}

impl Line {
    /// Opens a port at a baud rate (bits/s).
    pub(crate) fn open(path: &str, baud: u32) -> std::io::Result<Self> {
        let mut port = SerialPort::open(path, baud)?;
        port.set_read_timeout(Duration::from_millis(1))?;
        port.set_write_timeout(Duration::from_millis(20))?;
        Ok(Self { port, reader: PacketReader::default(), baud, out: Vec::with_capacity(1024) })
    }

    /// Sends [`Self::out`]. Answers that were late are dropped.
    pub(crate) fn send(&mut self) -> std::io::Result<()> {
        self.port.discard_input_buffer()?;
        self.reader = PacketReader::default();
        self.port.write_all(&self.out)
    }

    /// Passes answers to `take` until it returns true; returns after the time of `bytes` and `slack` at the latest.
    pub(crate) fn collect(
        &mut self,
        bytes: usize,
        slack: Duration,
        mut take: impl FnMut(Packet) -> bool,
    ) -> std::io::Result<()> {
        let end = Instant::now() + wire_time(self.out.len() + bytes, self.baud) + slack;
        let mut buffer = [0; 512];
        loop {
            match self.port.read(&mut buffer) {
                Ok(0) => return Err(ErrorKind::UnexpectedEof.into()),
                Ok(length) => self.reader.push(&buffer[..length]),
                Err(error) if matches!(error.kind(), ErrorKind::TimedOut | ErrorKind::WouldBlock) => {}
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) => return Err(error),
            }
            while let Some(packet) = self.reader.next_packet() {
                // Some adapters echo what is sent.
                if packet.instruction == Instruction::Status as u8 && take(packet) {
                    return Ok(());
                }
            }
            if Instant::now() > end {
                return Ok(());
            }
        }
    }

    /// Asks one servo, and returns its answer: error, then the rest; none where it stays silent.
    pub(crate) fn ask(&mut self, id: u8, instruction: Instruction, content: &[u8]) -> std::io::Result<Option<Vec<u8>>> {
        for _ in 0..TRIES {
            write_packet(id, instruction, content.iter().copied(), &mut self.out);
            self.send()?;
            let mut answer = None;
            self.collect(ANSWER, PATIENCE, |packet| {
                answer = (packet.id == id && !packet.parameters.is_empty()).then_some(packet.parameters);
                answer.is_some()
            })?;
            if answer.is_some() {
                return Ok(answer);
            }
        }
        Ok(None)
    }

    /// Reads `length` bytes at an address of one servo; none where it stays silent or refuses.
    pub(crate) fn read(&mut self, id: u8, address: u16, length: u16) -> std::io::Result<Option<Vec<u8>>> {
        let [[a, b], [c, d]] = [address.to_le_bytes(), length.to_le_bytes()];
        let answer = self.ask(id, Instruction::Read, &[a, b, c, d])?;
        Ok(answer.map(|bytes| bytes[1..].to_vec()).filter(|bytes| bytes.len() == usize::from(length)))
    }

    /// Writes bytes to an address of one servo; returns whether it took them.
    pub(crate) fn write(&mut self, id: u8, address: u16, value: &[u8]) -> std::io::Result<bool> {
        let content = [&address.to_le_bytes(), value].concat();
        let answer = self.ask(id, Instruction::Write, &content)?;
        Ok(answer.is_some_and(|bytes| bytes[0] & !ALERT == 0))
    }
}

/// Returns the time of bytes on a line: ten bits each, with start and stop.
pub(crate) fn wire_time(bytes: usize, baud: u32) -> Duration {
    Duration::from_secs_f64(10.0 * bytes as f64 / f64::from(baud))
}
