//! Promises of explanations, on the robot whose joints follow their targets.

#![allow(clippy::unwrap_used)]

use lifelike_robot::Robot;
use lifelike_robot::reference::standing_clip;

use super::*;
use crate::tests::{clip, controller};
use lifelike_sim::Simulation;
use lifelike_sim::testing::Followers;

fn options() -> EvaluationOptions {
    EvaluationOptions { seconds: 1.0, starts: 2, keep: 0, after_fall: 0.2, ..EvaluationOptions::default() }
}

/// Environment 1 diverges at its 7th step, in the first `bad` simulations.
fn explained(bad: usize) -> Vec<Explanation> {
    let clips = [clip("once", 4.0, false)];
    let controller = controller(1e-6);
    let made = std::cell::Cell::new(0);
    let simulate = |_, n: usize| {
        let mut simulation = Followers::new(n);
        simulation.diverge = (made.get() < bad).then_some((1, 7));
        made.set(made.get() + 1);
        Ok(Box::new(simulation) as Box<dyn Simulation>)
    };
    let setup = EvaluationSetup { controller: &controller, encoder: None, simulate: &simulate, environments: 2 };
    let first = setup.evaluate(&clips, &options(), |_, _| {}).unwrap();
    explain(&setup, &first, &clips, &options(), |_, _, _| {}).unwrap()
}

#[test]
fn the_mildest_change_that_works_is_proposed() {
    let all = explained(3);
    let e = &all[0];
    assert_eq!((e.clip.as_str(), e.falls, e.episodes), ("once", 1, 2));
    let survival: Vec<f64> = e.tried.iter().map(|t| t.survival).collect();
    assert_eq!(survival, [0.5, 0.5, 1.0], "what came after was not tried");
    assert_eq!(e.modification, Some(ClipModification::Slower(1.2)));
    let repaired = e.repaired.as_ref().unwrap();
    assert_eq!(repaired.name, "once-slower1.2");
    assert!(repaired.provenance.source.contains("1.2 times slower"), "{}", repaired.provenance.source);
    assert!((repaired.seconds() - 1.2 * 4.0).abs() < 0.02, "{}", repaired.seconds());
    // The post of the test has no soles and no shapes: half a metre up, it is held up by nothing.
    let words = e.words();
    for part in
        ["once falls in 1 of 2 episodes", "simulation diverged at 3.14 s", "held up by nothing", "1.2 times slower"]
    {
        assert!(words.contains(part), "{part}: {words}");
    }
    assert_eq!(table(&all).unwrap().rows.len(), 1);
}

#[test]
fn where_nothing_helps_it_says_so() {
    let e = &explained(100)[0];
    assert_eq!((e.tried.len(), e.modification, e.repaired.is_none()), (ClipModification::ALL.len(), None, true));
    assert!(e.proposal().contains("50% survive"), "{}", e.proposal());
    assert!(explained(0).is_empty() && table(&[]).is_none());
}

#[test]
fn changes_by_hand() {
    let lima = Robot::load("lima").unwrap();
    let mut bend = standing_clip(&lima, 2.0);
    let knee = bend.joint_names.iter().position(|n| n == "left_knee").unwrap();
    let n = bend.joint_names.len();
    for frame in 50..100 {
        bend.joints[frame * n + knee] += 0.4;
        bend.root_position[frame].x += 1.0;
    }
    let small = ClipModification::Smaller(0.5).apply(&bend, &lima).unwrap();
    let at = |clip: &MotionClip, frame: usize| clip.joints_at(frame)[knee];
    // The mean lies 0.2 above the first half: half as far to both sides.
    assert!((at(&small, 0) - at(&bend, 0) - 0.1).abs() < 1e-9 && (at(&bend, 99) - at(&small, 99) - 0.1).abs() < 1e-9);
    assert_eq!((small.root_position[99].x - small.root_position[0].x, small.len()), (0.5, bend.len()));
    let columns = bend.columns_for(&lima.character).unwrap();
    let lowest = |clip: &MotionClip| modification::lowest_soles(clip, &lima, &columns);
    assert!(
        lowest(&bend).iter().zip(lowest(&small)).all(|(a, b)| (a - b).abs() < 1e-9),
        "soles are as high as they were"
    );
    let slow = ClipModification::Slower(2.0).apply(&bend, &lima).unwrap();
    assert_eq!((slow.fps, slow.len()), (bend.fps, 2 * bend.len() - 1));
    assert_eq!((at(&slow, 0), at(&slow, 198)), (at(&bend, 0), at(&bend, 99)));
}
