//! Promises of principal components, on synthetic motion.

use crate::swings;
use crate::swings::{clips, layout};
use lifelike_representation::MotionPrior;
use lifelike_representation::WindowPlan;
use lifelike_representation::prior::pca::{PcaPlan, PcaTrainer};
use lifelike_representation::prior::{FeatureStatistics, PriorData, PriorTraining, Windows};
use lifelike_train::TrainingTask;
use nalgebra::DMatrix;

const LATENT: usize = 6;

fn plan() -> PcaPlan {
    let windows = WindowPlan { half_width: 5, held_out: 0.0, ..WindowPlan::default() };
    PcaPlan { windows, latent: LATENT, iterations: 30 }
}

fn data() -> PriorData {
    PriorData { layout: layout(), training: clips(), held_out: Vec::new() }
}

fn fitted(iterations: u64) -> PcaTrainer {
    let mut trainer = PcaTrainer::new(plan(), data()).unwrap();
    for _ in 0..iterations {
        trainer.step().unwrap();
    }
    trainer
}

/// All normalised windows, one to a row, less their mean.
fn centred() -> DMatrix<f64> {
    let windows = Windows::new(&plan().windows, &layout(), clips()).unwrap();
    let frames = clips().into_iter().flat_map(|c| c.frames).collect::<Vec<_>>();
    let statistics = FeatureStatistics::of(&layout(), &plan().windows.floors, frames.iter());
    let rows = windows.gather(&statistics, &(0..windows.len()).collect::<Vec<_>>()).unwrap();
    let mut x = DMatrix::from_row_iterator(windows.len(), rows.len() / windows.len(), rows.into_iter().map(f64::from));
    let mean = x.row_mean();
    x.row_iter_mut().for_each(|mut row| row -= &mean);
    x
}

/// Against the singular value decomposition of all windows at once.
#[test]
fn the_subspace_is_that_of_the_singular_value_decomposition() {
    let singular = centred().svd(false, false).singular_values;
    let squares: Vec<f64> = singular.iter().map(|s| s * s).collect();
    let expected = squares[..LATENT].iter().sum::<f64>() / squares.iter().sum::<f64>();
    let mut trainer = PcaTrainer::new(plan(), data()).unwrap();
    let explained: Vec<f64> = (0..30).map(|_| trainer.step().unwrap().explained).collect();
    assert!(explained[0] < expected - 1e-3, "{} of {expected}", explained[0]);
    assert!((explained[29] - expected).abs() < 1e-5, "{} of {expected}", explained[29]);
}

#[test]
fn codes_of_the_training_windows_are_uncorrelated_with_unit_variance() {
    let prior = fitted(30).prior().unwrap();
    let codes: Vec<f32> = clips().iter().flat_map(|c| prior.encode_clip(&c.frames).unwrap()).collect();
    let rows = DMatrix::from_row_iterator(codes.len() / LATENT, LATENT, codes.into_iter().map(f64::from));
    let covariance = rows.transpose() * &rows / rows.nrows() as f64;
    assert!((&covariance - DMatrix::identity(LATENT, LATENT)).amax() < 2e-3, "{covariance}");
    assert!(rows.row_mean().amax() < 1e-3);
}

#[test]
fn a_saved_prior_answers_like_the_live_one_and_a_stopped_fit_goes_on() {
    let straight = fitted(8);
    let stopped = fitted(3).checkpoint().unwrap();
    let mut resumed = fitted(0);
    resumed.restore(&stopped).unwrap();
    for _ in 0..5 {
        resumed.step().unwrap();
    }
    let bytes = |trainer: &PcaTrainer| trainer.checkpoint().unwrap().to_bytes().unwrap();
    assert!(bytes(&straight) == bytes(&resumed));

    let place = tempfile::tempdir().unwrap();
    let file = place.path().join("motion.prior.safetensors");
    let prior = straight.prior().unwrap();
    prior.save(&file).unwrap();
    let loaded = MotionPrior::load(&file).unwrap();
    assert_eq!(loaded.plan(), prior.plan());
    let frames = &clips()[0].frames;
    assert_eq!(loaded.encode_clip(frames).unwrap(), prior.encode_clip(frames).unwrap());
}

#[test]
fn more_components_than_windows_are_refused() {
    let few = PriorData { training: vec![swings::clip(0, 4)], ..data() };
    let error = PcaTrainer::new(plan(), few).unwrap_err().to_string();
    assert!(error.contains("latent: expected at most 4: 4 windows of"), "{error}");
}
