//! Floor 4: messages of Unitree's HG robots (G1).
//!
//! [`LowCmd`] and [`LowState`] are the messages of the topics `rt/lowcmd` and `rt/lowstate`, in DDS domain 0. They are
//! encoded as CDR, little-endian, with the four bytes of its header. [`G1_MOTORS`] names the motors. [`command`] and
//! [`measure`] convert from and to the runtime.
//!
//! Field names are Unitree's. Layouts and checksums are held to the package `unitree_dds_wrapper` byte for byte
//! (`peers/unitree/fixtures.py`). The transport is that of `lifelike-dds`.

mod convert;
mod crc;
mod messages;

pub use convert::{G1_MOTORS, Motors, MotorsError, command, measure};
pub use messages::{ImuState, LowCmd, LowState, MOTORS, MessageError, MotorCmd, MotorState};
