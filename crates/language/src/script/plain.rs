//! Roundabout phrases of people, in the words that rules read.

use super::asides::{without_asides, without_what_stays};
use super::geometry::plain_geometry;
use super::said::number;
use super::split::is_participle;

/// Phrases and plainer ones; an empty one says nothing.
const PLAIN: [(&str, &str); 152] = [
    ("heads shoulders knees and toes", "head , shoulders , knees and toes"),
    ("head shoulders knees and toes", "head , shoulders , knees and toes"),
    ("rite", "right"),
    ("teeny weeny", "tiny"),
    ("itsy bitsy", "tiny"),
    ("a plie", "a sumo squat"),
    ("hold it a seconds", "hold it for 1 seconds"),
    ("hold a seconds", "hold for 1 seconds"),
    ("hold for a beat", "hold for 1 seconds"),
    (", a long one", "big"),
    (", a big one", "big"),
    (", a small one", "small"),
    (", a tiny one", "small"),
    ("do the thing where you", ""),
    ("do that thing where you", ""),
    ("of course", ""),
    ("good luck", ""),
    ("and done", ""),
    ("and thats it", ""),
    (", any one", ""),
    (", step together", ""),
    (", same time", ", at the same time"),
    ("or as near as you can", ""),
    ("or as close as you can", ""),
    ("elbows locked", "elbows straight"),
    ("locked elbows", "straight elbows"),
    ("knees locked", "knees straight"),
    ("thigh is flat", "thigh is horizontal"),
    ("the small of your back", "your lower back"),
    ("the small of the back", "the lower back"),
    ("the small of it", "the lower back"),
    ("level with shoulders", "at shoulder height"),
    ("cactus arms", "upper arms out to the sides , forearms up"),
    ("goalpost arms", "upper arms out to the sides , forearms up"),
    ("in reverse", "backwards"),
    ("turn around complete", "turn around 360 degrees"),
    ("turn around completely", "turn around 360 degrees"),
    ("facing the way you started", "turn around"),
    ("facing the way you began", "turn around"),
    ("watch out ,", ""),
    ("why dont you", ""),
    ("why dont we", ""),
    ("go ahead and", ""),
    ("feel free to", ""),
    ("shall we", ""),
    ("go ahead ,", ""),
    ("id love to see you", ""),
    ("i would love to see you", ""),
    ("id like to see you", ""),
    ("i would like to see you", ""),
    ("i would like that you", ""),
    ("id like that you", ""),
    ("the left hand i mean", ""),
    ("the right hand i mean", ""),
    ("touch em all", ""),
    ("touch them all", ""),
    (", going backwards", "backwards"),
    ("the trunk to each side", "the trunk left and right"),
    ("your trunk to each side", "your trunk left and right"),
    (
        "heads , shoulders , knees and toes",
        "put your hands on your head , then touch your shoulders , then touch your knees , then touch your toes",
    ),
    (
        "head , shoulders , knees and toes",
        "put your hands on your head , then touch your shoulders , then touch your knees , then touch your toes",
    ),
    ("just like , you know ,", ""),
    ("like , you know ,", ""),
    (", you know ,", ","),
    ("and leave it like this", ""),
    ("and leave it like that", ""),
    ("and leave it there", ""),
    ("left leg standing", "stand on the left leg"),
    ("right leg standing", "stand on the right leg"),
    ("bent square", "bent at 90 degrees"),
    ("walk up and down", "pace the room"),
    ("walks up and down", "pace the room"),
    ("pace up and down", "pace the room"),
    ("paces up and down", "pace the room"),
    ("walk back and forth", "pace the room"),
    ("pace back and forth", "pace the room"),
    ("wait a seconds", "wait 1 seconds"),
    ("wait for a seconds", "wait 1 seconds"),
    ("pause a seconds", "wait 1 seconds"),
    ("pause for a seconds", "wait 1 seconds"),
    (", a full 360 degrees", "360 degrees"),
    (", a full 360", "360 degrees"),
    (", a full circle", "360 degrees"),
    (", a full turn", "360 degrees"),
    ("until it is level with the shoulder", "to shoulder height"),
    ("until its level with the shoulder", "to shoulder height"),
    ("until it is level with your shoulder", "to shoulder height"),
    ("until they are level with your shoulders", "to shoulder height"),
    ("until they are level with the shoulders", "to shoulder height"),
    ("level with the shoulder", "at shoulder height"),
    ("level with your shoulder", "at shoulder height"),
    ("level with your shoulders", "at shoulder height"),
    ("level with the shoulders", "at shoulder height"),
    ("when it is up", "then"),
    ("when its up", "then"),
    ("once it is up", "then"),
    ("once its up", "then"),
    ("when they are up", "then"),
    ("till it is", "until it is"),
    ("so the hand points up", "so your forearms point up"),
    ("so your hand points up", "so your forearms point up"),
    ("so that your hand points up", "so your forearms point up"),
    ("do a high kick", "kick high"),
    ("a high kick", "kick high"),
    ("one high kick", "kick high once"),
    (", as high as you can", "high"),
    (", as high as u can", "high"),
    ("on your lower back", "behind your back"),
    ("on the lower back", "behind the back"),
    ("as hard as you can", "powerfully"),
    ("as hard as u can", "powerfully"),
    ("with your head down", "sadly"),
    ("with the head down", "sadly"),
    ("as far as u can", "far"),
    ("as high as u can", "high"),
    ("half way", "halfway"),
    ("as high as you can", "high"),
    ("as high as possible", "high"),
    ("in one go", "at the same time"),
    ("in one move", "at the same time"),
    ("in one movement", "at the same time"),
    ("and from there ,", "while"),
    ("and from there", "while"),
    ("in a row", ""),
    ("with your back straight", ""),
    ("with the back straight", ""),
    ("keeping your back straight", ""),
    ("keep your back straight", ""),
    ("with both feet planted", ""),
    ("with your feet planted", ""),
    ("with feet planted", ""),
    ("feet planted", ""),
    ("as far as is comfortable", "far"),
    ("as far as you can", "far"),
    ("as far as possible", "far"),
    ("how it was", ""),
    ("how they were", ""),
    ("put everything back", "stand straight"),
    ("settle back onto flat feet", "stand straight"),
    ("back onto flat feet", "stand straight"),
    ("with a hanging head", "sadly"),
    ("with hanging head", "sadly"),
    ("with hanging shoulders", "sadly"),
    ("each times you", "while"),
    ("every times you", "while"),
    ("whenever you", "while"),
    ("a couple of seconds", "2 seconds"),
    ("couple of seconds", "2 seconds"),
    ("a few seconds", "3 seconds"),
    ("several seconds", "4 seconds"),
    ("for a seconds", "for 1 seconds"),
    ("half a seconds", "0.5 seconds"),
];
/// Words that join.
const JOINS: [&str; 6] = [",", "|", "and", "then", "while", "but"];
/// "On every step": the step is what is done meanwhile.
const MEANWHILE: [&str; 6] =
    ["on every step", "with every step", "at every step", "on each step", "with each step", "at each step"];
/// Limbs of which people have two.
const LIMBS: [&str; 6] = ["arm", "hand", "leg", "foot", "knee", "elbow"];
/// Words after "bring it back" that end it.
const ENDS: [&str; 5] = [",", "|", "and", "then", "again"];

/// Returns words in a plainer form.
pub(super) fn plainly(mut words: Vec<String>) -> Vec<String> {
    words.retain(|word| word != "also");
    words = held_meanwhile(ways_apart(without_robot(just_one(words))));
    words = without_what_stays(words);
    for (said, plain) in PLAIN {
        let said = split(said);
        while let Some(at) = place(&words, &said) {
            words.splice(at..at + said.len(), split(plain));
        }
    }
    words = plain_geometry(without_reasons(without_who(without_asides(words))));
    words = within_seconds(count_of_seconds(counted_seconds(words)));
    words = kept_as_it_is(words);
    words = with_hanging_arms(words);
    words = brought_back(words);
    words = back_without_a_turn(words);
    for said in MEANWHILE.map(split) {
        if let Some(at) = place(&words, &said) {
            words.drain(at..at + said.len());
            match words[..at].iter().rposition(|word| JOINS.contains(&word.as_str())) {
                Some(join) => words[join] = "while".into(),
                None => words.splice(0..0, split("walk while")).for_each(drop),
            }
        }
    }
    words = in_turn(then_for_than(over_there(words)));
    words = turned_and_gone(going_on(words));
    by_degrees(the_same_way(step_by_step(one_and_the_other(words))))
}

fn split(text: &str) -> Vec<String> {
    text.split_whitespace().map(str::to_string).collect()
}

fn place(words: &[String], said: &[String]) -> Option<usize> {
    words.windows(said.len()).position(|part| part == said)
}

fn is_one_of(words: &[String], at: usize, all: &[&str]) -> bool {
    words.get(at).is_some_and(|word| all.contains(&word.as_str()))
}

/// Drops what somebody does who another is likened to: "like a mouse that saw the cat".
fn without_who(words: Vec<String>) -> Vec<String> {
    const WHO: [&str; 5] = ["who", "whos", "whose", "that", "which"];
    let mut out: Vec<String> = Vec::with_capacity(words.len());
    let mut drops = false;
    for word in words {
        let liken = |from: usize| out[from..].iter().any(|word| word == "like");
        if JOINS.contains(&word.as_str()) {
            drops = false;
        } else if WHO.contains(&word.as_str()) && liken(out.len().saturating_sub(5)) {
            drops = true;
        }
        if !drops {
            out.push(word);
        }
    }
    out
}

/// Drops reasons and habits: "celebrate because it went in", "look left, like we do before we cross the road".
fn without_reasons(words: Vec<String>) -> Vec<String> {
    const REASONS: [&str; 5] = ["because", "cuz", "coz", "cos", "bc"];
    const PEOPLE: [&str; 6] = ["we", "you", "they", "people", "i", "everybody"];
    const DO: [&str; 5] = ["do", "does", "did", "always", "would"];
    let is_habit = |words: &[String], at: usize| {
        is_one_of(words, at, &["like", "as"]) && is_one_of(words, at + 1, &PEOPLE) && is_one_of(words, at + 2, &DO)
    };
    // "Look left and right like before you cross".
    let is_time = |words: &[String], at: usize| {
        is_one_of(words, at, &["like", "as"]) && is_one_of(words, at + 1, &["before", "when", "after"])
    };
    let mut out: Vec<String> = Vec::with_capacity(words.len());
    let mut drops = false;
    for (at, word) in words.iter().enumerate() {
        if JOINS.contains(&word.as_str()) {
            drops = false;
        } else if !out.is_empty() && (REASONS.contains(&word.as_str()) || is_habit(&words, at) || is_time(&words, at)) {
            drops = true;
            // A comma before it ends nothing now.
            if out.last().is_some_and(|last| last == ",") {
                out.pop();
            }
        }
        if !drops {
            out.push(word.clone());
        }
    }
    out
}

/// "For as long as it takes to count to five", "and count to five": five seconds.
fn counted_seconds(mut words: Vec<String>) -> Vec<String> {
    const BEFORE: [&str; 11] = ["for", "as", "long", "it", "takes", "to", "you", "while", "slowly", "and", ","];
    const QUIETLY: [&str; 5] = ["silently", "quietly", "slowly", "inwardly", "internally"];
    let counts = |word: &String| ["count", "counts", "counting"].contains(&word.as_str());
    // "Count silently to two".
    let quiet = words.windows(2).position(|two| counts(&two[0]) && QUIETLY.contains(&two[1].as_str()));
    quiet.map(|at| words.remove(at + 1));
    let is_count = |words: &[String], at: usize| {
        let counts = counts(&words[at]);
        counts
            && words.get(at + 1).is_some_and(|word| word == "to")
            && words.get(at + 2).and_then(|n| number(n)).is_some()
            && words.get(at + 3).is_none_or(|word| word != "on")
    };
    while let Some(at) = (0..words.len()).find(|at| is_count(&words, *at)) {
        let before = words[..at].iter().rev().take_while(|word| BEFORE.contains(&word.as_str())).count();
        if before == at {
            // Who only counts stands still.
            words.splice(at..at + 2, split("stand for"));
        } else {
            words.splice(at - before..at + 2, ["for".to_string()]);
        }
        let after = words.iter().skip(at - before.min(at)).position(|word| number(word).is_some());
        let number = after.map_or(words.len(), |after| at - before.min(at) + after + 1);
        words.insert(number.min(words.len()), "seconds".into());
    }
    words
}

/// Drops who is to do it: "the robot shall".
fn without_robot(mut words: Vec<String>) -> Vec<String> {
    const WHO: [&str; 8] = ["robot", "figure", "character", "humanoid", "dancer", "avatar", "actor", "person"];
    const MODALS: [&str; 8] = ["shall", "should", "must", "will", "may", "can", "needs", "has"];
    let from = usize::from(is_one_of(&words, 0, &["the", "a", "our", "this", "my"]));
    if is_one_of(&words, from, &WHO) && is_one_of(&words, from + 1, &MODALS) {
        words.drain(..from + 2);
        let begins = is_one_of(&words, 0, &["to"]);
        words.drain(..usize::from(begins));
    }
    words
}

/// "Old man walking to the bus": walking like one.
pub(super) fn as_somebody(mut words: Vec<String>) -> Vec<String> {
    const PEOPLE: [&str; 14] = [
        "man", "woman", "lady", "person", "child", "kid", "guy", "king", "queen", "soldier", "grandpa", "grandma",
        "toddler", "zombie",
    ];
    let from = usize::from(is_one_of(&words, 0, &["a", "an", "the"]));
    let does = |at: usize| {
        let is_described = at > from + 1 && words[at].ends_with('s');
        at > from && is_one_of(&words, at - 1, &PEOPLE) && (is_participle(&words[at]) || is_described)
    };
    if let Some(doing) = (0..words.len().min(from + 5)).find(|at| does(*at)) {
        let who: Vec<String> = words.drain(..doing).skip(from).collect();
        words.splice(1..1, split("like a").into_iter().chain(who));
    }
    words
}

/// "Step left step right", "punch left, right, left": one after the other, each with its verb.
fn ways_apart(mut words: Vec<String>) -> Vec<String> {
    const WAYS: [&str; 8] = ["left", "right", "forward", "forwards", "back", "backward", "backwards", "up"];
    let is_again = |words: &[String], at: usize| {
        words[at] == words[at + 2] && is_one_of(words, at + 1, &WAYS) && is_one_of(words, at + 3, &WAYS)
    };
    let mut at = 0;
    while at + 3 < words.len() {
        if is_again(&words, at) && !WAYS.contains(&words[at].as_str()) {
            words.insert(at + 2, ",".into());
        }
        let begins = at == 0 || JOINS.contains(&words[at - 1].as_str());
        let ends = |at: usize| words.get(at).is_none_or(|word| JOINS.contains(&word.as_str()));
        let lists = is_one_of(&words, at + 2, &[","]) && is_one_of(&words, at + 3, &WAYS[..2]) && ends(at + 4);
        if begins && is_one_of(&words, at + 1, &WAYS[..2]) && lists && words[at + 1] != words[at + 3] {
            words.splice(at + 2..at + 3, [",".to_string(), words[at].clone()]);
        }
        at += 1;
    }
    words
}

/// "Do a squat holding both arms out": while it holds them.
fn held_meanwhile(mut words: Vec<String>) -> Vec<String> {
    const HOLDS: [&str; 2] = ["holding", "keeping"];
    const LIMBS_OF: [&str; 8] = ["your", "both", "the", "ur", "his", "her", "arms", "hands"];
    let holds = |words: &[String], at: usize| {
        is_one_of(words, at, &HOLDS) && is_one_of(words, at + 1, &LIMBS_OF) && !is_one_of(words, at - 1, &JOINS)
    };
    if let Some(at) = (1..words.len()).find(|at| holds(&words, *at)) {
        words.insert(at, "while".into());
    }
    words
}

/// "A huge circle with the arm. Just one": once.
fn just_one(mut words: Vec<String>) -> Vec<String> {
    let is_last = |words: &[String], at: usize| words.get(at + 3).is_none_or(|word| JOINS.contains(&word.as_str()));
    let is_count = |words: &[String], at: usize| {
        is_one_of(words, at, &["|", ","])
            && is_one_of(words, at + 1, &["just", "only"])
            && is_one_of(words, at + 2, &["one", "once"])
            && is_last(words, at)
    };
    if let Some(at) = (1..words.len()).find(|at| is_count(&words, *at)) {
        words.splice(at..at + 3, ["once".to_string()]);
    }
    words
}

/// "For a count of three", "for three counts": three seconds.
fn count_of_seconds(mut words: Vec<String>) -> Vec<String> {
    let is_after = |words: &[String]| {
        words[0] == "for" && number(&words[1]).is_some() && ["counts", "beats"].contains(&words[2].as_str())
    };
    while let Some(at) = words.windows(3).position(is_after) {
        words[at + 2] = "seconds".into();
    }
    let is_count = |words: &[String]| {
        ["a", "the"].contains(&words[0].as_str())
            && words[1] == "count"
            && words[2] == "of"
            && number(&words[3]).is_some()
    };
    while let Some(at) = words.windows(4).position(is_count) {
        words.insert(at + 4, "seconds".into());
        words.drain(at..at + 3);
    }
    words
}

/// "Lift an arm, over six seconds": the time of the lift.
fn within_seconds(mut words: Vec<String>) -> Vec<String> {
    let is_time = |four: &[String]| {
        let within = ["over", "within", "in"].contains(&four[1].as_str());
        four[0] == "," && within && number(&four[2]).is_some() && four[3] == "seconds"
    };
    while let Some(at) = words.windows(4).position(is_time) {
        words.remove(at);
    }
    words
}

/// "Keep the upper arms where they are" asks for nothing.
fn kept_as_it_is(mut words: Vec<String>) -> Vec<String> {
    const ENDS: [&str; 8] = [
        "where they are",
        "where it is",
        "as they are",
        "stay quiet",
        "quiet",
        "glued to your body",
        "glued to your sides",
        "close to your body",
    ];
    for end in ENDS.map(split) {
        let Some(at) = place(&words, &end) else { continue };
        let keeps = |word: &String| ["keep", "keeps", "keeping"].contains(&word.as_str());
        let begin = words[..at].iter().rposition(keeps).filter(|begin| at - begin <= 4);
        let is_joined = |from: usize| words[from..at].iter().any(|word| JOINS.contains(&word.as_str()));
        if let Some(begin) = begin.filter(|begin| !is_joined(*begin)) {
            words.drain(begin..at + end.len());
        }
    }
    words
}

/// "Dance, but keep your arms at your sides": where they hang.
fn with_hanging_arms(mut words: Vec<String>) -> Vec<String> {
    const BETWEEN: [&str; 11] =
        ["your", "both", "the", "arms", "hands", "completely", "stiff", "straight", "still", "down", "hanging"];
    let keeps = |word: &String| ["keep", "keeps", "keeping"].contains(&word.as_str());
    let Some(begin) = words.iter().position(keeps).filter(|begin| *begin > 0) else { return words };
    let between = words[begin + 1..].iter().take_while(|word| BETWEEN.contains(&word.as_str())).count();
    let end = begin + 1 + between;
    let has_arms = words[begin..end].iter().any(|word| word == "arms" || word == "hands");
    let at_sides = words[end.min(words.len())..].iter().map(String::as_str).take(3).collect::<Vec<_>>();
    let hang = matches!(at_sides.as_slice(), ["at" | "by", "your", "side" | "sides"]);
    if has_arms && hang {
        let joins = words[..begin].iter().rev().take_while(|word| JOINS.contains(&word.as_str())).count();
        words.drain(begin - joins..end + 3);
    }
    words
}

/// "Tilt the head and bring it back" ends where it began.
fn brought_back(mut words: Vec<String>) -> Vec<String> {
    let is_back = |words: &[String], at: usize| {
        let brings = ["bring", "brings", "put", "puts", "move", "take"].contains(&words[at].as_str());
        let ends = words.get(at + 3).is_none_or(|word| ENDS.contains(&word.as_str()));
        brings && ["it", "them"].contains(&words[at + 1].as_str()) && words[at + 2] == "back" && ends
    };
    while let Some(at) = (0..words.len().saturating_sub(2)).find(|at| is_back(&words, *at)) {
        words.splice(at..at + 3, split("stand straight"));
    }
    words
}

/// "Back without turning round" is backwards.
fn back_without_a_turn(mut words: Vec<String>) -> Vec<String> {
    let Some(at) = words.windows(2).position(|two| two[0] == "without" && two[1] == "turning") else { return words };
    let around = words.get(at + 2).is_some_and(|word| ["round", "around"].contains(&word.as_str()));
    words.drain(at..at + 2 + usize::from(around));
    let joins = |at: usize| at > 0 && JOINS.contains(&words[at - 1].as_str());
    let backwards = |(at, word): (usize, &String)| match (word == "back", joins(at)) {
        (true, true) => "walk backwards".into(),
        (true, false) => "backwards".into(),
        (false, _) => word.clone(),
    };
    let text: Vec<String> = words.iter().enumerate().map(backwards).collect();
    split(&text.join(" "))
}

/// "Hurry over to the right": who runs somewhere turns there first.
fn over_there(mut words: Vec<String>) -> Vec<String> {
    const RUNS: [&str; 8] = ["run", "runs", "hurry", "rush", "dash", "jog", "sprint", "race"];
    const WALKS: [&str; 5] = ["walk", "walks", "go", "goes", "head"];
    const OVER: [&str; 3] = ["over", "off", "away"];
    let begin = (0..words.len()).find(|i| {
        let over = usize::from(is_one_of(&words, i + 1, &OVER));
        let goes = is_one_of(&words, *i, &RUNS) || is_one_of(&words, *i, &WALKS) && over > 0;
        let there = is_one_of(&words, i + 1 + over, &["to"]) && is_one_of(&words, i + 2 + over, &["the", "your"]);
        // Nothing follows the side: "to the right foot" is another place.
        let ends = words.get(i + 4 + over).is_none_or(|word| JOINS.contains(&word.as_str()));
        goes && there && is_one_of(&words, i + 3 + over, &["left", "right"]) && ends
    });
    if let Some(begin) = begin {
        let over = usize::from(is_one_of(&words, begin + 1, &OVER));
        let (verb, side) = (words[begin].clone(), words[begin + 3 + over].clone());
        words.splice(begin..begin + 4 + over, split(&format!("turn {side} , then {verb} forward")));
    }
    words
}

/// "One arm goes up, the other goes out": the right one and the left one.
fn one_and_the_other(mut words: Vec<String>) -> Vec<String> {
    const BEFORE: [&str; 6] = ["after", "of", "over", "by", "than", "behind"];
    let limb = |words: &[String], at: usize| words.get(at).filter(|word| LIMBS.contains(&word.as_str())).cloned();
    let one = (0..words.len()).find(|at| words[*at] == "one" && limb(&words, at + 1).is_some());
    let again = |one: usize| {
        let same = |at: &usize| words[*at] == "one" && limb(&words, at + 1) == limb(&words, one + 1);
        (one + 2..words.len()).find(same)
    };
    // "One arm up one arm out".
    let is_sided = |at: usize| words[at] == "left" || words[at] == "right";
    let names_side =
        (0..words.len()).any(|at| is_sided(at) && limb(&words, at + 1) == limb(&words, one.unwrap_or(0) + 1));
    if let Some(second) = one.and_then(again).filter(|_| !names_side) {
        words[second] = "left".into();
        if !JOINS.contains(&words[second - 1].as_str()) {
            words.insert(second, ",".into());
        }
        if let Some(first) = one {
            words[first] = "right".into();
        }
        return words;
    }
    let other = words.windows(2).position(|two| two[0] == "the" && two[1] == "other");
    let (Some(one), Some(other)) = (one, other.filter(|at| *at > 0)) else { return words };
    let says_side = words.iter().any(|word| word == "left" || word == "right");
    let is_joined = words[one..other.max(one)].iter().any(|word| JOINS.contains(&word.as_str()));
    if says_side || !is_joined || other < one || BEFORE.contains(&words[other - 1].as_str()) {
        return words;
    }
    let named = limb(&words, one + 1).unwrap_or_default();
    let is_named = limb(&words, other + 2).is_some() || words.get(other + 2).is_some_and(|word| word == "one");
    let said = limb(&words, other + 2).unwrap_or(named);
    words.splice(other..other + 2 + usize::from(is_named), ["the".to_string(), "left".into(), said]);
    words[one] = "right".into();
    words
}

/// "Continue talking", "keep turning": the same verb; "carry on" alone is to go on.
fn going_on(mut words: Vec<String>) -> Vec<String> {
    const GOES_ON: [&str; 10] =
        ["continue", "continues", "keep", "keeps", "start", "starts", "begin", "begins", "resume", "resumes"];
    let mut at = 0;
    while at + 1 < words.len() {
        let carries = is_one_of(&words, at, &["carry", "carries", "go", "goes"]) && words[at + 1] == "on";
        let length = if carries { 2 } else { usize::from(is_one_of(&words, at, &GOES_ON)) };
        let is_doing = words.get(at + length).is_some_and(|word| is_participle(word));
        if length > 0 && is_doing {
            words.drain(at..at + length);
            // After a comma it is no participle of what is done before.
            if at > 0 && words[at - 1] == "," {
                words[at - 1] = "then".into();
            }
        } else if length == 2 && words.get(at + 2).is_none_or(|word| JOINS.contains(&word.as_str())) {
            words[at] = "go".into();
        }
        at += 1;
    }
    words
}

/// "Turns and marches off": who leaves turns around.
fn turned_and_gone(mut words: Vec<String>) -> Vec<String> {
    const GOES: [&str; 14] = [
        "walk", "walks", "march", "marches", "run", "runs", "go", "goes", "jog", "jogs", "sneak", "sneaks", "stomp",
        "stomps",
    ];
    let leaves = |words: &[String], at: usize| {
        let goes = is_one_of(words, at, &GOES) && is_one_of(words, at + 1, &["away", "off", "out"]);
        goes || is_one_of(words, at, &["leave", "leaves", "exit", "exits"])
    };
    let turns = |at: &usize| {
        is_one_of(&words, *at, &["turn", "turns"]) && is_one_of(&words, at + 1, &["and"]) && leaves(&words, at + 2)
    };
    if let Some(at) = (0..words.len()).find(turns) {
        words.insert(at + 1, "around".into());
    }
    words
}

/// "First squat than jump" is one after the other.
fn then_for_than(mut words: Vec<String>) -> Vec<String> {
    for at in 1..words.len() {
        let begin = words[..at].iter().rposition(|word| JOINS.contains(&word.as_str())).map_or(0, |join| join + 1);
        let compares = |word: &String| word.ends_with("er") || ["more", "less", "rather"].contains(&word.as_str());
        if words[at] == "than" && !words[begin..at].iter().any(compares) {
            words[at] = "then".into();
        }
    }
    words
}

/// "Punch left, right, left" is in turn.
fn in_turn(words: Vec<String>) -> Vec<String> {
    let is_side = |word: Option<&String>| word.is_some_and(|word| word == "left" || word == "right");
    let ends = |at: usize| words.get(at).is_none_or(|word| JOINS.contains(&word.as_str()));
    let follows = |at: usize| words[at] == "," && is_side(words.get(at + 1)) && ends(at + 2);
    let joined = |at: usize| at > 1 && follows(at) && is_side(words.get(at - 1)) && words[at - 1] != words[at + 1];
    let is_row = (0..words.len()).filter(|at| joined(*at)).count() > 1;
    words.iter().enumerate().filter(|(at, _)| !(is_row && joined(*at))).map(|(_, word)| word.clone()).collect()
}

/// "Step left step right" is two steps; "look right and point there" points to the right.
fn step_by_step(words: Vec<String>) -> Vec<String> {
    let is_side = |word: &String| word == "left" || word == "right";
    let mut out: Vec<String> = Vec::with_capacity(words.len());
    let mut side: Option<String> = None;
    for word in words {
        let repeats = out.len() > 1
            && out[out.len() - 2] == word
            && is_side(&out[out.len() - 1])
            && !is_side(&word)
            && !JOINS.contains(&word.as_str());
        out.extend(repeats.then(|| ",".to_string()));
        let points = out.last().is_some_and(|last| ["point", "points", "pointing"].contains(&last.as_str()));
        match side.as_ref().filter(|_| points && word == "there") {
            Some(side) => out.extend(split(&format!("to the {side}"))),
            None => out.push(word),
        }
        side = out.last().filter(|last| is_side(last)).cloned().or(side);
    }
    out
}

/// "Turn right, walk, turn the same way": to the right.
fn the_same_way(mut words: Vec<String>) -> Vec<String> {
    const TURNS: [&str; 6] = ["turn", "look", "head", "step", "lean", "tilt"];
    let is_way = |two: &[String]| ["that", "same"].contains(&two[0].as_str()) && two[1] == "way";
    let Some(at) = words.windows(2).position(is_way) else { return words };
    let Some(side) = words[..at].iter().rev().find(|word| ["left", "right"].contains(&word.as_str())).cloned() else {
        return words;
    };
    let begin = words[..at].iter().rposition(|word| JOINS.contains(&word.as_str())).map_or(0, |join| join + 1);
    if words[begin..at].iter().any(|word| TURNS.contains(&word.as_str())) {
        let article = usize::from(at > 0 && words[at - 1] == "the");
        words.splice(at - article..at + 2, split(&format!("to the {side}")));
    }
    words
}

/// "Left by ten degrees, then right by twenty": degrees, too.
fn by_degrees(mut words: Vec<String>) -> Vec<String> {
    let Some(first) = words.iter().position(|word| word == "degrees") else { return words };
    let lacks = |words: &[String], at: usize| {
        let ends = words.get(at + 2).is_none_or(|word| JOINS.contains(&word.as_str()));
        words[at] == "by" && words.get(at + 1).and_then(|n| number(n)).is_some() && ends
    };
    while let Some(at) = (first..words.len()).find(|at| lacks(&words, *at)) {
        words.insert(at + 2, "degrees".into());
    }
    words
}

#[cfg(test)]
mod tests {
    use super::super::split::normal;

    #[test]
    fn roundabout_words_become_plain() {
        for (text, plain) in [
            ("jump two times in a row", "jump two times"),
            ("shrink like a mouse that saw the cat, then wave", "shrink like a mouse , then wave"),
            (
                "balance on your left foot for as long as it takes to count to five",
                "balance on your left foot for five seconds",
            ),
            ("touch your toes and count to 8", "touch your toes for 8 seconds"),
            ("do that thing where you clap", "clap"),
            ("count to three", "stand for three seconds"),
            ("raise both arms for a count of three", "raise both arms for three seconds"),
            ("bend your elbows. keep the upper arms where they are.", "bend your elbows | |"),
            ("tilt your head and then bring it back", "tilt your head and then stand straight"),
            ("walk ahead and then back without turning round", "walk ahead and then walk backwards"),
            ("one arm goes up, the other goes out", "right arm goes up , the left arm goes out"),
            ("raise one arm after the other", "raise one arm after the other"),
            ("one arm up one arm out to the side", "right arm up , left arm out to the side"),
            ("step left step right", "step left , step right"),
            ("hurry over to the right and wave", "turn right , then hurry forward and wave"),
            ("walk to the left", "walk to the left"),
            ("keep turning, then carry on", "turning , then go on"),
            ("he turns and marches out", "he turns around and marches out"),
            ("look to the right and point there", "look to the right and point to the right"),
            ("turn right, then turn the same way", "turn right , then turn to the right"),
            ("lean left by ten degrees, then right by twenty", "lean left by ten degrees , then right by 20 degrees"),
            ("stepping left right, pump both arms on every step", "stepping left right while pump both arms"),
            ("clap over your head each time you jump", "clap over your head while jump"),
            ("dance but keep your arms stiff at your sides", "dance"),
            ("hold it for a couple of seconds", "hold it for 2 seconds"),
        ] {
            assert_eq!(normal(text).join(" "), plain, "{text}");
        }
    }
}
