//! Counts the marked sentences that are read rightly: by rules, by the network, by both.
//!
//! `read_marked SENTENCES [held-out] [differ]`, with every tenth line alone for `held-out`, and with those that the network alone reads
//! rightly printed for `differ`. A sentence is right when its verbs are
//! those marked, in any order; names may have alternatives (`{wave/wave_high|...}`). Verbs that rules exchange by number or
//! side count as the same; a described posture stands. What is impossible must be said.

use std::collections::BTreeMap;

use lifelike_language::grammar::Grammar;
use lifelike_language::script::{Reader, Reading, Script};

/// Verbs that numbers and sides exchange: steps that are counted, one limb in the place of two.
const SAME: [(&str, &str); 8] = [
    ("posture", "stand"),
    ("step_forward", "walk"),
    ("step_back", "walk_backward"),
    ("one_arm_out", "arms_to_sides"),
    ("wave_both", "wave"),
    ("hand_on_hip", "hands_on_hips"),
    ("reach_up", "raise_arms"),
    ("march_forward", "march"),
];
/// Bounds of the classes of certainty.
const CLASSES: f64 = 5.0;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().collect();
    let path = arguments.get(1).ok_or("expected SENTENCES [held-out]")?;
    let text = std::fs::read_to_string(path)?;
    let step = if arguments.iter().any(|word| word == "held-out") { 10 } else { 1 };
    let differ = arguments.iter().any(|word| word == "differ");
    let grammar = Grammar::builtin()?;
    let reader = Reader::new(&grammar)?;
    let mut right = BTreeMap::new();
    let mut classes = BTreeMap::new();
    let mut all = 0;
    for line in text.lines().skip(step - 1).step_by(step) {
        let (plain, wanted) = unmarked(line, &reader);
        all += 1;
        let mut own = Vec::new();
        for (name, way) in [("rules", Reading::Rules), ("network", Reading::Network), ("both", Reading::Both)] {
            let is_right = agrees(&wanted, &reader.read_by(&plain, way));
            *right.entry(name).or_insert(0) += usize::from(is_right);
            own.push(is_right);
            if way == Reading::Network {
                let class = (reader.certainty(&plain) * CLASSES).floor().min(CLASSES - 1.0) as usize;
                let counts = classes.entry(class).or_insert([0, 0]);
                counts[0] += 1;
                counts[1] += usize::from(is_right);
            }
        }
        if differ && own[1..] == [true, false] {
            println!("{line}\n    both: {}", reader.read(&plain));
        }
    }
    for (name, n) in right {
        println!("{name}: {n} of {all} right, {:.1}%", 100.0 * n as f64 / f64::from(all));
    }
    for (class, [n, right]) in classes {
        let share = 100.0 * right as f64 / n as f64;
        println!("network from {:.0}% sure on: {right} of {n} right, {share:.1}%", 100.0 / CLASSES * class as f64);
    }
    Ok(())
}

/// Returns a sentence without its marks, and the names of its actions with their alternatives. A reaction (`{=cheer, then hug|...}`) has those
/// of its sentence.
fn unmarked(line: &str, reader: &Reader<'_>) -> (String, Vec<Vec<String>>) {
    let (mut plain, mut names) = (String::new(), Vec::new());
    let mut rest = line;
    while let Some((before, after)) = rest.split_once('{') {
        let (inside, after) = after.split_once('}').unwrap_or((after, ""));
        let (name, words) = inside.split_once('|').unwrap_or(("", inside));
        plain += before;
        plain += words;
        match name.strip_prefix('=') {
            Some(reaction) => {
                let script = reader.read_by(reaction, Reading::Rules);
                let verbs = script.clauses.iter().flat_map(|clause| &clause.actions);
                names.extend(verbs.map(|action| vec![same(&action.verb)]));
            }
            None => names.push(name.split('/').map(same).collect()),
        }
        rest = after;
    }
    (plain + rest, names)
}

fn same(verb: &str) -> String {
    SAME.iter().find(|(one, _)| *one == verb).map_or(verb, |(_, other)| other).to_string()
}

fn agrees(wanted: &[Vec<String>], script: &Script) -> bool {
    let is_listed = |names: &&Vec<String>| !names.iter().any(|name| name == "impossible" || name == "other");
    let asks_too_much = wanted.iter().any(|names| names.iter().any(|name| name == "impossible"));
    if asks_too_much && script.impossible.is_empty() && script.unknown.is_empty() {
        return false;
    }
    let mut open: Vec<&Vec<String>> = wanted.iter().filter(is_listed).collect();
    let verbs = script.clauses.iter().flat_map(|clause| &clause.actions).map(|action| same(&action.verb));
    for verb in verbs {
        match open.iter().position(|names| names.contains(&verb)) {
            Some(at) => open.remove(at),
            None => return false,
        };
    }
    open.is_empty()
}
