//! Metrics against numpy and scipy (`fixtures/metrics/make.py`).
use lifelike_generation::metrics::{Embeddings, Gaussian, Interval, POOL, Retrieval, frechet_distance};

#[derive(serde::Deserialize)]
struct Fixture {
    width: usize,
    motion: Vec<f32>,
    text: Vec<f32>,
    few: Vec<f32>,
    fid: f64,
    fid_few: f64,
    precision: [f64; 3],
    distance: f64,
    values: Vec<f64>,
    interval: [f64; 2],
}

fn fixture() -> Fixture {
    serde_json::from_str(include_str!("../fixtures/metrics/metrics.json")).unwrap()
}

#[track_caller]
fn near(got: f64, expected: f64, tolerance: f64) {
    assert!((got - expected).abs() < tolerance, "{got} instead of {expected}");
}

#[test]
fn the_frechet_distance_is_scipys() {
    let f = fixture();
    let moments = |numbers: Vec<f32>| Gaussian::of(&Embeddings::new(numbers, f.width).unwrap()).unwrap();
    let (motion, text, few) = (moments(f.motion), moments(f.text), moments(f.few));
    near(frechet_distance(&motion, &text).unwrap(), f.fid, 1e-9);
    near(frechet_distance(&text, &motion).unwrap(), f.fid, 1e-9);
    // A covariance of rank 3: its zero eigenvalues are off by 1e-16, the roots by 1e-8 each.
    near(frechet_distance(&motion, &few).unwrap(), f.fid_few, 1e-6);
    near(frechet_distance(&motion, &motion).unwrap(), 0.0, 1e-9);
}

#[test]
fn retrieval_and_interval_are_numpys() {
    let f = fixture();
    let [text, motion] = [f.text, f.motion].map(|numbers| Embeddings::new(numbers, f.width).unwrap());
    let pools: Vec<Vec<usize>> = (0..text.len() / POOL).map(|p| (p * POOL..(p + 1) * POOL).collect()).collect();
    let got = Retrieval::of(&text, &motion, &pools).unwrap();
    assert_eq!(got.precision, f.precision);
    near(got.distance, f.distance, 1e-12);
    let interval = Interval::of(&f.values);
    near(interval.mean, f.interval[0], 1e-12);
    near(interval.half_width, f.interval[1], 1e-12);
}

#[test]
fn embeddings_that_do_not_fit_are_refused() {
    assert!(Embeddings::new(vec![0.0; 7], 2).is_err() && Embeddings::new(Vec::new(), 0).is_err());
    let told = Embeddings::new(vec![0.0, 1.0, f32::NAN, 1.0], 2).unwrap_err().to_string();
    assert!(told.contains("embedding 1, number 0: expected a finite number, got NaN"), "{told}");
    let [a, b] = [2, 3].map(|width| Gaussian::of(&Embeddings::new(vec![1.0; 12], width).unwrap()).unwrap());
    assert!(frechet_distance(&a, &b).unwrap_err().to_string().contains("expected 2, got 3"));
    assert!(Gaussian::of(&Embeddings::new(vec![1.0; 2], 2).unwrap()).is_err());
}
