//! Promises of disturbances.

#![allow(clippy::unwrap_used)]

use std::sync::Arc;

use lifelike_robot::reference::standing_clip;
use lifelike_robot::{ReferenceLibrary, Robot};

use super::push::{punches, pushes};
use super::stairs::{climb, footfalls};
use super::switches::segments;
use super::*;
use crate::tests::{clip, controller};
use crate::{Episode, EvaluationOptions, EvaluationSetup};
use lifelike_sim::testing::{Followers, robot};

fn run(width: usize) -> Robustness {
    let options = RobustnessOptions {
        sizes: Vec::new(),
        seed: 7,
        few: true,
        disturbances: Disturbance::ALL.to_vec(),
        evaluation: EvaluationOptions {
            seconds: 1.5,
            starts: 2,
            keep: 1,
            after_fall: 0.2,
            ..EvaluationOptions::default()
        },
    };
    let clips = [clip("once", 2.0, false), clip("cycle", 1.0, true)];
    let simulate = |terrain, n| {
        let mut simulation = Followers::new(n);
        simulation.terrain = terrain;
        Ok(Box::new(simulation) as Box<dyn lifelike_sim::Simulation>)
    };
    let controller = controller(1e-6);
    let setup = EvaluationSetup { controller: &controller, encoder: None, simulate: &simulate, environments: width };
    sweep(&setup, &clips, &options, |_, _, _| {}).unwrap()
}

#[test]
fn the_curves_do_not_depend_on_how_many_run_at_once_and_each_says_what_it_is() {
    let all = run(64);
    assert_eq!(serde_json::to_string(&all).unwrap(), serde_json::to_string(&run(1)).unwrap());
    let names: Vec<&str> = all.curves.iter().map(|c| c.name).collect();
    // A post has neither head nor hands, its foot has no sole to fall, so there is nothing to push or to climb with.
    assert_eq!(names[0], "push root");
    assert!(
        !names.contains(&"push hands") && names.ends_with(&["friction", "mass", "calibration", "hills", "switches"])
    );
    let drift = |c: &RobustnessCurve| c.points.iter().map(|p| p.score.position_drift_mean_m).collect::<Vec<_>>();
    let pushed = drift(&all.curves[0]);
    assert!(pushed[0] < 1e-3 && pushed[0] < pushed[1] && pushed[1] < pushed[2], "{pushed:?}");
    let slippery: Vec<f64> = all
        .curves
        .iter()
        .find(|c| c.name == "friction")
        .unwrap()
        .points
        .iter()
        .map(|p| p.score.joint_error_deg)
        .collect();
    assert!(slippery[0] < slippery[2], "followers pull by friction: {slippery:?}");
    let hills = all.curves.iter().find(|c| c.name == "hills").unwrap();
    assert_eq!(hills.points[0].score.episodes, 3 * 4, "three landscapes");
    assert_eq!(all.tables().len(), all.curves.len());
    assert_eq!(all.curves().len(), 2 * all.curves.len());
}

#[test]
fn pushes_differ_by_force_alone() {
    let lima = Robot::load("lima").unwrap();
    let episode = Episode { number: 3, frame: 0, planned: 501 };
    let of = |force| pushes(&lima, Part::Hands, force, &episode, 1);
    let (one, two) = (of(1.0), of(2.0));
    assert_eq!(one.len(), 5, "one in each two seconds");
    let weight = (lima.character.mass() * lima.character.gravity.norm()) as f32;
    for (a, b) in one.iter().zip(&two) {
        assert_eq!((a.from, a.until, a.push.body), (b.from, b.until, b.push.body));
        assert!((5..=10).contains(&(a.until - a.from)), "0.1 to 0.2 s at 50 Hz: {a:?}");
        assert!((a.push.force_w[0].hypot(a.push.force_w[1]) / weight - 1.0).abs() < 1e-5);
        assert!((b.push.force_w[0] - 2.0 * a.push.force_w[0]).abs() < 1e-3);
    }
    assert!(one.windows(2).all(|w| w[0].until <= w[1].from), "one after the other");
    assert_ne!(of(1.0), pushes(&lima, Part::Hands, 1.0, &Episode { number: 4, ..episode }, 1));
}

#[test]
fn punches_are_those_of_the_published_schedule() {
    let lima = Robot::load("lima").unwrap();
    let weight = (lima.character.mass() * lima.character.gravity.norm()) as f32;
    let size = |push: &crate::TimedPush| push.push.force_w.iter().map(|x| x * x).sum::<f32>().sqrt() / weight;
    let (mut up, mut count, mut bodies) = (0.0, 0.0, std::collections::BTreeSet::new());
    let own: std::collections::BTreeSet<usize> = lima.character.scalar_joints().map(|joint| joint.body).collect();
    for number in 0..200 {
        let episode = Episode { number, frame: 0, planned: 4500 };
        let all = punches(&lima, 2.0, &episode, 1);
        assert_eq!(all.len(), 18, "one in each segment of 5 s");
        for (i, punch) in all.iter().enumerate() {
            assert_eq!((punch.from, punch.until), (5 + 250 * i, 9 + 250 * i), "0.1 s into it, for 0.08 s at 50 Hz");
            let largest = 2.0 / 3.0 + 4.0 / 3.0 * (5.0 * i as f32 / 60.0).min(1.0);
            assert!((0.499 * largest..1.001 * largest).contains(&size(punch)), "{i}: {}", size(punch));
            (up, count) = (up + punch.push.force_w[2] / weight / size(punch), count + 1.0);
            bodies.insert(punch.push.body);
        }
        let half = punches(&lima, 1.0, &episode, 1);
        assert!(
            half.iter().zip(&all).all(|(a, b)| a.push.body == b.push.body && (2.0 * size(a) - size(b)).abs() < 1e-4)
        );
    }
    // The mean of 3,600 heights that are uniform from -1 to 1 has a standard deviation of 0.0096.
    assert!((up / count).abs() < 0.05 && bodies == own, "{} {}", up / count, bodies.len());
}

#[test]
fn stairs_rise_where_feet_come_down() {
    let lima = Arc::new(Robot::load("lima").unwrap());
    let mut hop = standing_clip(&lima, 3.0);
    // Twice in the air for half a second.
    for (frame, root) in hop.root_position.iter_mut().enumerate() {
        root.z += if (25..50).contains(&frame) || (75..100).contains(&frame) { 0.2 } else { 0.0 };
    }
    let falls = footfalls(&hop, &lima).unwrap();
    assert_eq!(falls.len(), 2, "both feet come down together: {falls:?}");
    let before = hop.root_position.clone();
    let lift = climb(&mut hop, &lima, 0.1).unwrap();
    assert_eq!(lift[falls[0]], 0.0);
    assert!((lift[falls[0] + 15] - 0.1).abs() < 1e-12 && (lift[149] - 0.2).abs() < 1e-12, "0.3 s later a step higher");
    assert!((hop.root_position[149].z - before[149].z - 0.2).abs() < 1e-12);
}

#[test]
fn switches_come_when_asked_for_and_stay_inside_of_clips() {
    let clips = [clip("once", 2.0, false), clip("short", 0.3, false)];
    let library = ReferenceLibrary::new(&robot(), &clips, None).unwrap();
    let episode = Episode { number: 0, frame: 0, planned: 101 };
    let all = segments(&library, &episode, 500, 25, 1);
    assert_eq!(all[0].step, 1);
    for pair in all.windows(2) {
        let (from, frames) = (pair[0].frame, pair[1].step - pair[0].step);
        let clip = library.clip_of(from);
        // 0.5 s, or all of the short clip but its first and last frame.
        assert_eq!(frames, if clip == 0 { 25 } else { 14 });
        assert!(from + frames < library.range(clip).end - 1, "the last frame is never reached: {pair:?}");
    }
}
