//! Words of tempo, size, extent, pace and side show on the motion, in numbers.

use std::path::Path;

use lifelike_character::anatomy::Overrides;
use lifelike_character::{Anatomy, Character};
use lifelike_language::checks::{Fact, Finding, Tracks, measure};
use lifelike_language::grammar::{Generator, Grammar, Performed};
use lifelike_language::script::{Clause, Reader, Script};
use lifelike_motion::retarget::RetargetOptions;

fn lima() -> (Character, Anatomy) {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../robots/lima.xml");
    let lima = Character::from_mjcf(&std::fs::read_to_string(file).unwrap(), "lima.xml", None).unwrap();
    let anatomy = Anatomy::guess(&lima, &Overrides::new()).unwrap();
    (lima, anatomy)
}

/// Performs the clauses of a sentence.
fn perform(text: &str) -> (Vec<Performed>, Script) {
    let (lima, anatomy) = lima();
    let grammar = Grammar::builtin().unwrap();
    let script = Reader::new(&grammar).unwrap().read(text);
    let actions = script.clauses.iter().flat_map(|clause| &clause.actions);
    let verbs: Vec<&str> = actions.map(|action| action.verb.as_str()).collect();
    let generator = Generator::of_verbs(&grammar, &lima, &anatomy, RetargetOptions::default(), &verbs).unwrap();
    let clauses = script.clauses.iter().zip(0..);
    (clauses.map(|(clause, index)| generator.perform(clause, 1, index).unwrap()).collect(), script)
}

fn tracks(made: &Performed) -> Tracks {
    let (lima, anatomy) = lima();
    Tracks::of(&made.clip, &lima, &anatomy).unwrap()
}

fn of(made: &Performed, fact: Fact) -> &Finding {
    made.findings.iter().find(|finding| finding.fact == fact).unwrap()
}

#[test]
fn tempo_and_size_differ_by_a_quarter() {
    for (text, fact, [least, most]) in [
        ("nod gently", Fact::Size, [0.0, 0.8]),
        ("nod gently", Fact::Speed, [0.0, 0.8]),
        ("clap with gusto", Fact::Speed, [1.25, 2.0]),
        ("shake your head a bit", Fact::Size, [0.0, 0.8]),
        ("punch vigorously", Fact::Size, [1.25, 2.0]),
        ("knock softly", Fact::Speed, [0.0, 0.8]),
        ("march quickly on the spot", Fact::Speed, [1.25, 2.0]),
        ("do high knees slowly", Fact::Speed, [0.0, 0.8]),
        ("scurry backwards", Fact::Speed, [1.25, 2.0]),
        ("amble along", Fact::Speed, [0.0, 0.8]),
        ("bow slightly", Fact::Size, [0.0, 0.8]),
        ("look up slightly", Fact::Size, [0.0, 0.8]),
        ("play the guitar with big strokes", Fact::Size, [1.25, 2.0]),
        ("walk backwards with small steps", Fact::Size, [0.0, 0.8]),
    ] {
        let (made, script) = perform(text);
        let got: f64 = of(&made[0], fact).got.parse().unwrap();
        assert!((least..=most).contains(&got), "{text}: {script}: {fact:?} {got}");
    }
}

#[test]
fn a_bit_is_less_and_a_while_is_longer() {
    for [short, plain] in
        [["back up a bit", "back up"], ["jog a bit", "jog"], ["come a little closer to me", "come closer"]]
    {
        let [short, plain] = [short, plain].map(|text| measure::way(&tracks(&perform(text).0[0])));
        assert!(short < 0.8 * plain, "{short} of {plain} m");
    }
    for [long, plain] in [["wave for a while", "wave"], ["walk for a good while", "walk"], ["applaud", "clap twice"]] {
        let [long, plain] = [long, plain].map(|text| perform(text).0[0].clip.seconds());
        assert!(long > 1.25 * plain, "{long} of {plain} s");
    }
}

#[test]
fn a_pace_and_a_way_in_a_time_are_walked() {
    for (text, metres, seconds) in [
        ("walk at 0.35 m/s for 5 s", 1.75, 5.0),
        ("go 1 m forward in 5 seconds", 1.0, 5.0),
        ("walk backwards 0.8 m in 4 seconds", 0.8, 4.0),
    ] {
        let (lima, anatomy) = lima();
        let grammar = Grammar::builtin().unwrap();
        let (made, script) = perform(text);
        let clause: &Clause = &script.clauses[0];
        let verbs = [clause.actions[0].verb.as_str()];
        let generator = Generator::of_verbs(&grammar, &lima, &anatomy, RetargetOptions::default(), &verbs).unwrap();
        let lasting = generator.lasting(&made[0].clip, clause).unwrap().unwrap();
        let way = measure::way(&tracks(&made[0]));
        assert!((way / metres - 1.0).abs() < 0.15 && lasting.passed, "{text}: {way} m, {} s of {seconds}", lasting.got);
    }
}

#[test]
fn arms_are_there_when_the_body_is_lowest() {
    for text in [
        "squat with your arms out to the sides",
        "squat with both arms stretched forward",
        "squat with your hands behind your head",
        "sit down with your arms crossed",
    ] {
        let (made, script) = perform(text);
        let there =
            made[0].findings.iter().find(|finding| finding.expected.contains("when the body is lowest")).unwrap();
        assert!(there.passed, "{text}: {script}: {}", there.got);
    }
}

#[test]
fn one_hand_of_a_verb_of_both_moves_alone() {
    for (text, count, left) in
        [("curl your left arm three times", 3, true), ("do two lateral raises with the right arm", 2, false)]
    {
        let (made, script) = perform(text);
        let found = tracks(&made[0]);
        let [own, other] = if left { [0, 1] } else { [1, 0] };
        let gone = [own, other].map(|hand| measure::excursion(&found.hands[hand]));
        assert_eq!(of(&made[0], Fact::Count).got, count.to_string(), "{text}: {script}");
        assert!(gone[1] < 0.2 * gone[0], "{text}: {script}: {gone:?}");
    }
}

#[test]
fn a_turn_while_walking_has_a_way_on_both_sides() {
    let (made, script) = perform("do a u-turn while marching forward");
    assert_eq!(made.len(), 3, "{script}");
    let ways: Vec<f64> = made.iter().map(|made| measure::way(&tracks(made))).collect();
    assert!(ways[0] > 0.4 && ways[1] < 0.2 && ways[2] > 0.4, "{ways:?}");
    let yaw = tracks(&made[1]).yaw;
    let turned = (yaw[yaw.len() - 1] - yaw[0]).to_degrees().abs();
    assert!((turned - 180.0).abs() < 10.0, "{turned}");
}

#[test]
fn a_pose_and_the_way_to_it_take_as_long_as_is_said() {
    let (lima, anatomy) = lima();
    let grammar = Grammar::builtin().unwrap();
    for (text, wanted) in [
        ("take four seconds to raise your right arm", 4.0),
        ("raise both arms within 3 s", 3.0),
        ("stretch your left arm out to the side over five seconds", 5.0),
        ("sit down for three seconds", 3.0),
        ("hold a tree pose for four seconds", 4.0),
        ("hold an arabesque for five seconds", 5.0),
        ("crouch with your hands on your head for three seconds", 3.0),
    ] {
        let (made, script) = perform(text);
        let clause: &Clause = &script.clauses[0];
        let verbs = [clause.actions[0].verb.as_str()];
        let generator = Generator::of_verbs(&grammar, &lima, &anatomy, RetargetOptions::default(), &verbs).unwrap();
        let lasting = generator.lasting(&made[0].clip, clause).unwrap().unwrap();
        assert!(lasting.passed && clause.rise.or(clause.seconds) == Some(wanted), "{text}: {script}: {}", lasting.got);
    }
}

#[test]
fn arms_that_are_held_out_are_level() {
    for text in ["hold your arms out to the sides", "point to the left with your left arm", "stretch both arms ahead"] {
        let (made, script) = perform(text);
        let level = made[0].findings.iter().find(|finding| finding.expected.contains("arm up by")).unwrap();
        let got: f64 = level.got.parse().unwrap();
        assert!((85.0..110.0).contains(&got), "{text}: {script}: {got}");
    }
}
