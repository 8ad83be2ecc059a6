//! ROS 2 bags (MCAP) of `sensor_msgs/msg/JointState` as tables.
//!
//! A column is `JOINT.position` (rad or m), `JOINT.velocity` or `JOINT.effort`. If several topics have it, the topic
//! stands before it: `/joint_states/JOINT.position`. The rows are the messages with the first column that is asked
//! for. In every other column a row has the last value before it or at its time. The time is that of the message's
//! header.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use lifelike_cdr::{Reader, Records};
use mcap::records::Record;

use crate::AugmentationError;

/// The messages that are read.
const KIND: &str = "sensor_msgs/msg/JointState";
/// Names of ROS 1 and of older bags for the same.
const OLDER: &str = "sensor_msgs/JointState";
/// No record of a bag is larger (bytes), chunks included: rosbag2 writes chunks of a megabyte.
const LARGEST_RECORD: usize = 1 << 28;
/// The quantities of a joint, in the order of the message.
const QUANTITIES: [&str; 3] = ["position", "velocity", "effort"];

/// Times (s) and values of each quantity of a joint, by topic and name.
#[derive(Debug, Default)]
pub(super) struct Bag {
    columns: BTreeMap<[String; 2], Vec<[f64; 2]>>,
}

/// Times (s), and the values of each column.
type Rows = (Vec<f64>, Vec<Vec<f64>>);
/// An expectation, and what was found instead.
type Mismatch = (String, String);

impl Bag {
    /// Returns the rows of some columns: the time from the first row on (s), and the values of each column.
    ///
    /// # Errors
    /// The column that is not there, or in several topics, with what was expected and got.
    pub fn rows(&self, wanted: &[&str]) -> Result<Rows, Mismatch> {
        let all = wanted.iter().map(|name| self.column(name)).collect::<Result<Vec<_>, _>>()?;
        let Some(first) = all.first() else { return Ok((Vec::new(), Vec::new())) };
        let begin = all.iter().filter_map(|column| column.first()).map(|[time, _]| *time).fold(f64::MIN, f64::max);
        let rows: Vec<f64> = first.iter().map(|[time, _]| *time).filter(|time| *time >= begin).collect();
        let held = |column: &&[[f64; 2]]| -> Vec<f64> {
            let mut next = 0;
            let value_at = |time: &f64| {
                next += column[next..].iter().take_while(|[own, _]| own <= time).count();
                column[next.max(1) - 1][1]
            };
            rows.iter().map(value_at).collect()
        };
        let values = all.iter().map(held).collect();
        let start = rows.first().copied().unwrap_or(0.0);
        Ok((rows.iter().map(|time| time - start).collect(), values))
    }

    fn column(&self, wanted: &str) -> Result<&[[f64; 2]], Mismatch> {
        let is_it = |[topic, name]: &[String; 2]| name == wanted || wanted == format!("{topic}/{name}");
        let found: Vec<_> = self.columns.iter().filter(|(key, _)| is_it(key)).collect();
        match found.as_slice() {
            [(_, values)] => Ok(values),
            [] => {
                let known: Vec<String> = self.columns.keys().map(|[topic, name]| format!("{topic}/{name}")).collect();
                Err((format!("a column '{wanted}'"), known.join(", ")))
            }
            several => {
                let known: Vec<String> = several.iter().map(|([topic, name], _)| format!("{topic}/{name}")).collect();
                Err((format!("one topic with '{wanted}'"), known.join(", ")))
            }
        }
    }
}

/// Reads all topics of joint states from the bytes of a bag.
///
/// # Errors
/// [`AugmentationError::Log`]: no MCAP, a message that is cut off or of another encoding, no joint states.
pub(super) fn read(path: &Path, bytes: &[u8]) -> Result<Bag, AugmentationError> {
    let bad = |place: String, expected: &str, got: String| AugmentationError::log(path, place, expected, got);
    let expected = "a bag of ROS 2 (MCAP)";
    if bytes.starts_with(b"SQLite format 3") {
        let cure = "a bag in SQLite; `ros2 bag convert` writes one with storage_id: mcap";
        return Err(bad("MCAP".into(), expected, cure.into()));
    }
    let whole = |error: mcap::McapError| match error {
        mcap::McapError::UnsupportedCompression(kind) => {
            let cure = format!("chunks compressed by {kind}; `mcap compress --compression zstd` writes others");
            bad("MCAP".into(), "chunks without compression or with zstd", cure)
        }
        error => bad("MCAP".into(), expected, error.to_string()),
    };
    let mut schemas: BTreeMap<u16, String> = BTreeMap::new();
    let mut channels: BTreeMap<u16, String> = BTreeMap::new();
    let mut bag = Bag::default();
    let mut messages = 0;
    let mut others: Vec<String> = Vec::new();
    // A bag whose recorder was killed has no end; what is before it counts.
    for record in Records::new(bytes, LARGEST_RECORD) {
        let record = match record {
            Ok(record) => record,
            Err(mcap::McapError::UnexpectedEof | mcap::McapError::UnexpectedEoc) if messages > 0 => break,
            Err(error) if messages > 0 => {
                return Err(bad(format!("after message {messages}"), "a whole record", error.to_string()));
            }
            Err(error) => return Err(whole(error)),
        };
        match record {
            Record::Schema { header, .. } => {
                schemas.insert(header.id, header.name);
            }
            Record::Channel(channel) => {
                let kind = schemas.get(&channel.schema_id).map_or("", String::as_str);
                if kind != KIND && kind != OLDER {
                    others.push(format!("{} ({kind})", channel.topic));
                } else if channel.message_encoding != "cdr" {
                    let got = format!("'{}'", channel.message_encoding);
                    return Err(bad(format!("topic {}", channel.topic), "messages encoded as 'cdr'", got));
                } else {
                    channels.insert(channel.id, channel.topic);
                }
            }
            Record::Message { header, data } => {
                let Some(topic) = channels.get(&header.channel_id) else { continue };
                messages += 1;
                if append(&mut bag, topic, header.log_time, &data).is_none() {
                    let place = format!("topic {topic}, message {messages}");
                    return Err(bad(
                        place,
                        "a whole JointState with each joint once, little-endian",
                        format!("{} bytes", data.len()),
                    ));
                }
            }
            _ => {}
        }
    }
    if bag.columns.is_empty() {
        let got = if others.is_empty() { "no topics".to_string() } else { others.join(", ") };
        return Err(bad("MCAP".into(), &format!("messages of {KIND}"), got));
    }
    // Recorders write in the order of arrival.
    bag.columns.values_mut().for_each(|column| column.sort_by(|a, b| a[0].total_cmp(&b[0])));
    Ok(bag)
}

/// Appends a message; `None` where it is cut off, names a joint twice, or has another number of values than names.
fn append(bag: &mut Bag, topic: &str, logged: u64, data: &[u8]) -> Option<()> {
    let mut message = Reader::begin(data)?;
    let (seconds, nanoseconds) = (message.get::<i32>()?, message.get::<u32>()?);
    message.text()?;
    let names = message.length(4)?;
    let names: Vec<&str> = (0..names).map(|_| message.text()).collect::<Option<_>>()?;
    let values = [message.sequence::<f64>()?, message.sequence::<f64>()?, message.sequence::<f64>()?];
    let is_unique = names.iter().collect::<BTreeSet<_>>().len() == names.len();
    if !is_unique || values.iter().any(|all| !all.is_empty() && all.len() != names.len()) {
        return None;
    }
    let stamped = f64::from(seconds) + 1e-9 * f64::from(nanoseconds);
    let time = if stamped == 0.0 { 1e-9 * logged as f64 } else { stamped };
    for (quantity, all) in QUANTITIES.iter().zip(&values) {
        for (name, value) in names.iter().zip(all) {
            let key = [topic.to_string(), format!("{name}.{quantity}")];
            bag.columns.entry(key).or_default().push([time, *value]);
        }
    }
    Some(())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use lifelike_cdr::Writer;
    use mcap::records::MessageHeader;

    use super::*;

    /// A message as `ros2 topic pub` would send it.
    fn state(time: f64, joints: &[(&str, f64)]) -> Vec<u8> {
        let mut bytes = Vec::new();
        let mut message = Writer::begin(&mut bytes);
        message.put(time as i32);
        message.put(((time - time.floor()) * 1e9).round() as u32);
        message.text("");
        message.length(joints.len());
        joints.iter().for_each(|(name, _)| message.text(name));
        message.sequence(&joints.iter().map(|(_, q)| *q).collect::<Vec<f64>>());
        message.sequence::<f64>(&[]);
        message.sequence::<f64>(&[]);
        bytes
    }

    pub(crate) fn bag(messages: &[(&str, Vec<u8>)]) -> Vec<u8> {
        let mut file = mcap::Writer::new(std::io::Cursor::new(Vec::new())).unwrap();
        let schema = file.add_schema(KIND, "ros2msg", b"").unwrap();
        for (sequence, (topic, data)) in messages.iter().enumerate() {
            let channel_id = file.add_channel(schema, topic, "cdr", &BTreeMap::new()).unwrap();
            let (sequence, log_time) = (sequence as u32, 1_000_000 * sequence as u64);
            let header = MessageHeader { channel_id, sequence, log_time, publish_time: log_time };
            file.write_to_known_channel(&header, data).unwrap();
        }
        file.finish().unwrap();
        file.into_inner().into_inner()
    }

    #[test]
    fn commands_are_held_and_parts_of_a_robot_may_come_alone() {
        let (states, goals) = ("/joint_states", "/goals");
        let bytes = bag(&[
            (states, state(100.0, &[("knee", 0.1), ("hip", 0.5)])),
            (goals, state(100.005, &[("knee", 1.0)])),
            (states, state(100.01, &[("hip", 0.6), ("knee", 0.2)])),
            (states, state(100.015, &[("finger", 9.0)])),
            (states, state(100.02, &[("knee", 0.3)])),
            (goals, state(100.03, &[("knee", 2.0)])),
            (states, state(100.03, &[("knee", 0.4)])),
        ]);
        let bag = read(Path::new("a.mcap"), &bytes).unwrap();
        let (time, rows) = bag.rows(&["/joint_states/knee.position", "/goals/knee.position", "hip.position"]).unwrap();
        assert!(time.iter().zip([0.0, 0.01, 0.02]).all(|(a, b)| (a - b).abs() < 1e-6), "{time:?}");
        assert_eq!(rows, [vec![0.2, 0.3, 0.4], vec![1.0, 1.0, 2.0], vec![0.6, 0.6, 0.6]]);
        let (expected, got) = bag.rows(&["knee.position"]).unwrap_err();
        assert_eq!(expected, "one topic with 'knee.position'");
        assert_eq!(got, "/goals/knee.position, /joint_states/knee.position");
        assert!(bag.rows(&["knee.effort"]).is_err());
    }

    #[test]
    fn messages_that_arrive_late_are_sorted_by_their_stamps() {
        let times = [1.01, 1.0, 1.02];
        let messages = times.map(|time| ("/a", state(time, &[("knee", time)])));
        let (time, rows) = read(Path::new("a.mcap"), &bag(&messages)).unwrap().rows(&["knee.position"]).unwrap();
        assert!(time.iter().zip([0.0, 0.01, 0.02]).all(|(a, b)| (a - b).abs() < 1e-6), "{time:?}");
        assert_eq!(rows, [[1.0, 1.01, 1.02]]);
    }

    #[test]
    fn what_is_no_bag_or_cut_off_is_said() {
        let path = Path::new("a.mcap");
        let message = |bytes: &[u8]| read(path, bytes).unwrap_err().to_string();
        assert!(message(b"nothing").contains("expected a bag of ROS 2 (MCAP)"));
        assert!(message(b"SQLite format 3\0").contains("`ros2 bag convert`"));
        let twice = bag(&[("/a", state(1.0, &[("knee", 0.1), ("knee", 0.2)]))]);
        assert!(message(&twice).contains("with each joint once"), "{}", message(&twice));
        let cut = bag(&[("/a", state(1.0, &[("knee", 0.1)])[..30].to_vec())]);
        assert!(message(&cut).contains("topic /a, message 1: expected a whole JointState"), "{}", message(&cut));
        // What a killed recorder leaves is read as far as it goes, or refused.
        let whole = bag(&[("/a", state(1.0, &[("knee", 0.1)])), ("/a", state(2.0, &[("knee", 0.2)]))]);
        let rows = |bag: &Bag| bag.rows(&["knee.position"]).map_or(0, |(time, _)| time.len());
        let all: Vec<_> = (0..whole.len()).map(|end| read(path, &whole[..end])).collect();
        let read_of: Vec<usize> = all.iter().map(|bag| bag.as_ref().map_or(0, rows)).collect();
        // Both messages are in one chunk.
        assert!(read_of.is_sorted() && read_of[whole.len() - 100] == 2, "{read_of:?}");
        // A byte that changed is no end of a file: what was read before it does not count as the whole.
        let spoilt = (0..whole.len()).map(|at| {
            let mut bytes = whole.clone();
            bytes[at] ^= 0x5a;
            read(path, &bytes)
        });
        let kept = spoilt.filter(|bag| bag.as_ref().is_ok_and(|bag| rows(bag) == 2)).count();
        assert!(kept < whole.len(), "{kept} of {}", whole.len());
    }
}
