//! Promises of the Spline-based Transformer as a motion prior, on synthetic motion.

use std::sync::atomic::{AtomicBool, Ordering};

use crate::swings::{clip, clips, layout};
use lifelike_checkpoint::Checkpoint;
use lifelike_nn::adam::Rule;
use lifelike_report::run::RunFolder;
use lifelike_representation::RepresentationError;
use lifelike_representation::latent::Codes;
use lifelike_representation::prior::spline::{SplinePriorPlan, WindowSequences};
use lifelike_representation::prior::split;
use lifelike_representation::prior::vae::{VaePlan, VaeTrainer};
use lifelike_representation::spline_transformer::{HeldOut, SequencePlan, SequenceTrainer, Sequences};
use lifelike_representation::{MotionPrior, PriorClip, PriorPlan, WindowPlan};
use lifelike_train::TrainingRun;
use lifelike_train::collective::Alone;

/// Four control points of three numbers.
const SIZE: usize = 12;

fn small() -> SplinePriorPlan {
    let training = SequencePlan {
        latent: 3,
        layers: 1,
        heads: 2,
        width: 16,
        batch: 8,
        part: 4,
        iterations: 12,
        optimizer: Rule::Adam,
        learning_rate: 3e-3,
        validate_every: 5,
        ..SequencePlan::default()
    };
    SplinePriorPlan { training, ..SplinePriorPlan::default() }
}

fn sequences(plan: &SplinePriorPlan, clips: Vec<PriorClip>) -> WindowSequences {
    let (training, held_out) = split(&plan.windows, clips);
    WindowSequences::new(plan.windows, plan.training.seed, layout(), training, held_out).unwrap()
}

fn trained(plan: &SplinePriorPlan) -> SequenceTrainer<WindowSequences> {
    let mut trainer = SequenceTrainer::new(plan.training.clone(), sequences(plan, clips())).unwrap();
    while !trainer.is_done() {
        trainer.step().unwrap();
    }
    trainer
}

/// All training windows through the network by the other way, the one that it is trained by: `[windows, SIZE]`, and back.
fn reconstructed(trainer: &SequenceTrainer<WindowSequences>) -> (Vec<f32>, Vec<f32>) {
    let (data, windows) = (trainer.data(), trainer.data().training());
    let all: Vec<usize> = (0..windows.len()).collect();
    trainer.reconstruct(&windows.gather(data.statistics(), &all).unwrap()).unwrap()
}

fn column(rows: &[f32], i: usize) -> (f64, f64) {
    let values = || rows.iter().skip(i).step_by(SIZE).map(|x| f64::from(*x));
    let mean = values().sum::<f64>() / values().count() as f64;
    (mean, (values().map(|x| (x - mean).powi(2)).sum::<f64>() / values().count() as f64).sqrt())
}

fn codes_of_training(trainer: &SequenceTrainer<WindowSequences>, prior: &MotionPrior) -> Vec<f32> {
    trainer.data().training().clips().iter().flat_map(|c| prior.encode_clip(&c.frames).unwrap()).collect()
}

#[test]
fn codes_are_the_networks_control_points_by_their_mean_and_standard_deviation() {
    let trainer = trained(&small());
    let prior = MotionPrior::of_spline(&trainer).unwrap();
    assert_eq!(prior.latent_size(), SIZE);
    let codes = codes_of_training(&trainer, &prior);
    let (points, _) = reconstructed(&trainer);
    assert_eq!((codes.len(), points.len()), (7 * 120 * SIZE, 7 * 120 * SIZE));
    for i in 0..SIZE {
        let (mean, std) = column(&points, i);
        assert!(std > 1e-3, "number {i} says something");
        for (z, x) in codes.iter().zip(&points).skip(i).step_by(SIZE) {
            let expected = (f64::from(*x) - mean) / std;
            assert!((f64::from(*z) - expected).abs() < 2e-3, "number {i}: {z} {expected}");
        }
    }
}

#[test]
fn codes_of_the_training_windows_have_mean_0_and_standard_deviation_1() {
    let trainer = trained(&small());
    let codes = codes_of_training(&trainer, &MotionPrior::of_spline(&trainer).unwrap());
    for i in 0..SIZE {
        let (mean, std) = column(&codes, i);
        assert!(mean.abs() < 1e-5 && (std - 1.0).abs() < 1e-5, "number {i}: mean {mean}, standard deviation {std}");
    }
}

#[test]
fn a_network_that_says_nothing_gives_codes_of_nothing() {
    let plan = small();
    let mut checkpoint =
        SequenceTrainer::new(plan.training.clone(), sequences(&plan, clips())).unwrap().checkpoint().unwrap();
    // The map to control points at 0: all of them are the same.
    let mut silent = Checkpoint::new();
    for (name, entry) in checkpoint.entries() {
        if name.contains("to_latent") && name.starts_with("network") {
            silent.put_f32(name, entry.shape(), vec![0.0; entry.count()]).unwrap();
        } else {
            silent.put(name, entry.clone()).unwrap();
        }
    }
    for (key, value) in checkpoint.metadata() {
        silent.set_meta(key, value).unwrap();
    }
    checkpoint = silent;
    let mut trainer = SequenceTrainer::new(plan.training.clone(), sequences(&plan, clips())).unwrap();
    trainer.restore(&checkpoint).unwrap();
    let prior = MotionPrior::of_spline(&trainer).unwrap();
    assert!(prior.encode_clip(&clip(0, 10).frames).unwrap().iter().all(|z| *z == 0.0));
}

#[test]
fn decoding_is_the_networks_and_it_learns() {
    let training = SequencePlan { iterations: 250, batch: 16, width: 32, latent: 8, ..small().training };
    let plan = SplinePriorPlan { training, ..small() };
    let before = SequenceTrainer::new(plan.training.clone(), sequences(&plan, clips())).unwrap();
    let before = MotionPrior::of_spline(&before).unwrap().reconstruct(before.data().watched()).unwrap();
    let trainer = trained(&plan);
    let prior = MotionPrior::of_spline(&trainer).unwrap();
    let after = prior.reconstruct(trainer.data().watched()).unwrap();
    assert_eq!(after.windows, 120, "the clip that was held out");
    assert!(after.centre.joints_deg < 0.6 * before.centre.joints_deg, "{before:?}\n{after:?}");

    let (_, windows) = reconstructed(&trainer);
    let mut expected: Vec<f64> = windows.into_iter().map(f64::from).collect();
    prior.statistics().denormalize(&mut expected);
    let got = prior.decode(&codes_of_training(&trainer, &prior)).unwrap();
    assert_eq!(got.len(), expected.len());
    for (g, e) in got.iter().zip(&expected) {
        assert!((g - e).abs() < 2e-3 * e.abs().max(1.0), "{g} {e}");
    }
    let error = prior.decode(&[0.0; 33]).unwrap_err().to_string();
    assert_eq!(error, "latents: expected rows of 32 numbers, got 33 numbers");
}

#[test]
fn a_file_is_the_prior_bit_for_bit() {
    let folder = tempfile::tempdir().unwrap();
    let (one, two) = (folder.path().join("one"), folder.path().join("two"));
    let prior = MotionPrior::of_spline(&trained(&small())).unwrap();
    prior.save(&one).unwrap();
    let loaded = MotionPrior::load(&one).unwrap();
    loaded.save(&two).unwrap();
    assert_eq!(std::fs::read(&one).unwrap(), std::fs::read(&two).unwrap());
    assert_eq!(loaded.plan(), &PriorPlan::Spline(small()));
    assert_eq!((loaded.layout(), loaded.statistics()), (&layout(), prior.statistics()));
    let frames = clip(3, 40).frames;
    assert_eq!(loaded.encode_clip(&frames).unwrap(), prior.encode_clip(&frames).unwrap());

    // The rest of the library sees a prior like any other.
    let codes = Codes::of_prior(&loaded, &clips()[..2]).unwrap();
    assert_eq!((codes.len(), codes.dimension(), codes.fps()), (240, SIZE, 50.0));
    assert!(MotionPrior::is_in(&Checkpoint::load(&one).unwrap()));
    let mut other = VaeTrainer::new(VaePlan::default(), layout(), clips(), Vec::new()).unwrap();
    let error = other.restore(&Checkpoint::load(&one).unwrap()).unwrap_err().to_string();
    assert!(error.contains("expected a beta-VAE's run, got a spline motion prior"), "{error}");
}

#[test]
fn what_does_not_fit_is_told() {
    let prior = MotionPrior::of_spline(&trained(&small())).unwrap();
    let mut frames = clip(0, 10).frames;
    frames[7].joint_positions.pop();
    let error = prior.encode_clip(&frames).unwrap_err().to_string();
    assert!(error.contains("frame 7") && error.contains("4 joint positions"), "{error}");
    let none = WindowSequences::new(small().windows, 0, layout(), Vec::new(), clips()).unwrap_err();
    assert_eq!(none.to_string(), "training clips: expected at least one frame, got none");
    let mut other = clips();
    other.iter_mut().for_each(|clip| clip.frames[5].joint_positions[0] += 1e-9);
    let checkpoint = trained(&small()).checkpoint().unwrap();
    let mut other = SequenceTrainer::new(small().training, sequences(&small(), other)).unwrap();
    let refused = other.restore(&checkpoint).unwrap_err();
    assert!(matches!(refused, RepresentationError::Input(_)), "{refused}");
}

#[test]
fn a_run_that_was_stopped_is_the_run_it_would_have_been() {
    let folder = tempfile::tempdir().unwrap();
    let plan = small();
    let go = |name: &str, stop: u64| {
        let run = RunFolder::open_or_create(folder.path().join(name), &plan).unwrap();
        let flag = AtomicBool::new(false);
        let mut trainer = SequenceTrainer::new(plan.training.clone(), sequences(&plan, clips())).unwrap();
        let training = TrainingRun { folder: &run, stop: &flag, collective: &Alone };
        training.run(&mut trainer, |now| flag.store(now.iteration >= stop, Ordering::SeqCst)).unwrap();
        let file = folder.path().join(format!("{name}.prior"));
        MotionPrior::of_spline(&trainer).unwrap().save(&file).unwrap();
        (std::fs::read(file).unwrap(), std::fs::read(run.metrics_path()).unwrap())
    };
    let whole = go("whole", u64::MAX);
    assert_ne!(go("parts", 7).0, whole.0);
    assert_eq!(go("parts", u64::MAX), whole);
}

#[test]
fn the_loss_is_watched_on_what_was_held_out() {
    let data = sequences(&small(), clips());
    assert_eq!((data.held_out_len(HeldOut::Validation), data.watched().clips().len()), (120, 1));
    assert_eq!((data.tokens(), data.width()), (61, layout().size()));
    let unit = data.tokens() * data.width();
    let all = data.held_out(HeldOut::Validation, 0..120);
    assert_eq!(data.held_out(HeldOut::Validation, 7..9), all[7 * unit..9 * unit]);
    assert_eq!((data.batch(3, 5).len(), data.batch(3, 5)), (5 * unit, data.batch(3, 5)));
    assert_ne!(data.batch(3, 5), data.batch(4, 5));
    // Without held-out clips it is watched on the training clips, on some of their windows.
    let plan = small();
    let all = SplinePriorPlan { windows: WindowPlan { held_out: 0.0, ..plan.windows }, ..plan };
    let data = sequences(&all, clips());
    assert_eq!((data.training().len(), data.held_out_len(HeldOut::Validation)), (960, 480));
}
