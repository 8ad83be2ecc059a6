#![allow(clippy::unwrap_used)]
use std::sync::LazyLock;

use super::*;
use crate::grammar::Grammar;

fn reader() -> &'static Reader<'static> {
    static GRAMMAR: LazyLock<Grammar> = LazyLock::new(|| Grammar::builtin().unwrap());
    static READER: LazyLock<Reader<'static>> = LazyLock::new(|| Reader::new(&GRAMMAR).unwrap());
    &READER
}

fn read(text: &str) -> Script {
    reader().read(text)
}

fn line(text: &str) -> String {
    read(text).to_string()
}

#[test]
fn free_words_become_actions() {
    for (text, expected) in [
        ("take exactly two steps forward", "step forward, forward, 2 times"),
        ("take exactly 3 steps", "step forward, forward, 3 times"),
        ("step to the right", "walk sideways, to the right, once"),
        ("sidestep to the left", "walk sideways, to the left"),
        ("walk in a circle", "walk curve, to the left, 360 degrees"),
        ("stand on one leg", "balance, right side"),
        ("stand on your left leg", "balance, right side"),
        ("just stand still and do not move", "stand"),
        ("do not walk, wave", "wave, right side"),
        ("twirl around twice to the left", "turn, to the left, 360 degrees, 2 times"),
        ("turn your back to me", "turn, to the left, 180 degrees"),
        ("beckon me to come closer", "beckon, right side"),
        ("punch left and right", "punch, left side, once; then punch, right side, once"),
        ("say hello with your left hand", "wave, left side"),
        ("look over the left shoulder", "look over shoulder, to the left"),
        ("turn 45° to the right", "turn, to the right, 45 degrees"),
        ("do a half turn counter-clockwise", "turn, to the left, 180 degrees"),
        ("Squats two times!", "squat, 2 times"),
        ("nod 3x", "nod, 3 times"),
        ("the robot is walking for four seconds", "walk, forward, 4 s"),
        ("turn, wave, then bow", "turn, to the left, 90 degrees; then wave, right side; then bow"),
        ("walk forward while waving with the right hand", "wave, right side while: walk, forward"),
        ("he waves as he walks backwards", "wave, right side while: walk backward, backward"),
        ("walk forward and wave with your right hand while you walk", "wave, right side while: walk, forward"),
        ("give me five jumping jacks", "jumping jack, both side, in place, 5 times"),
        ("spin all the way round once, clockwise", "turn, to the right, 360 degrees"),
        ("three squats. deep ones. nice and slow.", "squat, 3 times, slow, big"),
        ("sidestep to the left pushing both palms out", "push, both side while: walk sideways, to the left"),
        ("let everything flop down", "trunk forward 55, held 2 s"),
        ("raise both arms", "raise arms, both side"),
        ("raise your left arm", "reach up, left side"),
        ("kick a ball with the left foot", "kick, left side"),
        ("after bowing, clap twice", "bow; then clap, both side, 2 times"),
        ("bow three times", "bow, 3 times"),
        ("walk sadly", "walk, forward, sad"),
        ("wavs with the left hand", "wave, left side"),
        ("take three steps back and then wave", "step back, backward, 3 times; then wave, right side"),
        (
            "turn 90 degrees left, then 90 degrees right",
            "turn, to the left, 90 degrees; then turn, to the right, 90 degrees",
        ),
        ("nod and clap at the same time", "nod while: clap, both side"),
        ("before you wave, take a bow", "bow; then wave, right side"),
        ("nod and clap in the same time", "nod while: clap, both side"),
        ("turn slowly on the spot and wave as you turn", "wave, right side while: turn, to the left, 90 degrees, slow"),
        (
            "Walk three steps forward, turn around and walk back to where you started",
            "step forward, forward, 3 times; then turn, to the left, 180 degrees; then walk, forward, 3 times",
        ),
        ("Stand at attention", "attention, in place"),
        ("step forward with your right foot", "step forward, forward, once"),
        ("turn around", "turn, to the left, 180 degrees"),
        ("sidestep to the left, 3 small steps", "walk sideways, to the left, 3 times, small"),
        ("tunr 90 degres rigth", "turn, to the right, 90 degrees"),
        ("wave with the lefft hand, no rush", "wave, left side"),
        ("walk ahead, waving", "wave, right side while: walk, forward"),
        ("bend down and pick something up", "pick up, right side"),
        ("jump three times, then run forward", "jump, in place, 3 times; then run, forward"),
        ("hop twice on the left leg", "hop, left side, in place, 2 times"),
        ("lift your right knee four times", "knee raise, right side, 4 times"),
        ("kick to the side with the left foot", "side kick, left side, once"),
        ("do five jumping jacks", "jumping jack, both side, in place, 5 times"),
        ("sit down, then stand up", "sit; then stand"),
        ("walk with arms crossed", "cross arms, both side while: walk, forward"),
        ("walk to the left", "walk sideways, to the left"),
        ("run backwards", "walk backward, backward, fast"),
        ("back up a little", "walk backward, backward, 2 times"),
        ("crouch down and after that get back up", "crouch; then stand"),
        ("wave angrily", "wave, right side, angry"),
        ("trudge forward, head hanging low", "walk tired, forward, sad"),
        (
            "scratch your head and rub your belly at the same time",
            "scratch head, right side while: rub belly, left side",
        ),
        ("one hand on the hip, the other beckoning", "hand on hip, right side while: beckon, left side"),
        ("turn in place with arms raised over your head", "raise arms, both side while: turn, to the left, 90 degrees"),
        ("bow with your hand on your heart", "hand on heart, right side while: bow"),
        ("cud u plz raize ur rigth hand thx", "reach up, right side"),
        ("jgo frwrad adn tehn stpo!!", "jog forward, forward; then stand"),
        ("bow gently", "bow, slow, small"),
        ("walk forward, stop, and salute", "walk, forward; then stand; then salute, right side"),
        ("wave once with each hand", "wave, left side, once; then wave, right side, once"),
        ("before you clap, turn all the way around", "turn, to the left, 360 degrees; then clap, both side"),
        ("face left then face the front again", "turn, to the left, 90 degrees; then turn, to the right, 90 degrees"),
        ("amble forward", "walk, forward, slow"),
        ("sway like in the 80s", "sway"),
        ("stand in warrior 2", "warrior pose, right side"),
        ("march for a while", "march, in place, 8 s"),
        ("nod over and over", "nod, 8 s"),
        ("walk at 0.3 m/s for 4 s", "walk, forward, 1.2 m, 4 s"),
        ("walk at 1.8 km/h", "walk, forward, 2.5 m, 5 s"),
        ("walk, turning around halfway", "walk, forward; then turn, to the left, 180 degrees; then walk, forward"),
        ("walks, turns round, walks back", "walk, forward; then turn, to the left, 180 degrees; then walk, forward"),
        ("lift your left arm 3x and your right arm once", "reach up, left side, 3 times; then reach up, right side"),
        (
            "wave 4 times with the right, then twice with the left",
            "wave, right side, 4 times; then wave, left side, 2 times",
        ),
        (
            "stamp four times, alternating feet, right first",
            "stamp, right side, once; then stamp, left side, once; then stamp, right side, once; then stamp, left side, once",
        ),
        ("pump your fist in the air 5 times", "fist pump, right side, 5 times"),
        (
            "the knight draws his sword, swings it twice and kneels",
            "draw sword, right side; then swing sword, both side, 2 times; then kneel, right side",
        ),
        ("put on a hat, then take it off", "put on hat, both side; then take off hat, right side"),
        ("draw circles in the air with your left foot", "foot circle, left side, once"),
        ("hop up and down and punch the air", "jump, in place, 3 times; then fist pump, right side"),
        ("shadow box for a bit", "jab cross, both side, 5 s"),
        ("turn in circle and flap the arms like bird", "flap, both side while: turn, to the left, 360 degrees"),
        ("turn around and wave", "turn, to the left, 180 degrees; then wave, right side"),
        ("bow like an old man", "bow, frail"),
        ("sit down like an exhausted old man", "sit, tired"),
        ("do a one-eighty", "turn, to the left, 180 degrees"),
        ("stand at ease", "hands behind back, both side"),
        ("curl your right arm twice", "bicep curl, right side, 2 times"),
        ("until I say stop jog on the spot", "jog in place, in place"),
        (
            "one arm makes big circles the other one rests on the hip",
            "hand on hip, left side while: arm circles, right side, big",
        ),
        ("bow, kneel, arms out to the sides", "bow; then kneel, right side; then arms to sides, both side"),
        (
            "lift your right arm, two steps left, nod",
            "reach up, right side; then walk sideways, to the left, 2 times; then nod",
        ),
        (
            "step left a bit, then right the same amount",
            "walk sideways, to the left, once; then walk sideways, to the right, once",
        ),
    ] {
        assert_eq!(line(text), expected, "{text}: {:?}", read(text));
    }
}

#[test]
fn what_is_left_out_or_said_otherwise_is_done() {
    for (text, expected) in [
        (
            "lean to the right and reach up with the left arm, then other way round",
            "trunk to the right 18; then left arm up 160 degrees; then left arm down, trunk to the left 18; then right arm up 160 degrees",
        ),
        ("kick with the left leg, now the other side", "kick, left side; then kick, right side"),
        (
            "one arm goes up, the other goes out sideways. then swap them",
            "left arm to the side 93 degrees, right arm up 160 degrees; then left arm up 160 degrees, right arm to the side 93 degrees",
        ),
        ("jump once, then two times in a row", "jump, in place, once; then jump, in place, 2 times"),
        ("clap over your head each time you jump", "clap overhead, both side while: jump, in place, once"),
        ("look left and right while you're walking", "look around while: walk, forward"),
        ("right arm straight ahead, left leg straight back", "right arm ahead 90 degrees, left foot up behind"),
        ("lean left by ten degrees, then right by twenty", "trunk to the left 10; then trunk to the right 20"),
        ("balance on your left foot for as long as it takes to count to five", "balance, right side, 5 s"),
        (
            "walk half a metre ahead and then back without turning round",
            "walk, forward, 0.5 m; then walk backward, backward",
        ),
        ("a squat, a twirl, a jump", "squat, once; then turn, to the left, 360 degrees; then jump, in place, once"),
        ("step step clap", "step in place, in place, 2 times; then clap, both side"),
        ("dance with your legs but keep your arms stiff at your sides", "tap dance, in place"),
        ("walk off with a hanging head", "turn, to the left, 180 degrees, sad; then walk, forward, sad"),
    ] {
        assert_eq!(line(text), expected, "{text}: {:?}", read(text));
    }
}

#[test]
fn what_is_not_understood_is_kept() {
    let script = read("wave acidly with the right hand");
    assert_eq!((script.to_string().as_str(), script.unknown), ("wave, right side", vec!["acidly".to_string()]));
    let script = read("defenestrate the marmalade");
    assert!(script.clauses.is_empty() && script.unknown == ["defenestrate the marmalade"], "{script:?}");
    let script = read("walk forward 1.2 m");
    assert_eq!((script.to_string().as_str(), script.unknown.len()), ("walk, forward, 1.2 m", 0), "{script:?}");
    let script = read("salutte slowly");
    assert_eq!(script.notes[0], "read 'salutte' as 'salute'");
}

#[test]
fn what_cannot_be_done_is_said_with_the_nearest() {
    let script = read("walk forward, then do a backflip, then bow");
    assert_eq!(script.to_string(), "walk, forward; then bow");
    let [one] = script.impossible.as_slice() else { panic!("{script:?}") };
    assert_eq!((one.said.as_str(), one.at, &one.nearest), ("do a backflip", 1, &None));
    let script = read("lie down and then bow").with_nearest();
    assert_eq!(script.to_string(), "crouch; then bow");
    assert!(script.impossible.is_empty() && script.notes[0].contains("with its feet only"), "{script:?}");
}

#[test]
fn every_phrase_of_the_grammar_means_its_own_verb() {
    use crate::grammar::words::captions;
    use lifelike_checkpoint::rng::stream;
    let grammar = Grammar::builtin().unwrap();
    let reader = Reader::new(&grammar).unwrap();
    let mut rng = stream(3, "script", 0, 0);
    let (mut right, mut all) = (0, 0);
    let mut wrong = Vec::new();
    for verb in &grammar.verbs {
        let action = Action { side: verb.side, direction: verb.direction, ..Action::of(&verb.name) };
        let facts = Facts { relation: Relation::Single, actions: vec![action], held_out: None };
        for text in captions(&grammar, &facts, false, 8, &mut rng).unwrap() {
            let script = reader.read(&text);
            all += 1;
            let is_right = script.clauses.len() == 1 && script.clauses[0].actions[0].verb == verb.name;
            right += usize::from(is_right);
            if !is_right {
                wrong.push(format!("{}: {text} -> {script}", verb.name));
            }
        }
    }
    assert!(right * 100 >= all * 95, "{right} of {all}: {wrong:#?}");
}

#[test]
fn new_words_are_taken_for_what_they_mean() {
    // The first words of none of these are in a phrase of their verb.
    for (text, expected) in [
        ("tidy the window", "wipe, right side"),
        ("hurl a stone into the pond with the left arm", "throw, left side"),
        ("swab the sweat off with your left wrist", "wipe brow, left side"),
    ] {
        let script = read(text);
        assert_eq!(script.to_string(), expected, "{text}: {script:?}");
    }
    // Words that nobody knows mean nothing.
    let script = read("xyzzyq the marmalade");
    assert_eq!((script.clauses.len(), script.unknown.len()), (0, 1), "{script:?}");
}

#[test]
fn frames_and_reasons_ask_for_nothing() {
    let script = read("my grandma is watching and she walked here all day, so wave at her twice");
    assert_eq!(script.to_string(), "wave, right side, 2 times", "{script:?}");
    let script = read("my dog is barking, so shush him with your left hand");
    assert_eq!((script.to_string().as_str(), script.unknown), ("shush, left side", Vec::new()));
    for (text, expected) in [
        ("I'd like you to walk backwards", "walk backward, backward"),
        ("why don't you wave?", "wave, right side"),
        ("go ahead and wave", "wave, right side"),
        ("I'd love to see you bow", "bow"),
        ("I would like that you make a pirouette", "turn, to the left, 360 degrees"),
        ("ok so um could you just like, you know, walk forward a bit", "walk, forward, 2 times"),
        (
            "look left, then look right, like we do before we cross the road",
            "look aside, to the left; then look aside, to the right",
        ),
        ("shoot a basketball then celebrate cuz it went in", "shoot basketball, both side; then cheer, both side"),
        ("can you wave five times with the left one? the left hand i mean", "wave, left side, 5 times"),
        ("bend your right elbow to ninety degrees and leave it like this", "right arm down, elbow bent 90"),
        (
            "big circles with the right arm, four of them, going backwards",
            "arm circles backward, right side, 4 times, big",
        ),
        ("the play is over and everyone's cheering for you", "bow, 55 degrees"),
        ("watch out, somebody has thrown a ball straight at your head!", "dodge, to the right"),
    ] {
        assert_eq!(line(text), expected, "{text}");
    }
}

#[test]
fn the_end_of_a_long_text_is_read() {
    let text = "It is a long story. ".repeat(40) + "Say hello to grandma with your left paw.";
    let script = reader().read_by(&text, Reading::Network);
    // What the network takes the story for does not matter here.
    assert!(script.to_string().ends_with("wave, left side"), "{script}");
}

#[test]
fn the_possible_part_is_done_and_the_rest_named() {
    let script = read("wave with your right hand and smile").with_the_rest();
    assert_eq!(script.to_string(), "wave, right side");
    assert!(script.impossible.is_empty() && script.notes[0].starts_with("cannot do 'smile'"), "{:?}", script.notes);
    // Nothing is left of a sentence that asks for nothing else.
    assert_eq!(read("smile").with_the_rest().impossible.len(), 1);
}

#[test]
fn a_script_can_be_edited() {
    let grammar = Grammar::builtin().unwrap();
    let script = read("turn 45 degrees left, then wave twice while walking");
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("s.toml");
    std::fs::write(&path, script.to_toml().unwrap()).unwrap();
    assert_eq!(Script::read(&path, &grammar).unwrap(), script);
    std::fs::write(&path, "[[clause]]\n[[clause.action]]\nverb = \"swim\"\n").unwrap();
    let error = Script::read(&path, &grammar).unwrap_err().to_string();
    assert!(error.contains("s.toml:3") && error.contains("'swim'"), "{error}");
    std::fs::write(&path, "[[clause]]\naction = []\ntempo = 3\n").unwrap();
    assert!(Script::read(&path, &grammar).unwrap_err().to_string().contains("s.toml:3"));
}

#[test]
fn numbers_of_an_edited_script_are_bounded() {
    let grammar = Grammar::builtin().unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("s.toml");
    for (clause, action, part) in [
        ("seconds = nan", "", "clause 1: expected seconds above 0, got NaN"),
        ("seconds = -3.0", "", "expected seconds above 0, got -3"),
        ("times = 0", "", "expected times from 1 to 1000, got 0"),
        ("times = 4000000000", "", "expected times from 1 to 1000"),
        ("", "count = 0", "expected count of 'wave' from 1 to 50, got 0"),
        ("", "count = 1000000", "expected count of 'wave' from 1 to 50"),
        ("", "metres = inf", "expected metres of 'wave' above 0, got inf"),
        ("", "[[clause.action]]\nverb = \"clap\"", "expected two actions of different limbs, got 'wave' and 'clap'"),
    ] {
        let text = format!("[[clause]]\n{clause}\n[[clause.action]]\nverb = \"wave\"\nside = \"right\"\n{action}\n");
        std::fs::write(&path, text).unwrap();
        let error = Script::read(&path, &grammar).unwrap_err().to_string();
        assert!(error.contains(part), "{error}");
    }
}

#[test]
fn every_reaction_to_a_situation_is_understood() {
    for means in reader().situations.reactions() {
        let script = reader().read_within(means, reader::MOST_WITHIN);
        assert!(!script.clauses.is_empty() && script.unknown.is_empty(), "{means}: {script:?}");
    }
}

#[test]
fn situations_lists_manners_and_numbers_of_people() {
    for (text, expected) in [
        ("they play the national anthem", "hand on heart, right side, 5 s"),
        ("somebody you know is across the street", "wave high, right side"),
        ("a bee is buzzing round your head", "swat fly, right side"),
        ("1. squat 2. turn around 3. clap", "squat, once; then turn, to the left, 180 degrees; then clap, both side"),
        ("wave, bow, and walk backwards", "wave, right side; then bow; then walk backward, backward"),
        ("wave w/ right hand", "wave, right side"),
        ("do one and a half turn", "turn, to the left, 270 degrees, 2 times"),
        ("clap like you don't really mean it", "clap, both side, tired"),
        ("walk in a hurry, you are late!", "walk, forward, fast"),
        ("lift your left knee to hip height and hold it", "left foot up, held 3 s"),
        ("do squats", "squat, 3 times"),
        ("please to make a squat", "squat, once"),
        ("bow 40 degrees", "bow, 40 degrees"),
        ("bring the left elbow to the right knee", "elbow to knee, right side, once"),
        ("both hands on top of your head", "hands on head, both side"),
        ("twist your upper body to the right", "twist aside, to the right"),
        ("one hand wave, other hand on hip", "wave, right side while: hand on hip, left side"),
        ("wave goodbye then walk away", "wave, right side; then turn, to the left, 180 degrees; then walk, forward"),
    ] {
        assert_eq!(line(text), expected, "{text}");
    }
    for text in ["run at 100 km/h", "walk 2 km", "jump 5 metres high"] {
        assert!(!read(text).impossible.is_empty(), "{text}: {}", line(text));
    }
    assert!(read("give me a thumbs up").notes.iter().any(|note| note.contains("lacks a thumb")));
}

#[test]
fn described_limbs_become_postures() {
    for (text, expected) in [
        (
            "raise your right hand, then your left hand, then put both down",
            "right arm up 160 degrees; then left arm up 160 degrees; then both arms down",
        ),
        (
            "raise left hand, raise right hand, put both down, kick",
            "left arm up 160 degrees; then right arm up 160 degrees; then both arms down; then kick, right side",
        ),
        ("hands up! hands down! now kneel", "both arms up 160 degrees; then both arms down; then kneel, right side"),
        ("lift your left knee to hip height and hold it", "left foot up, held 3 s"),
        ("Extend your right leg straight behind you, a few inches off the floor.", "right foot up behind"),
        ("right knee up to the chest, hold 2 s, down", "right foot up, held 2 s; then right foot down"),
        ("right elbow bent 90 degrees, forearm pointing up", "right arm ahead 84 degrees, elbow bent 90"),
        (
            "Bend both elbows so your forearms point up, upper arms straight out to the sides",
            "both arms to the side 88 degrees, elbow bent 90",
        ),
        ("lean 20 degrees to the right and stay there", "trunk to the right 20, held 3 s"),
        ("tilt ur head to one side and let it stay like that", "head to the right 25, trunk to the right 20, held 3 s"),
        ("lift the right knee and the left arm together", "left arm up 160 degrees, right foot up"),
        (
            "both arms straight in front of you, then open them wide",
            "both arms ahead 90 degrees; then both arms to the side 93 degrees",
        ),
        (
            "arms out sideways, lower them to 45 degrees",
            "both arms to the side 93 degrees; then both arms to the side 45 degrees",
        ),
        ("move your right foot back and bend the front knee", "right foot on the ground behind, knees bent"),
        (
            "left arm forward, right arm back, and hold",
            "left arm ahead 90 degrees, right arm behind 41 degrees, held 3 s",
        ),
        ("chin down, chin up, chin down again", "head forward 25; then head back 25; then head forward 25"),
    ] {
        assert_eq!(line(text), expected, "{text}");
    }
    let script = read("raise ur right arm to shoulder hight, don't move, put it down");
    assert_eq!(script.to_string(), "right arm ahead 90 degrees; then right arm down");
    assert_eq!(script.notes, ["read 'hight' as 'height'", "left out: dont move"]);
    // What a verb says as well stays that verb, and a row of postures beside unknown words is some action's description.
    for (text, expected) in [
        ("raise both arms", "raise arms, both side"),
        ("put your hands on your hips", "hands on hips, both side"),
        ("lift your right knee twice", "knee raise, right side, 2 times"),
        ("step forward with your right foot", "step forward, forward, once"),
    ] {
        assert_eq!(line(text), expected, "{text}");
    }
}

#[test]
fn limbs_are_read_by_joint_and_place() {
    for (text, expected) in [
        (
            "left elbow bent, hand pointing at the ceiling, other arm straight down",
            "left arm ahead 84 degrees, elbow bent 90, right arm down",
        ),
        (
            "right foot a step ahead of the left, weight on it",
            "trunk to the right 8, right foot on the ground ahead, knees a little bent",
        ),
        (
            "stand with your feet shoulder width apart and your hands on your hips",
            "both arms to the side 50 degrees, elbow bent 108, touching the hip, left foot down, right foot down",
        ),
        (
            "left hand behind your head, elbow out to the side",
            "left arm up 136 degrees, elbow bent 104, touching the back of the head",
        ),
        ("lift your right thigh until it is level with the floor, lower leg hanging down", "right foot up"),
        (
            "arms in a T, then bend the elbows so the hands point up",
            "both arms to the side 93 degrees; then both arms to the side 88 degrees, elbow bent 90, forearm up",
        ),
        (
            "right hand on left shoulder, left hand on right shoulder",
            "both arms ahead 65 degrees, elbow bent 95, touching the other shoulder",
        ),
        (
            "raise your arms sideways to shoulder height and let them sink again",
            "both arms to the side 90 degrees; then both arms down",
        ),
        ("elbows at your sides, forearms straight ahead", "both arms down, elbow bent 90"),
        (
            "right hand touches the left knee, then come back up",
            "right arm ahead 63 degrees, touching the other knee, trunk forward 38, knees a little bent; then right arm down, trunk straight",
        ),
        (
            "stretch left arm diagonally up and right arm diagonally down",
            "left arm to the side 135 degrees, right arm to the side 45 degrees",
        ),
        (
            "the left arm goes forward, the right arm goes back",
            "left arm ahead 90 degrees, right arm behind 41 degrees",
        ),
        ("step your left foot back and bend the front knee", "left foot on the ground behind, knees bent"),
        ("bend your left knee so that the heel comes toward your bottom", "left foot up behind"),
        ("hands at the height of your chin, elbows bent, fists closed", "both arms ahead 48 degrees, elbow bent 122"),
        (
            "left arm horizontal to the left, then sweep it to the front",
            "left arm to the side 93 degrees; then left arm ahead 90 degrees",
        ),
        (
            "shift your weight to the right foot, left leg goes out to the side",
            "trunk to the right 8, left foot up to the side",
        ),
        ("lower your right arm, keep the left one up", "left arm up 160 degrees, right arm down, held 3 s"),
        (
            "point with your right arm at the floor in front of you and with left arm at the sky",
            "left arm up 160 degrees, right arm ahead 45 degrees",
        ),
        (
            "put right hand in front of your mouth and lean head forward",
            "right arm ahead 84 degrees, elbow bent 96, touching the mouth; then head forward 25",
        ),
        ("hang your head and let your shoulders drop", "head forward 25; then trunk forward 10"),
        (
            "right hand on the back of your neck, left arm hanging",
            "right arm up 136 degrees, elbow bent 104, touching the back of the head",
        ),
        ("stand on the left leg, right foot tucked behind the left calf", "right foot up behind"),
        (
            "arms crossed over chest with hands on opposite shoulders",
            "both arms ahead 65 degrees, elbow bent 95, touching the other shoulder",
        ),
        (
            "left leg back, toes on the floor, both arms reaching forward",
            "both arms ahead 90 degrees, left foot on the ground behind, knees a little bent",
        ),
        (
            "turn your head over right shoulder with left arm across your chest",
            "left arm ahead 46 degrees, elbow bent 86, touching the chest, head turned right 55",
        ),
        ("right heel up to your buttocks, left arm forward", "left arm ahead 90 degrees, right foot up behind"),
        ("both arms out to the front, elbows slightly bent", "both arms ahead 90 degrees"),
        ("elbows in, forearms pointing to the sides, palms up", "both arms down, elbow bent 90"),
        (
            "raise your elbows to shoulder height, hands hanging down",
            "both arms to the side 88 degrees, elbow bent 90, forearm down",
        ),
        (
            "right arm bent at the elbow with the fist by the shoulder, left arm hangs down",
            "left arm down, right arm to the side 64 degrees, elbow bent 129, touching the shoulder",
        ),
        (
            "lift right knee to waist level, left hand touching it",
            "left arm ahead 53 degrees, touching the other knee, right foot up",
        ),
        (
            "right leg extended to the side, foot off the ground, arms horizontal",
            "both arms ahead 90 degrees, right foot up to the side",
        ),
        (
            "left foot back, right foot back, left foot forward, right foot forward",
            "left foot on the ground behind, knees a little bent; then right foot on the ground behind, knees a little bent; then left foot down; then right foot down",
        ),
        (
            "arms straight overhead, fingers interlocked, lean to the right then to the left",
            "both arms up 167 degrees, touching the other hand; then trunk to the right 18; then trunk to the left 18",
        ),
    ] {
        assert_eq!(line(text), expected, "{text}");
    }
}

#[test]
fn leans_and_crouches_are_bearings_of_gaits() {
    for (text, expected) in [
        ("lean forward 30 degrees while walking slowly", "trunk forward 30 while: walk, forward, slow"),
        ("lean back while you march forward", "trunk back 12 while: march forward, forward"),
        ("crouch while walking", "trunk forward 15, knees a little bent while: walk, forward"),
        ("walk like my grandpa when his hip is bad", "walk, forward, frail"),
        ("a very old lady waves", "wave, right side, frail"),
        ("hop on one foot, whichever one you like, maybe six times", "hop, right side, in place, 6 times"),
    ] {
        assert_eq!(read(text).to_string(), expected, "{text}");
    }
}

#[test]
fn every_part_of_a_row_is_done() {
    for (text, expected) in [
        (
            "a waiter carries a tray, puts it down, bows and goes away",
            "carry box, forward; then lift, both side; then bow; then turn, to the left, 180 degrees; then walk, forward",
        ),
        (
            "the king steps forward, spreads his arms, speaks to the people, then sits down",
            "step forward, forward; then arms to sides, both side; then present, right side; then sit",
        ),
        (
            "point at the sky, then point at yourself, then point at the ground",
            "point up, right side; then hand on heart, right side; then point down, right side",
        ),
        (
            "clap, turn right and do it again",
            "clap, both side; then turn, to the right, 90 degrees; then clap, both side; then turn, to the right, 90 degrees",
        ),
        ("first squat than jump", "squat, once; then jump, in place, once"),
        ("bow, swing the arms", "bow; then swing arms, both side"),
        (
            "shrug, walk up and down, then sit",
            "shrug, both side, once; then walk, forward; then turn, to the left, 180 degrees; then walk, forward; then sit",
        ),
        ("step over a puddle and carry on", "step over, forward; then walk, forward"),
        ("drink some water, continue talking", "drink, right side; then present, right side"),
        ("walk away shaking your head", "turn, to the left, 180 degrees; then shake head while: walk, forward"),
        ("shake your left leg, shake your right leg", "leg swing, left side, once; then leg swing, right side, once"),
        (
            "clap, tap your hips, tap your knees",
            "clap, both side; then hands on hips, both side; then touch knees, once",
        ),
        (
            "punch left, right, left",
            "punch, left side, once; then punch, right side, once; then punch, left side, once",
        ),
        ("talk on the phone while pacing", "phone, right side while: walk, forward"),
        ("kneel down and pray", "pray, both side while: kneel, right side"),
        ("crouch and cover your head with your hands", "hands on head, both side while: crouch"),
        ("walk proudly with chest out and hands on hips", "hands on hips, both side while: walk proud, forward, proud"),
        ("wave with the left hand and rub your belly with the right", "wave, left side while: rub belly, right side"),
        (
            "spin on the spot holding your arms over your head",
            "raise arms, both side while: turn, to the left, 360 degrees",
        ),
    ] {
        assert_eq!(line(text), expected, "{text}");
    }
}

#[test]
fn what_is_repeated_and_likened_is_read() {
    for (text, expected) in [
        ("squat, clap, repeat it once", "squat, once; then clap, both side; then squat, once; then clap, both side"),
        ("clap clap clap", "clap, both side, 3 times"),
        ("sway and flap your arms", "flap, both side while: sway"),
        ("walk forward waving with your left hand", "wave, left side while: walk, forward"),
        ("hands on your hips and sway side to side", "hands on hips, both side while: sway"),
        (
            "go forward, go back, then left, then right",
            "walk, forward; then walk backward, backward; then walk sideways, to the left; then walk sideways, to the right",
        ),
        ("walk like you just lost your best friend", "walk, forward, sad"),
        ("hurry up and walk over there, we are late", "walk, forward, fast"),
        ("walk a circle about one meter wide", "walk curve, to the left, 360 degrees, 1 m"),
        ("do a plié", "sumo squat, in place, once"),
    ] {
        assert_eq!(line(text), expected, "{text}");
    }
}

#[test]
fn counts_and_corrections_after_a_sentence_are_of_its_action() {
    for (text, expected) in [
        ("make a huge circle with your right arm. just one", "arm circles, right side, once, big"),
        ("step forward once with the left foot, a long one", "step forward, forward, once, big"),
        ("bend at the waist by forty-five degrees and stay down for two counts", "trunk forward 45, held 2 s"),
        ("The robot shall bow.", "bow"),
        (
            "left arm up, right arm up, both down",
            "left arm up 160 degrees; then right arm up 160 degrees; then both arms down",
        ),
        ("do a zombie walk", "arms ahead, both side while: walk, forward, slow"),
    ] {
        assert_eq!(line(text), expected, "{text}");
    }
}

#[test]
fn words_that_nobody_knows_are_left_out_of_a_description_and_said() {
    let script = read("stand with one arm draped over your head and the other dangling limply");
    assert!(script.clauses[0].is_only_postures(), "{script}");
    assert!(script.notes.iter().any(|note| note == "left out: draped"), "{:?}", script.notes);
    for (text, expected) in [
        (
            "the hands come together, elbows stick out sideways, and the head drops forward",
            "both arms ahead 52 degrees, elbow bent 60, touching the other hand, head forward 25",
        ),
        ("ten slow biceps curls, both arms together", "bicep curl, both side, 10 times, slow"),
        ("do a squat holding both arms straight out in front of you", "arms ahead, both side while: squat, once"),
        ("walk as if your puppy got lost", "walk, forward, sad"),
        ("a low bow, stay down for four seconds", "trunk forward 55, held 4 s"),
    ] {
        assert_eq!(line(text), expected, "{text}");
    }
}
