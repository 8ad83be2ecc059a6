//! Messages of ROS 2 as bytes: XCDR1, little-endian (OMG DDS-XTypes 1.3, section 7.4.3).

use lifelike_character::rotation::to_wxyz;
use lifelike_character::{Quat, Vec3};

/// One message in the making.
pub(super) struct Message(Vec<u8>);

impl Message {
    /// Returns an empty message: its header says little-endian.
    pub fn new() -> Self {
        Self(vec![0, 1, 0, 0])
    }

    /// Returns the bytes.
    pub fn into_bytes(self) -> Vec<u8> {
        self.0
    }

    /// Appends a number at the next multiple of its own size, counted from the end of the header.
    fn aligned<const N: usize>(mut self, bytes: [u8; N]) -> Self {
        let body = self.0.len() - 4;
        self.0.resize(4 + body.next_multiple_of(N), 0);
        self.0.extend(bytes);
        self
    }

    pub fn u8(self, value: u8) -> Self {
        self.aligned([value])
    }

    pub fn i32(self, value: i32) -> Self {
        self.aligned(value.to_le_bytes())
    }

    /// Appends a length or another unsigned number.
    pub fn len(self, value: usize) -> Self {
        self.aligned((value as u32).to_le_bytes())
    }

    pub fn f32(self, value: f32) -> Self {
        self.aligned(value.to_le_bytes())
    }

    pub fn f64(self, value: f64) -> Self {
        self.aligned(value.to_le_bytes())
    }

    /// Appends a text: its length with the final zero, its bytes, the zero.
    pub fn text(self, text: &str) -> Self {
        let mut out = self.len(text.len() + 1);
        out.0.extend(text.as_bytes());
        out.0.push(0);
        out
    }

    pub fn texts(self, all: &[String]) -> Self {
        all.iter().fold(self.len(all.len()), |message, text| message.text(text))
    }

    pub fn f64s(self, all: &[f64]) -> Self {
        all.iter().fold(self.len(all.len()), |message, value| message.f64(*value))
    }

    /// Appends a `std_msgs/Header`: time in nanoseconds, and the frame.
    pub fn header(self, nanoseconds: u64, frame: &str) -> Self {
        self.i32((nanoseconds / 1_000_000_000) as i32).len((nanoseconds % 1_000_000_000) as usize).text(frame)
    }

    /// Appends a point, or a vector.
    pub fn vector(self, v: &Vec3) -> Self {
        self.f64(v.x).f64(v.y).f64(v.z)
    }

    /// Appends a position and an orientation, which ROS writes as xyzw.
    pub fn pose(self, position: &Vec3, orientation: &Quat) -> Self {
        let [w, x, y, z] = to_wxyz(orientation);
        self.vector(position).f64(x).f64(y).f64(z).f64(w)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_aligned_to_their_size_after_the_header() {
        let bytes = Message::new().u8(7).f64(1.0).text("ab").i32(-1).into_bytes();
        let mut expected = vec![0, 1, 0, 0, 7, 0, 0, 0, 0, 0, 0, 0];
        expected.extend([0, 0, 0, 0, 0, 0, 0xf0, 0x3f]);
        expected.extend([3, 0, 0, 0, b'a', b'b', 0, 0]);
        expected.extend([0xff; 4]);
        assert_eq!(bytes, expected);
    }
}
