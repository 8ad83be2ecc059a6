//! Records of runs: MCAP files that Foxglove and rerun open, and that [`crate::replay`] replays.
//!
//! | topic | content, one JSON object each |
//! | --- | --- |
//! | `/measured` | every packet that arrived, used or not |
//! | `/command` | every tick: time, request, phase, and the command that was sent |
//! | `/policy` | every policy step: the policy's targets, and the modelled heat of each motor |
//!
//! Metadata `lifelike` names robot, joints, settings and digests. Attachments hold the controller and the clips, so a record
//! needs no other file. Numbers that are not finite are null. A record that was cut off is readable to its last chunk.

mod message;
mod reader;
mod recorder;

pub use message::{CommandMessage, MeasuredMessage, PolicyMessage};
pub use reader::{Entry, Record};
pub use recorder::{Attachment, Recorder};

const MEASURED: &str = "/measured";
const COMMAND: &str = "/command";
const POLICY: &str = "/policy";
const METADATA: &str = "lifelike";
