//! Both buses against a robot in another process. Its messages are encoded by rustdds' own CDR, from the published definitions.
#![allow(clippy::unwrap_used)]

mod robot;

use std::io::ErrorKind;
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use lifelike_dds::{JointTrajectory, Ros2Options, ros2, unitree};
use lifelike_robot::Robot;
use lifelike_runtime::gate::{Gate, Intent, LimitSettings};
use lifelike_runtime::{Bus, Limits, Measurement, Mode};

fn legs() -> Robot {
    let file = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/data/legs.xml");
    Robot::load(&file.display().to_string()).unwrap()
}

/// This file's program as a robot, which prints what it was told when it ends.
fn start(test: &str, environment: &[(&str, &str)]) -> Child {
    let mut command = Command::new(std::env::current_exe().unwrap());
    command.args(["--exact", test, "--ignored", "--nocapture"]).envs(environment.iter().copied());
    command.stdout(Stdio::piped()).spawn().unwrap()
}

/// Returns the line that a robot ends with.
fn end(robot: Child) -> Vec<f64> {
    let text = String::from_utf8(robot.wait_with_output().unwrap().stdout).unwrap();
    let line = text.lines().find_map(|line| line.split_once("told:")).unwrap_or_else(|| panic!("{text}")).1;
    line.split_whitespace().map(|x| x.parse().unwrap()).collect()
}

/// Drives through the gate for a time in a mode, and returns the last measurement and command.
fn drive(bus: &mut dyn Bus, gate: &mut Gate, begin: Instant, mode: Mode, seconds: f64) -> (Measurement, Vec<f32>) {
    let (mut measured, mut sent) = (Measurement::new(2), Vec::new());
    let until = Instant::now() + Duration::from_secs_f64(seconds);
    while Instant::now() < until {
        let now = begin.elapsed().as_nanos() as u64;
        while bus.receive(&mut measured).unwrap() {
            gate.receive(now, &measured);
        }
        let command = gate.pass(now, Intent { mode, targets: &[0.25, -0.5], rate: 10.0, reference: &[], up_b: None });
        sent = command.position().to_vec();
        // A thread that sends late, beside other work, leaves no room for one command.
        let sending = bus.send(command);
        assert!(sending.is_ok() || sending.is_err_and(|error| error.kind() == ErrorKind::WouldBlock));
        std::thread::sleep(Duration::from_millis(2));
    }
    (measured, sent)
}

fn gate(robot: &Robot) -> Gate {
    let patient = LimitSettings { lost_time: 5.0, delay_max: 5.0, overrun_time: 5.0, ..LimitSettings::default() };
    Gate::new(Limits::of(robot, patient).unwrap(), 500.0)
}

#[test]
fn a_robot_under_ros_2_is_driven_by_names() {
    let peer = start("robot::plays_ros_2", &[("SECONDS", "9")]);
    let robot = legs();
    let options = Ros2Options { domain: 41, ..Ros2Options::default() };
    let mut bus = ros2(&options, &robot, 500.0).unwrap();
    let facts = bus.facts().unwrap();
    assert_eq!(facts.joints, robot.layout.joints, "in the order of the controller's robot, without the hand");
    assert!((100.0..260.0).contains(&facts.state_hz), "{}", facts.state_hz);
    let (mut gate, begin) = (gate(&robot), Instant::now());
    let (measured, sent) = drive(&mut bus, &mut gate, begin, Mode::Position, 1.5);
    assert_eq!(gate.trip(), None);
    assert_eq!(sent, [0.25, -0.5]);
    // The robot reports where it was driven to; velocities, torques and the IMU are those of the peer.
    assert_eq!(measured.position, [0.25, -0.5]);
    assert_eq!((measured.velocity.as_slice(), measured.torque.as_slice()), (&[0.01, 0.02][..], &[1.0, 2.0][..]));
    assert_eq!((measured.orientation, measured.gyroscope_b), ([1.0, 0.0, 0.0, 0.0], [0.1, 0.2, 0.3]));
    drive(&mut bus, &mut gate, begin, Mode::Damp, 0.3);
    drop(bus);
    let told = end(peer);
    // Number of commands, of which those of another layout, then the targets of knee, waist and time (s).
    assert!(told[0] > 100.0 && told[1] == 0.0, "{told:?}");
    assert_eq!(told[2..], [0.25, -0.5, 0.002], "braking holds the pose");
}

#[test]
fn a_g1_is_driven_and_says_what_it_is() {
    let peer = start("robot::plays_a_g1", &[("SECONDS", "6"), ("DOMAIN", "0")]);
    let robot = legs();
    let mut bus = unitree("", None, &robot).unwrap();
    let facts = bus.facts().unwrap();
    assert_eq!((facts.robot.as_str(), facts.motors, facts.mode.as_str()), ("legs", 2, "position"));
    assert!((200.0..510.0).contains(&facts.state_hz), "{}", facts.state_hz);
    let (mut gate, begin) = (gate(&robot), Instant::now());
    let (measured, _) = drive(&mut bus, &mut gate, begin, Mode::Position, 1.5);
    assert_eq!(gate.trip(), None);
    assert_eq!(measured.position, [0.25, -0.5]);
    assert_eq!((measured.battery, measured.temperature.as_slice()), (52.0, &[36.0, 36.0][..]));
    // A rival's commands and another revision are seen in the facts of a second bus.
    let other = unitree("", Some(11), &robot).unwrap().facts().unwrap();
    assert_eq!(other.robot, "a G1 of mode_machine 5 in place of 11");
    assert!(other.mode.contains("another program, which sends rt/lowcmd"), "{}", other.mode);
    drive(&mut bus, &mut gate, begin, Mode::Damp, 0.2);
    drop(bus);
    let told = end(peer);
    // Commands, wrong checksums, wrong mode_machine, enabled motors of the last, its sum of kp.
    assert!(told[0] > 100.0, "{told:?}");
    assert_eq!(told[1..], [0.0, 0.0, 2.0, 0.0]);
}

#[test]
fn a_trajectory_is_that_of_cyclone_dds_byte_for_byte() {
    let joint_names = ["left_knee_joint", "hip"].map(String::from).to_vec();
    let message = JointTrajectory { joint_names, positions: vec![0.5, -0.25], time_from_start: 1_000_000_002 };
    let (mut bytes, expected) = (Vec::new(), include_bytes!("data/joint_trajectory.cdr"));
    message.write(&mut bytes);
    // Cyclone says in its header how many bytes it added to fill the last word.
    let added = usize::from(expected[3]);
    assert_eq!(bytes[4..], expected[4..expected.len() - added]);
}

#[test]
fn what_is_missing_is_said() {
    let robot = legs();
    let error = unitree("no-such-interface", None, &robot).err().unwrap().to_string();
    assert!(error.contains("expected a network interface, one of ") && error.contains("lo"), "{error}");
    let options = Ros2Options { domain: 43, ..Ros2Options::default() };
    let error = ros2(&options, &robot, 500.0).err().unwrap().to_string();
    assert!(error.contains("expected a sensor_msgs/JointState on /joint_states within 3 s"), "{error}");
    let lima = Robot::load("lima").unwrap();
    let error = unitree("", None, &lima).err().unwrap().to_string();
    assert!(error.contains("expected a robot with the joints of the G1"), "{error}");
}

/// Against Cyclone DDS and Unitree's published messages, in Python (`peers/unitree/robot.py` says what to install).
#[test]
#[ignore = "needs Python with unitree_dds_wrapper: LIFELIKE_PYTHON names it"]
fn a_g1_of_the_published_package_is_driven() {
    let python = std::env::var("LIFELIKE_PYTHON").unwrap_or_else(|_| "python3".into());
    let script = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../peers/unitree/robot.py");
    let play = |words: &[&str]| {
        let mut command = Command::new(&python);
        command.arg(&script).args(words).stdout(Stdio::piped()).spawn().unwrap()
    };
    let told = |robot: Child| String::from_utf8(robot.wait_with_output().unwrap().stdout).unwrap();
    let robot = legs();

    let peer = play(&["--seconds", "12", "--stop-after", "4"]);
    let mut bus = unitree("", None, &robot).unwrap();
    let facts = bus.facts().unwrap();
    assert_eq!((facts.robot.as_str(), facts.motors, facts.mode.as_str()), ("legs", 2, "position"));
    let (mut gate, begin) = (gate(&robot), Instant::now());
    let (measured, _) = drive(&mut bus, &mut gate, begin, Mode::Position, 3.0);
    assert_eq!((gate.trip(), measured.battery), (None, 52.0));
    assert!((measured.position[0] - 0.25).abs() < 1e-3 && (measured.position[1] + 0.5).abs() < 1e-3, "{measured:?}");
    // L2 and B of the remote.
    drive(&mut bus, &mut gate, begin, Mode::Position, 2.0);
    assert!(gate.trip().is_some_and(|trip| trip.words(&robot.layout.joints).contains("stop button")));
    drop(bus);
    let said = told(peer);
    println!("{facts:?}\n{said}");
    for part in ["\"damaged\": 0", "\"other_mode_machine\": 0", "\"enabled\": 2"] {
        assert!(said.contains(part), "{part}: {said}");
    }
    assert!(!said.contains("\"commands\": 0") && !said.contains("\"braking\": 0"), "{said}");

    let peer = play(&["--seconds", "6", "--rival", "--mode-machine", "4"]);
    let facts = unitree("", None, &robot).unwrap().facts().unwrap();
    assert_eq!(facts.robot, "a G1 of mode_machine 4 in place of 5");
    assert!(facts.mode.contains("which sends rt/lowcmd"), "{}", facts.mode);
    told(peer);
}
