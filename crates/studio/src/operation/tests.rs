//! Tests of operations.

#![allow(clippy::unwrap_used)]
use super::*;

fn after(operations: &[&str]) -> Scene {
    let mut scene = Scene::default();
    operations.iter().for_each(|text| Operation::parse(text).unwrap().apply(&mut scene).unwrap());
    scene
}

#[test]
fn every_action_is_a_line() {
    let scene = after(&[
        "say text = \"a person walks\"",
        "add clip = \"builtin:wave\", index = 0",
        "lay clip = \"builtin:wave\", at = 1, parts = [\"arms\"]",
        "trim id = \"m2\", start = 0.5, end = 2.5",
        "split id = \"m2\", at = 1.5",
        "speed id = \"m1\", value = 2",
        "mirror id = \"m1\"",
        "repeat id = \"m1\", times = 3",
        "fade id = \"m1\", seconds = 0.2",
        "wait id = \"m1\", seconds = 1",
        "sentence id = \"m1\", seed = 7, best_of = 4",
        "edit id = \"m2\", body = \"left_hand\", at = 1, by = [0.1, 0, 0.2]",
        "edit id = \"m2\", body = \"left_hand\", at = 1.01, by = [0, 0.1, -0.05], reach = 0.4",
        "style id = \"m2\", gain = 1.3, smooth = 4",
        "point id = \"m2\", at = 0.7, gain = 1.5",
        "feasible id = \"m2\", value = true",
        "style id = \"m3\", gain = 1.3",
        "plain id = \"m3\"",
        "push at = 1, seconds = 0.2, body = \"torso\", newtons = [40, 0, 0]",
        "switch at = 2, friction = 0.3",
        "move id = \"p1\", at = 3",
        "move id = \"m1\", index = 2",
        "camera azimuth = 1, follow = false",
        "seed value = 5",
    ]);
    let ids: Vec<&str> = scene.motion.iter().map(|block| block.id.as_str()).collect();
    assert_eq!(ids, ["m2", "m3", "m1"]);
    let part = |i: usize| (scene.motion[i].start, scene.motion[i].end, scene.motion[i].fade);
    assert_eq!((part(0), part(1)), ((Some(0.5), Some(1.5), None), (Some(1.5), Some(2.5), Some(0.0))));
    assert_eq!((scene.motion[2].speed, scene.motion[2].mirror, scene.motion[2].repeat), (Some(2.0), true, Some(3)));
    assert_eq!((scene.motion[2].seed, scene.motion[2].best_of), (Some(7), Some(4)));
    assert_eq!((scene.push[0].at, scene.switch[0].friction, scene.seed), (3.0, Some(0.3), 5));
    assert!(!scene.camera.follow && scene.camera.azimuth == 1.0);
    let (whole, plain) = (&scene.motion[0], &scene.motion[1]);
    let sum = Edit { body: "left_hand".into(), at: 1.0, by: [0.1, 0.1, 0.15], reach: Some(0.4) };
    assert_eq!(whole.edits, [sum]);
    assert_eq!((whole.gain, whole.smooth, whole.feasible), (Some(1.3), Some(4.0), true));
    assert_eq!(whole.points, [PointGain { at: 0.7, gain: 1.5 }]);
    assert!(plain.gain.is_none() && plain.edits.is_empty() && plain.points.is_empty() && !plain.feasible);
    let removed = after(&["say text = \"a\"", "say text = \"b\"", "remove id = \"m1\""]);
    assert_eq!(removed.motion.len(), 1);
}

#[test]
fn refused_operations_change_nothing() {
    let mut scene = after(&["add clip = \"builtin:walk\""]);
    let before = scene.clone();
    for (text, told) in [
        ("remove id = \"x\"", "expected one of the scene's ids (m1), got 'x'"),
        ("speed id = \"m1\", value = 0", "speed: expected 0.1 to 10, got 0"),
        ("move id = \"m1\", index = 4", "index: expected 0 to 0, got 4"),
        ("split id = \"m1\", at = -1", "expected a time within"),
        ("style id = \"m1\", gain = 9", "gain: expected 0 to 4, got 9"),
        ("edit id = \"m1\", body = \"head\", at = 0, by = [9, 0, 0]", "by: expected -3 to 3, got 9"),
        ("sentence id = \"m1\", text = \"a\"", "expected a sentence, got a clip"),
        ("push at = 1, seconds = inf, body = \"b\", newtons = [0, 0, 0]", "seconds: expected"),
    ] {
        let error = Operation::parse(text).unwrap().apply(&mut scene).unwrap_err().to_string();
        assert!(error.contains(told), "{text}: {error}");
        assert_eq!(scene, before, "{text}");
    }
    for text in ["", "fly", "trim id = 3", "trim id = \"m1\", stert = 1", "seed value = 1 } x = {"] {
        assert!(Operation::parse(text).is_err(), "{text}");
    }
}
