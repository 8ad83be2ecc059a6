//! A frame as bytes: what a viewer draws.
//!
//! All numbers are little endian. A packet is a head of 32 bytes, then the body of the frame:
//!
//! | bytes | content |
//! | --- | --- |
//! | 1 | kind, 1 |
//! | 1 | flags: 1 plays, 2 has fallen, 4 is being built, 8 has a kept take |
//! | 2 | number of bodies B, the world left out |
//! | 2, 2 | numbers of joints J and feet F |
//! | 4, 4, 4 | frame, simulated frames, frames of the scene |
//! | 4 | version of the view that it belongs to |
//! | 4 | rate of the clock (f32) |
//! | 4 | held force (N, f32) |
//! | 16 + 14 B | physics: root (f32 x 3, m), unit (f32, m), bodies (i16 x 7) |
//! | 16 + 14 B | reference, likewise |
//! | J | joint errors in steps of half a degree |
//! | J | torques in 255ths of the largest |
//! | F | ground forces in 50ths of the weight |
//! | 16 + 14 B | physics of the kept take, where there is one |
//!
//! Bodies, errors, torques and forces are those of the frame while the clock stands, and of the next while it plays.
//! A body is its position less the root's in units, and its quaternion `wxyz` in units of 1/32767.

use lifelike_character::rotation::to_wxyz;
use lifelike_character::{Quat, Vec3};
use lifelike_evaluation::{Rollout, Snapshot};

/// Kind of a packet with a frame.
pub const FRAME: u8 = 1;
/// Kind of a packet with strips.
pub const STRIPS: u8 = 2;
/// Columns of the strips at most.
const MAX_COLUMNS: usize = 1000;
/// Numbers of a column: joint error, largest torque, two feet, fall.
const ROWS: usize = 5;

/// Numbers before a frame's body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Head {
    /// Plays, has fallen, is being built, has a kept take.
    pub flags: u8,
    /// Numbers of bodies (without the world), joints and feet.
    pub sizes: [u16; 3],
    /// Frame, simulated frames, frames of the scene, version of the view.
    pub counts: [u32; 4],
    /// Rate of the clock.
    pub rate: f32,
    /// Held force (N).
    pub force: f32,
}

impl Head {
    /// Returns the counts of a packet; zeros before the first one.
    pub fn counts_of(packet: &[u8]) -> [u32; 4] {
        let count = |i: usize| packet.get(8 + 4 * i..12 + 4 * i).and_then(|bytes| bytes.try_into().ok());
        [0, 1, 2, 3].map(|i| count(i).map_or(0, u32::from_le_bytes))
    }
}

/// Returns a packet.
pub fn packet(head: &Head, body: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(32 + body.len());
    bytes.extend([FRAME, head.flags]);
    head.sizes.iter().for_each(|size| bytes.extend(size.to_le_bytes()));
    head.counts.iter().for_each(|count| bytes.extend(count.to_le_bytes()));
    bytes.extend(head.rate.to_le_bytes());
    bytes.extend(head.force.to_le_bytes());
    bytes.extend(body);
    bytes
}

/// Returns the part of a frame's body in which physics is.
pub fn physics(body: &[u8], bodies: usize) -> &[u8] {
    body.get(..16 + 14 * bodies).unwrap_or_default()
}

/// Returns the body of the last frame of a rollout, and its column of the strips.
pub fn frame(rollout: &Rollout, fell: bool) -> (Box<[u8]>, [u8; ROWS]) {
    let (Some(simulated), Some(reference)) = (rollout.simulated.last(), rollout.reference.last()) else {
        return (Box::default(), [0; ROWS]);
    };
    let (joints, feet) = (rollout.names.joints.len(), rollout.names.feet.len());
    let mut bytes = Vec::with_capacity(32 + 28 * simulated.bodies.len() + 2 * joints + feet);
    pose(simulated, &mut bytes);
    pose(reference, &mut bytes);
    let errors = simulated.joints.iter().zip(&reference.joints).map(|(a, b)| (a - b).abs().to_degrees());
    let errors: Vec<f64> = errors.collect();
    bytes.extend(errors.iter().map(|degrees| (2.0 * degrees).round() as u8));
    let torques = last(&rollout.torque_share, joints).iter().map(|share| (255.0 * share).round() as u8);
    let torques: Vec<u8> = torques.collect();
    bytes.extend(&torques);
    let forces: Vec<u8> = last(&rollout.foot_force, feet).iter().map(|share| (50.0 * share).round() as u8).collect();
    bytes.extend(&forces);
    let mean = errors.iter().sum::<f64>() / errors.len().max(1) as f64;
    let foot = |i: usize| forces.get(i).copied().unwrap_or(0);
    let column =
        [(8.0 * mean).round() as u8, torques.iter().copied().max().unwrap_or(0), foot(0), foot(1), fell.into()];
    (bytes.into(), column)
}

fn last(values: &[f32], width: usize) -> &[f32] {
    &values[values.len().saturating_sub(width)..]
}

/// Root and bodies; a state that is not finite is drawn at the origin.
fn pose(snapshot: &Snapshot, bytes: &mut Vec<u8>) {
    let finite = |v: Vec3| if v.iter().all(|c| c.is_finite()) { v } else { Vec3::zeros() };
    let bodies = snapshot.bodies.get(1..).unwrap_or_default();
    let root = bodies.first().map_or_else(Vec3::zeros, |body| finite(body.0));
    let reach = bodies.iter().map(|body| (finite(body.0) - root).amax()).fold(0.0, f64::max);
    let unit = (reach / 32_767.0).max(1e-9);
    root.iter().chain([&unit]).for_each(|value| bytes.extend((*value as f32).to_le_bytes()));
    for (position, orientation) in bodies {
        let shift = (finite(*position) - root) / unit;
        let turn: [f64; 4] = to_wxyz(&Quat::new_normalize(**orientation)).map(|c| c * 32_767.0);
        shift.iter().chain(&turn).for_each(|value| bytes.extend((value.round() as i16).to_le_bytes()));
    }
}

/// Returns the strips below the timeline: kind, 3 bytes of padding, numbers of columns, simulated frames and frames of the
/// scene (u32), then rows. A column is the largest value of its frames.
pub fn strips(columns: &[[u8; ROWS]], frames: usize) -> Vec<u8> {
    let per = columns.len().div_ceil(MAX_COLUMNS).max(1);
    let merged: Vec<[u8; ROWS]> = columns
        .chunks(per)
        .map(|some| some.iter().fold([0; ROWS], |most, one| std::array::from_fn(|i| most[i].max(one[i]))))
        .collect();
    let mut bytes = vec![STRIPS, 0, 0, 0];
    [merged.len(), columns.len(), frames].iter().for_each(|count| bytes.extend((*count as u32).to_le_bytes()));
    (0..ROWS).for_each(|row| bytes.extend(merged.iter().map(|column| column[row])));
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_packet_begins_as_its_table_says() {
        let head = Head { flags: 3, sizes: [30, 29, 2], counts: [7, 8, 9, 1], rate: 0.25, force: 50.0 };
        let bytes = packet(&head, &[5]);
        assert_eq!(bytes.len(), 33);
        assert_eq!(bytes[..8], [1, 3, 30, 0, 29, 0, 2, 0]);
        assert_eq!((bytes[8], bytes[12], bytes[16], bytes[20]), (7, 8, 9, 1));
        assert_eq!(bytes[24..28], 0.25_f32.to_le_bytes());
    }

    #[test]
    fn many_frames_become_few_columns_without_losing_a_fall() {
        let mut columns = vec![[0; ROWS]; 75_000];
        columns[40_000][4] = 1;
        let bytes = strips(&columns, 75_000);
        assert_eq!(bytes.len(), 16 + 5 * 1000);
        assert_eq!(bytes[16 + 4 * 1000..].iter().filter(|fell| **fell == 1).count(), 1);
    }
}
