//! Messages of ROS 2 (`sensor_msgs`, `trajectory_msgs`) as CDR, field by field as ROS names them.

use lifelike_cdr::{Reader, Writer};

/// `sensor_msgs/msg/JointState`.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct JointState {
    /// Time of the measurement (ns).
    pub stamp: u64,
    /// Joint names.
    pub name: Vec<String>,
    /// Positions, in the order of names (rad).
    pub position: Vec<f64>,
    /// Velocities (rad/s); empty where they are not measured.
    pub velocity: Vec<f64>,
    /// Torques (N m); empty where they are not measured.
    pub effort: Vec<f64>,
}

/// `sensor_msgs/msg/Imu`, without covariances.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Imu {
    /// Orientation (`wxyz`; ROS sends `xyzw`).
    pub orientation: [f64; 4],
    /// Angular velocity (rad/s).
    pub angular_velocity: [f64; 3],
    /// Specific force (m/s²).
    pub linear_acceleration: [f64; 3],
}

/// `trajectory_msgs/msg/JointTrajectory` with one point of positions, to reach from now on.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct JointTrajectory {
    /// Joint names.
    pub joint_names: Vec<String>,
    /// Positions, in the order of names (rad).
    pub positions: Vec<f64>,
    /// Time in which to reach them (ns).
    pub time_from_start: u32,
}

fn begin(out: &mut Vec<u8>, stamp: u64) -> Writer<'_> {
    let mut to = Writer::begin(out);
    to.put((stamp / 1_000_000_000) as i32);
    to.put((stamp % 1_000_000_000) as u32);
    to.text("");
    to
}

/// Reads a header, and returns its time (ns).
fn header(from: &mut Reader) -> Option<u64> {
    let (seconds, nanoseconds) = (from.get::<i32>()?, from.get::<u32>()?);
    from.text()?;
    Some(u64::try_from(seconds).ok()? * 1_000_000_000 + u64::from(nanoseconds))
}

fn put_names(to: &mut Writer, names: &[String]) {
    to.length(names.len());
    names.iter().for_each(|name| to.text(name));
}

fn names(from: &mut Reader) -> Option<Vec<String>> {
    // A text has at least its length and a zero.
    (0..from.length(5)?).map(|_| from.text().map(String::from)).collect()
}

impl JointState {
    /// Writes the message.
    pub fn write(&self, out: &mut Vec<u8>) {
        let mut to = begin(out, self.stamp);
        put_names(&mut to, &self.name);
        [&self.position, &self.velocity, &self.effort].into_iter().for_each(|values| to.sequence(values));
    }

    /// Reads a message; `None` for anything else, and where a list has another length than that of names.
    pub fn read(bytes: &[u8]) -> Option<Self> {
        let mut from = Reader::begin(bytes)?;
        let (stamp, name) = (header(&mut from)?, names(&mut from)?);
        let state =
            Self { stamp, name, position: from.sequence()?, velocity: from.sequence()?, effort: from.sequence()? };
        let fits = |values: &[f64]| values.is_empty() || values.len() == state.name.len();
        (fits(&state.position) && fits(&state.velocity) && fits(&state.effort)).then_some(state)
    }
}

impl Imu {
    /// Writes the message with a time (ns).
    pub fn write(&self, stamp: u64, out: &mut Vec<u8>) {
        let mut to = begin(out, stamp);
        let [w, x, y, z] = self.orientation;
        to.all(&[x, y, z, w]);
        to.all(&[0.0; 9]);
        to.all(&self.angular_velocity);
        to.all(&[0.0; 9]);
        to.all(&self.linear_acceleration);
        to.all(&[0.0; 9]);
    }

    /// Reads a message; `None` for anything else.
    pub fn read(bytes: &[u8]) -> Option<Self> {
        let mut from = Reader::begin(bytes)?;
        header(&mut from)?;
        let [x, y, z, w] = from.all()?;
        from.all::<f64, 9>()?;
        let angular_velocity = from.all()?;
        from.all::<f64, 9>()?;
        let linear_acceleration = from.all()?;
        from.all::<f64, 9>()?;
        Some(Self { orientation: [w, x, y, z], angular_velocity, linear_acceleration })
    }
}

impl JointTrajectory {
    /// Writes the message without a time of its own, which is: from now on.
    pub fn write(&self, out: &mut Vec<u8>) {
        let mut to = begin(out, 0);
        put_names(&mut to, &self.joint_names);
        to.length(1);
        to.sequence(&self.positions);
        // Velocities, accelerations, efforts.
        (0..3).for_each(|_| to.length(0));
        to.put((self.time_from_start / 1_000_000_000) as i32);
        to.put(self.time_from_start % 1_000_000_000);
    }

    /// Reads a message with one point; `None` for anything else.
    pub fn read(bytes: &[u8]) -> Option<Self> {
        let mut from = Reader::begin(bytes)?;
        header(&mut from)?;
        let joint_names = names(&mut from)?;
        // A point has at least four lengths and a duration.
        if from.length(24)? != 1 {
            return None;
        }
        let positions = from.sequence()?;
        for _ in 0..3 {
            from.sequence::<f64>()?;
        }
        let (seconds, nanoseconds) = (from.get::<i32>()?, from.get::<u32>()?);
        let time_from_start = u32::try_from(seconds).ok()?.checked_mul(1_000_000_000)?.checked_add(nanoseconds)?;
        Some(Self { joint_names, positions, time_from_start })
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn state() -> JointState {
        let name = vec!["knee".into(), "hip".into()];
        JointState { stamp: 3_000_000_007, name, position: vec![1.0, -2.0], velocity: vec![], effort: vec![3.0, 4.0] }
    }

    #[test]
    fn messages_are_read_as_they_were_written() {
        let mut bytes = Vec::new();
        state().write(&mut bytes);
        // By hand: header, time, a text of one zero, two names of which the first has four letters and a zero.
        assert_eq!(bytes[..17], [0, 1, 0, 0, 3, 0, 0, 0, 7, 0, 0, 0, 1, 0, 0, 0, 0]);
        assert_eq!(bytes[20..33], *b"\x02\0\0\0\x05\0\0\0knee\0");
        assert_eq!(JointState::read(&bytes), Some(state()));
        let (orientation, angular_velocity) = ([0.5, 0.1, 0.2, 0.3], [1.0, 2.0, 3.0]);
        let imu = Imu { orientation, angular_velocity, linear_acceleration: [4.0, 5.0, 6.0] };
        imu.write(5, &mut bytes);
        assert_eq!(Imu::read(&bytes), Some(imu));
        let joint_names = state().name;
        let trajectory = JointTrajectory { joint_names, positions: vec![0.5, 0.25], time_from_start: 1_000_000_002 };
        trajectory.write(&mut bytes);
        assert_eq!(JointTrajectory::read(&bytes), Some(trajectory));
    }

    #[test]
    fn messages_that_are_cut_off_or_long_are_refused() {
        let mut bytes = Vec::new();
        state().write(&mut bytes);
        for end in 0..bytes.len() {
            assert_eq!(JointState::read(&bytes[..end]), None, "{end} bytes");
        }
        for at in 4..bytes.len() - 4 {
            let mut damaged = bytes.clone();
            damaged[at..at + 4].fill(0xFF);
            // No length is believed: this neither panics nor runs out of memory.
            let _ = (JointState::read(&damaged), Imu::read(&damaged), JointTrajectory::read(&damaged));
        }
        JointState { effort: vec![1.0], ..state() }.write(&mut bytes);
        assert_eq!(JointState::read(&bytes), None, "one torque of two joints");
    }
}
