//! Promise: whatever is measured, asked for and when, nothing outside of the limits leaves.
use crate::common;
use lifelike_checkpoint::rng::stream;
use lifelike_runtime::gate::{Gate, Intent, LimitSettings};
use lifelike_runtime::{Limits, Measurement, Mode};
use rand::Rng;

/// Numbers that programs get wrong.
const ODD: [f32; 12] = [
    0.0,
    -0.0,
    f32::NAN,
    f32::INFINITY,
    f32::NEG_INFINITY,
    f32::MAX,
    f32::MIN,
    f32::MIN_POSITIVE,
    1e-30,
    1e30,
    -1e10,
    1e6,
];

fn number(rng: &mut impl Rng, size: f32) -> f32 {
    if rng.random_bool(0.02) { ODD[rng.random_range(0..ODD.len())] } else { size * rng.random_range(-1.0f32..=1.0) }
}

/// Time constant so short that motors get hot in this test.
fn settings() -> LimitSettings {
    LimitSettings { thermal_time: 0.2, ..LimitSettings::default() }
}

/// Runs triples of state, command and time, and returns how many were commands in position mode, with reduced gains, and
/// after a trip.
fn adversarial(triples: usize, seed: u64) -> [usize; 3] {
    let robot = common::lima();
    let limits = Limits::of(&robot, settings()).unwrap();
    let joints = robot.joints();
    let mut seen = [0; 3];
    let mut done = 0;
    while done < triples {
        let mut rng = stream(seed, "adversarial", 0, done as u64);
        let mut gate = Gate::new(limits.clone(), 1000.0);
        let (mut now, mut clock, mut sequence) = (0u64, 0u64, 0u32);
        let mut packet = Measurement::new(joints);
        let mut targets = vec![0.0f32; joints];
        let wildness = [0.0, 0.001, 0.05][rng.random_range(0..3)];
        let mut last: Option<(Vec<f32>, Option<Vec<f32>>)> = None;
        for tick in 0..rng.random_range(20..400) {
            now += if rng.random_bool(wildness) { rng.random_range(0..200_000_000) } else { 1_000_000 };
            clock = if rng.random_bool(wildness) { rng.random() } else { clock + 1_000_000 };
            sequence = if rng.random_bool(wildness) { rng.random() } else { sequence.wrapping_add(1) };
            (packet.sequence, packet.clock) = (sequence, clock);
            let wild = rng.random_bool(wildness);
            for j in 0..joints {
                let step = if wild { number(&mut rng, 20.0) } else { 0.02 * rng.random_range(-1.0f32..=1.0) };
                packet.position[j] = if packet.position[j].is_finite() { packet.position[j] + step } else { 0.0 };
                packet.velocity[j] = if wild { number(&mut rng, 50.0) } else { rng.random_range(-8.0f32..=8.0) };
                packet.torque[j] = if wild { number(&mut rng, 50.0) } else { f32::NAN };
                packet.temperature[j] = if wild { number(&mut rng, 120.0) } else { 60.0 };
                if tick % 20 == 0 || wild {
                    targets[j] = number(&mut rng, 3.0);
                    targets[j] = if wild || targets[j].is_finite() { targets[j] } else { 0.0 };
                }
            }
            packet.orientation = if wild { [(); 4].map(|()| number(&mut rng, 1.0)) } else { [1.0, 0.0, 0.0, 0.0] };
            packet.stop = wild && rng.random_bool(0.1);
            gate.receive(now, &packet);
            let mode = if rng.random_bool(0.99) { Mode::Position } else { Mode::Damp };
            let rate = if wild { number(&mut rng, 10.0) } else { f32::MAX };
            let up_b = if wild { [(); 3].map(|()| number(&mut rng, 1.0)) } else { [0.0, 0.0, 1.0] };
            let tripped = gate.trip().is_some();
            let state = gate.measured().cloned();
            let command = gate.pass(now, Intent { mode, targets: &targets, rate, reference: &[], up_b: Some(up_b) });
            done += 1;
            assert!(!tripped || command.mode() != Mode::Position, "a trip stays");
            seen[2] += usize::from(tripped);
            let mut reduced = false;
            let mut speeds = vec![0.0; joints];
            for (j, own) in limits.joints.iter().enumerate() {
                let (target, kp, kd) = (command.position()[j], command.kp()[j], command.kd()[j]);
                assert!((own.position.0..=own.position.1).contains(&target), "{target} {own:?}");
                assert!((0.0..=own.kp).contains(&kp) && (0.0..=own.kd).contains(&kd), "{kp} {kd}");
                if command.mode() != Mode::Position {
                    assert_eq!(kp, 0.0);
                }
                reduced |= kp > 0.0 && kp < own.kp;
                let Some(state) = &state else {
                    assert_ne!(command.mode(), Mode::Position, "nothing is known yet");
                    continue;
                };
                let torque = command.torque(j, state.position[j], state.velocity[j]);
                // A few roundings of numbers that may be as large as f32 allows.
                assert!(torque.abs() <= own.torque * (1.0 + 1e-5), "{torque} of {}", own.torque);
                if let (Some((before, speed)), Mode::Position) = (&last, command.mode()) {
                    let moved = target - before[j];
                    speeds[j] = moved / 1e-3;
                    let rounding = 4.0 * f32::EPSILON * target.abs().max(1.0);
                    assert!(moved.abs() <= own.rate * 1e-3 * (1.0 + 1e-5) + rounding, "{moved}");
                    let Some(speed) = speed else { continue };
                    let change = (speeds[j] - speed[j]).abs();
                    let most = own.acceleration * 1e-3 * (1.0 + 1e-4) + 2.0 * rounding / 1e-3;
                    assert!(change <= most, "{change} of {most} rad/s");
                }
            }
            seen[0] += usize::from(command.mode() == Mode::Position);
            seen[1] += usize::from(reduced);
            let known = last.is_some().then_some(speeds);
            last = (command.mode() == Mode::Position).then(|| (command.position().to_vec(), known));
        }
    }
    seen
}

#[test]
fn nothing_outside_of_the_limits_leaves() {
    let [driving, reduced, tripped] = adversarial(100_000, 1);
    assert!(driving > 20_000 && reduced > 2_000 && tripped > 5_000, "{driving} {reduced} {tripped}");
}

#[test]
#[ignore = "ten million triples: minutes"]
fn nothing_outside_of_the_limits_leaves_in_ten_million() {
    let counts: Vec<[usize; 3]> = (0..10).map(|seed| adversarial(1_000_000, 100 + seed)).collect();
    let sum = |i: usize| counts.iter().map(|count| count[i]).sum::<usize>();
    println!("driving {}, reduced gains {}, after a trip {}", sum(0), sum(1), sum(2));
}
