//! Writing a record beside the loop.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::Duration;

use mcap::records::{MessageHeader, Metadata};
use rtrb::{Consumer, Producer, RingBuffer};

use super::message::{CommandMessage, MeasuredMessage, PolicyMessage, all, schema};
use crate::bus::Measurement;
use crate::gate::Mode;
use crate::phase::{Phase, Request};
use crate::supervisor::Supervisor;
use crate::udp::packet::{self, Received};
use crate::{FromInput, RuntimeError};

/// Bytes between the loop and the writer: seconds of a 1 kHz loop.
const RING: usize = 8 << 20;
/// Wait of the writer when there is nothing to write.
const REST: Duration = Duration::from_millis(5);

const PACKET: u8 = 0;
const TICK: u8 = 1;
const STEP: u8 = 2;
/// Length, kind, time.
const FRAME: usize = 4 + 1 + 8;

/// A file within a record.
#[derive(Debug, Clone)]
pub struct Attachment {
    /// Name of the file.
    pub name: String,
    /// Content.
    pub bytes: Vec<u8>,
}

/// The loop's end of a record. Pushing neither allocates nor locks; a thread of its own writes the file.
pub struct Recorder {
    ring: Producer<u8>,
    scratch: Vec<u8>,
    frame: Vec<u8>,
    dropped: u64,
    is_over: Arc<AtomicBool>,
    writer: Option<JoinHandle<Result<(), String>>>,
    path: PathBuf,
}

impl Recorder {
    /// Begins a record in a new file.
    ///
    /// # Errors
    /// The file is there already, or cannot be made.
    pub fn create(
        path: &Path,
        joints: usize,
        metadata: BTreeMap<String, String>,
        attachments: &[Attachment],
    ) -> Result<Self, RuntimeError> {
        let file = File::create_new(path).map_err(RuntimeError::io(path))?;
        let failed = |error: mcap::McapError| RuntimeError::format(path.display(), "a file that can be written", error);
        let options = mcap::WriteOptions::new().profile("").library("lifelike").compression_level(1);
        let mut mcap = options.create(BufWriter::new(file)).map_err(failed)?;
        mcap.write_metadata(&Metadata { name: super::METADATA.into(), metadata }).map_err(failed)?;
        for Attachment { name, bytes } in attachments {
            let data = Cow::Borrowed(bytes.as_slice());
            let media_type = "application/octet-stream".into();
            mcap.attach(&mcap::Attachment { log_time: 0, create_time: 0, name: name.clone(), media_type, data })
                .map_err(failed)?;
        }
        let mut channels = [0; 3];
        for (channel, topic) in channels.iter_mut().zip([super::MEASURED, super::COMMAND, super::POLICY]) {
            let schema = schema(topic).to_string();
            let name = format!("lifelike{}", topic.replace('/', "."));
            let id = mcap.add_schema(&name, "jsonschema", schema.as_bytes()).map_err(failed)?;
            *channel = mcap.add_channel(id, topic, "json", &BTreeMap::new()).map_err(failed)?;
        }
        let (producer, consumer) = RingBuffer::new(RING);
        let is_over = Arc::new(AtomicBool::new(false));
        let seen = Arc::clone(&is_over);
        let writer = Writer { mcap, channels, ring: consumer, joints, counts: [0; 3] };
        let thread = std::thread::spawn(move || writer.run(&seen).map_err(|error| error.to_string()));
        let room = || Vec::with_capacity(packet::MAX_BYTES);
        let (scratch, frame) = (room(), room());
        Ok(Self { ring: producer, scratch, frame, dropped: 0, is_over, writer: Some(thread), path: path.into() })
    }

    /// Returns the number of frames that did not fit between the loop and the writer.
    pub fn dropped(&self) -> u64 {
        self.dropped
    }

    pub(crate) fn packet(&mut self, now: u64, packet: &Measurement) {
        packet::write_state(packet, &mut self.scratch);
        self.push(PACKET, now, &[]);
    }

    pub(crate) fn tick(&mut self, now: u64, request: Request, supervisor: &Supervisor) {
        packet::write_command(supervisor.gate().command(), now, &mut self.scratch);
        let phase = Phase::ALL.iter().position(|phase| *phase == supervisor.phase()).unwrap_or_default();
        self.push(TICK, now, &[request as u8, phase as u8]);
        if supervisor.has_stepped() {
            self.scratch.clear();
            let targets = supervisor.policy_targets().iter().copied();
            targets.chain(supervisor.gate().heat()).for_each(|x| self.scratch.extend_from_slice(&x.to_le_bytes()));
            self.push(STEP, now, &[]);
        }
    }

    /// Pushes the scratch behind a few bytes.
    fn push(&mut self, kind: u8, now: u64, before: &[u8]) {
        self.frame.clear();
        self.frame.extend_from_slice(&((before.len() + self.scratch.len()) as u32).to_le_bytes());
        self.frame.push(kind);
        self.frame.extend_from_slice(&now.to_le_bytes());
        self.frame.extend_from_slice(before);
        self.frame.extend_from_slice(&self.scratch);
        self.dropped += u64::from(self.ring.push_entire_slice(&self.frame).is_err());
    }

    /// Waits for the writer, and ends the file.
    ///
    /// # Errors
    /// The file could not be written; what was written before is readable.
    pub fn finish(mut self) -> Result<(), RuntimeError> {
        self.is_over.store(true, Ordering::Release);
        let result = self.writer.take().map_or(Ok(Ok(())), JoinHandle::join);
        let failed = |got: String| Err(RuntimeError::format(self.path.display(), "a file that can be written", got));
        match result {
            Ok(Ok(())) => Ok(()),
            Ok(Err(error)) => failed(error),
            Err(_) => failed("a writer that stopped".into()),
        }
    }
}

/// The file's end of a record.
struct Writer {
    mcap: mcap::Writer<BufWriter<File>>,
    channels: [u16; 3],
    ring: Consumer<u8>,
    joints: usize,
    counts: [u32; 3],
}

impl Writer {
    fn run(mut self, is_over: &AtomicBool) -> mcap::McapResult<()> {
        let mut head = [0; FRAME];
        let mut body = Vec::new();
        let mut measured = Measurement::new(self.joints);
        let mut command = Received::new(self.joints);
        loop {
            // Read before the ring is looked at: what is pushed before the end is written.
            let ends = is_over.load(Ordering::Acquire);
            if self.ring.pop_entire_slice(&mut head).is_err() {
                if ends {
                    break;
                }
                std::thread::sleep(REST);
                continue;
            }
            let [a, b, c, d, kind, time @ ..] = head;
            body.resize(u32::from_le_bytes([a, b, c, d]) as usize, 0);
            // Frames are pushed whole.
            let _ = self.ring.pop_entire_slice(&mut body);
            let time_ns = u64::from_le_bytes(time);
            let json = match kind {
                PACKET if packet::read_state(&body, &mut measured) => {
                    serde_json::to_vec(&MeasuredMessage::of(time_ns, &measured))
                }
                TICK if body.len() > 2 && packet::read_command(&body[2..], &mut command) => {
                    serde_json::to_vec(&message_of(time_ns, &body, &command))
                }
                _ => {
                    let (numbers, _) = body.as_chunks::<4>();
                    let numbers: Vec<f32> = numbers.iter().map(|x| f32::from_le_bytes(*x)).collect();
                    let (targets, heat) = numbers.split_at(self.joints.min(numbers.len()));
                    serde_json::to_vec(&PolicyMessage { time_ns, targets: all(targets), heat: all(heat) })
                }
            };
            let topic = usize::from(kind.min(STEP));
            let header = MessageHeader {
                channel_id: self.channels[topic],
                sequence: self.counts[topic],
                log_time: time_ns,
                publish_time: time_ns,
            };
            self.counts[topic] = self.counts[topic].wrapping_add(1);
            self.mcap.write_to_known_channel(&header, &json.unwrap_or_default())?;
        }
        self.mcap.finish()?;
        Ok(())
    }
}

fn message_of(time_ns: u64, body: &[u8], command: &Received) -> CommandMessage {
    let request = match body[0] {
        1 => Request::Stop,
        2 => Request::Damp,
        _ => Request::Run,
    };
    let Received { sequence, mode, position, kp, kd } = command.clone();
    let phase = Phase::ALL.get(usize::from(body[1])).copied().unwrap_or(Phase::Idle);
    // Commands are finite: the gate lets nothing else pass.
    debug_assert!(mode == Mode::Off || position.iter().chain(&kp).chain(&kd).all(|x| x.is_finite()));
    CommandMessage { time_ns, request, phase, sequence, mode, position, kp, kd }
}
