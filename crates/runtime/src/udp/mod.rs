//! A robot behind UDP: its packets, and the bus that speaks them.

mod bus;
pub mod packet;

pub use bus::UdpBus;
