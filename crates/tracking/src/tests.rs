//! Contracts of environments, trainer and policy, on a robot of two joints.

#![allow(clippy::unwrap_used)]

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use lifelike_checkpoint::Checkpoint;
use lifelike_motion::{MotionClip, Provenance};
use lifelike_robot::controller::PolicyWorkspace;
use lifelike_robot::observation::Part;
use lifelike_robot::{ActionSpec, Controller, ControllerFile, ReferenceLibrary, ReferenceSpec, Robot};
use lifelike_sim::randomization::{PushSpec, RandomizationSpec};

mod beginning;
mod frozen;
mod processes;
mod records;
mod sensors;
mod teachers;

use super::plan::{Curriculum, Ramp, SensorSpec, Termination, TrackerPlan};
use super::policy::Policy;
use super::progress::TrackerMetrics;
use super::terminations::Cause;
use super::{Environment, Start, StepOutcome, Trainer};
use lifelike_report::run::{MetricsRow, RunFolder};
use lifelike_sim::testing::{Followers, robot};
use lifelike_train::collective::Alone;
use lifelike_train::ppo::{Iteration, NetworkSpec};
use lifelike_train::{Summary, TrainingRun};

fn clip(name: &str, seconds: f64, amplitude: f64) -> MotionClip {
    let frames = (seconds * 50.0) as usize;
    let angle = |i: usize| amplitude * (i as f64 * 0.1).sin();
    MotionClip {
        name: name.into(),
        fps: 50.0,
        joint_names: vec!["hip".into(), "knee".into()],
        root_position: (0..frames).map(|i| lifelike_character::Vec3::new(2.0 + 0.01 * i as f64, 1.0, 0.5)).collect(),
        root_orientation: vec![lifelike_character::Quat::identity(); frames],
        joints: (0..frames).flat_map(|i| [angle(i), -angle(i)]).collect(),
        contacts: None,
        cyclic: false,
        provenance: Provenance::default(),
    }
}

fn plan(environments: usize) -> TrackerPlan {
    let mut plan = TrackerPlan::new("post", &[]);
    plan.ppo.environments = environments;
    plan.ppo.steps = 8;
    plan.ppo.minibatch = environments * 4;
    plan.ppo.epochs = 2;
    plan.network.actor = vec![16];
    plan.network.critic = vec![16];
    plan.inputs.future = vec![5];
    plan.termination = Termination { effector: Some(0.15), ..Termination::NONE };
    plan
}

fn exact(mut plan: TrackerPlan) -> TrackerPlan {
    plan.rsi.joint_noise = 0.0;
    plan.rsi.velocity_noise = 0.0;
    plan.rsi.path_noise = 0.0;
    plan.rsi.heading_noise = 0.0;
    plan
}

fn library(robot: &Robot) -> Arc<ReferenceLibrary> {
    let clips = [clip("calm", 3.0, 0.1), clip("wild", 2.0, 0.5)];
    Arc::new(ReferenceLibrary::new(robot, &clips, None).unwrap())
}

fn environment(plan: &TrackerPlan) -> Environment {
    let robot = robot();
    let library = library(&robot);
    Environment::new(plan, robot, library, Box::new(Followers::new(plan.ppo.environments))).unwrap()
}

fn part<'a>(environment: &Environment, row: &'a [f32], name: &str) -> &'a [f32] {
    let parts = environment.observation().parts();
    let range = parts.iter().find(|part| part.name == name).unwrap().range.clone();
    &row[range]
}

#[test]
fn an_episode_begins_on_its_frame_and_the_policy_sees_the_next_one() {
    let mut e = environment(&exact(plan(3)));
    e.reset(&[1], Some(&[Start::at(40)])).unwrap();
    let library = library(&robot());
    let width = e.actor_size();
    let row = e.actor_rows()[width..2 * width].to_vec();
    assert_eq!(part(&e, &row, "joint_position"), library.joints_at(40));
    let seen = part(&e, &row, "reference");
    assert_eq!(&seen[..13], &library.features_at(41)[..13]);
    assert_eq!(part(&e, &row, "reference+5")[13..15], library.joints_at(45)[..]);
    // On the path: the next frame's root is one step ahead (0.01 m), straight on.
    assert!((part(&e, &row, "anchor_position")[0] - 0.01).abs() < 1e-6);
    assert_eq!(part(&e, &row, "anchor_heading"), [0.0, 1.0]);
    // One step on, the state is compared with frame 41, and frame 42 is the next.
    e.step(&[0.0; 6], &mut StepOutcome::default()).unwrap();
    assert_eq!(e.episodes()[1].frame, 41);
    let row = e.actor_rows()[width..2 * width].to_vec();
    assert_eq!(&part(&e, &row, "reference")[..13], &library.features_at(42)[..13]);
}

#[test]
fn near_the_end_of_a_clip_the_last_frame_is_repeated() {
    let mut e = environment(&exact(plan(1)));
    e.reset(&[0], Some(&[Start::at(148)])).unwrap();
    let library = library(&robot());
    let row = e.actor_rows().to_vec();
    assert_eq!(part(&e, &row, "reference+5")[13..15], library.joints_at(149)[..], "and not the next clip's first");
}

#[test]
fn a_clip_that_ends_truncates_the_episode_and_shows_the_value_function_its_last_state() {
    let mut e = environment(&exact(plan(2)));
    e.reset(&[0], Some(&[Start::at(147)])).unwrap();
    let mut outcome = StepOutcome::default();
    e.step(&[0.0; 4], &mut outcome).unwrap();
    assert_eq!((outcome.truncated[0], outcome.terminated[0]), (false, false));
    e.step(&[0.0; 4], &mut outcome).unwrap();
    assert_eq!((outcome.truncated[0], outcome.terminated[0]), (true, false));
    assert_eq!(outcome.final_critic_observations.len(), e.critic_size());
    assert_ne!(
        outcome.final_critic_observations[..],
        e.critic_rows()[..e.critic_size()],
        "its row is of the next episode"
    );
    assert_eq!((e.episodes()[0].length, e.episodes()[0].number), (0, 3));
}

#[test]
fn with_switching_a_clip_that_ends_is_followed_by_another_where_the_robot_stands() {
    let mut p = exact(plan(1));
    p.episode.switch_clips = true;
    p.episode.grace_seconds = 0.2;
    let mut e = environment(&p);
    e.reset(&[0], Some(&[Start::at(148)])).unwrap();
    let mut outcome = StepOutcome::default();
    e.step(&[0.0; 2], &mut outcome).unwrap();
    let episode = &e.episodes()[0];
    assert!(!outcome.truncated[0] && !outcome.terminated[0]);
    assert_eq!((episode.length, episode.number, episode.grace), (1, 2, 10));
    assert_eq!(episode.frame, episode.segment_start);
    assert_eq!(episode.finished_segment, Some((148, 149)));
    let row = e.actor_rows().to_vec();
    // The new reference begins where the robot is: its next frame is one step (0.01 m) ahead.
    assert!((part(&e, &row, "anchor_position")[0] - 0.01).abs() < 1e-6);
}

#[test]
fn the_reference_is_re_anchored_to_a_robot_that_leaves_it() {
    let robot = robot();
    // The clip turns back after a second; the robot, which has no feet to turn with, goes straight on.
    let mut there_and_back = clip("back", 3.0, 0.1);
    for (i, p) in there_and_back.root_position.iter_mut().enumerate() {
        p.x = 0.01 * if i < 50 { i as f64 } else { 100.0 - i as f64 };
    }
    let library = Arc::new(ReferenceLibrary::new(&robot, &[there_and_back], None).unwrap());
    for (reanchor, expected) in [(true, lifelike_robot::ObservationSpec::ANCHOR_REACH), (false, 1.0)] {
        let mut p = exact(plan(1));
        p.termination = Termination::NONE;
        p.episode.reanchor = reanchor;
        let mut e = Environment::new(&p, robot.clone(), library.clone(), Box::new(Followers::new(1))).unwrap();
        e.reset(&[0], Some(&[Start::at(0)])).unwrap();
        (0..100).for_each(|_| e.step(&[0.0; 2], &mut StepOutcome::default()).unwrap());
        let episode = &e.episodes()[0];
        assert_eq!(episode.frame, 100);
        let reference = episode.alignment.position(library.position_at(100));
        let root = &e.state().root_position;
        let apart = (root[0] - reference[0]).hypot(root[1] - reference[1]);
        assert!((apart - expected).abs() < 0.02, "re-anchoring {reanchor}: {apart} m");
    }
}

#[test]
fn deviation_ends_the_episode_and_is_counted_by_cause() {
    let mut e = environment(&exact(plan(2)));
    e.reset(&[0, 1], Some(&[Start::at(0), Start::at(0)])).unwrap();
    let mut outcome = StepOutcome::default();
    let mut steps = 0;
    // The first environment is sent two radians off; the second does what the reference does.
    while !outcome.terminated.first().copied().unwrap_or(false) {
        e.step(&[4.0, 0.0, 0.0, 0.0], &mut outcome).unwrap();
        assert!(!outcome.terminated[1]);
        steps += 1;
        assert!(steps < 100);
    }
    assert!(steps > 2, "not at once: the joint needs time");
    assert_eq!(e.statistics().causes[Cause::Effector.index()], 1);
    assert_eq!(e.episodes()[1].length, steps);
}

#[test]
fn the_rewarded_follower_is_the_one_that_follows() {
    let mut e = environment(&exact(plan(2)));
    e.reset(&[0, 1], Some(&[Start::at(10), Start::at(10)])).unwrap();
    let mut outcome = StepOutcome::default();
    e.step(&[0.0, 0.0, 1.0, 1.0], &mut outcome).unwrap();
    assert!(outcome.rewards[0] > outcome.rewards[1] + 0.05, "{:?}", outcome.rewards);
}

#[test]
fn a_diverged_environment_ends_without_reward_and_the_others_are_unchanged() {
    let run = |diverge| {
        let p = exact(plan(3));
        let robot = robot();
        let library = library(&robot);
        let mut simulation = Followers::new(3);
        simulation.diverge = diverge;
        let mut e = Environment::new(&p, robot, library, Box::new(simulation)).unwrap();
        e.reset(&[0, 1, 2], Some(&[Start::at(0), Start::at(0), Start::at(0)])).unwrap();
        let mut outcome = StepOutcome::default();
        for _ in 0..4 {
            e.step(&[0.1; 6], &mut outcome).unwrap();
        }
        let neighbours = [&e.actor_rows()[..e.actor_size()], &e.actor_rows()[2 * e.actor_size()..]].concat();
        (outcome, neighbours, e.episodes()[1].length, e.statistics().causes[Cause::Diverged.index()])
    };
    let (outcome, neighbours, length, diverged) = run(Some((1, 4)));
    assert_eq!((outcome.rewards[1], outcome.terminated[1], length, diverged), (0.0, true, 0, 1));
    let (_, undisturbed, length, diverged) = run(None);
    assert_eq!((length, diverged), (4, 0));
    assert_eq!(neighbours, undisturbed);
}

#[test]
fn encoder_offsets_are_seen_and_commanded_around_but_not_rewarded() {
    let mut p = exact(plan(1));
    p.randomization = RandomizationSpec { joint_offset: 0.2, ..RandomizationSpec::none() };
    p.termination = Termination::NONE;
    let mut e = environment(&p);
    e.reset(&[0], Some(&[Start::at(40)])).unwrap();
    let offset = e.episodes()[0].offset.clone();
    assert!(offset.iter().all(|o| o.abs() <= 0.2) && offset.iter().any(|o| o.abs() > 0.01), "{offset:?}");
    let row = e.actor_rows().to_vec();
    let seen = part(&e, &row, "joint_position");
    let truth = library(&robot()).joints_at(40).to_vec();
    for ((s, t), o) in seen.iter().zip(&truth).zip(&offset) {
        assert!((s - t - o).abs() < 1e-6);
    }
    // Held at one target, the joints settle where the ENCODERS show it.
    p.action = ActionSpec::Absolute;
    let mut e = environment(&p);
    e.reset(&[0], Some(&[Start::at(0)])).unwrap();
    for _ in 0..100 {
        e.step(&[0.3, -0.3], &mut StepOutcome::default()).unwrap();
    }
    let row = e.actor_rows().to_vec();
    let seen = part(&e, &row, "joint_position");
    assert!((seen[0] - 0.3).abs() < 1e-3 && (seen[1] + 0.3).abs() < 1e-3, "{seen:?}");
}

fn restless() -> TrackerPlan {
    let mut p = plan(6);
    let pushes =
        PushSpec { roles: vec![lifelike_character::Role::Pelvis], interval: [0.1, 0.3], ..PushSpec::default() };
    p.randomization = RandomizationSpec { joint_offset: 0.02, pushes: Some(pushes), ..RandomizationSpec::default() };
    p.sensors =
        SensorSpec { joint_velocity_noise: 0.1, observation_delay: 2, action_delay: 1, ..SensorSpec::default() };
    p.curriculum = Curriculum {
        randomization: Some(Ramp { from: 0.2, to: 1.0, begin: 50, end: 250 }),
        termination: Some(Ramp { from: 2.0, to: 1.0, begin: 0, end: 200 }),
        smoothness: Some(Ramp { from: 0.0, to: 1.0, begin: 0, end: 300 }),
    };
    p.inputs.window = vec![-5, 5];
    p.network.encoder = vec![8];
    p.network.code = 4;
    p.checkpoint_every = 2;
    p.budget.steps = 6 * 8 * 7;
    p
}

fn trainer(plan: &TrackerPlan) -> Trainer {
    let robot = robot();
    let library = library(&robot);
    Trainer::new(plan, robot, library, Box::new(Followers::new(plan.ppo.environments))).unwrap()
}

/// Returns the reports of some iterations, and the policy's file after them.
fn iterations(mut trainer: Trainer, n: usize) -> (Vec<Iteration>, Vec<u8>) {
    let reports = (0..n).map(|_| trainer.iterate().unwrap()).collect();
    (reports, trainer.policy().to_checkpoint().unwrap().to_bytes().unwrap())
}

/// Goes on with a run until its budget is spent, or until it is stopped after an iteration.
fn go_on(plan: &TrackerPlan, folder: &RunFolder, stop: Option<u64>) -> Summary<TrackerMetrics> {
    let flag = AtomicBool::new(false);
    let run = TrainingRun { folder, stop: &flag, collective: &Alone };
    run.run(&mut trainer(plan), |now| flag.store(stop == Some(now.iteration), Ordering::SeqCst)).unwrap()
}

#[test]
fn a_run_that_goes_on_has_a_policy_with_each_checkpoint() {
    let plan = TrackerPlan { checkpoint_every: 2, ..restless() };
    let place = tempfile::tempdir().unwrap();
    let folder = RunFolder::create(place.path().join("run"), &plan).unwrap();
    let run = TrainingRun { folder: &folder, stop: &AtomicBool::new(false), collective: &Alone };
    // Iterations, and those of the policy that is there; one is 8 steps of 6 environments.
    let mut steps = Vec::new();
    let mut look = |iteration: u64| {
        let policy = ControllerFile::read(&Trainer::policy_path(folder.path()));
        steps.push((iteration, policy.ok().map(|policy| policy.header().provenance.steps / 48)));
    };
    run.run(&mut trainer(&plan), |now| look(now.iteration)).unwrap();
    assert_eq!(steps[..5], [(1, None), (2, None), (3, Some(2)), (4, Some(2)), (5, Some(4))]);
}

/// The files of a run that equal runs have in common.
fn files(folder: &RunFolder) -> (String, String, Vec<u8>) {
    let text = |path| std::fs::read_to_string(path).unwrap();
    let policy = std::fs::read(Trainer::policy_path(folder.path())).unwrap();
    (text(folder.metrics_path()), text(folder.snapshots_path()), policy)
}

/// The same run with a recurrent unit over earlier steps in place of the reference's window.
fn remembering() -> TrackerPlan {
    let mut p = restless();
    p.inputs = ReferenceSpec { window: Vec::new(), history: 3, ..p.inputs };
    p.network = NetworkSpec { encoder: Vec::new(), code: 0, memory: 16, ..p.network };
    p
}

/// Metrics, snapshots and the policy of a run that is stopped after each number of iterations given, and resumed.
fn run(plan: &TrackerPlan, stops: &[u64]) -> (String, String, Vec<u8>) {
    let place = tempfile::tempdir().unwrap();
    let folder = RunFolder::create(place.path().join("run"), plan).unwrap();
    for stop in stops {
        assert!(go_on(plan, &folder, Some(*stop)).interrupted);
    }
    assert!(!go_on(plan, &folder, None).interrupted);
    files(&folder)
}

#[test]
fn a_stopped_and_resumed_run_gives_the_same_bytes_as_one_that_ran_through() {
    for plan in [restless(), remembering()] {
        let whole = run(&plan, &[]);
        assert_eq!((whole.0.lines().count(), whole.1.lines().count()), (7, 8));
        for stops in [&[1][..], &[4], &[3, 5]] {
            assert!(run(&plan, stops) == whole, "{stops:?}");
        }
    }
}

#[test]
fn a_killed_run_goes_on_from_its_last_checkpoint_and_gives_the_same_bytes() {
    let whole = run(&restless(), &[]);
    let place = tempfile::tempdir().unwrap();
    let plan = restless();
    let folder = RunFolder::create(place.path().join("run"), &plan).unwrap();
    go_on(&plan, &folder, Some(4));
    // A kill loses what came after the checkpoint of iteration 4, but its metrics had been written.
    let mut longer = std::fs::read_to_string(folder.metrics_path()).unwrap();
    longer.push_str(whole.0.lines().nth(4).unwrap());
    longer.push_str("\n{\"iteration\":6,\"Train/mea");
    std::fs::write(folder.metrics_path(), longer).unwrap();
    go_on(&plan, &folder, None);
    assert!(files(&folder) == whole);
}

#[test]
fn what_a_run_writes_per_iteration_does_not_grow_with_the_clips() {
    let place = tempfile::tempdir().unwrap();
    let plan = restless();
    let folder = RunFolder::create(place.path().join("run"), &plan).unwrap();
    go_on(&plan, &folder, None);
    let rows: Vec<MetricsRow> = folder.metrics().unwrap();
    let names = trainer(&plan).clips().iter().map(|clip| clip.name.to_string()).collect::<Vec<_>>();
    assert!(rows.iter().all(|row| !row.values.iter().any(|(key, _)| names.iter().any(|name| key.ends_with(name)))));
    let snapshots = std::fs::read_to_string(folder.snapshots_path()).unwrap();
    assert!(names.iter().all(|name| snapshots.lines().next().unwrap().contains(name)), "{snapshots}");
}

#[test]
fn a_run_on_other_motion_is_refused_by_name() {
    let place = tempfile::tempdir().unwrap();
    let plan = restless();
    let folder = RunFolder::create(place.path().join("run"), &plan).unwrap();
    go_on(&plan, &folder, Some(2));
    let robot = robot();
    let mut other = ReferenceLibrary::clone(&library(&robot));
    other.features[3] += 1e-6;
    let mut trainer =
        Trainer::new(&plan, robot, Arc::new(other), Box::new(Followers::new(plan.ppo.environments))).unwrap();
    let run = TrainingRun { folder: &folder, stop: &AtomicBool::new(false), collective: &Alone };
    let error = run.run(&mut trainer, |_| {}).unwrap_err().to_string();
    assert!(error.contains("reference motion") && error.contains("00000002"), "{error}");
}

#[test]
fn the_number_of_threads_changes_nothing() {
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let mut plan = restless();
            // Enough environments for several chunks and sums beyond one block.
            plan.ppo.environments = 40;
            plan.ppo.minibatch = 160;
            let mut t = trainer(&plan);
            for _ in 0..3 {
                t.iterate().unwrap();
            }
            t.policy().to_checkpoint().unwrap().to_bytes().unwrap()
        })
    };
    assert!(with(1) == with(3));
}

#[test]
fn a_checkpoint_of_another_plan_is_refused() {
    let plan = restless();
    let checkpoint = trainer(&plan).checkpoint().unwrap();
    let mut other = plan.clone();
    other.ppo.gamma = 0.5;
    let error = trainer(&other).restore(&checkpoint).unwrap_err().to_string();
    assert!(error.contains("plan"), "{error}");
    let mut longer = plan;
    longer.budget.steps *= 2;
    trainer(&longer).restore(&checkpoint).unwrap();
}

#[test]
fn ppo_learns_to_follow() {
    // Targets are offsets from the default pose, so an idle policy (output zero) misses the moving reference.
    let mut p = exact(plan(32));
    p.action = ActionSpec::DefaultPose { scale: 0.5 };
    p.termination = Termination::NONE;
    p.ppo.steps = 16;
    p.ppo.epochs = 4;
    p.ppo.minibatch = 128;
    let mut t = trainer(&p);
    let rewards: Vec<f64> = (0..150).map(|_| t.iterate().unwrap().reward).collect();
    let mean = |r: &[f64]| r.iter().sum::<f64>() / r.len() as f64;
    let (first, last) = (mean(&rewards[..10]), mean(&rewards[140..]));
    assert!(last > first + 0.1, "{first} → {last}");
}

#[test]
fn a_policy_file_comes_back_the_same_and_knows_its_robot() {
    let place = tempfile::tempdir().unwrap();
    let path = place.path().join("t.controller.safetensors");
    let mut t = trainer(&restless());
    t.iterate().unwrap();
    let policy = t.policy();
    policy.save(&path).unwrap();
    let robot = robot();
    let back = Controller::load(&path, Arc::clone(&robot)).unwrap();
    let rows = t.environment().actor_rows().to_vec();
    let expected = policy.outputs(rows.clone()).unwrap();
    let mut got = vec![f32::NAN; expected.len()];
    back.outputs(&mut rows.clone(), &mut PolicyWorkspace::batched(), &mut got);
    assert_eq!(got, expected);
    assert_eq!(back.header(), policy.controller().unwrap().header());
    assert!(policy.outputs(rows[1..].to_vec()).is_err());
    let environment: TrackerPlan = toml::from_str(back.header().environment.as_ref().unwrap()).unwrap();
    assert_eq!((environment.robot.as_str(), environment.clips.len()), (robot.name.as_str(), 0));
    let exported = back.file().to_checkpoint().unwrap();
    assert!(!exported.contains("actor.log_std") && !exported.contains("critic_normalizer.mean"));
    let mut other = (*robot).clone();
    other.layout.joints.swap(0, 1);
    let error = Controller::load(&path, Arc::new(other)).unwrap_err().to_string();
    assert!(error.contains("joints") && error.contains("hip"), "{error}");
}
