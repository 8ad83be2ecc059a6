//! The grammar's promises hold on its own clips, and the checks can fail.

use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

use lifelike_character::anatomy::Overrides;
use lifelike_character::{Anatomy, Character};
use lifelike_language::checks::{Fact, Tracks, check};
use lifelike_language::facts::{Relation, Side};
use lifelike_language::grammar::{Generator, Grammar, Options, write};
use lifelike_motion::edit::mirror;
use lifelike_motion::retarget::RetargetOptions;

/// Lima with 80 % of its actuators' speeds, as the command retargets to it.
fn lima() -> (Character, Anatomy, RetargetOptions) {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../robots/lima.xml");
    let xml = std::fs::read_to_string(file).unwrap();
    let character = Character::from_mjcf(&xml, "lima.xml", None).unwrap();
    let anatomy = Anatomy::guess(&character, &Overrides::new()).unwrap();
    let mut options = RetargetOptions::default();
    for joint in &character.joints {
        let upper = ["neck_", "shoulder_", "elbow"].iter().any(|part| joint.name.contains(part));
        options.velocity_limit.insert(joint.name.clone(), 0.8 * if upper { 7.0 } else { 20.0 });
    }
    (character, anatomy, options)
}

#[test]
fn sentences_are_true_of_their_clips_and_not_of_mirror_images() {
    let (character, anatomy, options) = lima();
    let grammar = Grammar::builtin().unwrap();
    let generator = Generator::new(&grammar, &character, &anatomy, options).unwrap();
    assert!(generator.left_out.is_empty(), "{:?}", generator.left_out);
    let (mut made, mut held, mut sided, mut fooled, mut miscounted) = (0, 0, 0, 0, 0);
    for index in 0..80 {
        let drawn = generator.draw(5, index).unwrap();
        let Ok(Some(clip)) = generator.make(&drawn, 5) else { continue };
        assert_eq!(generator.draw(5, index).unwrap(), drawn);
        made += 1;
        held += usize::from(clip.is_true());
        if !clip.is_true() || drawn.facts.relation != Relation::Single {
            continue;
        }
        let action = &drawn.facts.actions[0];
        let tracks = Tracks::of(&clip.clip, &character, &anatomy).unwrap();
        if let Some(count) = action.count {
            let mut more = drawn.facts.clone();
            more.actions[0].count = Some(count + 1);
            let found = check(&tracks, &grammar, &more).unwrap();
            miscounted += usize::from(found.iter().any(|f| f.fact == Fact::Count && f.passed));
        }
        if matches!(action.side, Some(Side::Left | Side::Right))
            || action.direction != drawn.facts.mirrored().actions[0].direction
        {
            sided += 1;
            let image = mirror(&clip.clip, &character).unwrap();
            let tracks = Tracks::of(&image, &character, &anatomy).unwrap();
            let wrong = check(&tracks, &grammar, &drawn.facts).unwrap();
            fooled += usize::from(wrong.iter().all(|f| f.passed));
            let right = check(&tracks, &grammar, &drawn.facts.mirrored()).unwrap();
            assert!(right.iter().all(|f| f.passed), "{index}: {right:?}");
        }
    }
    assert!(held * 100 >= made * 93, "{held} of {made}");
    assert!(sided >= 10 && fooled == 0 && miscounted == 0, "{sided} {fooled} {miscounted}");
}

#[test]
fn a_set_that_was_interrupted_becomes_the_one_that_was_not() {
    let (character, anatomy, options) = lima();
    let grammar = Grammar::builtin().unwrap();
    let generator = Generator::new(&grammar, &character, &anatomy, options).unwrap();
    let (whole, cut) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let extent = |seed, resume| Options { hours: 0.12, seed, resume };
    let index = |folder: &Path| std::fs::read_to_string(folder.join("dataset.jsonl")).unwrap();

    write(&generator, whole.path(), &extent(5, false), &AtomicBool::new(false), |_| {}).unwrap();
    let stop = AtomicBool::new(false);
    let half = write(&generator, cut.path(), &extent(5, false), &stop, |_| stop.store(true, Ordering::SeqCst)).unwrap();
    assert!(half.hours < 0.12 && index(cut.path()) != index(whole.path()));
    let other = write(&generator, cut.path(), &extent(6, true), &AtomicBool::new(false), |_| {}).unwrap_err();
    assert!(other.to_string().contains("begun with"), "{other}");
    let done = write(&generator, cut.path(), &extent(5, true), &AtomicBool::new(false), |_| {}).unwrap();
    assert!(done.hours >= 0.12);
    assert!(index(cut.path()) == index(whole.path()), "the same clips under the same sentences");
    assert!(!cut.path().join("unfinished.json").exists());
    let again =
        |folder: &Path| write(&generator, folder, &extent(5, true), &AtomicBool::new(false), |_| {}).unwrap_err();
    let finished = again(cut.path()).to_string();
    assert!(finished.ends_with("got a finished one: use it as it is, or make another in a new folder"), "{finished}");
    let nowhere = cut.path().join("new");
    assert!(again(&nowhere).to_string().ends_with("got none: begin it without --resume") && !nowhere.exists());
}
