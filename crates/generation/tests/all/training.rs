//! A small training learns, goes on bit for bit, and its file makes motion.

use std::path::PathBuf;

use lifelike_generation::data::CaptionedMotion;
use lifelike_generation::generator::{Generator, SampleOptions};
use lifelike_generation::space::SpaceKind;
use lifelike_generation::training::{GeneratorPlan, GeneratorTrainer, TrainingData};
use lifelike_language::{CaptionedSet, Entry, Split};
use lifelike_motion::container;
use lifelike_robot::{Robot, clips};

fn plan() -> GeneratorPlan {
    GeneratorPlan {
        clips: vec![PathBuf::from("builtin")],
        max_seconds: 3.0,
        width: 32,
        layers: 1,
        heads: 2,
        inner: 64,
        pieces: 200,
        batch: 8,
        part: 3,
        iterations: 60,
        warmup: 5,
        learning_rate: 3e-3,
        diffusion_steps: 20,
        ..GeneratorPlan::default()
    }
}

fn trainer(plan: &GeneratorPlan, robot: &Robot) -> GeneratorTrainer {
    let motions = CaptionedMotion::load(&plan.clips, robot, plan.max_seconds).unwrap();
    let data = TrainingData::new(plan, robot, &motions).unwrap();
    GeneratorTrainer::new(plan.clone(), robot, data).unwrap()
}

#[test]
fn a_training_learns_in_both_spaces_and_makes_clips() {
    let robot = Robot::load("lima").unwrap();
    for space in [SpaceKind::default(), SpaceKind::Frames] {
        let plan = GeneratorPlan { space, ..plan() };
        let mut trainer = trainer(&plan, &robot);
        let before = trainer.validation_loss().unwrap();
        for _ in 0..plan.iterations {
            assert!(trainer.step().unwrap().step.loss.is_finite());
        }
        let after = trainer.validation_loss().unwrap();
        assert!(after < 0.7 * before, "{space:?}: {before} {after}");

        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("x.generator.safetensors");
        trainer.generator().save(&path).unwrap();
        let generator = Generator::load(&path).unwrap();
        let options = SampleOptions { seconds: Some(1.0), candidates: 3, steps: Some(5), ..SampleOptions::default() };
        let all = generator.sample("a person walks", &options).unwrap();
        assert_eq!((all.len(), all[0].rows.n), (3, 21));
        assert_ne!(all[0].rows, all[1].rows);
        let one = generator.sample("a person walks", &SampleOptions { candidates: 1, ..options }).unwrap();
        assert_eq!(one[0].rows, all[0].rows, "a candidate does not depend on the others");
        let clip = generator.clip(&all[0], "a person walks", &robot).unwrap();
        assert_eq!((clip.fps, clip.len()), (robot.control_hz, 51));
        for joint in robot.character.scalar_joints() {
            let column = clip.joint_names.iter().position(|name| *name == joint.name).unwrap();
            let (low, high) = joint.range.unwrap();
            for t in 0..clip.len() {
                let q = clip.joints_at(t)[column];
                assert!(q >= low - 1e-9 && q <= high + 1e-9, "{}: {q}", joint.name);
            }
        }
        refused(&generator, &options);
        let other = generator.check_robot(&Robot::load("humanoid").unwrap()).unwrap_err().to_string();
        assert!(other.contains("'lima'") && other.contains("'humanoid'"), "{other}");
    }
}

fn refused(generator: &Generator, options: &SampleOptions) {
    let error = |prompt: &str, options: SampleOptions| generator.sample(prompt, &options).unwrap_err().to_string();
    assert!(error("", *options).contains("prompt"));
    assert!(error("wave\u{7}", *options).contains("prompt"));
    assert!(error(&"walk ".repeat(10_000), *options).contains("prompt"));
    let with = |change: fn(&mut SampleOptions)| {
        let mut options = *options;
        change(&mut options);
        error("a person walks", options)
    };
    assert!(with(|o| o.seconds = Some(f64::NAN)).contains("seconds"));
    assert!(with(|o| o.seconds = Some(1e9)).contains("0.5 to 3"));
    assert!(with(|o| o.steps = Some(0)).contains("steps"));
    assert!(with(|o| o.steps = Some(21)).contains("1 to 20"));
    assert!(with(|o| o.candidates = 0).contains("candidates"));
    assert!(with(|o| o.guidance = -1.0).contains("guidance"));
    assert!(with(|o| o.eta = 2.0).contains("eta"));
}

#[test]
fn a_run_goes_on_bit_for_bit_and_only_with_its_own_data() {
    let robot = Robot::load("lima").unwrap();
    let plan = plan();
    let mut whole = trainer(&plan, &robot);
    for _ in 0..4 {
        whole.step().unwrap();
    }
    let mut first = trainer(&plan, &robot);
    for _ in 0..2 {
        first.step().unwrap();
    }
    let saved = first.checkpoint().unwrap();
    let mut second = trainer(&plan, &robot);
    second.restore(&saved).unwrap();
    for _ in 0..2 {
        second.step().unwrap();
    }
    assert_eq!(second.checkpoint().unwrap().to_bytes().unwrap(), whole.checkpoint().unwrap().to_bytes().unwrap());
    let other = GeneratorPlan { max_seconds: 2.0, ..plan };
    let error = trainer(&other, &robot).restore(&saved).unwrap_err().to_string();
    assert!(error.contains("captioned motion"), "{error}");
}

#[test]
fn a_captioned_set_keeps_its_splits_and_sentences() {
    let robot = Robot::load("lima").unwrap();
    let folder = tempfile::tempdir().unwrap();
    let own = clips::builtin(&robot).all().unwrap();
    let mut entries = Vec::new();
    for (i, (clip, split)) in
        own.iter().zip([Split::Train, Split::Train, Split::Validation, Split::HeldOut]).enumerate()
    {
        let file = format!("{i}.motion.safetensors");
        container::write(&folder.path().join(&file), clip).unwrap();
        let captions = vec![format!("a person does number {i}"), "somebody moves".into()];
        let (seconds, source, licence) = (clip.seconds(), "own".into(), "CC0".into());
        entries.push(Entry { file, split, seconds, captions, source, licence, facts: None });
    }
    CaptionedSet { folder: folder.path().into(), entries }.write().unwrap();
    let inputs = [folder.path().to_path_buf()];
    let motions = CaptionedMotion::load(&inputs, &robot, 2.0).unwrap();
    assert_eq!(motions.len(), 4);
    assert!(motions.iter().all(|motion| motion.rows.n <= 41 && motion.captions.len() == 2));
    let data = TrainingData::new(&plan(), &robot, &motions).unwrap();
    assert!(data.describe().starts_with("2 motions, 1 for validation, SHA-256"), "{}", data.describe());
    std::fs::write(folder.path().join("dataset.jsonl"), "{").unwrap();
    let error = CaptionedMotion::load(&inputs, &robot, 2.0).unwrap_err().to_string();
    assert!(error.contains("dataset.jsonl:1"), "{error}");
}
