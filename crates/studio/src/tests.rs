//! The studio as a whole: a session replays to the same bytes, and an edit concerns only what follows it.

#![allow(clippy::unwrap_used)]

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::Sender;
use std::time::{Duration, Instant};

use lifelike_generation::generator::Generator;
use lifelike_motion::container;
use lifelike_robot::{Controller, Robot};

use crate::engine::Engine;
use crate::history::History;
use crate::performer::Events;
use crate::request::{Message, Request, Screen};
use crate::{Document, Operation, Policies, Scene, Stage, packet, stage};

fn lima(folder: &Path) -> Stage {
    let robot = Arc::new(Robot::load("lima").unwrap());
    let assets = Path::new(env!("CARGO_MANIFEST_DIR")).join("../lifelike/assets");
    let controller = Controller::load(&assets.join("lima-path.controller.safetensors"), robot).unwrap();
    let generator = Generator::load(&assets.join("lima.generator.safetensors")).unwrap();
    Stage {
        controller: Arc::new(controller),
        generator: Some(Arc::new(generator)),
        spline: None,
        prior: None,
        folder: folder.into(),
        policies: Policies::default(),
    }
}

fn scene(operations: &[&str]) -> Scene {
    let mut scene = Scene::default();
    operations.iter().for_each(|text| Operation::parse(text).unwrap().apply(&mut scene).unwrap());
    scene
}

/// Flags, frame, simulated frames and frames of the newest packet.
fn head(screen: &Screen) -> (u8, [u32; 3]) {
    let packet = screen.frame.borrow().clone();
    let count = |at: usize| u32::from_le_bytes(packet[at..at + 4].try_into().unwrap());
    if packet.is_empty() { (4, [0; 3]) } else { (packet[1], [8, 12, 16].map(count)) }
}

fn wait(screen: &Screen, what: &str, holds: impl Fn(u8, [u32; 3]) -> bool) {
    let began = Instant::now();
    loop {
        let (flags, counts) = head(screen);
        if holds(flags, counts) {
            return;
        }
        assert!(began.elapsed() < Duration::from_secs(20), "{what}: {flags} {counts:?}");
        std::thread::sleep(Duration::from_millis(2));
    }
}

/// Waits until nothing is built or simulated.
fn settled(engine: &Sender<Message>, screen: &Screen) -> Scene {
    // Messages are answered in their order.
    let (answer, scene) = tokio::sync::oneshot::channel();
    engine.send(Message::Scene(answer)).unwrap();
    let scene = scene.blocking_recv().unwrap();
    std::thread::sleep(Duration::from_millis(30));
    wait(screen, "settled", |flags, [_, known, frames]| flags & 4 == 0 && known == frames);
    scene
}

fn send(engine: &Sender<Message>, request: Request) {
    engine.send(Message::Request(request)).unwrap();
}

fn operate(engine: &Sender<Message>, text: &str) {
    send(engine, Request::Operation(Operation::parse(text).unwrap()));
}

/// Frames of a scene that nobody touches while it plays.
fn headless(stage: &Stage, scene: &Scene) -> Vec<Vec<u8>> {
    let built = stage.workshop().build(scene).unwrap();
    let reference = stage.reference(&built).unwrap();
    let events = Events::of(scene, stage.robot()).unwrap();
    let mut history = History::new(stage.performer(&reference, false).unwrap());
    while history.len() < stage::frames(&reference, &events, 50.0) {
        history.step(&events).unwrap();
    }
    (0..history.len()).map(|frame| history.body(frame).to_vec()).collect()
}

#[test]
fn a_session_replays_to_the_same_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let stage = lima(folder.path());
    let file = folder.path().join("a.scene.toml");
    let (engine, screen) = Engine::start(stage.clone(), Document::open(&file, Scene::default).unwrap()).unwrap();
    operate(&engine, "say text = \"a person walks forward\"");
    settled(&engine, &screen);
    send(&engine, Request::Rate(4.0));
    send(&engine, Request::Play(true));
    wait(&screen, "a second", |_, [frame, ..]| frame > 50);
    let body = stage.robot().character.bodies[1].name.clone();
    for force in [20.0, 45.0, 30.0] {
        send(&engine, Request::Pull { body: body.clone(), newtons: [force, 15.0, 0.0] });
        let before = head(&screen).1[0];
        wait(&screen, "a while", |_, [frame, ..]| frame > before + 6);
    }
    send(&engine, Request::Release);
    operate(&engine, "say text = \"a person waves with the right hand\"");
    wait(&screen, "four seconds", |_, [frame, ..]| frame > 200);
    // Into the past, and back out of it.
    operate(&engine, "trim id = \"m1\", start = 0.4");
    operate(&engine, &format!("push at = 0.7, seconds = 0.1, body = \"{body}\", newtons = [0, 40, 0]"));
    operate(&engine, "switch at = 2.5, friction = 0.6");
    operate(&engine, "mirror id = \"m2\"");
    send(&engine, Request::Undo);
    operate(&engine, "lay clip = \"builtin:wave\", at = 1, parts = [\"arms\"]");
    send(&engine, Request::Play(false));
    let saved = settled(&engine, &screen);
    let began = Instant::now();
    while Scene::load(&file).ok().as_ref() != Some(&saved) {
        assert!(began.elapsed() < Duration::from_secs(5), "the scene is saved");
    }
    assert!(saved.push.len() >= 4 && saved.motion.len() == 2 && saved.over.len() == 1, "{saved:?}");
    let expected = headless(&stage, &saved);
    assert_eq!(head(&screen).1[2] as usize, expected.len());
    for frame in (0..expected.len()).step_by(9).chain([expected.len() - 1]) {
        send(&engine, Request::Seek(frame as f64 / 50.0));
        wait(&screen, "the frame", |_, [now, ..]| now as usize == frame);
        assert!(screen.frame.borrow()[32..] == expected[frame], "frame {frame}");
    }
    engine.send(Message::Close).unwrap();
}

#[test]
fn a_take_has_the_same_bytes_every_time() {
    let folder = tempfile::tempdir().unwrap();
    let stage = lima(folder.path());
    let scene = scene(&["say text = \"a person walks forward\"", "add clip = \"builtin:wave\""]);
    let bytes = || container::to_bytes(&stage.perform(&scene).unwrap().clip("a")).unwrap();
    assert!(bytes() == bytes());
    // Page and packets show the same motion.
    let take = stage.perform(&scene).unwrap();
    let frames = headless(&stage, &scene);
    assert_eq!(take.rollout().simulated.len(), frames.len());
    let root = |frame: &[u8]| f32::from_le_bytes(frame[..4].try_into().unwrap());
    for (i, frame) in frames.iter().enumerate() {
        assert_eq!(root(frame), take.rollout().simulated[i].root_position.x as f32, "frame {i}");
    }
    assert_eq!(take.evaluation("a").overall.survival, 1.0);
}

#[test]
fn a_fall_is_told_and_the_robot_goes_on() {
    let folder = tempfile::tempdir().unwrap();
    let stage = lima(folder.path());
    let body = &stage.robot().character.bodies[1].name;
    let push = format!("push at = 1, seconds = 0.3, body = \"{body}\", newtons = [0, 300, 0]");
    let scene = scene(&["say text = \"a person walks forward\"", &push]);
    let take = stage.perform(&scene).unwrap();
    assert_eq!(take.falls.len(), 1, "{:?}", take.falls);
    let fall = &take.falls[0];
    assert!((1.0..2.5).contains(&fall.second) && fall.why.contains("left first"), "{fall:?}");
    let last = take.rollout().simulated.last().unwrap();
    let upright = last.root_orientation * lifelike_character::Vec3::z();
    assert!(upright.z > 0.95 && last.root_position.z > 0.25, "{last:?}");
    assert_eq!(take.evaluation("a").overall.survival, 0.0);
}

#[test]
fn what_a_block_is_asked_for_is_what_it_gets() {
    let folder = tempfile::tempdir().unwrap();
    let stage = lima(folder.path());
    let build = |operations: &[&str]| stage.workshop().build(&scene(operations));
    let whole = build(&["add clip = \"builtin:wave\""]).unwrap().spans[0].whole;
    let cut = build(&[
        "add clip = \"builtin:wave\"",
        "trim id = \"m1\", start = 0.5, end = 2.5",
        "speed id = \"m1\", value = 2",
    ]);
    let cut = cut.unwrap();
    assert!((cut.spans[0].to - cut.spans[0].from - 1.0).abs() < 0.03 && cut.spans[0].whole == whole, "{:?}", cut.spans);
    let halves = build(&["add clip = \"builtin:wave\"", "split id = \"m1\", at = 1"]).unwrap();
    let plain = build(&["add clip = \"builtin:wave\""]).unwrap();
    assert_eq!(halves.clip.len(), plain.clip.len(), "halves of a motion are the motion");
    let off = halves.clip.joints.iter().zip(&plain.clip.joints).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(off < 1e-9, "{off}");
    let waits = build(&["add clip = \"builtin:wave\", wait = 2"]).unwrap();
    assert!((waits.clip.seconds() - plain.clip.seconds() - 1.7).abs() < 0.05, "two seconds less the fade");
    for (operation, told) in [
        ("add clip = \"builtin:wavee\"", "did you mean 'builtin:wave'"),
        ("add clip = \"../secret.bvh\"", "block 'm1'"),
        ("add clip = \"/etc/passwd\"", "expected a file below"),
        ("lay clip = \"builtin:wave\", at = 99, parts = [\"arms\"]", "block 'o1'"),
        ("lay clip = \"builtin:wave\", at = 0, parts = [\"wings\"]", "wings"),
    ] {
        let error = build(&[operation]).unwrap_err().to_string();
        assert!(error.contains(told), "{operation}: {error}");
    }
}

#[test]
fn five_hundred_blocks_are_built_and_edited() {
    let folder = tempfile::tempdir().unwrap();
    let stage = lima(folder.path());
    let mut scene = Scene::default();
    for i in 0..500 {
        let clip = ["walk", "wave", "squat"][i % 3];
        Operation::parse(&format!("add clip = \"builtin:{clip}\"")).unwrap().apply(&mut scene).unwrap();
    }
    let mut workshop = stage.workshop();
    workshop.build(&scene).unwrap();
    let began = Instant::now();
    Operation::parse("mirror id = \"m250\"").unwrap().apply(&mut scene).unwrap();
    let built = workshop.build(&scene).unwrap();
    let took = began.elapsed();
    assert_eq!(built.spans.len(), 500);
    assert!(built.spans.is_sorted_by(|a, b| a.from < b.from && a.to <= b.to));
    println!(
        "500 blocks, {:.0} s of motion: an edit is built in {:.0} ms",
        built.clip.seconds(),
        1e3 * took.as_secs_f64()
    );
}

#[test]
fn every_example_plays() {
    let folder = tempfile::tempdir().unwrap();
    let stage = lima(folder.path());
    for (name, text) in crate::examples::ALL {
        let scene = Scene::parse(text, name).unwrap();
        let take = stage.perform(&scene).unwrap();
        assert_eq!(take.falls.len(), usize::from(name == "fall"), "{name}: {:?}", take.falls);
        assert_eq!(Scene::parse(&scene.to_toml().unwrap(), name).unwrap(), scene);
    }
}

#[test]
fn a_frame_of_many_bodies_is_small() {
    let folder = tempfile::tempdir().unwrap();
    let stage = lima(folder.path());
    let built = stage.workshop().build(&Scene::default()).unwrap();
    let performer = stage.performer(&stage.reference(&built).unwrap(), false).unwrap();
    let (body, _) = packet::frame(performer.rollout(), false);
    let (n, joints) = (stage.robot().character.bodies.len() - 1, stage.robot().joints());
    let feet = stage.robot().anatomy.soles.len();
    let bytes = |bodies: usize, joints: usize| 32 + 2 * (16 + 14 * bodies) + 2 * joints + feet;
    assert_eq!(32 + body.len(), bytes(n, joints));
    assert!(bytes(30, 29) <= 2000, "a robot of thirty bodies");
    println!("lima, {n} bodies: {} bytes", 32 + body.len());
}

#[test]
fn a_save_that_is_cut_off_loses_nothing() {
    // The process that saves is this test, run again by itself with a file to write.
    let own = "LIFELIKE_STUDIO_SAVES";
    if let Some(file) = std::env::var_os(own) {
        let mut document = Document::open(&PathBuf::from(file), Scene::default).unwrap();
        for i in 0.. {
            document.apply(Operation::parse(&format!("say text = \"a person walks {i}\"")).unwrap()).unwrap();
            document.save().unwrap();
        }
    }
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("a.scene.toml");
    let mut most = 0;
    for i in 0..20 {
        let mut child = std::process::Command::new(std::env::current_exe().unwrap())
            .args([
                "a_save_that_is_cut_off_loses_nothing",
                "--exact",
                "--nocapture",
                "tests::a_save_that_is_cut_off_loses_nothing",
            ])
            .env(own, &file)
            .stdout(std::process::Stdio::null())
            .stderr(std::process::Stdio::null())
            .spawn()
            .unwrap();
        std::thread::sleep(Duration::from_millis(40 + 7 * i));
        child.kill().unwrap();
        child.wait().unwrap();
        if file.exists() {
            let scene = Scene::load(&file).unwrap();
            assert!(scene.motion.len() >= most, "{} blocks after {most}", scene.motion.len());
            most = scene.motion.len();
        }
    }
    assert!(most > 20, "{most} blocks were saved");
}

/// Returns where the left hand and the soles of a scene's motion are in a frame (m).
fn places(stage: &Stage, scene: &Scene, frame: usize) -> (Vec<lifelike_character::Vec3>, crate::Built) {
    let built = stage.workshop().build(scene).unwrap();
    let character = &stage.robot().character;
    let root = lifelike_character::Kinematics::new(character);
    let mut kinematics = root;
    let mut q = vec![0.0; character.nq];
    let library = stage.reference(&built).unwrap();
    let mut v = vec![0.0; character.nv];
    library.write_state(frame, stage.robot(), [0.0; 2], 0.0, &mut q, &mut v);
    kinematics.update(character, &q);
    let hand = &stage.robot().anatomy.places[&lifelike_character::Role::LeftHand];
    let mut points = vec![kinematics.point(hand.body, &hand.point)];
    let feet = [lifelike_character::Role::LeftFoot, lifelike_character::Role::RightFoot];
    points.extend(feet.map(|role| {
        let foot = &stage.robot().anatomy.places[&role];
        kinematics.point(foot.body, &foot.point)
    }));
    (points, built)
}

#[test]
fn a_hand_is_moved_as_asked_and_feet_stay() {
    let folder = tempfile::tempdir().unwrap();
    let stage = lima(folder.path());
    let before = scene(&["add clip = \"builtin:wave\""]);
    let frame = 60;
    let (was, _) = places(&stage, &before, frame);
    let mut after = before.clone();
    let at = frame as f64 / stage.robot().control_hz;
    let edit = format!("edit id = \"m1\", body = \"left_hand\", at = {at}, by = [0.06, 0.03, 0.04]");
    Operation::parse(&edit).unwrap().apply(&mut after).unwrap();
    let (is, built) = places(&stage, &after, frame);
    // The wave begins along x, so forward, left and up are the axes of the world but for the turn of its hips.
    let turn = lifelike_character::rotation::heading(&built.clip.root_orientation[frame]);
    let wanted = turn * lifelike_character::Vec3::new(0.06, 0.03, 0.04);
    assert!((is[0] - was[0] - wanted).norm() < 0.005, "{} for {}", is[0] - was[0], wanted);
    for foot in [1, 2] {
        assert!((is[foot] - was[foot]).norm() < 0.002, "{} to {}", was[foot], is[foot]);
    }
    // Far from it nothing changed.
    let (far, _) = places(&stage, &before, 5);
    assert_eq!(places(&stage, &after, 5).0, far);
}

#[test]
fn a_jump_that_is_too_slow_is_repaired_and_said() {
    let folder = tempfile::tempdir().unwrap();
    let stage = lima(folder.path());
    let slow = scene(&["add clip = \"builtin:jump\"", "speed id = \"m1\", value = 1"]);
    let gain =
        scene(&["add clip = \"builtin:jump\"", "style id = \"m1\", gain = 2", "feasible id = \"m1\", value = true"]);
    let whole = stage.workshop().build(&slow).unwrap();
    let repaired = stage.workshop().build(&gain).unwrap();
    assert_eq!(whole.spans[0].changed, "");
    assert!(repaired.spans[0].changed.starts_with("repaired: root by"), "{}", repaired.spans[0].changed);
}

#[test]
fn another_policy_performs_beside_the_kept_take_and_undo_brings_the_first_back() {
    let folder = tempfile::tempdir().unwrap();
    let robot = Arc::new(Robot::load("lima").unwrap());
    let assets = Path::new(env!("CARGO_MANIFEST_DIR")).join("../lifelike/assets");
    let load = move |name: Option<&str>| {
        let file = assets.join(format!("{}.controller.safetensors", name.unwrap_or("lima-path")));
        Controller::load(&file, Arc::clone(&robot)).map(Arc::new).map_err(|error| error.to_string())
    };
    let policies = Policies { names: vec!["lima-path".into(), "lima-blind".into()], load: Some(Arc::new(load)) };
    let stage = Stage { policies, ..lima(folder.path()) };
    let mut walk = scene(&["add clip = \"builtin:walk\""]);
    let exported = |scene: &Scene| crate::files::export(&stage, scene, "a", "clip").unwrap().bytes;
    let best = exported(&walk);
    walk.policy = Some("lima-blind".into());
    assert_ne!(exported(&walk), best, "an export is performed by the scene's own policy");
    let document = Document::open(&folder.path().join("a.scene.toml"), Scene::default).unwrap();
    let (engine, screen) = Engine::start(stage, document).unwrap();
    let view = || serde_json::from_str::<serde_json::Value>(&screen.view.borrow()).unwrap();
    let last = || {
        send(&engine, Request::Seek(1e9));
        std::thread::sleep(Duration::from_millis(300));
        screen.frame.borrow().to_vec()
    };
    operate(&engine, "add clip = \"builtin:walk\"");
    settled(&engine, &screen);
    let first = last();
    operate(&engine, "policy name = \"lima-blind\"");
    assert_eq!(settled(&engine, &screen).policy.as_deref(), Some("lima-blind"));
    assert_ne!(last(), first, "another network walks otherwise");
    operate(&engine, "policy name = \"nobody\"");
    assert_eq!(settled(&engine, &screen).policy.as_deref(), Some("lima-blind"));
    std::thread::sleep(Duration::from_millis(400));
    assert!(view()["problem"].as_str().unwrap().contains("lima-path, lima-blind, got 'nobody'"), "{}", view());
    send(&engine, Request::Undo);
    assert_eq!(settled(&engine, &screen).policy, None);
    let again = last();
    // The version in the head differs; what physics made is the same to the last bit.
    assert_eq!(again[32..], first[32..]);
}

#[test]
fn clips_that_are_like_a_moment_are_found_and_the_clip_itself_is_the_nearest() {
    let folder = tempfile::tempdir().unwrap();
    let robot = Arc::new(Robot::load("lima").unwrap());
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../lifelike/assets/lima.prior.safetensors");
    let prior = Some(Arc::new(lifelike_representation::MotionPrior::load(&file).unwrap()));
    let walk = lifelike_robot::clips::load_one(Path::new("builtin:walk"), &robot).unwrap();
    let mut search = crate::similar::Similar::new(Arc::clone(&robot), prior, folder.path().into());
    let all = search.to(&walk, 2.0, None).unwrap();
    assert!(all[0].clip == "builtin:walk" && all[0].similarity > 0.999 && (all[0].time - 2.0).abs() < 0.05, "{all:?}");
    assert!(all.len() == 6 && all.windows(2).all(|pair| pair[0].similarity >= pair[1].similarity), "{all:?}");
    let others = search.to(&walk, 2.0, Some("builtin:walk")).unwrap();
    assert_eq!(others[..5], all[1..]);
    let none = crate::similar::Similar::new(robot, None, folder.path().into()).to(&walk, 2.0, None).unwrap_err();
    assert!(none.to_string().contains("no motion prior"), "{none}");
}
