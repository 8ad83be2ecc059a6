//! Messages of ROS 2 in the making.

use lifelike_cdr::{Number, Writer};
use lifelike_character::rotation::to_wxyz;
use lifelike_character::{Quat, Vec3};

/// One message in the making.
pub(super) struct Message(Vec<u8>);

impl Message {
    /// Returns an empty message.
    pub fn new() -> Self {
        let mut bytes = Vec::new();
        Writer::begin(&mut bytes);
        Self(bytes)
    }

    /// Returns the bytes.
    pub fn into_bytes(self) -> Vec<u8> {
        self.0
    }

    /// Appends a number.
    pub fn put<T: Number>(mut self, value: T) -> Self {
        Writer::resume(&mut self.0).put(value);
        self
    }

    /// Appends the length of a sequence.
    pub fn len(mut self, value: usize) -> Self {
        Writer::resume(&mut self.0).length(value);
        self
    }

    pub fn text(mut self, text: &str) -> Self {
        Writer::resume(&mut self.0).text(text);
        self
    }

    pub fn texts(self, all: &[String]) -> Self {
        all.iter().fold(self.len(all.len()), |message, text| message.text(text))
    }

    pub fn f64s(mut self, all: &[f64]) -> Self {
        Writer::resume(&mut self.0).sequence(all);
        self
    }

    /// Appends a `std_msgs/Header`: time in nanoseconds, and the frame.
    pub fn header(self, nanoseconds: u64, frame: &str) -> Self {
        self.put((nanoseconds / 1_000_000_000) as i32).put((nanoseconds % 1_000_000_000) as u32).text(frame)
    }

    /// Appends a point, or a vector.
    pub fn vector(self, v: &Vec3) -> Self {
        self.put(v.x).put(v.y).put(v.z)
    }

    /// Appends a position and an orientation, which ROS writes as xyzw.
    pub fn pose(self, position: &Vec3, orientation: &Quat) -> Self {
        let [w, x, y, z] = to_wxyz(orientation);
        self.vector(position).put(x).put(y).put(z).put(w)
    }
}
