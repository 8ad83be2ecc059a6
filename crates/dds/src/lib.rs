//! Floor 5: buses of the runtime over DDS.
//!
//! [`unitree`] drives a G1 by its topics `rt/lowcmd` and `rt/lowstate`; [`ros2`] a robot under ROS 2. Both describe the machine
//! before a thread of their own serves it ([`lifelike_runtime::ThreadedBus`]). DDS is `rustdds`; messages are bytes of
//! `lifelike-cdr`.

mod participant;
mod ros2;
mod ros2_messages;
mod unitree;

pub use ros2::{Ros2Options, ros2};
pub use ros2_messages::{Imu, JointState, JointTrajectory};
pub use unitree::unitree;
