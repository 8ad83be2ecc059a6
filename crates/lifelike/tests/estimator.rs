//! The root's estimate against the physics, while lima walks.
#![allow(clippy::unwrap_used)]

use std::collections::VecDeque;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use lifelike::commands::clips;
use lifelike::commands::controller_file::Loaded;
use lifelike::simulated_robot::{MemoryBus, SensorOptions, SimulatedRobot, stepwise};
use lifelike_character::rotation::from_wxyz;
use lifelike_character::{Quat, Vec3};
use lifelike_runtime::{Bus, Config, Measurement, Phase, Playlist, Request, StateEstimator, Supervisor};
use lifelike_sim::{BatchState, EnvironmentParameters, SimulationSpec};

/// Returns orientation and linear velocity (m/s, world) of the root.
fn root(state: &BatchState) -> (Quat, Vec3) {
    let (q, v) = (&state.root_orientation, &state.linear_velocity_w);
    let orientation = from_wxyz([q[0], q[1], q[2], q[3]].map(f64::from)).unwrap();
    (orientation, Vec3::new(v[0].into(), v[1].into(), v[2].into()))
}

/// Errors of an estimate against the physics, over a run.
#[derive(Debug, Default)]
struct EstimateErrors {
    /// Root mean square of the velocity's error (m/s), largest tilt (rad), largest error of the height (m).
    velocity: f64,
    tilt: f64,
    height: f64,
    /// Share of steps in which a foot's contact is the engine's.
    contacts: f64,
}

/// A walk in which the estimator sees a machine's packets, some of them changed.
struct Walk {
    noise: f32,
    bias: f32,
    friction: Option<f32>,
    /// Packets by which joints are late against the IMU.
    joints_late: usize,
    /// Integrate the IMU without legs from the true state on.
    dead_reckoning: bool,
}

impl Walk {
    const PLAIN: Self = Self { noise: 0.0, bias: 0.0, friction: None, joints_late: 0, dead_reckoning: false };

    /// Runs lima's policy on the true root's state, so that no error of the estimate changes the walk.
    fn errors(&self) -> EstimateErrors {
        let loaded = Loaded::load(Path::new("lima"), None, None).unwrap();
        let controller = Arc::new(loaded.controller);
        let robot = Arc::clone(controller.robot());
        let fine = Arc::new(stepwise(&robot).unwrap());
        let (noise, bias) = (self.noise, self.bias);
        let options = SensorOptions { noise, bias, seed: 1, battery: 24.0, has_external: true, gantry: 0.0 };
        let mut simulation = SimulationSpec::new(1).build(fine).unwrap();
        if let Some(friction) = self.friction {
            let parameters = EnvironmentParameters { ground_friction: Some(friction), ..Default::default() };
            simulation.set_parameters(0, parameters).unwrap();
        }
        let machine = SimulatedRobot::new(&robot, simulation, options);
        let clips = ["builtin:walk", "builtin:turn_left_90", "builtin:side_step", "builtin:squat"].map(PathBuf::from);
        let clips = clips::load(&clips, &robot).unwrap();
        let motions = Playlist::new(&controller, &clips, 0.5).unwrap();
        let mut config = Config::default();
        config.durations.stand = 0.0;
        let mut supervisor = Supervisor::new(controller, motions, config).unwrap();
        let mut bus = MemoryBus::new(machine, supervisor.config().command_hz);
        bus.settle();
        let mut estimator = StateEstimator::new(&robot).unwrap();
        let mut packet = Measurement::new(robot.joints());
        let mut late: VecDeque<(Vec<f32>, Vec<f32>)> = VecDeque::new();
        let (mut reckoned, mut clock) = (None, 0);
        let (mut sums, mut count) = (EstimateErrors::default(), 0.0);
        for tick in 0..30_000_u64 {
            while bus.receive(&mut packet).unwrap() {
                supervisor.receive(tick * 1_000_000, &packet);
                late.push_back((packet.position.clone(), packet.velocity.clone()));
                if late.len() > self.joints_late + 1 {
                    late.pop_front();
                }
                (packet.position, packet.velocity) = late[0].clone();
                estimator.receive(&packet);
                let machine = bus.robot();
                let state = machine.simulation().state();
                let (root, moved) = root(state);
                let dt = (packet.clock - clock) as f64 * 1e-9;
                clock = packet.clock;
                // The start is not judged: the filter begins with a wrong velocity.
                if clock < 1_000_000_000 || dt == 0.0 {
                    continue;
                }
                let (own, speed) = reckoned.get_or_insert((root, moved));
                if self.dead_reckoning {
                    let three = |x: [f32; 3]| Vec3::from(x.map(f64::from));
                    *own *= Quat::from_scaled_axis(three(packet.gyroscope_b) * dt);
                    *speed += (*own * three(packet.accelerometer_b) - Vec3::z() * 9.81) * dt;
                } else {
                    let estimate = estimator.estimate().unwrap();
                    *own = from_wxyz(estimate.orientation.map(f64::from)).unwrap();
                    *speed = Vec3::from(estimate.linear_velocity_w.map(f64::from));
                    let height = f64::from(estimate.position[2] - state.root_position[2]).abs();
                    sums.height = sums.height.max(height);
                }
                // In the root's frame, because nothing measures the heading.
                let difference = own.inverse() * *speed - root.inverse() * moved;
                sums.velocity += difference.norm_squared();
                sums.tilt = sums.tilt.max((own.inverse() * Vec3::z()).angle(&(root.inverse() * Vec3::z())));
                let forces = state.foot_force.iter().map(|force| *force > 1.0);
                sums.contacts += estimator.contacts().zip(forces).filter(|(a, b)| a == b).count() as f64 / 2.0;
                count += 1.0;
            }
            let command = supervisor.tick(tick * 1_000_000, Request::Run);
            bus.send(command).unwrap();
            if supervisor.phase() == Phase::Idle && tick > 1000 {
                break;
            }
        }
        assert!(count > 2000.0 && supervisor.trip().is_none(), "{count} {:?}", supervisor.trip());
        EstimateErrors { velocity: (sums.velocity / count).sqrt(), contacts: sums.contacts / count, ..sums }
    }
}

/// Largest root mean square of the velocity's error (m/s). A leg of 0.42 m with 5 mrad of play and noise is 2.1 mm off at both ends
/// of a step of 0.3 s: 10 mm/s, and three times that.
const VELOCITY: f64 = 0.03;
/// Largest tilt (rad): such an error of the velocity, gained within half a step, is an acceleration of 2% of gravity.
const TILT: f64 = 0.02;
/// Largest error of the height (m): play, the rounding of the contact point over the sole, and feet that sink in.
const HEIGHT: f64 = 0.02;

#[test]
fn the_root_is_estimated_while_lima_walks() {
    for (name, walk) in [
        ("plain", Walk::PLAIN),
        ("noise", Walk { noise: 0.002, ..Walk::PLAIN }),
        ("bias", Walk { noise: 0.002, bias: 0.01, ..Walk::PLAIN }),
        ("joints 5 ms late", Walk { joints_late: 1, ..Walk::PLAIN }),
        ("friction 0.3", Walk { friction: Some(0.3), ..Walk::PLAIN }),
    ] {
        let errors = walk.errors();
        println!("{name}: {errors:?}");
        // The accelerometer's bias, ten times the gyroscope's on both horizontal axes, is a tilt while the robot hardly turns.
        let tilt = TILT + 10.0 * f64::from(walk.bias) * 2.0_f64.sqrt() / 9.81;
        assert!(errors.velocity < VELOCITY && errors.tilt < tilt && errors.height < HEIGHT, "{name}: {errors:?}");
    }
}

#[test]
fn without_contacts_the_errors_are_beyond_every_tolerance() {
    let errors = Walk { noise: 0.002, bias: 0.01, dead_reckoning: true, ..Walk::PLAIN }.errors();
    assert!(errors.velocity > 10.0 * VELOCITY && errors.tilt > TILT, "{errors:?}");
}
