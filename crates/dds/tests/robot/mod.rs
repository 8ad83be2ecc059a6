//! The other process: robots that speak through rustdds and serde, for as many SECONDS as the environment says.

use std::time::{Duration, Instant};

use lifelike_unitree::{LowCmd, LowState};
use rustdds::{DomainParticipant, QosPolicies, QosPolicyBuilder, TopicKind, policy};
use serde::{Deserialize, Serialize};

const KNEE: usize = 3;
const WAIST: usize = 12;

#[derive(Debug, Serialize, Deserialize, Default, Clone)]
struct Header {
    seconds: i32,
    nanoseconds: u32,
    frame_id: String,
}

#[derive(Debug, Serialize)]
struct JointState {
    header: Header,
    name: Vec<String>,
    position: Vec<f64>,
    velocity: Vec<f64>,
    effort: Vec<f64>,
}

#[derive(Debug, Serialize)]
struct Imu {
    header: Header,
    orientation: [f64; 4],
    orientation_covariance: [f64; 9],
    angular_velocity: [f64; 3],
    angular_velocity_covariance: [f64; 9],
    linear_acceleration: [f64; 3],
    linear_acceleration_covariance: [f64; 9],
}

#[derive(Deserialize, Clone)]
struct Point {
    positions: Vec<f64>,
    velocities: Vec<f64>,
    accelerations: Vec<f64>,
    effort: Vec<f64>,
    seconds: i32,
    nanoseconds: u32,
}

#[derive(Deserialize, Clone)]
struct JointTrajectory {
    header: Header,
    joint_names: Vec<String>,
    points: Vec<Point>,
}

#[derive(Deserialize, Clone, Copy)]
struct MotorCmd {
    mode: u8,
    q: f32,
    dq: f32,
    tau: f32,
    kp: f32,
    kd: f32,
    reserve: u32,
}

/// Arrays of more than 32 items are arrays of arrays: CDR has no lengths between them.
#[derive(Deserialize, Clone)]
struct Command {
    modes: [u8; 2],
    motors: [[MotorCmd; 7]; 5],
    reserve: [u32; 4],
    crc: u32,
}

#[derive(Debug, Serialize, Default, Clone, Copy)]
struct MotorState {
    mode: u8,
    motion: [f32; 4],
    temperature: [i16; 2],
    vol: f32,
    words: [u32; 7],
}

#[derive(Debug, Serialize)]
struct State {
    version: [u32; 2],
    modes: [u8; 2],
    tick: u32,
    imu: [f32; 13],
    imu_temperature: i16,
    motors: [[MotorState; 7]; 5],
    remote: [[u8; 8]; 5],
    reserve: [u32; 4],
    crc: u32,
}

fn seconds() -> Duration {
    Duration::from_secs(std::env::var("SECONDS").map_or(1, |text| text.parse().unwrap()))
}

fn qos() -> QosPolicies {
    let reliable = policy::Reliability::Reliable { max_blocking_time: rustdds::Duration::from_millis(100) };
    QosPolicyBuilder::new().reliability(reliable).history(policy::History::KeepLast { depth: 10 }).build()
}

fn topic(domain: &DomainParticipant, name: &str, kind: &str) -> rustdds::Topic {
    domain.create_topic(name.into(), kind.into(), &qos(), TopicKind::NoKey).unwrap()
}

#[test]
#[ignore = "the other process of a_robot_under_ros_2_is_driven_by_names"]
fn plays_ros_2() {
    let domain = DomainParticipant::new(41).unwrap();
    let (publisher, subscriber) = (domain.create_publisher(&qos()).unwrap(), domain.create_subscriber(&qos()).unwrap());
    let states = topic(&domain, "rt/joint_states", "sensor_msgs::msg::dds_::JointState_");
    let states = publisher.create_datawriter_no_key_cdr::<JointState>(&states, None).unwrap();
    let imus = topic(&domain, "rt/imu/data", "sensor_msgs::msg::dds_::Imu_");
    let imus = publisher.create_datawriter_no_key_cdr::<Imu>(&imus, None).unwrap();
    let commands = "rt/joint_trajectory_controller/joint_trajectory";
    let commands = topic(&domain, commands, "trajectory_msgs::msg::dds_::JointTrajectory_");
    let mut commands = subscriber.create_datareader_no_key_cdr::<JointTrajectory>(&commands, None).unwrap();
    let names = ["hand_joint", "waist_yaw_joint", "left_knee_joint"].map(String::from).to_vec();
    let (mut count, mut wrong, mut knee, mut waist, mut time) = (0, 0, 0.0, 0.0, 0.0);
    let begin = Instant::now();
    while begin.elapsed() < seconds() {
        while let Ok(Some(sample)) = commands.take_next_sample() {
            let JointTrajectory { header, joint_names, points } = sample.into_value();
            count += 1;
            let is_now = (header.seconds, header.nanoseconds) == (0, 0) && header.frame_id.is_empty();
            let [point] = &points[..] else { panic!("{} points", points.len()) };
            let is_bare = point.velocities.is_empty() && point.accelerations.is_empty() && point.effort.is_empty();
            wrong += usize::from(!is_now || !is_bare || joint_names != ["left_knee_joint", "waist_yaw_joint"]);
            (knee, waist) = (point.positions[0], point.positions[1]);
            time = f64::from(point.seconds) + 1e-9 * f64::from(point.nanoseconds);
        }
        let now = begin.elapsed();
        let header =
            Header { seconds: now.as_secs() as i32, nanoseconds: now.subsec_nanos(), frame_id: "base_link".into() };
        let (position, velocity) = (vec![9.0, waist, knee], vec![9.0, 0.02, 0.01]);
        let state =
            JointState { header: header.clone(), name: names.clone(), position, velocity, effort: vec![9.0, 2.0, 1.0] };
        states.write(state, None).unwrap();
        let imu = Imu {
            header,
            orientation: [0.0, 0.0, 0.0, 1.0],
            orientation_covariance: [7.0; 9],
            angular_velocity: [0.1, 0.2, 0.3],
            angular_velocity_covariance: [7.0; 9],
            linear_acceleration: [0.0, 0.0, 9.81],
            linear_acceleration_covariance: [7.0; 9],
        };
        imus.write(imu, None).unwrap();
        std::thread::sleep(Duration::from_millis(4));
    }
    println!("told: {count} {wrong} {knee} {waist} {time}");
}

#[test]
#[ignore = "the other process of a_g1_is_driven_and_says_what_it_is"]
fn plays_a_g1() {
    let domain = DomainParticipant::new(0).unwrap();
    let (publisher, subscriber) = (domain.create_publisher(&qos()).unwrap(), domain.create_subscriber(&qos()).unwrap());
    let states = topic(&domain, "rt/lowstate", "unitree_hg::msg::dds_::LowState_");
    let states = publisher.create_datawriter_no_key_cdr::<State>(&states, None).unwrap();
    let commands = topic(&domain, "rt/lowcmd", "unitree_hg::msg::dds_::LowCmd_");
    let mut commands = subscriber.create_datareader_no_key_cdr::<Command>(&commands, None).unwrap();
    let (mut count, mut damaged, mut others, mut enabled, mut stiffness) = (0, 0, 0, 0, 0.0);
    let mut state = LowState { mode_machine: 5, ..LowState::default() };
    state.imu_state.quaternion = [1.0, 0.0, 0.0, 0.0];
    let begin = Instant::now();
    while begin.elapsed() < seconds() {
        while let Ok(Some(sample)) = commands.take_next_sample() {
            let Command { modes: [mode_pr, mode_machine], motors, reserve, crc } = sample.into_value();
            let mut message = LowCmd { mode_pr, mode_machine, reserve, ..LowCmd::default() };
            for (to, from) in message.motor_cmd.iter_mut().zip(motors.iter().flatten()) {
                (to.mode, to.q, to.dq, to.tau) = (from.mode, from.q, from.dq, from.tau);
                (to.kp, to.kd, to.reserve) = (from.kp, from.kd, from.reserve);
            }
            (count, damaged) = (count + 1, damaged + usize::from(message.crc() != crc));
            others += usize::from(mode_machine != 5);
            enabled = message.motor_cmd.iter().filter(|motor| motor.mode == 1).count();
            stiffness = message.motor_cmd.iter().map(|motor| motor.kp).sum();
            for i in [KNEE, WAIST] {
                if message.motor_cmd[i].kp > 0.0 {
                    state.motor_state[i].q = message.motor_cmd[i].q;
                }
                (state.motor_state[i].vol, state.motor_state[i].temperature) = (52.0, [30, 36]);
            }
        }
        state.tick = (begin.elapsed().as_millis() as u32) & !1;
        let mut motors = [[MotorState::default(); 7]; 5];
        for (to, from) in motors.iter_mut().flatten().zip(&state.motor_state) {
            (to.motion[0], to.temperature, to.vol) = (from.q, from.temperature, from.vol);
        }
        let mut imu = [0.0; 13];
        imu[0] = 1.0;
        let message = State {
            version: [0; 2],
            modes: [0, 5],
            tick: state.tick,
            imu,
            imu_temperature: 0,
            motors,
            remote: [[0; 8]; 5],
            reserve: [0; 4],
            crc: state.crc(),
        };
        states.write(message, None).unwrap();
        std::thread::sleep(Duration::from_millis(2));
    }
    println!("told: {count} {damaged} {others} {enabled} {stiffness}");
}
