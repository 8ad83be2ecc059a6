//! The runtime's side of UDP.

use std::net::UdpSocket;
use std::time::{Duration, Instant};

use super::packet::{self, Kind, MAX_BYTES};
use crate::bus::{Bus, Facts, Measurement};
use crate::error::RuntimeError;
use crate::gate::SafeCommand;

/// Longest wait for the robot's facts.
const PATIENCE: Duration = Duration::from_secs(3);

/// A robot behind UDP, such as `lifelike simulate-robot`.
#[derive(Debug)]
pub struct UdpBus {
    socket: UdpSocket,
    address: String,
    start: Instant,
    inbox: Vec<u8>,
    outbox: Vec<u8>,
}

impl UdpBus {
    /// Connects to a robot at `HOST:PORT`.
    ///
    /// # Errors
    /// The address is none, or no socket can be opened.
    pub fn connect(address: &str) -> Result<Self, RuntimeError> {
        let open = || {
            let socket = UdpSocket::bind("0.0.0.0:0")?;
            socket.connect(address)?;
            socket.set_nonblocking(true)?;
            Ok(socket)
        };
        let socket = open().map_err(|error: std::io::Error| RuntimeError::Bus {
            bus: format!("sim:{address}"),
            expected: "an address HOST:PORT".into(),
            got: error.to_string(),
        })?;
        let (inbox, outbox) = (vec![0; MAX_BYTES], Vec::with_capacity(MAX_BYTES));
        Ok(Self { socket, address: address.into(), start: Instant::now(), inbox, outbox })
    }

    /// Returns the bytes of the next packet; none when none is waiting.
    fn next(&mut self) -> std::io::Result<Option<usize>> {
        match self.socket.recv(&mut self.inbox) {
            Ok(length) => Ok(Some(length)),
            Err(error) if error.kind() == std::io::ErrorKind::WouldBlock => Ok(None),
            Err(error) => Err(error),
        }
    }
}

impl Bus for UdpBus {
    fn facts(&mut self) -> Result<Facts, RuntimeError> {
        let begin = Instant::now();
        let mut got = "no answer".to_string();
        while begin.elapsed() < PATIENCE {
            packet::write_question(&mut self.outbox);
            if let Err(error) = self.socket.send(&self.outbox) {
                got = error.to_string();
            }
            std::thread::sleep(Duration::from_millis(50));
            // Nobody listens yet: asking again is all there is to do.
            while let Ok(Some(length)) = self.next() {
                if packet::kind(&self.inbox[..length]) != Some(Kind::Facts) {
                    continue;
                }
                if let Some(facts) = packet::read_facts(&self.inbox[..length]) {
                    return Ok(facts);
                }
                got = "facts that this version does not know".into();
            }
        }
        let expected = "the robot's facts within 3 s: start it, or check the address".into();
        Err(RuntimeError::Bus { bus: format!("sim:{}", self.address), expected, got })
    }

    fn receive(&mut self, into: &mut Measurement) -> std::io::Result<bool> {
        while let Some(length) = self.next()? {
            if packet::read_state(&self.inbox[..length], into) {
                return Ok(true);
            }
        }
        Ok(false)
    }

    fn send(&mut self, command: &SafeCommand) -> std::io::Result<()> {
        packet::write_command(command, self.start.elapsed().as_nanos() as u64, &mut self.outbox);
        self.socket.send(&self.outbox).map(|_| ())
    }
}
