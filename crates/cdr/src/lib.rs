//! Floor 0: CDR, the encoding of DDS and ROS 2 messages (XCDR1, little-endian; OMG DDS-XTypes 1.3, section 7.4.3).
//!
//! A message begins with a header of four bytes. Numbers are aligned to their own size, counted from behind the header. A text is
//! its length with the final zero, its bytes and the zero. A sequence is its length and its items.
//!
//! ```
//! use lifelike_cdr::{Reader, Writer};
//!
//! let mut bytes = Vec::new();
//! let mut message = Writer::begin(&mut bytes);
//! message.text("knee");
//! message.sequence(&[0.5_f64, -1.0]);
//! let mut message = Reader::begin(&bytes).unwrap();
//! assert_eq!((message.text(), message.sequence()), (Some("knee"), Some(vec![0.5_f64, -1.0])));
//! ```
//!
//! [`Records`] are the records of an MCAP file, in which such messages are kept.

mod records;

pub use records::Records;

/// Header of plain CDR, little-endian.
const HEADER: [u8; 4] = [0, 1, 0, 0];

/// Numbers that CDR holds.
pub trait Number: Copy {
    /// Appends the number.
    fn put(self, out: &mut Vec<u8>);
    /// Reads the number at a place; none where the bytes end before.
    fn get(bytes: &[u8], at: usize) -> Option<Self>;
}

macro_rules! number {
    ($($kind:ty),+) => {
        $(impl Number for $kind {
            fn put(self, out: &mut Vec<u8>) {
                out.extend_from_slice(&self.to_le_bytes());
            }
            fn get(bytes: &[u8], at: usize) -> Option<Self> {
                let end = at.checked_add(size_of::<Self>())?;
                bytes.get(at..end)?.try_into().ok().map(Self::from_le_bytes)
            }
        })+
    };
}

number!(u8, i16, i32, u32, f32, f64);

/// Returns the place of the next number of this size.
fn aligned<T>(at: usize) -> usize {
    (at - HEADER.len()).next_multiple_of(size_of::<T>()) + HEADER.len()
}

/// Writes a message into a buffer.
#[derive(Debug)]
pub struct Writer<'a>(&'a mut Vec<u8>);

impl<'a> Writer<'a> {
    /// Begins a message, in place of what is in the buffer.
    pub fn begin(out: &'a mut Vec<u8>) -> Self {
        out.clear();
        out.extend_from_slice(&HEADER);
        Self(out)
    }

    /// Continues the message in a buffer that [`Self::begin`] began.
    pub fn resume(out: &'a mut Vec<u8>) -> Self {
        debug_assert!(out.starts_with(&HEADER));
        Self(out)
    }

    /// Appends a number.
    pub fn put<T: Number>(&mut self, value: T) {
        self.0.resize(aligned::<T>(self.0.len()), 0);
        value.put(self.0);
    }

    /// Appends numbers without their count.
    pub fn all<T: Number>(&mut self, values: &[T]) {
        values.iter().for_each(|value| self.put(*value));
    }

    /// Appends the length of a sequence, at most that of a `u32`.
    pub fn length(&mut self, length: usize) {
        self.put(u32::try_from(length).unwrap_or(u32::MAX));
    }

    /// Appends a sequence of numbers.
    pub fn sequence<T: Number>(&mut self, values: &[T]) {
        self.length(values.len());
        self.all(values);
    }

    /// Appends a text.
    pub fn text(&mut self, text: &str) {
        self.length(text.len() + 1);
        self.0.extend_from_slice(text.as_bytes());
        self.0.push(0);
    }
}

/// Reads a message. Everything returns `None` where the message ends before.
#[derive(Debug, Clone)]
pub struct Reader<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Reader<'a> {
    /// Begins a message; `None` where the header is another, such as that of big-endian numbers.
    pub fn begin(bytes: &'a [u8]) -> Option<Self> {
        bytes.starts_with(&HEADER).then_some(Self { bytes, at: HEADER.len() })
    }

    /// Reads a number.
    pub fn get<T: Number>(&mut self) -> Option<T> {
        let at = aligned::<T>(self.at);
        let value = T::get(self.bytes, at)?;
        self.at = at + size_of::<T>();
        Some(value)
    }

    /// Reads N numbers.
    pub fn all<T: Number + Default, const N: usize>(&mut self) -> Option<[T; N]> {
        let mut values = [T::default(); N];
        for value in &mut values {
            *value = self.get()?;
        }
        Some(values)
    }

    /// Reads the length of a sequence whose items have at least `size` bytes each.
    pub fn length(&mut self, size: usize) -> Option<usize> {
        let length = usize::try_from(self.get::<u32>()?).ok()?;
        (length.checked_mul(size)? <= self.bytes.len() - self.at).then_some(length)
    }

    /// Reads a sequence of numbers.
    pub fn sequence<T: Number>(&mut self) -> Option<Vec<T>> {
        let length = self.length(size_of::<T>())?;
        (0..length).map(|_| self.get()).collect()
    }

    /// Reads a text; `None` where it is none.
    pub fn text(&mut self) -> Option<&'a str> {
        let length = self.length(1)?;
        let bytes = &self.bytes[self.at..self.at + length];
        self.at += length;
        std::str::from_utf8(bytes.strip_suffix(&[0])?).ok()
    }

    /// Returns the number of bytes that were read.
    pub fn read(&self) -> usize {
        self.at
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn numbers_are_aligned_to_their_size_after_the_header() {
        let mut bytes = Vec::new();
        let mut message = Writer::begin(&mut bytes);
        message.put(7_u8);
        message.put(1.0_f64);
        message.text("ab");
        message.put(-1_i32);
        let mut expected = vec![0, 1, 0, 0, 7, 0, 0, 0, 0, 0, 0, 0];
        expected.extend([0, 0, 0, 0, 0, 0, 0xf0, 0x3f]);
        expected.extend([3, 0, 0, 0, b'a', b'b', 0, 0]);
        expected.extend([0xff; 4]);
        assert_eq!(bytes, expected);
        let mut message = Reader::begin(&bytes).unwrap();
        assert_eq!((message.get(), message.get(), message.text()), (Some(7_u8), Some(1.0_f64), Some("ab")));
        assert_eq!((message.get(), message.get::<u8>(), message.read()), (Some(-1_i32), None, bytes.len()));
    }

    #[test]
    fn what_is_cut_off_or_too_long_is_none() {
        let mut bytes = Vec::new();
        Writer::begin(&mut bytes).sequence(&[1.0_f32, 2.0]);
        for end in 4..bytes.len() {
            assert_eq!(Reader::begin(&bytes[..end]).unwrap().sequence::<f32>(), None, "{end} bytes");
        }
        let endless = [0, 1, 0, 0, 0xff, 0xff, 0xff, 0xff, 1];
        assert_eq!(Reader::begin(&endless).unwrap().sequence::<f64>(), None);
        assert_eq!(Reader::begin(&endless).unwrap().text(), None);
        assert!(Reader::begin(&[0, 0, 0, 0]).is_none(), "big-endian");
    }
}
