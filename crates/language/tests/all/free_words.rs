//! Sentences in free words and their readings: described limbs, rows, pairs, manners, situations.

use std::sync::LazyLock;

use lifelike_language::grammar::Grammar;
use lifelike_language::script::Reader;

/// Checks readings, and that nothing of them was left over.
fn check(table: &[(&str, &str)]) {
    static GRAMMAR: LazyLock<Grammar> = LazyLock::new(|| Grammar::builtin().unwrap());
    static READER: LazyLock<Reader<'static>> = LazyLock::new(|| Reader::new(&GRAMMAR).unwrap());
    for (text, expected) in table {
        let script = READER.read(text);
        assert_eq!(script.to_string(), *expected, "{text}: {script:?}");
        assert!(script.unknown.is_empty(), "{text}: {:?}", script.unknown);
    }
}

#[test]
fn limbs_are_described_by_joints_and_places() {
    check(&[
        (
            "right upper arm out to the side at shoulder height, forearm hanging straight down from the elbow",
            "right arm to the side 88 degrees, elbow bent 90, forearm down",
        ),
        (
            "upper arms tight against the ribs, elbows bent 90 degrees, parallel to the floor",
            "both arms down, elbow bent 90",
        ),
        ("lift your left knee till the thigh is flat, let the shin dangle", "left foot up"),
        ("arms make a Y over the head, elbows locked", "both arms to the side 135 degrees"),
        (
            "left shoulder flexion 90°, elbow fully extended, right arm relaxed at side",
            "left arm ahead 90 degrees, right arm down",
        ),
        ("goalpost arms", "both arms to the side 88 degrees, elbow bent 90, forearm up"),
        (
            "right arm behind your back, forearm across the small of it, other arm hangs loose",
            "left arm down, right arm behind 60 degrees, elbow bent 81, touching the back",
        ),
        ("the right heel touching your bum, knee pointing at the floor, standing of course", "right foot up behind"),
        (
            "right arm forward a touch above shoulder, left arm to the side and slightly behind",
            "left arm to the side 93 degrees, right arm ahead 105 degrees",
        ),
        (
            "head looking up at the sky, arms away from the body, chest open",
            "both arms to the side 35 degrees, head back 25, trunk back 6",
        ),
        (
            "left hand on the tummy, right hand on top of the head",
            "left arm down, elbow bent 88, right arm up 177 degrees, elbow bent 57, left hand touching the belly, right hand touching the top of the head",
        ),
        (
            "right arm straight out to the right side, left elbow bent and pulled back at shoulder level so the left hand is by the left shoulder, look right",
            "left arm to the side 64 degrees, elbow bent 129, right arm to the side 93 degrees, touching the shoulder, head turned right 55",
        ),
        ("chin down on the chest, arms dangling, knees a bit soft", "head forward 25, knees a little bent"),
        (
            "twist the torso 20 deg to the left, keep your hips still, arms out to the sides",
            "both arms to the side 93 degrees, trunk turned left 20",
        ),
    ]);
}

#[test]
fn every_part_of_a_row_is_read() {
    check(&[
        (
            "lift right arm to side, keep it there, lift left arm to side, keep it too, now lower both together",
            "right arm to the side 93 degrees, held 3 s; then left arm to the side 93 degrees, held 3 s; then both arms down",
        ),
        ("right arm up. wait 3 seconds. right arm down", "right arm up 160 degrees, held 3 s; then right arm down"),
        (
            "throw both arms up, count silently to two, drop them",
            "both arms up 160 degrees, held 2 s; then both arms down",
        ),
        (
            "clap once, after you turn around complete, after you nod",
            "clap, both side, once; then turn, to the left, 360 degrees; then nod",
        ),
        (
            "step left, step together, step right, step together",
            "walk sideways, to the left, once; then walk sideways, to the right, once",
        ),
        ("point at yourself, then thumb... no, then just bow", "hand on heart, right side; then bow"),
        (
            "balance on the left foot 2 seconds, swap to the right foot 2 seconds",
            "balance, right side, 2 s; then balance, left side, 2 s",
        ),
        (
            "walk forward, turn around, walk back, finish by facing the way you started",
            "walk, forward; then turn, to the left, 180 degrees; then walk, forward; then turn, to the left, 180 degrees",
        ),
        ("fold forward and hang for 4 seconds, then roll back up slowly", "touch toes, 4 s; then stand"),
        (
            "karate chop after a deep breath",
            "arms to sides, both side, 35 degrees, slow; then karate chop, right side, once",
        ),
    ]);
}

#[test]
fn limbs_act_at_once() {
    check(&[
        (
            "lunge forward with the left leg as both arms go up in a Y",
            "both arms to the side 135 degrees while: lunge, left side",
        ),
        ("nod nod nod, shake your head once", "nod, 3 times; then shake head, once"),
        ("can you bow and at the same time raise both arms? x2", "raise arms, both side while: bow, 2 times"),
        ("march in reverse holding a salute", "salute, right side while: walk backward, backward"),
        (
            "left hand on your hip and right arm straight up while you march on the spot",
            "left arm to the side 50 degrees, elbow bent 108, right arm up 160 degrees, touching the hip while: march, in place",
        ),
        (
            "cover your eyes with your left arm and reach out in front with the right one as you walk",
            "left arm ahead 84 degrees, elbow bent 96, right arm ahead 90 degrees, touching the eyes while: walk, forward",
        ),
        (
            "walk backwards looking over your left shoulder",
            "look over shoulder, to the left while: walk backward, backward",
        ),
        (
            "one arm windmill forward, the other windmill backward, same time",
            "arm circles, right side while: arm circles backward, left side",
        ),
        ("nod your head and shrug simultaneously", "nod while: shrug, both side"),
        ("twist the waist left and right and let the arms swing loosely", "swing arms, both side while: twist"),
        (
            "step right foot forward into a lunge: front knee 90, back leg straight, hands above head together",
            "both arms up 167 degrees, touching the other hand while: lunge, right side",
        ),
    ]);
}

#[test]
fn numbers_and_manners_are_read() {
    check(&[
        ("a dozen high knees, six each side, alternating", "high knees, in place, 12 times"),
        (
            "lift your right arm forward to 100 deg, over 5 seconds",
            "reach up, right side, 100 degrees, 5 s to get there",
        ),
        ("clap in a sharp and bossy way", "clap, both side, fast, proud"),
        ("nod eagerly!! like a child", "nod, fast, happy"),
        ("bow with great dignity, unhurried", "bow, slow, proud"),
    ]);
}

#[test]
fn situations_are_told_from_requests() {
    check(&[
        ("the floor is wet and slippery", "arms to sides, both side while: walk, forward, afraid, 3 s"),
        ("the judge enters the courtroom. all rise", "stand, 3 s"),
        ("its freezing cold here and you forgot your jacket", "hug, both side; then rub hands, both side"),
    ]);
}
