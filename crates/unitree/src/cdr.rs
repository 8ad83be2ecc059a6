//! CDR, little-endian: numbers aligned to their size, behind a header of four bytes.

/// Header of plain CDR, little-endian.
pub(crate) const HEADER: [u8; 4] = [0, 1, 0, 0];

/// Numbers that CDR holds.
pub(crate) trait Number: Copy {
    /// Appends the number.
    fn put(self, out: &mut Vec<u8>);
    /// Reads the number at a place that is within the bytes.
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

number!(u8, i16, u32, f32);

/// Writes a message.
pub(crate) struct Writer<'a>(&'a mut Vec<u8>);

impl<'a> Writer<'a> {
    /// Begins a message, in place of what is in the buffer.
    pub(crate) fn begin(out: &'a mut Vec<u8>) -> Self {
        out.clear();
        out.extend_from_slice(&HEADER);
        Self(out)
    }

    pub(crate) fn put<T: Number>(&mut self, value: T) {
        // Alignment counts from behind the header, which is four bytes long.
        while !self.0.len().is_multiple_of(size_of::<T>()) {
            self.0.push(0);
        }
        value.put(self.0);
    }

    pub(crate) fn all<T: Number>(&mut self, values: &[T]) {
        values.iter().for_each(|value| self.put(*value));
    }
}

/// Reads a message.
pub(crate) struct Reader<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Reader<'a> {
    /// Begins a message; none where the header is another.
    pub(crate) fn begin(bytes: &'a [u8]) -> Option<Self> {
        bytes.starts_with(&HEADER).then_some(Self { bytes, at: HEADER.len() })
    }

    pub(crate) fn get<T: Number>(&mut self) -> Option<T> {
        self.at = self.at.next_multiple_of(size_of::<T>());
        let value = T::get(self.bytes, self.at)?;
        self.at += size_of::<T>();
        Some(value)
    }

    pub(crate) fn all<T: Number + Default, const N: usize>(&mut self) -> Option<[T; N]> {
        let mut values = [T::default(); N];
        for value in &mut values {
            *value = self.get()?;
        }
        Some(values)
    }

    /// Returns the number of bytes that were read.
    pub(crate) fn read(&self) -> usize {
        self.at
    }
}
