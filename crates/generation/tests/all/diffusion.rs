//! Schedules and samplers against numpy (`fixtures/make_diffusion.py`).

use std::collections::BTreeMap;
use std::convert::Infallible;

use lifelike_generation::diffusion::{Known, Sampler, Schedule, guide};

struct Fixture(BTreeMap<String, Vec<f64>>);

impl Fixture {
    fn read() -> Self {
        Self(serde_json::from_str(include_str!("../fixtures/diffusion.json")).unwrap())
    }

    fn f32s(&self, name: &str) -> Vec<f32> {
        self.0[name].iter().map(|x| *x as f32).collect()
    }

    /// Single precision: a few roundings of numbers around 1.
    fn close(&self, name: &str, got: &[f32]) {
        let expected = &self.0[name];
        assert_eq!(got.len(), expected.len());
        assert!(
            got.iter().zip(expected).all(|(a, b)| (f64::from(*a) - b).abs() < 1e-6),
            "{name}: {got:?} {expected:?}"
        );
    }
}

#[test]
fn the_schedule_and_its_noise_are_numpys() {
    let f = Fixture::read();
    for steps in [50, 1000] {
        let schedule = Schedule::cosine(steps);
        assert_eq!(schedule.len(), steps);
        for (d, expected) in f.0[&format!("{steps}.remaining")].iter().enumerate() {
            let got = schedule.remaining(Some(d));
            assert!((got - expected).abs() < 1e-10 * expected.max(1e-9), "{steps}, {d}: {got} {expected}");
        }
        f.close(&format!("{steps}.noisy"), &schedule.add_noise(&f.f32s("clean"), &f.f32s("noise"), steps / 3));
    }
}

#[test]
fn steps_are_those_of_ddpm_and_ddim() {
    let f = Fixture::read();
    for steps in [50, 1000] {
        let schedule = Schedule::cosine(steps);
        let d = steps / 3;
        let step = |eta: f64, next: usize| {
            let mut motion = f.f32s("motion");
            let places = (d, Some(next));
            Sampler { steps, eta }.step(&schedule, places, &mut motion, &f.f32s("clean"), &f.f32s("noise"));
            motion
        };
        f.close(&format!("{steps}.ddpm"), &step(1.0, d - 1));
        for eta in [0.0, 0.5] {
            f.close(&format!("{steps}.ddim.{eta:?}"), &step(eta, d / 2));
        }
    }
}

#[test]
fn steps_are_spread_from_the_last_to_the_first() {
    let schedule = Schedule::cosine(1000);
    assert_eq!(schedule.spread(1), [999]);
    assert_eq!(schedule.spread(4), [999, 666, 333, 0]);
    assert_eq!(schedule.spread(5000).len(), 1000);
    assert_eq!(Schedule::cosine(50).spread(50), (0..50).rev().collect::<Vec<_>>());
}

/// Of data that is normal with mean 3 and standard deviation 0.5 the best prediction is known, so samples must have
/// those moments: 2000 of them, within four standard errors and what 50 steps leave.
#[test]
fn samples_of_a_normal_distribution_are_normal() {
    use lifelike_checkpoint::rng::stream;
    use rand_distr::{Distribution, StandardNormal};
    let (mean, std, n) = (3.0_f64, 0.5_f64, 2000);
    let schedule = Schedule::cosine(50);
    for (steps, eta, slack) in [(50, 1.0, 0.03), (50, 0.0, 0.03), (25, 0.0, 0.05)] {
        let draw = |m: usize, d: usize, out: &mut [f32]| {
            let mut rng = stream(1, "test", m as u64, d as u64);
            out.iter_mut().for_each(|x| *x = StandardNormal.sample(&mut rng));
        };
        let mut first = vec![vec![0.0; n]];
        draw(0, 999, &mut first[0]);
        let predict = |motions: &[Vec<f32>], d: usize| -> Result<_, Infallible> {
            let left = schedule.remaining(Some(d));
            let gain = left.sqrt() * std * std / (left * std * std + 1.0 - left);
            let of = |x: &f32| (mean + gain * (f64::from(*x) - left.sqrt() * mean)) as f32;
            Ok(motions.iter().map(|motion| motion.iter().map(of).collect()).collect())
        };
        let motions = Sampler { steps, eta }.sample(&schedule, first, &[], draw, predict).unwrap();
        let got_mean = motions[0].iter().map(|x| f64::from(*x)).sum::<f64>() / n as f64;
        let got_std = (motions[0].iter().map(|x| (f64::from(*x) - got_mean).powi(2)).sum::<f64>() / n as f64).sqrt();
        assert!((got_mean - mean).abs() < 0.045, "{steps} {eta}: {got_mean}");
        assert!((got_std - std).abs() < 0.032 + slack, "{steps} {eta}: {got_std}");
    }
}

#[test]
fn what_is_known_is_there_at_the_end() {
    let schedule = Schedule::cosine(50);
    let known = Known::nothing(vec![7.0; 8], 2).prefix(2);
    let predict = |motions: &[Vec<f32>], _| -> Result<_, Infallible> { Ok(motions.to_vec()) };
    let motions = Sampler { steps: 10, eta: 1.0 }
        .sample(&schedule, vec![vec![1.0; 8]; 2], &[Some(known), None], |_, _, _| {}, predict)
        .unwrap();
    assert_eq!(motions[0][..4], [7.0; 4]);
    assert!(motions[0][4..].iter().chain(&motions[1]).all(|x| *x != 7.0));
}

#[test]
fn guidance_goes_beyond_the_prompt() {
    let mut told = [1.0, 2.0];
    guide(&mut told, &[0.0, 2.0], 2.5);
    assert_eq!(told, [2.5, 2.0]);
}
