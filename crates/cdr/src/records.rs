//! Records of an MCAP file: bags of ROS 2, and records of a run.

use mcap::McapResult;
use mcap::records::Record;
use mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};

/// The records of a file, those of its chunks included, each of a size that is checked before it is allocated.
pub struct Records<'a> {
    rest: &'a [u8],
    reader: LinearReader,
}

impl<'a> Records<'a> {
    /// Returns the records of a file's bytes. None may be longer than `most` bytes, chunks included.
    pub fn new(bytes: &'a [u8], most: usize) -> Self {
        let options = LinearReaderOptions::default().with_skip_end_magic(true).with_record_length_limit(most);
        Self { rest: bytes, reader: LinearReader::new_with_options(options) }
    }
}

impl Iterator for Records<'_> {
    type Item = McapResult<Record<'static>>;

    fn next(&mut self) -> Option<Self::Item> {
        while let Some(event) = self.reader.next_event() {
            match event {
                Ok(LinearReadEvent::ReadRequest(wanted)) => {
                    let (now, later) = self.rest.split_at(wanted.min(self.rest.len()));
                    self.reader.insert(now.len()).copy_from_slice(now);
                    self.reader.notify_read(now.len());
                    self.rest = later;
                }
                Ok(LinearReadEvent::Record { data, opcode }) => {
                    return Some(mcap::parse_record(opcode, data).map(Record::into_owned));
                }
                Err(error) => return Some(Err(error)),
            }
        }
        None
    }
}
