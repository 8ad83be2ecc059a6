//! From a checked script to a clip.

use lifelike_character::{Quat, Vec3};

use super::balance;
use super::curve::Curve;
use super::feet::{self, Foot};
use super::figure::{self, ARMS, CHEST, HEAD, LEGS, PELVIS};
use super::flight::{self, Flight};
use super::legs;
use super::text::{Channel, Script};
use crate::error::MotionError;
use crate::source::SourceClip;

/// Rounds of moving the pelvis until the centre of mass is where balance wants it. The legs make up a third of the
/// mass, so each round leaves less than a third of the error: after eight, well below a millimetre.
const ROUNDS: usize = 8;

/// Every curve of the script, by channel.
struct Curves([Curve; Channel::COUNT]);

impl Curves {
    fn new(script: &Script) -> Self {
        let period = script.cyclic.then_some(script.seconds);
        Self(std::array::from_fn(|at| Curve::new(&script.keys[at], period)))
    }

    /// Returns a channel's value (rad or m).
    fn at(&self, channel: Channel, time: f64) -> f64 {
        let value = self.0[channel as usize].at(time);
        if channel.is_length() { value } else { value.to_radians() }
    }

    /// Returns the rotation by pitch forward, then roll, then yaw, about fixed axes.
    fn turn(&self, [pitch, roll, yaw]: [Channel; 3], time: f64) -> Quat {
        Quat::from_euler_angles(self.at(roll, time), self.at(pitch, time), self.at(yaw, time))
    }
}

/// Flights of a clip that leaves the ground, and the height of the centre of mass in standing (m).
struct Air {
    flights: Vec<Flight>,
    centre: f64,
}

/// Returns the clip of a script.
pub(super) fn animate(script: &Script, name: &str) -> Result<SourceClip, MotionError> {
    let curves = Curves::new(script);
    let frames = (script.seconds * script.fps).round().max(1.0) as usize + 1;
    let pressure = balance::pressure(&script.steps, script.fps, frames);
    let flights = flight::flights(&script.steps);
    let time_of = |frame: usize| frame as f64 / script.fps;
    let rises: Vec<[f64; 2]> =
        (0..frames).map(|frame| flight::rise(&flights, time_of(frame), script.gravity)).collect();
    let gravity = if flights.is_empty() { balance::GRAVITY } else { script.gravity };
    let wanted = balance::centre_path(&pressure, &rises, script.fps, gravity);
    let far = |foot: usize, time: f64| {
        let side = ["left", "right"][foot];
        let message = format!("the {side} foot is out of the leg's reach at {time:.2} s");
        MotionError::Unfit { clip: name.to_owned(), message }
    };
    let mut air = Air { flights: Vec::new(), centre: 0.0 };
    if !flights.is_empty() {
        let (root, rotations) = posture(script, &curves, &air, 0.0, wanted[0]).map_err(|foot| far(foot, 0.0))?;
        let (places, turns) = figure::place(&root, &rotations);
        air = Air { flights, centre: figure::centre_of_mass(&places, &turns).z };
    }

    let mut clip = SourceClip {
        name: name.to_owned(),
        fps: script.fps,
        skeleton: figure::skeleton(),
        root_position: Vec::with_capacity(frames),
        rotations: Vec::with_capacity(frames),
        cyclic: script.cyclic,
        captions: Vec::new(),
        provenance: "keyframed for lifelike, MIT OR Apache-2.0".to_owned(),
        notes: Vec::new(),
    };
    for (frame, centre) in wanted.iter().enumerate() {
        let time = time_of(frame);
        let (root, rotations) = posture(script, &curves, &air, time, *centre).map_err(|foot| far(foot, time))?;
        clip.root_position.push(root);
        clip.rotations.push(rotations);
    }
    Ok(clip)
}

/// Returns the root and rotations at a time, with the centre of mass above `centre` (and what the script adds to that).
/// In a clip that leaves the ground the height, too, is that of the centre of mass, so that it falls as bodies do. The
/// error is the foot that cannot be reached.
fn posture(
    script: &Script,
    curves: &Curves,
    air: &Air,
    time: f64,
    centre: [f64; 2],
) -> Result<(Vec3, Vec<Quat>), usize> {
    let pitch = [Channel::LeftHeel, Channel::RightHeel].map(|channel| curves.at(channel, time));
    let both = [0, 1].map(|foot| feet::foot_at(&script.steps, foot, time).tilted(pitch[foot]));
    let heading = Quat::from_axis_angle(&Vec3::z_axis(), 0.5 * (both[0].yaw + both[1].yaw));
    let mut rotations = vec![Quat::identity(); figure::JOINTS];
    rotations[PELVIS] = heading * curves.turn([Channel::PelvisPitch, Channel::PelvisRoll, Channel::PelvisYaw], time);
    rotations[CHEST] = curves.turn([Channel::ChestPitch, Channel::ChestRoll, Channel::ChestYaw], time);
    rotations[HEAD] = curves.turn([Channel::HeadPitch, Channel::HeadRoll, Channel::HeadYaw], time);
    for side in 0..2 {
        let ahead = (heading.inverse() * (both[1 - side].ankle - both[side].ankle)).x;
        arm(&mut rotations, curves, time, side, (script.arm_swing * ahead).to_radians());
    }

    let offset = heading * Vec3::new(curves.at(Channel::PelvisX, time), curves.at(Channel::PelvisY, time), 0.0);
    let rise = curves.at(Channel::PelvisZ, time) + flight::rise(&air.flights, time, script.gravity)[0];
    let goal = Vec3::new(centre[0] + offset.x, centre[1] + offset.y, air.centre + rise);
    let mut root = Vec3::new(goal.x, goal.y, figure::STANDING + rise);
    for _ in 0..ROUNDS {
        for (side, foot) in both.iter().enumerate() {
            // Out of reach on the way does not matter; only where the pelvis ends up must both feet be reached.
            let _ = stand(&mut rotations, &root, side, foot);
        }
        let (places, turns) = figure::place(&root, &rotations);
        let off = goal - figure::centre_of_mass(&places, &turns);
        let up = if air.flights.is_empty() { 0.0 } else { off.z };
        root += Vec3::new(off.x, off.y, up);
    }
    for (side, foot) in both.iter().enumerate() {
        stand(&mut rotations, &root, side, foot).ok_or(side)?;
    }
    Ok((root, rotations))
}

/// Sets a leg so that its foot is where it should be. `None`: out of reach.
fn stand(rotations: &mut [Quat], root: &Vec3, side: usize, foot: &Foot) -> Option<()> {
    let pelvis = rotations[PELVIS];
    let sign = if side == feet::LEFT { 1.0 } else { -1.0 };
    let hip = root + pelvis * Vec3::new(0.0, sign * figure::HALF_HIPS, 0.0);
    // The knee points where pelvis and foot point on average.
    let forward = pelvis * Vec3::x() + foot.turn() * Vec3::x();
    let leg = legs::reach(&pelvis, &hip, &foot.ankle, &foot.turn(), &forward)?;
    for (joint, rotation) in LEGS[side].into_iter().zip(leg) {
        rotations[joint] = rotation;
    }
    Some(())
}

/// Sets an arm. Written from a hanging arm: turned inward about itself, lifted aside, raised forward.
fn arm(rotations: &mut [Quat], curves: &Curves, time: f64, side: usize, swing: f64) {
    let sign = if side == feet::LEFT { 1.0 } else { -1.0 };
    let [raise, aside, turn, elbow, twist] = Channel::ARMS[side].map(|channel| curves.at(channel, time));
    let about = |axis: Vec3, angle: f64| Quat::from_scaled_axis(axis * angle);
    let hanging = about(Vec3::x(), -sign * std::f64::consts::FRAC_PI_2);
    rotations[ARMS[side][0]] =
        about(Vec3::y(), -(raise + swing)) * about(Vec3::x(), sign * aside) * about(Vec3::z(), -sign * turn) * hanging;
    rotations[ARMS[side][1]] = about(Vec3::z(), -sign * elbow);
    rotations[ARMS[side][2]] = about(Vec3::y(), -twist);
}
