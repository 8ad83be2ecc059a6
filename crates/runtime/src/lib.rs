//! Floor 3: a controller on a machine.
//!
//! The main path: [`Bus`] → [`Supervisor`] → [`drive()`]. The supervisor owns the controller, the reference, the state machine
//! ([`Phase`]) and the [`gate::Gate`]. It is a function of time, packets and requests, so a [`record`] replays bit for bit.
//! [`drive()`] calls it on a real-time clock, or on a virtual one in tests.
//!
//! Only the gate makes a [`SafeCommand`], and a bus sends nothing else. [`handshake`] refuses a machine that is not the one
//! of the controller. The crate contains no physics and no training.

pub mod bus;
pub mod clock;
pub mod config;
pub mod drive;
pub mod error;
pub mod estimator;
pub mod gate;
pub mod handshake;
pub mod motions;
pub mod packets;
pub mod phase;
pub mod record;
pub mod replay;
mod rescue;
pub mod scheduling;
pub mod supervisor;
pub mod threaded;
pub mod timing;
pub mod udp;
pub mod wiggle;

pub use bus::{Bus, External, Facts, Measurement};
pub use clock::{Clock, MonotonicClock, RecordedClock, VirtualClock};
pub use config::Config;
pub use drive::{Summary, drive};
pub use error::RuntimeError;
pub use estimator::{Estimate, StateEstimator};
pub use gate::{Limits, Mode, SafeCommand, Trip};
pub use lifelike_checkpoint::FromInput;
pub use motions::Playlist;
pub use phase::{Phase, Request};
pub use supervisor::Supervisor;
pub use threaded::{ThreadedBus, Wire};
