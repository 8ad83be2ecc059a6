//! Promises about the loop: no allocation, every phase, and a record that replays bit for bit.
#![allow(clippy::unwrap_used, clippy::expect_used)]

#[path = "all/common/mod.rs"]
mod common;

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::collections::BTreeMap;

use common::{Fault, Plant};
use lifelike_runtime::gate::Cause;
use lifelike_runtime::record::{Attachment, Entry, Record, Recorder};
use lifelike_runtime::replay::{ReplayBus, replay};
use lifelike_runtime::{
    Bus, Clock, Facts, Measurement, Phase, Request, RuntimeError, StateEstimator, VirtualClock, drive,
};

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

/// Metadata as the command writes it.
fn metadata(plant: &mut Plant, config: &lifelike_runtime::Config) -> BTreeMap<String, String> {
    let json = |value: serde_json::Value| value.to_string();
    BTreeMap::from([
        ("joints".to_string(), json(serde_json::json!(plant.robot.layout.joints))),
        ("facts".to_string(), json(serde_json::to_value(plant.facts().unwrap()).unwrap())),
        ("config".to_string(), json(serde_json::to_value(config).unwrap())),
    ])
}

/// Records a run with a fault, and returns the folder that holds the file.
fn record(fault: Fault) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let mut supervisor = common::supervisor(&common::controller(), |_| {});
    let mut plant = Plant::new(5);
    (plant.fault, plant.from) = (fault, 500);
    let metadata = metadata(&mut plant, supervisor.config());
    let attachment = Attachment { name: "note.txt".into(), bytes: b"hello".to_vec() };
    let mut recorder = Recorder::create(&folder.path().join("run.mcap"), 20, metadata, &[attachment]).unwrap();
    let mut clock = VirtualClock::default();
    let summary = drive(&mut supervisor, &mut plant, &mut clock, Some(&mut recorder), |_, _| Some(Request::Run));
    assert_eq!(summary.unrecorded, 0);
    recorder.finish().unwrap();
    folder
}

#[test]
fn no_tick_allocates_with_a_record_or_without() {
    let folder = tempfile::tempdir().unwrap();
    for records in [false, true] {
        let mut supervisor = common::supervisor(&common::controller(), |_| {});
        let mut plant = Plant::new(5);
        let metadata = metadata(&mut plant, supervisor.config());
        let mut recorder =
            records.then(|| Recorder::create(&folder.path().join("run.mcap"), 20, metadata, &[]).unwrap());
        // The plant is a test's: its allocations are known, and taken off.
        let (mut before, mut at) = (0, Vec::with_capacity(10_000));
        let mut clock = VirtualClock::default();
        let own = plant_allocations();
        drive(&mut supervisor, &mut plant, &mut clock, recorder.as_mut(), |_, phase| {
            let now = COUNT.get();
            at.push((phase, now - before));
            before = now;
            Some(Request::Run)
        });
        let ticks = at.iter().filter(|(phase, _)| *phase == Phase::Run).count();
        assert!(ticks > 300, "{ticks} ticks");
        // The first tick of the policy may.
        let most = at[2..].iter().filter(|(phase, _)| *phase != Phase::Stand).skip(2).map(|(_, count)| *count).max();
        assert_eq!(most, Some(own), "allocations in a tick, where the plant has {own}");
    }
}

/// Allocations of the plant in one tick without a runtime: a packet has four vectors.
fn plant_allocations() -> usize {
    4
}

#[test]
fn the_estimator_does_not_allocate_and_a_robot_at_rest_stays_at_rest() {
    let robot = common::lima();
    let mut estimator = StateEstimator::new(&robot).unwrap();
    let mut packet = Measurement::new(robot.joints());
    packet.position = robot.default_pose.iter().map(|angle| *angle as f32).collect();
    packet.accelerometer_b = [0.0, 0.0, 9.81];
    let before = COUNT.get();
    // Ten minutes of standing, so that a covariance that loses its symmetry would show.
    for _ in 0..120_000 {
        packet.clock += 5_000_000;
        estimator.receive(&packet);
    }
    assert_eq!(COUNT.get(), before);
    let estimate = estimator.estimate().unwrap();
    let at_rest = estimate.linear_velocity_w.iter().chain(&estimate.angular_velocity_b).all(|x| x.abs() < 1e-6);
    assert!(at_rest && estimator.contacts().all(|carries| carries), "{estimate:?}");
}

#[test]
fn a_run_goes_through_its_phases_in_order() {
    let mut supervisor = common::supervisor(&common::controller(), |_| {});
    let mut plant = Plant::new(5);
    let mut phases = Vec::new();
    drive(&mut supervisor, &mut plant, &mut VirtualClock::default(), None, |_, phase| {
        phases.push(phase);
        Some(Request::Run)
    });
    phases.dedup();
    assert_eq!(phases[..6], Phase::ALL[..6]);
}

#[test]
fn a_stop_is_obeyed_from_every_phase() {
    for stop in [Request::Stop, Request::Damp] {
        for wanted in [Phase::Stand, Phase::BlendIn, Phase::Run, Phase::BlendOut] {
            let mut supervisor = common::supervisor(&common::controller(), |_| {});
            let mut plant = Plant::new(5);
            let mut since = None;
            let mut ticks = 0u64;
            let summary = drive(&mut supervisor, &mut plant, &mut VirtualClock::default(), None, |_, phase| {
                ticks += 1;
                if phase == wanted {
                    since.get_or_insert(ticks);
                }
                Some(since.map_or(Request::Run, |_| stop))
            });
            // 0.2 s of blending out, 0.1 s of braking.
            let after = summary.ticks - since.unwrap();
            assert!(after <= 310, "{stop:?} in {wanted:?}: {after} ticks");
            assert_eq!(summary.trip, None, "a stop is no trip");
        }
    }
}

#[test]
fn a_record_replays_bit_for_bit_and_an_altered_one_does_not() {
    for fault in [Fault::None, Fault::Drop(0.3), Fault::NotANumber(3), Fault::Reorder, Fault::ClockJump(1.0)] {
        let folder = record(fault);
        let mut record = Record::read(&folder.path().join("run.mcap")).unwrap();
        assert!(!record.is_cut_off && record.attached("note.txt").count() == 1);
        let fresh = || common::supervisor(&common::controller(), |_| {});
        let outcome = replay(&record, &mut fresh());
        assert_eq!(outcome.difference, None, "{fault:?}");
        assert!(outcome.ticks > 500 && outcome.packets > 400);

        // One encoder in the packets of one policy step.
        for entry in &mut record.entries {
            if let Entry::Measured(message) = entry
                && (440_000_000..465_000_000).contains(&message.time_ns)
            {
                message.velocity[3] = message.velocity[3].map(|x| x + 0.5);
            }
        }
        let difference = replay(&record, &mut fresh()).difference.expect("another command");
        assert!(difference.what.contains("joint") && difference.seconds >= 0.44, "{difference:?}");
    }
}

#[test]
fn a_record_is_a_bus() {
    let folder = record(Fault::Drop(0.1));
    let record = Record::read(&folder.path().join("run.mcap")).unwrap();
    let mut bus = ReplayBus::new(&record).unwrap();
    let mut supervisor = common::supervisor(&common::controller(), |_| {});
    let summary = drive(&mut supervisor, &mut bus, &mut VirtualClock::default(), None, |_, _| Some(Request::Run));
    let commands = record.entries.iter().filter(|entry| matches!(entry, Entry::Command(_))).count() as u64;
    assert_eq!((summary.trip, summary.ticks), (None, commands));
}

/// A machine's clock: every hundredth wake-up is 20 ms late.
#[derive(Default)]
struct Sleepy {
    clock: VirtualClock,
    ticks: u64,
}

impl Clock for Sleepy {
    fn now(&mut self) -> u64 {
        self.clock.now()
    }

    fn wait_until(&mut self, deadline: u64) -> u64 {
        self.ticks += 1;
        self.clock.wait_until(deadline + if self.ticks.is_multiple_of(100) { 20_000_000 } else { 0 })
    }
}

/// A loop that slept for 20 ms eight times, while its robot went on: replayed at another time, its packets are early or late.
#[test]
fn a_record_with_gaps_is_replayed_at_its_own_times() {
    let folder = record(Fault::None);
    let mut record = Record::read(&folder.path().join("run.mcap")).unwrap();
    let mut ticks = 0;
    for entry in &mut record.entries {
        let gaps = 20_000_000 * (ticks / 100).min(8);
        match entry {
            Entry::Measured(message) => {
                message.time_ns += gaps;
                message.clock_ns += gaps;
            }
            Entry::Command(message) => {
                message.time_ns += gaps;
                ticks += 1;
            }
            Entry::Policy(_) => {}
        }
    }
    let trip = |clock: &mut dyn Clock| {
        let mut bus = ReplayBus::new(&record).unwrap();
        let mut supervisor = common::supervisor(&common::controller(), |_| {});
        let summary = drive(&mut supervisor, &mut bus, clock, None, |_, _| Some(Request::Run));
        (summary.trip.map(|trip| trip.cause), summary.ticks)
    };
    let mut clock = ReplayBus::new(&record).unwrap().clock();
    // Phases last a time, so a loop that slept makes fewer ticks of them.
    let (cause, played) = trip(&mut clock);
    assert!(cause.is_none() && (ticks - 30..=ticks).contains(&played), "{cause:?} after {played} of {ticks} ticks");
    assert_eq!(trip(&mut Sleepy::default()).0, Some(Cause::Delayed));
}

#[test]
fn a_record_that_was_cut_off_is_read_to_its_last_chunk_and_others_are_refused() {
    let folder = record(Fault::None);
    let (whole, cut) = (folder.path().join("run.mcap"), folder.path().join("cut.mcap"));
    let bytes = std::fs::read(&whole).unwrap();
    std::fs::write(&cut, &bytes[..bytes.len() * 2 / 3]).unwrap();
    let record = Record::read(&cut).unwrap();
    assert!(record.is_cut_off);
    for bad in [b"".as_slice(), b"nonsense", &bytes[..20]] {
        std::fs::write(&cut, bad).unwrap();
        let error = Record::read(&cut).unwrap_err();
        assert!(matches!(error, RuntimeError::Input(_)) && error.to_string().contains("expected an MCAP record"));
    }
    let again = Recorder::create(&whole, 20, BTreeMap::new(), &[]);
    assert!(again.is_err_and(|error| error.to_string().contains("exists")), "nothing is overwritten");
    let _ = Facts::of(&common::lima(), 1.0, 1.0);
}

#[test]
fn a_declared_length_is_not_believed() {
    let folder = record(Fault::None);
    let (whole, changed) = (folder.path().join("run.mcap"), folder.path().join("changed.mcap"));
    let bytes = std::fs::read(&whole).unwrap();
    // A metadata record of four exabytes, and a chunk that says to become as many.
    let mut long = bytes[..8].to_vec();
    long.push(0x0C);
    long.extend((1u64 << 62).to_le_bytes());
    let mut chunk = bytes[..8].to_vec();
    chunk.push(0x06);
    chunk.extend(48u64.to_le_bytes());
    chunk.extend([0; 16]);
    chunk.extend((1u64 << 62).to_le_bytes());
    chunk.extend([0, 0, 0, 0, 4, 0, 0, 0]);
    chunk.extend(b"zstd");
    chunk.extend(4u64.to_le_bytes());
    chunk.extend([0; 4]);
    for bad in [long, chunk] {
        std::fs::write(&changed, bad).unwrap();
        assert!(matches!(Record::read(&changed), Err(RuntimeError::Input(_))));
    }
    // Any field of the first records may be another: the reader returns, with a record or a refusal.
    for at in 8..500.min(bytes.len() - 8) {
        let mut damaged = bytes.clone();
        damaged[at..at + 8].copy_from_slice(&(u64::MAX >> 8).to_le_bytes());
        std::fs::write(&changed, damaged).unwrap();
        let _ = Record::read(&changed);
    }
}
