//! Unitree's checksum: CRC-32 over words of 32 bits, most significant bit first, without a final exclusive or.

const POLYNOMIAL: u32 = 0x04C1_1DB7;

/// A checksum that grows word by word.
pub(crate) struct Crc(u32);

impl Crc {
    pub(crate) fn new() -> Self {
        Self(u32::MAX)
    }

    pub(crate) fn word(&mut self, word: u32) {
        self.0 ^= word;
        for _ in 0..32 {
            let carry = if self.0 & 1 << 31 != 0 { POLYNOMIAL } else { 0 };
            self.0 = self.0 << 1 ^ carry;
        }
    }

    pub(crate) fn number(&mut self, x: f32) {
        self.word(x.to_bits());
    }

    pub(crate) fn value(&self) -> u32 {
        self.0
    }
}
