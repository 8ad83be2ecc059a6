#![allow(clippy::unwrap_used)]
use super::*;

fn plan() -> GetUpPlan {
    GetUpPlan {
        robot: "lima".into(),
        script: "lima".into(),
        seed: 1,
        twins: Vec::new(),
        candidates: 16,
        elites: 4,
        starts: 2,
        deviation: 0.1,
        iterations: 2,
        minutes: None,
    }
}

fn search() -> GetUpSearch {
    let robot = Arc::new(Robot::load("lima").unwrap());
    let script = GetUpScript::parse(GetUpScript::builtin("lima").unwrap()).unwrap();
    GetUpSearch::new(&plan(), &robot, script, 1).unwrap()
}

#[test]
fn a_candidate_is_the_script_that_it_was_made_of() {
    let search = search();
    let (own, script) = (search.script(), &search.script);
    for (a, b) in [(&own.roll, &script.roll), (&own.rise, &script.rise)] {
        assert_eq!(a.len(), b.len());
        for (a, b) in a.iter().zip(b.iter()) {
            assert!((a.seconds - b.seconds).abs() < 1e-9);
            for (joint, (a, b)) in a.pose.iter().zip(&b.pose).enumerate() {
                // Targets beyond a joint's range are part of the script, and none is clipped.
                assert!((f64::from(*a) - f64::from(*b)).abs() < 0.011, "joint {joint}: {a} {b}");
            }
        }
    }
    let read = GetUpScript::parse(&text(&own)).unwrap();
    assert_eq!(text(&read), text(&own));
}

#[test]
fn the_shipped_script_is_worth_more_than_one_that_only_lies() {
    let mut search = search();
    let lie = vec![search.script.lie[1].clone(); 2];
    for (stage, keys) in [(Stage::Roll, search.script.roll.clone()), (Stage::Rise, search.script.rise.clone())] {
        let mut candidates = vec![lie.clone(); 16];
        candidates[0] = keys;
        let outcomes = search.trials.run(stage, &candidates, 0).unwrap();
        assert!(outcomes[1].success[0] == 0.0 && outcomes[0].value > 3.0 * outcomes[1].value, "{stage:?} {outcomes:?}");
        assert!(outcomes[0].success[0] > 0.4, "{stage:?} {outcomes:?}");
    }
}

#[test]
fn a_resumed_search_goes_on_as_if_it_had_not_stopped() {
    let (mut whole, mut first) = (search(), search());
    for _ in 0..2 {
        whole.step().unwrap();
    }
    first.step().unwrap();
    let saved = first.checkpoint().unwrap();
    let mut second = search();
    second.restore(&saved).unwrap();
    second.step().unwrap();
    assert_eq!(whole.searches, second.searches);
    assert_ne!(whole.searches, first.searches);
}
