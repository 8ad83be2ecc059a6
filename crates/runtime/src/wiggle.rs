//! A wiggle on a stand: each motor turns its own joint, by the right sign, and its encoder sees it.
//!
//! One joint after the other follows a sine about where it is. Every encoder is read, and the product with the sine is
//! summed: an encoder that belongs to the motor has the amplitude of the command.

use crate::bus::{Bus, Measurement};
use crate::clock::Clock;
use crate::gate::{Gate, Intent, Limits, Mode};

/// Amplitude of the command (rad).
const AMPLITUDE: f32 = 0.1;
/// Length of the wiggle of one joint, one period (s).
const SECONDS: f64 = 1.0;
/// Rest between two joints (s).
const REST: f64 = 0.25;
/// Least response of a joint that is driven, as a share of the command.
const RESPONSE: f32 = 0.3;

/// Response of every encoder to one motor, as shares of the command's amplitude.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Response {
    /// The joint whose motor was driven.
    pub joint: String,
    /// Response of each encoder, `[J]`.
    pub encoders: Vec<f32>,
}

/// Drives every motor of a robot on a stand, and returns the responses; those before a trip of the gate where it trips.
pub fn identify(
    joints: &[String],
    limits: Limits,
    command_hz: f64,
    bus: &mut dyn Bus,
    clock: &mut dyn Clock,
) -> (Vec<Response>, Option<crate::gate::Trip>) {
    let period = (1e9 / command_hz).round() as u64;
    let count = joints.len();
    let mut gate = Gate::new(limits, command_hz);
    let (mut packet, mut targets) = (Measurement::new(count), vec![0.0; count]);
    let mut origin: Option<Vec<f32>> = None;
    let mut responses = Vec::new();
    let (ticks, rest) = ((SECONDS * command_hz).round() as usize, (REST * command_hz).round() as usize);
    let mut sums = vec![0.0f32; count];
    let (mut driven, mut tick, mut waited, mut norm) = (0, 0, 0, 0.0f32);
    let mut deadline = clock.now();
    // Up to two seconds for the first packets.
    while driven < count && gate.trip().is_none() && waited as f64 <= 2.0 * command_hz {
        deadline += period;
        let now = clock.wait_until(deadline);
        while bus.receive(&mut packet).unwrap_or(false) {
            gate.receive(now, &packet);
        }
        let Some(measured) = gate.measured().map(|measured| measured.position.clone()) else {
            waited += 1;
            continue;
        };
        let home = origin.get_or_insert_with(|| measured.clone());
        let angle = std::f32::consts::TAU * tick as f32 / ticks as f32;
        targets.copy_from_slice(home);
        let sine = if tick < ticks { angle.sin() } else { 0.0 };
        targets[driven] += AMPLITUDE * sine;
        norm += AMPLITUDE * sine * sine;
        for ((sum, q), home) in sums.iter_mut().zip(&measured).zip(home.iter()) {
            *sum += (q - home) * sine;
        }
        let intent = Intent { mode: Mode::Position, targets: &targets, rate: f32::MAX, reference: &[], up_b: None };
        let _ = bus.send(gate.pass(now, intent));
        tick += 1;
        if tick == ticks + rest {
            let encoders = sums.iter().map(|sum| sum / norm.max(1e-9)).collect();
            responses.push(Response { joint: joints[driven].clone(), encoders });
            sums.fill(0.0);
            (driven, tick, norm) = (driven + 1, 0, 0.0);
        }
    }
    let braking = Intent { mode: Mode::Off, targets: &targets, rate: 0.0, reference: &[], up_b: None };
    let _ = bus.send(gate.pass(deadline, braking));
    (responses, gate.trip())
}

/// Returns a line for each motor whose encoder is not its own, dead or reversed.
pub fn defects(responses: &[Response], joints: &[String]) -> Vec<String> {
    let mut lines = Vec::new();
    for (i, response) in responses.iter().enumerate() {
        let own = response.encoders.get(i).copied().unwrap_or(f32::NAN);
        let strongest = (0..response.encoders.len())
            .max_by(|a, b| response.encoders[*a].abs().total_cmp(&response.encoders[*b].abs()))
            .unwrap_or(i);
        let (joint, share) = (&response.joint, response.encoders.get(strongest).copied().unwrap_or(0.0));
        if strongest != i && share.abs() >= RESPONSE {
            let other = &joints[strongest];
            lines.push(format!("motor '{joint}': expected its own encoder to move, got that of '{other}': swapped"));
        } else if own <= -RESPONSE {
            lines.push(format!("motor '{joint}': expected its encoder to follow, got the opposite sign: reversed"));
        } else if own.is_nan() || own < RESPONSE {
            let got = 100.0 * own;
            lines.push(format!("motor '{joint}': expected its encoder to move, got {got:.0}% of the command: dead"));
        }
    }
    if responses.len() < joints.len() {
        lines.push(format!("expected {} motors to be driven, got {}", joints.len(), responses.len()));
    }
    lines
}
