//! The IMU of a robot of servos: packets over UDP.

use std::net::UdpSocket;
use std::time::{Duration, Instant};

use lifelike_runtime::udp::packet;
use lifelike_runtime::{Measurement, RuntimeError};

/// Longest wait for the first packet.
const PATIENCE: Duration = Duration::from_secs(3);
/// Age at which a reading does not count any more.
const STALE: Duration = Duration::from_millis(50);

/// A port that receives packets of kind "state" with no joints ([`lifelike_runtime::udp::packet`]).
///
/// They carry orientation, gyroscope, accelerometer, the stop button, and the root's state of motion capture where there is one.
pub(crate) struct Imu {
    socket: UdpSocket,
    newest: Option<Instant>,
    packet: Measurement,
    buffer: [u8; 512],
}

impl Imu {
    /// Listens on an address `HOST:PORT` and waits for the first packet.
    pub(crate) fn listen(bus: &str, address: &str) -> Result<Self, RuntimeError> {
        let fails = |expected: &str, got: String| RuntimeError::Bus { bus: bus.into(), expected: expected.into(), got };
        let open = || {
            let socket = UdpSocket::bind(address)?;
            socket.set_nonblocking(true)?;
            Ok(socket)
        };
        let socket = open().map_err(|error: std::io::Error| {
            fails("an address HOST:PORT of this computer for imu=", error.to_string())
        })?;
        let mut imu = Self { socket, newest: None, packet: Measurement::new(0), buffer: [0; 512] };
        let begin = Instant::now();
        let mut others = 0;
        while imu.fresh().is_none() {
            others += imu.receive().map_err(|error| fails("packets of the IMU", error.to_string()))?;
            if begin.elapsed() > PATIENCE {
                let got = if others > 0 { format!("{others} other packets") } else { "none".into() };
                let expected = format!(
                    "a packet of the IMU on {address} within 3 s: the gate compares the root's tilt, and servos measure none"
                );
                return Err(fails(&expected, got));
            }
            std::thread::sleep(Duration::from_millis(1));
        }
        Ok(imu)
    }

    /// Reads what has arrived; returns the number of packets that were none of an IMU.
    pub(crate) fn receive(&mut self) -> std::io::Result<u32> {
        let mut others = 0;
        loop {
            match self.socket.recv(&mut self.buffer) {
                Ok(length) if packet::read_state(&self.buffer[..length], &mut self.packet) => {
                    self.newest = Some(Instant::now());
                }
                Ok(_) => others += 1,
                Err(error) if error.kind() == std::io::ErrorKind::WouldBlock => return Ok(others),
                Err(error) => return Err(error),
            }
        }
    }

    /// Returns the newest reading; none where it is too old.
    pub(crate) fn fresh(&self) -> Option<&Measurement> {
        self.newest.filter(|time| time.elapsed() < STALE).map(|_| &self.packet)
    }
}
