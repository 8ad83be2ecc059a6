//! A participant of a DDS domain, whose messages are bytes of CDR with their header.

use std::convert::Infallible;
use std::net::IpAddr;

use lifelike_runtime::RuntimeError;
use rustdds::bytes::Bytes;
use rustdds::dds::result::CreateError;
use rustdds::no_key::{self, Decode, DefaultDecoder, DeserializerAdapter, SerializerAdapter};
use rustdds::{DomainParticipant, DomainParticipantBuilder, Duration, QosPolicies, QosPolicyBuilder};
use rustdds::{RepresentationIdentifier, Topic, TopicKind, policy};

/// Header of plain CDR, little-endian.
const HEADER: [u8; 4] = [0, 1, 0, 0];

/// Messages as they are.
pub(crate) struct Plain;

/// Puts the header back in front of a message.
#[derive(Clone)]
pub(crate) struct WithHeader;

impl Decode<'_, Vec<u8>> for WithHeader {
    type Error = Infallible;

    fn decode_bytes(self, bytes: &[u8], _: RepresentationIdentifier) -> Result<Vec<u8>, Infallible> {
        Ok([&HEADER, bytes].concat())
    }
}

impl DeserializerAdapter<Vec<u8>> for Plain {
    type Error = Infallible;
    type Decoded = Vec<u8>;

    fn supported_encodings() -> &'static [RepresentationIdentifier] {
        &[RepresentationIdentifier::CDR_LE]
    }

    fn transform_decoded(decoded: Vec<u8>) -> Vec<u8> {
        decoded
    }
}

impl DefaultDecoder<Vec<u8>> for Plain {
    type Decoder = WithHeader;
    const DECODER: WithHeader = WithHeader;
}

impl SerializerAdapter<Vec<u8>> for Plain {
    type Error = Infallible;

    fn output_encoding() -> RepresentationIdentifier {
        RepresentationIdentifier::CDR_LE
    }

    fn to_bytes(value: &Vec<u8>) -> Result<Bytes, Infallible> {
        Ok(Bytes::copy_from_slice(value.get(HEADER.len()..).unwrap_or_default()))
    }
}

/// A topic that is read: the newest messages, without repeats of lost ones.
pub(crate) struct Reader(no_key::DataReader<Vec<u8>, Plain>);

impl Reader {
    /// Returns the next message that has arrived.
    pub(crate) fn next(&mut self) -> std::io::Result<Option<Vec<u8>>> {
        let sample = self.0.take_next_sample().map_err(std::io::Error::other)?;
        Ok(sample.map(|sample| sample.into_value()))
    }
}

/// A topic that is written.
pub(crate) struct Writer(no_key::DataWriter<Vec<u8>, Plain>);

impl Writer {
    /// Sends a message.
    pub(crate) fn send(&self, message: Vec<u8>) -> std::io::Result<()> {
        self.0.write(message, None).map_err(|error| std::io::Error::other(error.to_string()))
    }
}

/// A participant of one domain.
pub(crate) struct Participant {
    bus: String,
    domain: DomainParticipant,
}

impl Participant {
    /// Joins a domain on a network interface: its name or an address of it; on all where it is empty.
    ///
    /// # Errors
    /// There is no such interface, or no socket can be opened.
    pub(crate) fn join(bus: &str, domain: u16, interface: &str) -> Result<Self, RuntimeError> {
        let mut builder = DomainParticipantBuilder::new(domain);
        if !interface.is_empty() {
            builder = builder.with_only_networks(addresses(bus, interface)?);
        }
        let domain = builder.build().map_err(|error| broken(bus, "a DDS participant", error))?;
        Ok(Self { bus: bus.into(), domain })
    }

    /// Reads a topic.
    pub(crate) fn read(&self, topic: &str, kind: &str) -> Result<Reader, RuntimeError> {
        // Repeats of lost messages would be late; the gate counts losses.
        let qos = qos(policy::Reliability::BestEffort, 16);
        let open = || {
            let topic = self.topic(topic, kind, &qos)?;
            self.domain.create_subscriber(&qos)?.create_datareader_no_key(&topic, None)
        };
        open().map(Reader).map_err(|error| broken(&self.bus, "a reader", error))
    }

    /// Writes a topic.
    pub(crate) fn write(&self, topic: &str, kind: &str) -> Result<Writer, RuntimeError> {
        // A reader that asks for reliable messages matches no other writer.
        let qos = qos(policy::Reliability::Reliable { max_blocking_time: Duration::from_millis(1) }, 1);
        let open = || {
            let topic = self.topic(topic, kind, &qos)?;
            self.domain.create_publisher(&qos)?.create_datawriter_no_key(&topic, None)
        };
        open().map(Writer).map_err(|error| broken(&self.bus, "a writer", error))
    }

    /// Returns whether another program writes a topic.
    pub(crate) fn is_written(&self, topic: &str) -> bool {
        self.domain.discovered_writers().iter().any(|writer| writer.publication_topic_data.topic_name == topic)
    }

    /// Returns whether another program reads a topic.
    pub(crate) fn is_read(&self, topic: &str) -> bool {
        self.domain.discovered_readers().iter().any(|reader| reader.subscription_topic_data.topic_name() == topic)
    }

    fn topic(&self, name: &str, kind: &str, qos: &QosPolicies) -> Result<Topic, CreateError> {
        self.domain.create_topic(name.into(), kind.into(), qos, TopicKind::NoKey)
    }
}

fn qos(reliability: policy::Reliability, depth: i32) -> QosPolicies {
    let history = policy::History::KeepLast { depth };
    let durability = policy::Durability::Volatile;
    QosPolicyBuilder::new().reliability(reliability).history(history).durability(durability).build()
}

/// Returns the addresses of an interface.
fn addresses(bus: &str, interface: &str) -> Result<Vec<IpAddr>, RuntimeError> {
    let all = netdev::get_interfaces();
    let addresses = |one: &netdev::Interface| one.ip_addrs();
    let address = interface.parse::<IpAddr>().ok();
    let fits = |one: &&netdev::Interface| one.name == interface || address.is_some_and(|a| addresses(one).contains(&a));
    match all.iter().find(fits) {
        Some(_) if address.is_some() => Ok(address.into_iter().collect()),
        Some(one) => Ok(addresses(one)),
        None => {
            let mut names: Vec<&str> = all.iter().map(|one| one.name.as_str()).collect();
            names.sort_unstable();
            let expected = format!("a network interface, one of {}", names.join(", "));
            Err(RuntimeError::Bus { bus: bus.into(), expected, got: format!("'{interface}'") })
        }
    }
}

fn broken(bus: &str, expected: &str, got: impl std::fmt::Display) -> RuntimeError {
    RuntimeError::Bus { bus: bus.into(), expected: expected.into(), got: got.to_string() }
}
