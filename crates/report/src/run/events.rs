//! TensorBoard's event files: records of length, masked CRC-32C and a protobuf `Event`, as TensorFlow's
//! `record_writer.cc` and `event.proto` define them. Only scalars are written, so the handful of protobuf fields is
//! encoded here rather than by a code generator.

use std::fs::{File, OpenOptions};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::{SystemTime, UNIX_EPOCH};

use crate::{FromInput, ReportError};

/// Writes scalars for TensorBoard.
#[derive(Debug)]
pub struct EventWriter {
    path: PathBuf,
    file: File,
}

impl EventWriter {
    /// Starts a new event file in a folder. `first_step` is the first step that will be written: after a resume
    /// TensorBoard drops what earlier files say from there on.
    ///
    /// # Errors
    /// [`ReportError::Input`].
    pub fn create(folder: &Path, first_step: u64) -> Result<Self, ReportError> {
        let now = wall_time();
        // Readers sort the files of a folder by name, hence seconds first, with leading zeros as TensorFlow writes them.
        let (seconds, nanos) = (now as u64, (now.fract() * 1e9) as u64);
        let path = folder.join(format!("events.out.tfevents.{seconds:010}.{nanos:09}.lifelike"));
        let file = OpenOptions::new().create(true).append(true).open(&path).map_err(ReportError::io(&path))?;
        let mut writer = Self { path, file };
        let mut version = event(now, 0);
        field_bytes(&mut version, 3, b"brain.Event:2");
        writer.write(&version)?;
        // SessionLog { status: START }.
        let mut start = event(now, first_step);
        field_bytes(&mut start, 7, &[0x08, 0x01]);
        writer.write(&start)?;
        Ok(writer)
    }

    /// Writes the scalars of one step. Values that are not finite are left out: TensorBoard's axes choke on them, and
    /// `metrics.jsonl` has them.
    ///
    /// # Errors
    /// [`ReportError::Input`].
    pub fn scalars(&mut self, step: u64, values: &[(&str, f64)]) -> Result<(), ReportError> {
        self.write(&scalar_event(wall_time(), step, values))
    }

    fn write(&mut self, payload: &[u8]) -> Result<(), ReportError> {
        self.file.write_all(&record(payload)).map_err(ReportError::io(&self.path))
    }
}

fn wall_time() -> f64 {
    SystemTime::now().duration_since(UNIX_EPOCH).map_or(0.0, |d| d.as_secs_f64())
}

/// `Event { wall_time: 1 (double), step: 2 (int64) }`, to be continued.
fn event(wall_time: f64, step: u64) -> Vec<u8> {
    let mut out = vec![0x09];
    out.extend(wall_time.to_le_bytes());
    out.push(0x10);
    varint(&mut out, step);
    out
}

/// `Event.summary: 5 { value: 1 { tag: 1, simple_value: 2 (float) } }`.
fn scalar_event(wall_time: f64, step: u64, values: &[(&str, f64)]) -> Vec<u8> {
    let mut summary = Vec::new();
    for (tag, value) in values.iter().filter(|(_, v)| v.is_finite()) {
        let mut one = Vec::new();
        field_bytes(&mut one, 1, tag.as_bytes());
        one.push(0x15);
        one.extend((*value as f32).to_le_bytes());
        field_bytes(&mut summary, 1, &one);
    }
    let mut out = event(wall_time, step);
    field_bytes(&mut out, 5, &summary);
    out
}

fn varint(out: &mut Vec<u8>, mut value: u64) {
    while value >= 0x80 {
        out.push(value as u8 | 0x80);
        value >>= 7;
    }
    out.push(value as u8);
}

fn field_bytes(out: &mut Vec<u8>, field: u8, bytes: &[u8]) {
    out.push(field << 3 | 2);
    varint(out, bytes.len() as u64);
    out.extend(bytes);
}

/// Returns the length, its masked CRC, payload, its masked CRC; all little endian.
fn record(payload: &[u8]) -> Vec<u8> {
    let length = (payload.len() as u64).to_le_bytes();
    let mut out = Vec::with_capacity(payload.len() + 16);
    out.extend(length);
    out.extend(masked(crc32c(&length)).to_le_bytes());
    out.extend(payload);
    out.extend(masked(crc32c(payload)).to_le_bytes());
    out
}

fn masked(crc: u32) -> u32 {
    crc.rotate_right(15).wrapping_add(0xa282_ead8)
}

/// CRC-32C (Castagnoli), reflected, bit by bit: a few hundred bytes per iteration do not deserve a table.
fn crc32c(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(!0_u32, |crc, byte| {
        (0..8).fold(crc ^ u32::from(*byte), |c, _| if c & 1 == 1 { c >> 1 ^ 0x82f6_3b78 } else { c >> 1 })
    })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn the_checksum_is_castagnolis() {
        // RFC 3720, appendix B.4, and the customary check value.
        assert_eq!(crc32c(b"123456789"), 0xe306_9283);
        assert_eq!(crc32c(&[0; 32]), 0x8a91_36aa);
        assert_eq!(crc32c(&[0xff; 32]), 0x62a8_ab43);
    }

    #[test]
    fn a_scalar_event_is_the_bytes_that_tensorflow_writes() {
        // From tensorboard's own protobuf classes: Event(wall_time=1.5, step=300,
        // summary=Summary(value=[Summary.Value(tag="a", simple_value=0.25)])).SerializeToString().
        let expected = [
            0x09, 0, 0, 0, 0, 0, 0, 0xf8, 0x3f, 0x10, 0xac, 0x02, 0x2a, 0x0a, 0x0a, 0x08, 0x0a, 0x01, b'a', 0x15, 0, 0,
            0x80, 0x3e,
        ];
        assert_eq!(scalar_event(1.5, 300, &[("a", 0.25), ("left out", f64::NAN)]), expected);
    }

    #[test]
    fn records_follow_one_another_with_their_checksums() {
        let folder = tempfile::tempdir().unwrap();
        let mut writer = EventWriter::create(folder.path(), 7).unwrap();
        writer.scalars(7, &[("loss", 0.5)]).unwrap();
        let bytes = std::fs::read(&writer.path).unwrap();
        let (mut at, mut records) = (0, 0);
        while at < bytes.len() {
            let n = u64::from_le_bytes(bytes[at..at + 8].try_into().unwrap()) as usize;
            let crc = u32::from_le_bytes(bytes[at + 12 + n..at + 16 + n].try_into().unwrap());
            assert_eq!(crc, masked(crc32c(&bytes[at + 12..at + 12 + n])));
            at += 16 + n;
            records += 1;
        }
        assert_eq!((at, records), (bytes.len(), 3), "version, session start, scalars");
    }
}
