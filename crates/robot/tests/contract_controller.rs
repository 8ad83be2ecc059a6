//! Promises about controllers: one file, one robot, no surprises, no allocation.
#![allow(clippy::unwrap_used, clippy::expect_used)]

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use lifelike_checkpoint::{Checkpoint, Entry};
use lifelike_robot::actuator::ExtendedFriction;
use lifelike_robot::controller::{ControllerHeader, PriorEncoder, RobotDescription};
use lifelike_robot::reference::standing_clip;
use lifelike_robot::{ClipPlayer, Controller, ControllerFile, ControllerState, MeasuredState, ReferenceLibrary, Robot};

/// Counts the allocations of a thread.
struct Counting;

thread_local! {
    static COUNT: Cell<usize> = const { Cell::new(0) };
}

// SAFETY: every call is the system's allocator's own.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        let _ = COUNT.try_with(|count| count.set(count.get() + 1));
        unsafe { System.alloc(layout) }
    }
    unsafe fn dealloc(&self, at: *mut u8, layout: Layout) {
        unsafe { System.dealloc(at, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

fn asset(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets").join(name)
}

fn lima() -> Arc<Robot> {
    Arc::new(Robot::load("lima").unwrap())
}

fn numbers(count: usize, step: usize, size: f32) -> Vec<f32> {
    (0..count).map(|i| (((i * step) % 997) as f32 / 498.5 - 1.0) * size).collect()
}

/// A policy that wants everything: latent codes, a window of its own, future frames.
fn curious(robot: &Arc<Robot>, prior: Option<&Checkpoint>) -> Controller {
    use lifelike_robot::{ActionSpec, AnchorSpec, ObservationSpec, ReferenceSpec};
    let reference =
        ReferenceSpec { frame: true, future: vec![5], latent: 64, window: vec![-2, 0, 2], ..Default::default() };
    let observation = ObservationSpec::new(robot, reference, AnchorSpec { heading: true, position: true });
    let (size, window, joints) = (observation.size(), observation.window_size(), robot.joints());
    let header = ControllerHeader {
        encoder: Some((vec![32], 8)),
        ..ControllerHeader::new(robot, observation, ActionSpec::Reference { scale: 0.5 }, vec![24])
    };
    let mut file = Checkpoint::new();
    for (name, widths) in [("actor.encoder", [window, 32, 8]), ("actor.mean", [size - window + 8, 24, joints])] {
        for (i, pair) in widths.windows(2).enumerate() {
            let weight = numbers(pair[0] * pair[1], 7919 + i, 0.2);
            file.put_f32(&format!("{name}.layers.{i}.weight"), pair, weight).unwrap();
            file.put_f32(&format!("{name}.layers.{i}.bias"), &pair[1..], numbers(pair[1], 31, 0.1)).unwrap();
        }
    }
    file.put_f64("normalizer.mean", &[size], vec![0.1; size]).unwrap();
    file.put_f64("normalizer.variance", &[size], vec![0.7; size]).unwrap();
    file.put_f64("normalizer.settings", &[4], vec![1.0, 1.0, 5.0, 1.0]).unwrap();
    let prior = prior.map(|prior| PriorEncoder::from_prior(prior).unwrap());
    Controller::new(ControllerFile::new(header, &file, prior, robot).unwrap(), Arc::clone(robot)).unwrap()
}

/// A policy with a memory: a recurrent unit over its last four steps.
fn remembering(robot: &Arc<Robot>) -> Controller {
    use lifelike_robot::{ActionSpec, AnchorSpec, ObservationSpec, ReferenceSpec};
    let reference = ReferenceSpec { frame: true, history: 4, ..Default::default() };
    let observation = ObservationSpec::new(robot, reference, AnchorSpec::default());
    let (size, history, joints) = (observation.size(), observation.history_size(), robot.joints());
    let header = ControllerHeader {
        memory: Some(16),
        ..ControllerHeader::new(robot, observation, ActionSpec::Reference { scale: 0.5 }, Vec::new())
    };
    let mut file = Checkpoint::new();
    let maps =
        [("memory.input", [history / 4, 48]), ("memory.state", [16, 48]), ("mean", [size - history + 16, joints])];
    for (i, (name, shape)) in maps.into_iter().enumerate() {
        let weight = numbers(shape[0] * shape[1], 7919 + i, 0.2);
        file.put_f32(&format!("actor.{name}.layers.0.weight"), &shape, weight).unwrap();
        file.put_f32(&format!("actor.{name}.layers.0.bias"), &shape[1..], numbers(shape[1], 31, 0.1)).unwrap();
    }
    file.put_f64("normalizer.mean", &[size], vec![0.1; size]).unwrap();
    file.put_f64("normalizer.variance", &[size], vec![0.7; size]).unwrap();
    file.put_f64("normalizer.settings", &[4], vec![1.0, 1.0, 5.0, 1.0]).unwrap();
    Controller::new(ControllerFile::new(header, &file, None, robot).unwrap(), Arc::clone(robot)).unwrap()
}

#[test]
fn a_policy_with_a_memory_sees_its_own_past_and_forgets_it_where_an_episode_begins() {
    let (robot, folder) = (lima(), tempfile::tempdir().unwrap());
    let library = ReferenceLibrary::new(&robot, &[bend(&robot)], None).unwrap();
    let path = folder.path().join("x.controller.safetensors");
    remembering(&robot).save(&path).unwrap();
    let controller = Controller::load(&path, robot.clone()).unwrap();
    let first = run(&controller, &library, 12);
    assert_eq!(run(&controller, &library, 12), first);
    // A robot that stands still: what differs between steps is the reference and the own actions of the past.
    let state = ControllerState::new(&controller);
    assert_eq!(state.history.memory.past(), [0.0; 0]);
    let spec = controller.observation();
    let own = spec.size() - spec.history_size();
    let (q, v) = (library.joints_at(3).to_vec(), vec![0.0; robot.joints()]);
    let measured = upright(&q, &v);
    let (mut state, mut player) = (state, ClipPlayer::new(&library, 0));
    let (mut targets, mut seen) = (vec![0.0; robot.joints()], Vec::new());
    for _ in 0..6 {
        controller.step(&mut state, &measured, &mut player, &mut targets).unwrap();
        // As the network gets it: normalised, history included.
        let row = state.observation();
        seen.push(spec.remembered().iter().map(|&number| row[number]).collect::<Vec<_>>());
        let newest = &row[spec.size() - spec.history_size() / 4..];
        let before = &seen[seen.len().saturating_sub(2)];
        assert_eq!(newest, before, "step {}", seen.len());
        assert_eq!(&row[own..][..seen[0].len()], &seen[seen.len().saturating_sub(5)]);
    }
    controller.begin(&mut state, &measured, &player).unwrap();
    assert_eq!(state.history.memory.past(), [0.0; 0]);
}

/// A robot that stands at the origin.
fn upright<'a>(q: &'a [f32], v: &'a [f32]) -> MeasuredState<'a> {
    MeasuredState {
        joint_position: q,
        joint_velocity: v,
        root_orientation: [1.0, 0.0, 0.0, 0.0],
        root_position: Some([0.0; 3]),
        linear_velocity_w: Some([0.0; 3]),
        ..MeasuredState::default()
    }
}

/// Runs a controller over a still robot and gives all joint targets.
fn run(controller: &Controller, library: &ReferenceLibrary, steps: usize) -> Vec<f32> {
    let robot = controller.robot();
    let (q, v) = (library.joints_at(3).to_vec(), vec![0.0; robot.joints()]);
    let measured = MeasuredState {
        joint_position: &q,
        joint_velocity: &v,
        root_orientation: [0.8, 0.0, 0.0, 0.6],
        root_position: Some([1.0, 2.0, 0.5]),
        linear_velocity_w: Some([0.1, 0.0, 0.0]),
        ..MeasuredState::default()
    };
    let mut state = ControllerState::new(controller);
    let mut player = ClipPlayer::new(library, 0);
    let mut all = Vec::new();
    for _ in 0..steps {
        let mut targets = vec![f32::NAN; robot.joints()];
        controller.step(&mut state, &measured, &mut player, &mut targets).unwrap();
        all.extend(targets);
    }
    all
}

fn bend(robot: &Robot) -> lifelike_motion::MotionClip {
    let mut clip = standing_clip(robot, 1.0);
    let joints = robot.joints();
    for (i, q) in clip.joints.iter_mut().enumerate() {
        *q += 0.1 * ((i / joints) as f64 * 0.2 + (i % joints) as f64).sin();
    }
    clip
}

#[test]
fn a_controller_that_is_written_again_gives_the_same_numbers() {
    let (robot, folder) = (lima(), tempfile::tempdir().unwrap());
    let library = ReferenceLibrary::new(&robot, &[bend(&robot)], None).unwrap();
    let name = "lima-path.controller.safetensors";
    let policy = Controller::load(&asset(name), robot.clone()).unwrap();
    let path = folder.path().join("x.controller.safetensors");
    policy.save(&path).unwrap();
    let controller = Controller::load(&path, robot.clone()).unwrap();
    let (expected, got) = (run(&policy, &library, 20), run(&controller, &library, 20));
    assert!(expected.iter().all(|x| x.is_finite()));
    assert_eq!(expected, got, "{name}");
    assert_eq!(policy.header(), controller.header());
}

#[test]
fn one_file_holds_the_priors_encoder_and_codes_made_live_are_those_made_beforehand() {
    let (robot, folder) = (lima(), tempfile::tempdir().unwrap());
    let prior = Checkpoint::load(&asset("lima.prior.safetensors")).unwrap();
    let controller = curious(&robot, Some(&prior));
    let path = folder.path().join("x.controller.safetensors");
    controller.save(&path).unwrap();
    let loaded = Controller::load(&path, robot.clone()).unwrap();
    let with_codes = ReferenceLibrary::new(&robot, &[bend(&robot)], Some(loaded.prior().unwrap())).unwrap();
    let without = ReferenceLibrary::new(&robot, &[bend(&robot)], None).unwrap();
    let (beforehand, live) = (run(&loaded, &with_codes, 30), run(&loaded, &without, 30));
    for (a, b) in beforehand.iter().zip(&live) {
        assert!((a - b).abs() < 1e-5, "{a} {b}");
    }
    assert!(with_codes.latents.iter().any(|z| z.abs() > 0.1), "codes say something");

    let (mut permuted, mut without_codes) = (with_codes.clone(), without.clone());
    permuted.permute_codes(1).unwrap();
    let sorted = |library: &ReferenceLibrary| {
        let mut rows: Vec<Vec<u32>> =
            library.latents.chunks(library.latent).map(|row| row.iter().map(|z| z.to_bits()).collect()).collect();
        rows.sort();
        rows
    };
    assert_eq!(sorted(&permuted), sorted(&with_codes), "every code is used once");
    assert_ne!(run(&loaded, &permuted, 30), beforehand, "and by another frame");
    assert_eq!(permuted.features, with_codes.features);
    assert!(without_codes.permute_codes(1).is_err());

    let blind = curious(&robot, None);
    assert_eq!(run(&blind, &with_codes, 5), beforehand[..5 * robot.joints()]);
    blind.save(&path).unwrap();
    let error = Controller::load(&path, robot.clone()).unwrap_err().to_string();
    assert!(error.contains("motion prior") && error.contains("none"), "{error}");
    let read = Controller::new(ControllerFile::read(&path).unwrap(), robot.clone()).unwrap();
    assert_eq!(run(&read, &with_codes, 5), beforehand[..5 * robot.joints()]);
}

#[test]
fn a_step_allocates_nothing() {
    let robot = lima();
    let prior = Checkpoint::load(&asset("lima.prior.safetensors")).unwrap();
    let plain = Controller::load(&asset("lima-path.controller.safetensors"), robot.clone()).unwrap();
    let curious = curious(&robot, Some(&prior));
    let library = ReferenceLibrary::new(&robot, &[bend(&robot)], None).unwrap();
    let (q, v) = (vec![0.1; robot.joints()], vec![0.0; robot.joints()]);
    for controller in [plain, curious, remembering(&robot)] {
        let measured = upright(&q, &v);
        let mut state = ControllerState::new(&controller);
        let mut player = ClipPlayer::new(&library, 0);
        let mut targets = vec![0.0; robot.joints()];
        controller.step(&mut state, &measured, &mut player, &mut targets).unwrap();
        let before = COUNT.get();
        for _ in 0..20 {
            controller.step(&mut state, &measured, &mut player, &mut targets).unwrap();
        }
        assert_eq!(COUNT.get() - before, 0, "allocations in 20 steps");
    }
}

#[test]
fn key_bodies_that_nobody_measures_are_computed() {
    use lifelike_robot::controller::{History, ObservationScratch};
    let robot = Arc::new(Robot::load("humanoid").unwrap());
    let reference = lifelike_robot::ReferenceSpec { frame: true, ..Default::default() };
    let spec = lifelike_robot::ObservationSpec::new(&robot, reference, Default::default());
    let (size, joints) = (spec.size(), robot.joints());
    let header = ControllerHeader::new(&robot, spec, lifelike_robot::ActionSpec::Absolute, Vec::new());
    let mut file = Checkpoint::new();
    file.put_f32("actor.mean.layers.0.weight", &[size, joints], vec![0.0; size * joints]).unwrap();
    file.put_f32("actor.mean.layers.0.bias", &[joints], vec![0.0; joints]).unwrap();
    file.put_f64("normalizer.mean", &[size], vec![0.0; size]).unwrap();
    file.put_f64("normalizer.variance", &[size], vec![1.0; size]).unwrap();
    file.put_f64("normalizer.settings", &[4], vec![1.0, 1.0, 5.0, 1.0]).unwrap();
    let file = ControllerFile::new(header, &file, None, &robot).unwrap();
    let controller = Controller::new(file, robot.clone()).unwrap();

    let q: Vec<f32> = (0..joints).map(|i| 0.05 * (i as f32).sin()).collect();
    let v = vec![0.0; joints];
    let mut position = robot.default_position();
    position[7..].iter_mut().zip(&q).for_each(|(p, q)| *p = f64::from(*q));
    let mut kinematics = lifelike_character::Kinematics::new(&robot.character);
    kinematics.update(&robot.character, &position);
    let places: Vec<f32> = robot
        .key_bodies
        .iter()
        .flat_map(|(body, point)| <[f64; 3]>::from(kinematics.point(*body, point)))
        .map(|x| x as f32)
        .collect();
    let measured = MeasuredState {
        joint_position: &q,
        joint_velocity: &v,
        root_orientation: [1.0, 0.0, 0.0, 0.0],
        root_position: Some([position[0] as f32, position[1] as f32, position[2] as f32]),
        linear_velocity_w: Some([0.0; 3]),
        key_bodies_w: Some(&places),
        ..MeasuredState::default()
    };
    let library = ReferenceLibrary::standing(&robot, 0.2).unwrap();
    let player = ClipPlayer::new(&library, 0);
    let (mut history, mut scratch) = (History::new(joints), ObservationScratch::new(&controller));
    let (mut given, mut computed) = (vec![0.0; size], vec![0.0; size]);
    controller.observe(&mut history, &mut scratch, &measured, &player, &mut given).unwrap();
    let unmeasured = MeasuredState { key_bodies_w: None, ..measured };
    controller.observe(&mut history, &mut scratch, &unmeasured, &player, &mut computed).unwrap();
    given.iter().zip(&computed).for_each(|(a, b)| assert!((a - b).abs() < 1e-5, "{a} {b}"));
}

/// The file's content with one thing changed.
fn changed(file: &Checkpoint, skip: &str, put: impl FnOnce(&mut Checkpoint)) -> Checkpoint {
    let mut other = Checkpoint::new();
    for (key, value) in file.metadata().iter().filter(|(key, _)| *key != skip) {
        other.set_meta(key, value).unwrap();
    }
    for (name, entry) in file.entries().iter().filter(|(name, _)| *name != skip) {
        other.put(name, entry.clone()).unwrap();
    }
    put(&mut other);
    other
}

fn refusal(file: &Checkpoint, robot: &Arc<Robot>) -> String {
    let file = ControllerFile::from_checkpoint(file, "x.controller.safetensors");
    file.and_then(|file| Controller::new(file, robot.clone())).unwrap_err().to_string()
}

#[test]
fn every_mismatch_is_refused_in_plain_words() {
    let robot = lima();
    let controller = Controller::load(&asset("lima-path.controller.safetensors"), robot.clone()).unwrap();
    let file = controller.file().to_checkpoint().unwrap();
    Controller::new(ControllerFile::from_checkpoint(&file, "x").unwrap(), robot.clone()).unwrap();

    let mut weaker = (*robot).clone();
    weaker.actuators.parameters[3].kp = 20.0;
    let text = refusal(&file, &Arc::new(weaker));
    let expected = format!("expected {}, got 20", robot.actuators.parameters[3].kp);
    assert!(text.contains("kp of joint 'left_knee'") && text.contains(&expected), "{text}");
    // Friction under load is a part of the robot, in the file as in memory.
    let mut rougher = (*robot).clone();
    rougher.actuators.parameters[3].extended_friction =
        Some(ExtendedFriction { base: 0.2, load: [0.3, 0.1], ..ExtendedFriction::default() });
    let rougher = Arc::new(rougher);
    let text = refusal(&file, &rougher);
    assert!(text.contains("friction (N m) of joint 'left_knee'") && text.contains("expected 0, got 0.2"), "{text}");
    let described = RobotDescription::of(&rougher);
    assert_ne!(described.digest, RobotDescription::of(&robot).digest);
    assert!(described.check(&robot).unwrap_err().to_string().contains("expected 0.2, got 0"));
    let mut slower = (*robot).clone();
    slower.control_hz = 40.0;
    assert!(refusal(&file, &Arc::new(slower)).contains("expected 50, got 40"));
    let mut finer = (*robot).clone();
    finer.substeps += 1;
    assert!(refusal(&file, &Arc::new(finer)).contains("physics steps"));
    let mut swapped = (*robot).clone();
    swapped.layout.joints.swap(0, 1);
    assert!(refusal(&file, &Arc::new(swapped)).contains("joints"));
    assert!(refusal(&file, &Arc::new(Robot::load("humanoid").unwrap())).contains("joints"));

    let mut weight = match file.entry("actor.mean.layers.0.weight").unwrap() {
        Entry::F32(shape, values) => (shape.clone(), values.clone()),
        _ => panic!(),
    };
    weight.1[17] += 0.5;
    let other = changed(&file, "actor.mean.layers.0.weight", |other| {
        other.put_f32("actor.mean.layers.0.weight", &weight.0, weight.1).unwrap();
    });
    let text = refusal(&other, &robot);
    assert!(text.contains("golden vector") && text.contains("tolerance"), "{text}");

    let header = |change: &dyn Fn(&mut serde_json::Value)| {
        let mut header = file.metadata()["controller"].clone();
        change(&mut header);
        refusal(&changed(&file, "controller", |other| other.set_meta("controller", &header).unwrap()), &robot)
    };
    let text = header(&|h| h["parts"][2][0] = "joint_velocity".into());
    assert!(text.contains("part 2") && text.contains("root_angular_velocity_h"), "{text}");
    assert!(header(&|h| h["version"] = 2.into()).contains("version: expected 1, got 2"));
    assert!(header(&|h| h["hidden"] = serde_json::json!([1u64 << 60])).contains("expected shape"));
    assert!(header(&|h| h["observation"]["reference"]["latent"] = (u64::MAX).into()).contains("latent"));
    assert!(header(&|h| h["encoder"] = serde_json::json!([[], u64::MAX])).contains("expected 0"));
    assert!(header(&|h| h["observation"]["default_pose"] = serde_json::json!([0.0])).contains("default pose"));
    assert!(header(&|h| h["control_hz"] = (-1.0).into()).contains("rate"));

    let text = refusal(&changed(&file, "golden.outputs", |_| ()), &robot);
    assert!(text.contains("golden.outputs"), "{text}");
}

#[test]
fn a_spline_prior_and_a_file_of_another_kind_are_refused_precisely() {
    let mut spline = Checkpoint::new();
    spline.set_meta("kind", &"spline motion prior").unwrap();
    let error = PriorEncoder::from_prior(&spline).unwrap_err().to_string();
    assert!(error.contains("expected a convolutional one") && error.contains("Spline-based"), "{error}");
    let error = ControllerFile::read(&asset("lima.prior.safetensors")).unwrap_err().to_string();
    assert!(error.contains("expected a controller") && error.contains("lima.prior.safetensors"), "{error}");
}
