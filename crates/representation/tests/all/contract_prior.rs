//! Promises of the motion prior, on synthetic motion.

use std::sync::atomic::{AtomicBool, Ordering};

use crate::swings::{clip, clips, layout};
use lifelike_character::{Quat, Vec3};
use lifelike_checkpoint::Checkpoint;
use lifelike_motion::{FeatureLayout, Frame};
use lifelike_nn::adam::Rule;
use lifelike_report::run::RunFolder;
use lifelike_representation::RepresentationError;
use lifelike_representation::latent::Codes;
use lifelike_representation::latent::codes::features_of;
use lifelike_representation::latent::interpolation::middle_frames;
use lifelike_representation::prior::pca::{PcaPlan, PcaTrainer};
use lifelike_representation::prior::vae::{VaeMetrics, VaePlan, VaeTrainer};
use lifelike_representation::prior::{PriorData, PriorTraining, split};
use lifelike_representation::{MotionPrior, WindowPlan};
use lifelike_train::collective::Alone;
use lifelike_train::{TrainingRun, TrainingTask};

fn small() -> VaePlan {
    VaePlan { channels: 16, blocks: 1, latent: 8, batch: 16, iterations: 60, restart_first: 60, ..VaePlan::default() }
}

fn trainer(plan: VaePlan) -> VaeTrainer {
    let (train, aside) = split(&plan.windows, clips());
    VaeTrainer::new(plan, layout(), train, aside).unwrap()
}

fn run(trainer: &mut VaeTrainer, iterations: u64) -> Vec<VaeMetrics> {
    (0..iterations).map(|_| trainer.step().unwrap()).collect()
}

#[test]
fn a_stopped_run_continues_bit_for_bit() {
    let losses = [Rule::Adam, Rule::Radam, Rule::Muon].map(|optimizer| {
        let plan = VaePlan { optimizer, ..small() };
        let mut straight = trainer(plan.clone());
        let expected = run(&mut straight, 24);

        let mut stopped = trainer(plan.clone());
        let mut got = run(&mut stopped, 11);
        let checkpoint = stopped.checkpoint().unwrap();
        drop(stopped);
        let mut resumed = trainer(plan);
        resumed.restore(&checkpoint).unwrap();
        got.extend(run(&mut resumed, 13));

        assert_eq!(expected, got);
        let bytes = |trainer: &VaeTrainer| trainer.checkpoint().unwrap().to_bytes().unwrap();
        assert!(bytes(&straight) == bytes(&resumed));
        expected.last().unwrap().step.loss
    });
    assert!(losses[0] != losses[1] && losses[1] != losses[2] && losses[2] != losses[0], "three rules: {losses:?}");
}

#[test]
fn a_run_in_a_folder_that_was_stopped_is_the_run_it_would_have_been() {
    let place = tempfile::tempdir().unwrap();
    let go = |name: &str, stop: u64| {
        let folder = RunFolder::open_or_create(place.path().join(name), &small()).unwrap();
        let flag = AtomicBool::new(false);
        let run = TrainingRun { folder: &folder, stop: &flag, collective: &Alone };
        let mut trainer = trainer(small());
        run.run(&mut trainer, |now| flag.store(now.iteration == stop, Ordering::SeqCst)).unwrap();
        trainer.prior().save(&place.path().join("prior")).unwrap();
        (std::fs::read(place.path().join("prior")).unwrap(), std::fs::read(folder.metrics_path()).unwrap())
    };
    let whole = go("whole", 0);
    assert_ne!(go("parts", 7).0, whole.0);
    assert!(go("parts", 0) == whole);
}

#[test]
fn a_linear_path_is_what_learning_begins_with_and_stays_as_it_is() {
    let windows = WindowPlan { held_out: 0.0, ..WindowPlan::default() };
    let plan = VaePlan {
        linear_path: true,
        iterations: 400,
        restart_first: 400,
        channels: 32,
        batch: 32,
        optimizer: Rule::Adam,
        learning_rate: 2e-3,
        windows,
        ..small()
    };
    let (train, aside) = split(&plan.windows, clips());
    let data = PriorData { layout: layout(), training: train, held_out: aside };
    let mut pca =
        PcaTrainer::new(PcaPlan { windows: plan.windows, latent: plan.latent, iterations: 12 }, data).unwrap();
    for _ in 0..12 {
        TrainingTask::step(&mut pca).unwrap();
    }
    let components = pca.prior().unwrap();

    let mut still = trainer(VaePlan { learning_rate: 1e-9, ..plan.clone() });
    still.step().unwrap();
    let frames = &clips()[0].frames;
    let (a, b) = (components.encode_clip(frames).unwrap(), still.prior().encode_clip(frames).unwrap());
    let apart = a.iter().zip(&b).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    assert!(apart < 1e-4, "{apart}");
    let before = still.report().unwrap().window.joints_deg;
    assert!((before - components.reconstruct(still.watched()).unwrap().window.joints_deg).abs() < 1e-3, "{before}");

    let mut vae = trainer(plan.clone());
    vae.step().unwrap();
    let checkpoint = vae.checkpoint().unwrap();
    let mut resumed = trainer(plan);
    resumed.restore(&checkpoint).unwrap();
    run(&mut vae, 399);
    run(&mut resumed, 399);
    let bytes = |trainer: &VaeTrainer| trainer.checkpoint().unwrap().to_bytes().unwrap();
    assert!(bytes(&vae) == bytes(&resumed));
    let kept =
        |checkpoint: &lifelike_checkpoint::Checkpoint| checkpoint.entry("components.directions").unwrap().clone();
    assert!(kept(&checkpoint) == kept(&vae.checkpoint().unwrap()));
    let after = vae.report().unwrap().window.joints_deg;
    assert!(after < before, "learning adds to it: {before} deg, then {after}");
}

#[test]
fn resuming_on_other_clips_is_refused() {
    let checkpoint = trainer(small()).checkpoint().unwrap();
    let (mut train, aside) = split(&small().windows, clips());
    train[0].frames[5].joint_positions[0] += 1e-9;
    let mut other = VaeTrainer::new(small(), layout(), train, aside).unwrap();
    assert!(matches!(other.restore(&checkpoint), Err(RepresentationError::Input(_))));
}

#[test]
fn it_learns_and_a_saved_prior_answers_like_the_live_one() {
    // No clip is held out, so the report is about the clips it learns from.
    let optimizer = Rule::Adam;
    let windows = WindowPlan { held_out: 0.0, ..WindowPlan::default() };
    let plan = VaePlan { iterations: 300, restart_first: 300, channels: 24, windows, optimizer, ..small() };
    let mut run_ = trainer(plan);
    let before = run_.report().unwrap();
    let metrics = run(&mut run_, 300);
    let after = run_.report().unwrap();
    assert!(metrics.iter().all(|m| m.step.loss.is_finite() && m.step.skipped == 0));
    assert!(after.centre.joints_deg < 0.5 * before.centre.joints_deg, "{before:?}\n{after:?}");
    assert!(after.window.effectors_mm < 0.5 * before.window.effectors_mm, "{before:?}\n{after:?}");

    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("swing.prior.safetensors");
    let prior = run_.prior();
    prior.save(&path).unwrap();
    let loaded = MotionPrior::load(&path).unwrap();
    let frames = clip(3, 40).frames;
    let z = loaded.encode_clip(&frames).unwrap();
    assert_eq!(z.len(), 40 * 8);
    assert_eq!(z, prior.encode_clip(&frames).unwrap());
    assert_eq!(loaded.layout(), &layout());
    let windows = loaded.decode(&z).unwrap();
    assert_eq!(windows.len(), 40 * 61 * layout().size());
    assert!(loaded.decode(&z[1..]).is_err());
}

#[test]
fn a_latent_knows_neither_place_nor_heading() {
    let prior = trainer(small()).prior();
    let here = clip(1, 70).frames;
    let turn = Quat::from_euler_angles(0.0, 0.0, 2.5);
    let shift = Vec3::new(3.0, -4.0, 0.0);
    let there: Vec<Frame> = here
        .iter()
        .map(|f| Frame {
            root_position: turn * f.root_position + shift,
            root_orientation: turn * f.root_orientation,
            linear_velocity_w: turn * f.linear_velocity_w,
            angular_velocity_w: turn * f.angular_velocity_w,
            effectors_w: f.effectors_w.iter().map(|p| turn * p + shift).collect(),
            ..f.clone()
        })
        .collect();
    let (a, b) = (prior.encode_clip(&here).unwrap(), prior.encode_clip(&there).unwrap());
    let scale = a.iter().fold(0.0_f32, |m, x| m.max(x.abs()));
    assert!(scale > 0.01);
    for (a, b) in a.iter().zip(&b) {
        assert!((a - b).abs() < 1e-5 * scale.max(1.0), "{a} {b}");
    }
}

#[test]
fn frames_that_do_not_fit_are_named() {
    let prior = trainer(small()).prior();
    let mut frames = clip(0, 10).frames;
    frames[7].joint_positions[2] = f64::NAN;
    let message = prior.encode_clip(&frames).unwrap_err().to_string();
    assert!(message.contains("frame 7"), "{message}");
    frames[7].joint_positions.pop();
    let message = prior.encode_clip(&frames).unwrap_err().to_string();
    assert!(message.contains("4 joint positions") && message.contains("3 joint positions"), "{message}");
    assert!(prior.encode_clip(&[]).is_err());
}

#[test]
fn statistics_are_those_of_hand_arithmetic_with_floors() {
    let windows = WindowPlan { held_out: 0.0, ..WindowPlan::default() };
    let run_ = trainer(VaePlan { windows, ..small() });
    let prior = run_.prior();
    let all: Vec<Frame> = clips().into_iter().flat_map(|c| c.frames).collect();
    let column: Vec<f64> = all.iter().map(|f| f.joint_positions[1]).collect();
    let mean = column.iter().sum::<f64>() / column.len() as f64;
    let std = (column.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / column.len() as f64).sqrt();
    let at = layout().joint_positions().start + 1;
    assert!((prior.statistics().mean()[at] - mean).abs() < 1e-12);
    assert!((prior.statistics().std()[at] - std).abs() < 1e-12);
    assert_eq!(prior.statistics().std()[FeatureLayout::ORIENTATION], [1.0; 6]);
    // The sideways velocity never changes: its standard deviation is the floor.
    assert_eq!(prior.statistics().std()[8], small().windows.floors.linear_velocity);
}

#[test]
fn the_middle_of_every_decoded_window_is_taken_however_many_there_are() {
    let prior = trainer(small()).prior();
    // More codes than are decoded at a time.
    let codes: Vec<f32> = clips().iter().take(3).flat_map(|c| prior.encode_clip(&c.frames).unwrap()).collect();
    let (size, window) = (layout().size(), prior.windows().window().len());
    let got = middle_frames(&prior, &codes).unwrap();
    assert_eq!(got.len(), 3 * 120 * size);
    for at in [0, 255, 256, 359] {
        let whole = prior.decode(&codes[8 * at..8 * (at + 1)]).unwrap();
        let middle = window / 2 * size;
        let pairs = got[at * size..].iter().zip(&whole[middle..middle + size]);
        // The same numbers up to the order in which a larger batch is summed up.
        assert!(pairs.clone().all(|(g, e)| (g - e).abs() < 1e-4), "code {at}");
        let others = got[at * size..(at + 1) * size].iter().zip(&whole[middle + size..]);
        assert!(others.clone().any(|(g, e)| (g - e).abs() > 1e-3), "the next frame is another one");
    }
}

#[test]
fn codes_of_clips_stand_beside_their_features() {
    let (prior, clips) = (trainer(small()).prior(), clips());
    let codes = Codes::of_prior(&prior, &clips[..2]).unwrap();
    assert_eq!((codes.len(), codes.dimension(), codes.fps()), (240, 8, 50.0));
    assert_eq!(codes.names(), ["swing_0", "swing_1"]);
    assert_eq!(&codes.rows()[120 * 8..], prior.encode_clip(&clips[1].frames).unwrap());
    let features = features_of(&clips[..2], prior.layout()).unwrap();
    // The 121st row is the second clip's first frame: 0.8 m high.
    let row = &features[120 * layout().size()..121 * layout().size()];
    assert!((row[0] - 0.8).abs() < 1e-6, "{row:?}");
    let mut broken = clips[..2].to_vec();
    broken[1].frames[3].joint_positions.pop();
    let told = |error: RepresentationError| error.to_string();
    assert!(told(Codes::of_prior(&prior, &broken).unwrap_err()).contains("swing_1, frame 3"));
    assert!(told(features_of(&broken, prior.layout()).unwrap_err()).contains("swing_1, frame 3"));
}

#[test]
fn a_gradient_that_is_not_finite_is_skipped_and_counted() {
    let mut trainer = trainer(small());
    // A weight of the largest size: all passes overflow.
    let good = trainer.checkpoint().unwrap();
    let mut broken = Checkpoint::new();
    good.metadata().iter().for_each(|(key, value)| broken.set_meta(key, value).unwrap());
    for (name, entry) in good.entries() {
        match name.as_str() {
            "vae.encoder_out.weight" => {
                let count = entry.shape().iter().product();
                broken.put_f32(name, entry.shape(), vec![f32::MAX; count]).unwrap();
            }
            _ => broken.put(name, entry.clone()).unwrap(),
        }
    }
    trainer.restore(&broken).unwrap();
    let weights = |trainer: &VaeTrainer| {
        let checkpoint = trainer.checkpoint().unwrap();
        let own = checkpoint.entries().iter().filter(|(name, _)| name.starts_with("vae."));
        own.map(|(name, entry)| (name.clone(), entry.clone())).collect::<Vec<_>>()
    };
    let before = weights(&trainer);
    assert!(before.len() > 8, "{}", before.len());
    let skipped: Vec<u64> = run(&mut trainer, 3).iter().map(|metrics| metrics.step.skipped).collect();
    assert_eq!(skipped, [1, 2, 3]);
    assert!(weights(&trainer) == before, "no number that is not finite gets into the weights");
}
