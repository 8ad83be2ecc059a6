//! Reading a record.

use std::collections::{BTreeMap, HashMap};
use std::path::{Path, PathBuf};

use lifelike_cdr::Records;
use mcap::records::Record as McapRecord;

use super::message::{CommandMessage, MeasuredMessage, PolicyMessage};
use super::recorder::Attachment;
use crate::{FromInput, RuntimeError};

/// Largest record and chunk that is believed (bytes): a chunk has 1 MB, a controller at most some hundred.
const LARGEST: usize = 1 << 30;

/// One message of a record.
#[derive(Debug, Clone, PartialEq)]
pub enum Entry {
    /// A packet of the robot.
    Measured(MeasuredMessage),
    /// A tick and its command.
    Command(CommandMessage),
    /// A step of the policy.
    Policy(PolicyMessage),
}

/// A record in memory.
#[derive(Debug, Clone)]
pub struct Record {
    /// The file.
    pub path: PathBuf,
    /// Robot, joints, settings and digests, by name.
    pub metadata: BTreeMap<String, String>,
    /// Files within it.
    pub attachments: Vec<Attachment>,
    /// Messages in their order.
    pub entries: Vec<Entry>,
    /// The file ends without its footer: the run was cut off.
    pub is_cut_off: bool,
}

impl Record {
    /// Reads a record.
    ///
    /// # Errors
    /// The file is none of [`super::Recorder`], or a message is malformed.
    pub fn read(path: &Path) -> Result<Self, RuntimeError> {
        let bytes = std::fs::read(path).map_err(RuntimeError::io(path))?;
        let bad = |got: String| RuntimeError::format(path.display(), "an MCAP record of `lifelike run`", got);
        let mut record = Self {
            path: path.into(),
            metadata: BTreeMap::new(),
            attachments: Vec::new(),
            entries: Vec::new(),
            is_cut_off: true,
        };
        let mut topics: HashMap<u16, String> = HashMap::new();
        let mut has_metadata = false;
        // Text is seldom compressed to less than a thousandth.
        let most = bytes.len().saturating_mul(1024).min(LARGEST);
        for item in Records::new(&bytes, most) {
            let item = match item {
                Ok(item) => item,
                // A file that was cut off ends anywhere: what is before it counts.
                Err(_) if has_metadata => break,
                Err(error) => return Err(bad(error.to_string())),
            };
            match item {
                McapRecord::Metadata(metadata) if metadata.name == super::METADATA => {
                    record.metadata = metadata.metadata;
                    has_metadata = true;
                }
                McapRecord::Attachment { header, data, .. } => {
                    record.attachments.push(Attachment { name: header.name, bytes: data.into_owned() });
                }
                McapRecord::Channel(channel) => {
                    topics.insert(channel.id, channel.topic);
                }
                McapRecord::Message { header, data } => {
                    let place = |error: serde_json::Error| bad(format!("message {}: {error}", record.entries.len()));
                    let entry = match topics.get(&header.channel_id).map(String::as_str) {
                        Some(super::MEASURED) => serde_json::from_slice(&data).map(Entry::Measured),
                        Some(super::COMMAND) => serde_json::from_slice(&data).map(Entry::Command),
                        Some(super::POLICY) => serde_json::from_slice(&data).map(Entry::Policy),
                        _ => continue,
                    };
                    record.entries.push(entry.map_err(place)?);
                }
                McapRecord::Footer(_) => record.is_cut_off = false,
                _ => {}
            }
        }
        if !has_metadata {
            return Err(bad("a file without its metadata".into()));
        }
        let joints = record.joints().len();
        for (i, entry) in record.entries.iter().enumerate() {
            let lengths = match entry {
                Entry::Measured(m) => vec![m.position.len(), m.velocity.len(), m.torque.len(), m.temperature.len()],
                Entry::Command(c) => vec![c.position.len(), c.kp.len(), c.kd.len()],
                Entry::Policy(p) => vec![p.targets.len(), p.heat.len()],
            };
            if lengths.iter().any(|length| *length != joints) {
                return Err(bad(format!("message {i} of {lengths:?} joints, where the record has {joints}")));
            }
        }
        Ok(record)
    }

    /// Returns the names of the joints.
    pub fn joints(&self) -> Vec<String> {
        self.metadata.get("joints").and_then(|text| serde_json::from_str(text).ok()).unwrap_or_default()
    }

    /// Returns an entry of the metadata.
    ///
    /// # Errors
    /// There is none of this name.
    pub fn meta(&self, key: &str) -> Result<&str, RuntimeError> {
        self.metadata
            .get(key)
            .map(String::as_str)
            .ok_or_else(|| RuntimeError::format(self.path.display(), format!("metadata '{key}'"), "none"))
    }

    /// Returns the attachments whose names end so.
    pub fn attached<'a>(&'a self, ending: &'a str) -> impl Iterator<Item = &'a Attachment> + 'a {
        self.attachments.iter().filter(move |attachment| attachment.name.ends_with(ending))
    }
}
