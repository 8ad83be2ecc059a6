//! Rollouts as MCAP files that Foxglove, rerun and rosbag2 open.
//!
//! Messages are those of ROS 2. Frames `physics/BODY` and `reference/BODY` move in the frame `world`.
//!
//! | topic | message |
//! | --- | --- |
//! | `/tf` | bodies of physics and reference |
//! | `/joint_states` | positions (rad), velocities (rad/s), torques (N m) of physics |
//! | `/reference/joint_states` | positions of the reference |
//! | `/contacts/FOOT` | normal ground force on a foot (N) |
//! | `/robot`, `/reference/robot` | shapes, which move with the frames |

mod cdr;
mod schemas;
mod shapes;

use std::collections::BTreeMap;
use std::io::Cursor;

use ::mcap::records::MessageHeader;
use ::mcap::{McapError, WriteOptions, Writer};
use lifelike_character::Vec3;
use lifelike_robot::Robot;

use self::cdr::Message;
use crate::EvaluationError;
use crate::rollout::{Names, Rollout, Snapshot};

/// An MCAP file in the making.
struct File {
    writer: Writer<Cursor<Vec<u8>>>,
    channels: BTreeMap<String, (u16, u32)>,
}

impl File {
    /// Appends a message of a topic, whose channel is opened with the first one.
    fn write(&mut self, topic: &str, kind: &str, time: u64, message: Message) -> Result<(), McapError> {
        if !self.channels.contains_key(topic) {
            let schema = self.writer.add_schema(kind, "ros2msg", schemas::text(kind).as_bytes())?;
            let channel = self.writer.add_channel(schema, topic, "cdr", &BTreeMap::new())?;
            self.channels.insert(topic.to_string(), (channel, 0));
        }
        let Some((channel, sequence)) = self.channels.get_mut(topic) else { return Ok(()) };
        *sequence += 1;
        let header = MessageHeader { channel_id: *channel, sequence: *sequence, log_time: time, publish_time: time };
        self.writer.write_to_known_channel(&header, &message.into_bytes())
    }
}

/// Returns a rollout as the bytes of an MCAP file. Its clock begins at 0.
///
/// # Errors
/// [`EvaluationError::Record`].
pub fn mcap(rollout: &Rollout, robot: &Robot) -> Result<Vec<u8>, EvaluationError> {
    written(rollout, robot).map_err(|error| EvaluationError::Record(error.to_string()))
}

fn written(rollout: &Rollout, robot: &Robot) -> Result<Vec<u8>, McapError> {
    let options = WriteOptions::new().profile("ros2").library(concat!("lifelike ", env!("CARGO_PKG_VERSION")));
    let mut file = File { writer: options.create(Cursor::new(Vec::new()))?, channels: BTreeMap::new() };
    let names = &rollout.names;
    let weight = robot.character.mass() * robot.character.gravity.norm();
    let limits: Vec<f64> = robot.actuators.parameters.iter().map(|p| p.torque_max).collect();
    for (topic, prefix, ghost) in [("/robot", "physics", false), ("/reference/robot", "reference", true)] {
        file.write(topic, schemas::MARKERS, 0, shapes::markers(&robot.character, prefix, ghost))?;
    }
    let frames = rollout.simulated.len().min(rollout.reference.len());
    for frame in 0..frames {
        let time = (frame as f64 / rollout.fps * 1e9).round() as u64;
        let (physics, reference) = (&rollout.simulated[frame], &rollout.reference[frame]);
        file.write("/tf", schemas::TF, time, transforms(time, names, physics, reference))?;
        let (joints, feet) = (names.joints.len(), names.feet.len());
        let torque = rollout.torque_share.get(frame * joints..(frame + 1) * joints).unwrap_or_default();
        let torque: Vec<f64> = torque.iter().zip(&limits).map(|(share, limit)| f64::from(*share) * limit).collect();
        let velocity = velocities(&rollout.simulated, frame, rollout.fps);
        let states = |positions: &[f64], velocities: &[f64], torques: &[f64]| {
            let message = Message::new().header(time, "").texts(&names.joints);
            message.f64s(positions).f64s(velocities).f64s(torques)
        };
        file.write("/joint_states", schemas::JOINTS, time, states(&physics.joints, &velocity, &torque))?;
        let planned = velocities(&rollout.reference, frame, rollout.fps);
        file.write("/reference/joint_states", schemas::JOINTS, time, states(&reference.joints, &planned, &[]))?;
        for (foot, name) in names.feet.iter().enumerate() {
            let share = rollout.foot_force.get(frame * feet + foot).copied().unwrap_or_default();
            let force = Vec3::z() * (f64::from(share) * weight);
            let message = Message::new().header(time, "world").vector(&force).vector(&Vec3::zeros());
            file.write(&format!("/contacts/{name}"), schemas::WRENCH, time, message)?;
        }
    }
    file.writer.finish()?;
    Ok(file.writer.into_inner().into_inner())
}

/// Returns joint velocities by the difference to the frame before; zero in the first.
fn velocities(frames: &[Snapshot], frame: usize, fps: f64) -> Vec<f64> {
    let before = &frames[frame.saturating_sub(1)].joints;
    frames[frame].joints.iter().zip(before).map(|(now, was)| (now - was) * fps).collect()
}

/// Returns a `tf2_msgs/TFMessage` of all bodies but the world.
fn transforms(time: u64, names: &Names, physics: &Snapshot, reference: &Snapshot) -> Message {
    let figures = [("physics", physics), ("reference", reference)];
    let count: usize = figures.iter().map(|(_, snapshot)| snapshot.bodies.len().saturating_sub(1)).sum();
    let mut message = Message::new().len(count);
    for (prefix, snapshot) in figures {
        for (name, (position, orientation)) in names.bodies.iter().zip(&snapshot.bodies).skip(1) {
            message = message.header(time, "world").text(&format!("{prefix}/{name}")).pose(position, orientation);
        }
    }
    message
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::rollout::example::{rollout, snapshot};

    #[test]
    fn a_file_is_read_back_with_its_topics_times_and_numbers() {
        let robot = Robot::load("lima").unwrap();
        let mut one = rollout(3, |_| snapshot(Vec3::z(), 0.0, 0.0), |_| snapshot(Vec3::z(), 0.0, 0.25));
        one.fps = 50.0;
        let bytes = mcap(&one, &robot).unwrap();
        let messages: Vec<::mcap::Message> = ::mcap::MessageStream::new(&bytes).unwrap().map(Result::unwrap).collect();
        let messages_of = |topic: &str| messages.iter().filter(|m| m.channel.topic == topic).collect::<Vec<_>>();
        assert_eq!(messages_of("/tf").len(), 3);
        assert_eq!(messages_of("/robot").len(), 1);
        let last = messages_of("/joint_states")[2];
        assert_eq!((last.log_time, last.sequence), (40_000_000, 3), "two frames at 50 Hz");
        let schema = last.channel.schema.as_ref().unwrap();
        assert_eq!((schema.name.as_str(), schema.encoding.as_str()), (schemas::JOINTS, "ros2msg"));
        assert!(last.data.windows(8).any(|w| w == 0.25_f64.to_le_bytes()), "the joint's position");
    }
}
