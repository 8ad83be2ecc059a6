//! Measures on a robot what each word of tempo and size does to each verb, as a share of the normal motion.
//!
//! `modifiers [VERB ...]` prints, for slow, fast, small and big, the measured factor, `-` where the verb has none of its
//! own, and `!` behind a factor that nobody would see. The last line counts.

use std::path::Path;

use lifelike_character::anatomy::Overrides;
use lifelike_character::{Anatomy, Character};
use lifelike_language::checks::Fact;
use lifelike_language::facts::{Action, Size, Speed};
use lifelike_language::grammar::{Generator, Grammar, Verb};
use lifelike_language::script::Clause;
use lifelike_motion::retarget::RetargetOptions;

/// Columns: name, speed, size.
const WAYS: [(&str, Option<Speed>, Option<Size>); 4] = [
    ("slow", Some(Speed::Slow), None),
    ("fast", Some(Speed::Fast), None),
    ("small", None, Some(Size::Small)),
    ("big", None, Some(Size::Big)),
];

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../robots/lima.xml");
    let lima = Character::from_mjcf(&std::fs::read_to_string(file)?, "lima.xml", None)?;
    let anatomy = Anatomy::guess(&lima, &Overrides::new())?;
    let grammar = Grammar::builtin()?;
    let wanted: Vec<String> = std::env::args().skip(1).collect();
    let chosen = |verb: &&Verb| wanted.is_empty() || wanted.contains(&verb.name);
    let verbs: Vec<&Verb> = grammar.verbs.iter().filter(chosen).collect();
    let names: Vec<&str> = verbs.iter().map(|verb| verb.name.as_str()).collect();
    let generator = Generator::of_verbs(&grammar, &lima, &anatomy, RetargetOptions::default(), &names)?;
    let (mut seen, mut all) = (0, 0);
    for verb in verbs {
        let mut line = format!("{:<24}", verb.name);
        for (_, speed, size) in WAYS {
            let takes = speed.map_or(verb.takes_size(), |_| verb.takes_speed());
            if !takes {
                line += "      - ";
                continue;
            }
            let own = Action { side: verb.side, direction: verb.direction, ..Action::of(&verb.name) };
            let clause = Clause::new(vec![Action { speed, size, ..own }]);
            let Ok(made) = generator.perform(&clause, 1, 0) else {
                all += 1;
                line += "   none!";
                continue;
            };
            let finding = made.findings.iter().find(|f| matches!(f.fact, Fact::Speed | Fact::Size));
            let passed = finding.is_some_and(|f| f.passed);
            (seen, all) = (seen + usize::from(passed), all + 1);
            line += &format!("{:>7}{}", finding.map_or("none", |f| &f.got), if passed { ' ' } else { '!' });
        }
        println!("{line}");
    }
    println!("{seen} of {all} are seen ({})", WAYS.map(|(name, ..)| name).join(", "));
    Ok(())
}
