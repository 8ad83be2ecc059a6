//! Floor 4: Dynamixel servos of the X series on a serial port, by protocol 2.0.
//!
//! [`dynamixel()`] is the bus: it checks every servo of a [`ServoFile`], and a thread of its own reads and writes them all in each cycle
//! ([`lifelike_runtime::ThreadedBus`]). [`write_packet`], [`sync_read`] and [`sync_write`] make packets; [`PacketReader`] finds the
//! answers in a stream of bytes.

mod bus;
mod connect;
mod imu;
mod line;
mod model;
mod packet;
mod reader;
mod servos;

pub use connect::{DynamixelOptions, dynamixel};
pub use model::{Model, address};
pub use packet::{BROADCAST, Instruction, sync_read, sync_write, write_packet};
pub use reader::{Defects, Packet, PacketReader};
pub use servos::{OperatingMode, Servo, ServoFile};
