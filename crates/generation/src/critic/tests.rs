//! Contracts of the critic.

#![allow(clippy::unwrap_used)]

use lifelike_checkpoint::Checkpoint;

use super::network::CriticNetwork;
use super::*;
use crate::representation::{FeatureMatrix, RepresentationSpec, Standardizer};

const BOUNDS: Bounds = Bounds { low: -3.0, high: 9.0 };

/// 7 + 2 numbers: one joint.
fn spec() -> RepresentationSpec {
    RepresentationSpec::new(vec!["knee".into()])
}

fn noise(count: usize, seed: u64) -> Vec<f32> {
    lifelike_nn::init::normal(&mut lifelike_checkpoint::rng::stream(seed, "test", 0, 0), count, 1.0)
}

fn motion(n: usize, seed: u64) -> FeatureMatrix {
    FeatureMatrix::new(noise(n * 9, seed), 9).unwrap()
}

fn critic(radius: usize, hidden: &[usize]) -> Critic {
    let sizes = CriticNetwork::sizes((2 * radius + 1) * 9, hidden);
    let mut network = CriticNetwork::init(sizes, 4, 2.0, BOUNDS);
    let n = network.parameters().len();
    network.update(|values| values.iter_mut().zip(noise(n, 8)).for_each(|(x, z)| *x += 0.1 * z));
    let std = (0..9).map(|i| 0.3 + 0.2 * i as f32).collect();
    let header = CriticHeader {
        robot: "post".into(),
        controller: "00".into(),
        representation: spec(),
        standardizer: Standardizer { mean: vec![0.1; 9], std },
        radius,
        hidden: hidden.to_vec(),
        bounds: BOUNDS,
        gamma: 0.9,
        control_hz: 50.0,
        steps: 0,
        members: 1,
    };
    Critic::new(header, vec![network])
}

/// The sum of values in double precision, written out once more.
fn exact_sum(critic: &Critic, parameters: &[f32], rows: &[f64]) -> f64 {
    let header = critic.header();
    let (n, r) = (rows.len() / 9, header.radius as isize);
    let sizes = CriticNetwork::sizes((2 * header.radius + 1) * 9, &header.hidden);
    let value = |t: usize| {
        let mut x: Vec<f64> = Vec::new();
        for k in -r..=r {
            let row = (t as isize + k).clamp(0, n as isize - 1) as usize;
            let Standardizer { mean, std } = &header.standardizer;
            x.extend((0..9).map(|c| (rows[row * 9 + c] - f64::from(mean[c])) / f64::from(std[c])));
        }
        for (l, layer) in sizes.layers().iter().enumerate() {
            let (w, b) = (&parameters[layer.weight()], &parameters[layer.bias()]);
            let sum = |j: usize| {
                f64::from(b[j]) + (0..layer.inputs).map(|i| x[i] * f64::from(w[i * layer.outputs + j])).sum::<f64>()
            };
            let elu = |y: f64| if l + 1 < sizes.layers().len() && y < 0.0 { y.exp_m1() } else { y };
            x = (0..layer.outputs).map(|j| elu(sum(j))).collect();
        }
        3.0 + 6.0 * (x[0] / 6.0).tanh()
    };
    (0..n).map(value).sum()
}

#[test]
fn the_gradient_by_the_motion_is_that_of_differences_in_double_precision() {
    // Motions shorter than a window, of one panel, and of several.
    for (n, radius, hidden) in [(1, 2, &[8][..]), (5, 6, &[16, 8]), (60, 3, &[16, 16, 16]), (101, 0, &[12])] {
        let (critic, motion) = (critic(radius, hidden), motion(n, 3));
        let (values, by) = critic.gradient(&motion).unwrap();
        assert_eq!(values, critic.values(&motion).unwrap());
        let parameters = critic.networks()[0].parameters().to_vec();
        let rows: Vec<f64> = motion.rows.iter().map(|x| f64::from(*x)).collect();
        let sum: f64 = values.iter().map(|v| f64::from(*v)).sum();
        assert!((sum - exact_sum(&critic, &parameters, &rows)).abs() < 2e-5 * n as f64);
        let largest = by.rows.iter().fold(0.0_f32, |most, x| most.max(x.abs()));
        for i in (0..rows.len()).step_by(7) {
            let at = |delta: f64| {
                let mut rows = rows.clone();
                rows[i] += delta;
                exact_sum(&critic, &parameters, &rows)
            };
            // Central differences of 1e-5 are exact to 1e-10 of the third derivative, but where ELU bends.
            let expected = (at(1e-5) - at(-1e-5)) / 2e-5;
            let off = (f64::from(by.rows[i]) - expected).abs();
            assert!(off < 2e-5 * f64::from(largest), "{n} rows, number {i}: {} for {expected}", by.rows[i]);
        }
    }
}

/// Motions whose first column is constant and says the reward: v = r / (1 − γ).
fn data(motions: usize) -> CriticData {
    let level = |m: usize| 0.2 + 0.8 * m as f32 / motions as f32;
    let rows = |m: usize| {
        let mut motion = motion(40, m as u64);
        motion.rows.iter_mut().step_by(9).for_each(|x| *x = level(m));
        motion
    };
    let names = (0..motions).map(|m| format!("clip {m}")).collect();
    let mut records = RewardRecords::new(names, 50.0, motions);
    for frame in 0..90 {
        for m in 0..motions {
            records.sequence.push(m as u32);
            records.frame.push(frame);
            records.reward.push(level(m));
            records.end.push(if frame == 89 { StepEnd::Truncated } else { StepEnd::Continues });
        }
    }
    let (robot, controller) = ("post".into(), "00".into());
    CriticData {
        robot,
        controller,
        representation: spec(),
        motions: (0..motions).map(rows).collect(),
        others: Vec::new(),
        records,
    }
}

fn plan() -> CriticPlan {
    let hidden = vec![16];
    CriticPlan {
        window: 0.1,
        hidden,
        learning_rate: 3e-3,
        epochs: 80,
        minibatch: 96,
        validation: 0.2,
        members: 1,
        ..Default::default()
    }
}

#[test]
fn a_critic_learns_what_a_motion_promises_and_keeps_its_best_network() {
    let mut trainer = CriticTrainer::new(&plan(), 1, data(30)).unwrap();
    let first = trainer.epoch_once();
    let mut best = f64::NEG_INFINITY;
    for _ in 1..80 {
        trainer.epoch_once();
        best = best.max(trainer.validate_once().unwrap()[0]);
    }
    assert!(best > 0.9, "{best} of the variance on motions held out");
    let last = trainer.epoch_once();
    assert!(last.step.loss < 0.2 * first.step.loss, "{first:?} → {last:?}");
    // The mean reward is 0.2 + 0.8 · 14.5 / 30 = 0.587.
    let critic = trainer.critic();
    let realism = |m: usize| critic.realism(&data(30).motions[m]).unwrap();
    assert!((realism(3) - 2.8).abs() < 0.8 && (realism(27) - 9.2).abs() < 0.8, "{} {}", realism(3), realism(27));
}

#[test]
fn the_least_of_three_members_is_the_value_and_has_its_gradient_and_a_file_carries_all() {
    let mut trainer = CriticTrainer::new(&CriticPlan { members: 3, ..plan() }, 1, data(12)).unwrap();
    for _ in 0..4 {
        trainer.epoch_once();
        trainer.validate_once().unwrap();
    }
    let critic = trainer.critic();
    assert_eq!((critic.header().members, critic.networks().len()), (3, 3));
    let single = |member: usize| {
        let header = CriticHeader { members: 1, ..critic.header().clone() };
        Critic::new(header, vec![critic.networks()[member].clone()])
    };
    let motion = motion(70, 9);
    let all: Vec<_> = (0..3).map(|member| single(member).values(&motion).unwrap()).collect();
    let least: Vec<f32> = (0..70).map(|row| all[0][row].min(all[1][row]).min(all[2][row])).collect();
    let (values, by) = critic.gradient(&motion).unwrap();
    assert!(values == least && critic.values(&motion).unwrap() == least);
    assert!((0..3).filter(|member| all[*member] == least).count() == 0, "no member is the least everywhere");
    // By differences: members change places at no row between two values so near.
    let sum = |rows: Vec<f32>| -> f64 {
        let values = critic.values(&FeatureMatrix::new(rows, 9).unwrap()).unwrap();
        values.iter().map(|v| f64::from(*v)).sum()
    };
    let largest = by.rows.iter().fold(0.0_f32, |most, x| most.max(x.abs()));
    for i in (0..motion.rows.len()).step_by(37) {
        let at = |delta: f32| {
            let mut rows = motion.rows.clone();
            rows[i] += delta;
            sum(rows)
        };
        let expected = ((at(0.01) - at(-0.01)) / 0.02) as f32;
        assert!((by.rows[i] - expected).abs() < 0.02 * largest, "{i}: {} for {expected}", by.rows[i]);
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("three.critic.safetensors");
    critic.save(&path).unwrap();
    assert_eq!(Critic::load(&path).unwrap().values(&motion).unwrap(), least);
}

#[test]
fn other_rows_share_the_records_of_their_sequence() {
    // Rewards are told by the first column of the raw rows alone; the grounded ones have nothing that tells them.
    let blind = |mut data: CriticData| {
        data.others =
            (0..data.motions.len()).map(|s| OtherRows { sequence: s, rows: data.motions[s].clone() }).collect();
        data.motions.iter_mut().for_each(|motion| motion.rows.iter_mut().step_by(9).for_each(|x| *x = 0.0));
        data
    };
    let mut trainer = CriticTrainer::new(&plan(), 1, blind(data(30))).unwrap();
    for _ in 0..80 {
        trainer.epoch_once();
    }
    let critic = trainer.critic();
    let realism = |m: usize| critic.realism(&data(30).motions[m]).unwrap();
    // 1 / (1 - 0.9) = 10 times the levels 0.28 and 0.92.
    assert!((realism(3) - 2.8).abs() < 1.2 && (realism(27) - 9.2).abs() < 1.2, "{} {}", realism(3), realism(27));
    let mut wrong = blind(data(5));
    wrong.others[2].rows = motion(70, 1);
    assert!(CriticTrainer::new(&plan(), 1, wrong).err().unwrap().to_string().contains("other rows of 'clip 2'"));
}

#[test]
fn a_saved_training_goes_on_bit_for_bit_on_any_number_of_threads() {
    let file = |threads: usize, stop: bool| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let mut trainer = CriticTrainer::new(&plan(), 1, data(12)).unwrap();
            for epoch in 0..6 {
                trainer.epoch_once();
                trainer.validate_once();
                if stop && epoch == 2 {
                    let bytes = trainer.save().unwrap().to_bytes().unwrap();
                    trainer = CriticTrainer::new(&plan(), 1, data(12)).unwrap();
                    trainer.load(&Checkpoint::from_bytes(&bytes, "here".as_ref()).unwrap()).unwrap();
                }
            }
            trainer.save().unwrap().to_bytes().unwrap()
        })
    };
    let whole = file(1, false);
    assert!(whole == file(3, false) && whole == file(2, true));
}

#[test]
fn no_motion_is_promised_more_than_rewards_can_sum_to() {
    assert_eq!(Bounds::of_rewards(&[0.5, 1.0, -0.25], 0.5), Bounds { low: -0.5, high: 2.0 });
    let bounds = Bounds::of_rewards(&[0.0], 0.5);
    assert!(bounds.low < bounds.high);
    let far: Vec<f32> = motion(40, 5).rows.iter().map(|x| 1e4 * x).collect();
    let values = critic(2, &[16]).values(&FeatureMatrix::new(far, 9).unwrap()).unwrap();
    assert!(values.iter().all(|v| (BOUNDS.low..=BOUNDS.high).contains(v)), "{values:?}");
}

#[test]
fn a_file_gives_the_same_values_and_another_file_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.critic.safetensors");
    let saved = critic(2, &[16, 8]);
    saved.save(&path).unwrap();
    let read = Critic::load(&path).unwrap();
    assert_eq!(
        (read.header(), read.values(&motion(50, 1)).unwrap()),
        (saved.header(), saved.values(&motion(50, 1)).unwrap())
    );
    read.check(&spec()).unwrap();
    let other = RepresentationSpec::new(vec!["elbow".into()]);
    assert!(read.check(&other).unwrap_err().to_string().contains("elbow"));
    let wide = FeatureMatrix::new(vec![0.0; 22], 11).unwrap();
    assert!(read.values(&wide).unwrap_err().to_string().contains("at least one row of 9"));
    Checkpoint::new().save(&path).unwrap();
    assert!(Critic::load(&path).is_err());
    let mut header = saved.header().clone();
    header.standardizer.std[2] = 0.0;
    Critic::new(header, saved.networks().to_vec()).save(&path).unwrap();
    assert!(Critic::load(&path).unwrap_err().to_string().contains("above 0"));
}

#[test]
fn records_that_do_not_fit_the_motions_are_refused() {
    let wrong = |change: &dyn Fn(&mut CriticData)| {
        let mut data = data(5);
        change(&mut data);
        CriticTrainer::new(&plan(), 1, data).err().unwrap().to_string()
    };
    assert!(wrong(&|d| d.records.frame[7] = 500).contains("frame 500"));
    assert!(wrong(&|d| d.records.reward[3] = f32::NAN).contains("finite"));
    assert!(wrong(&|d| drop(d.motions.pop())).contains("expected 5, got 4"));
    assert!(wrong(&|d| d.representation = RepresentationSpec::new(vec![])).contains("7"));
    let bad = CriticPlan { gamma: 1.0, ..plan() };
    let error = CriticTrainer::new(&bad, 1, data(5)).err().unwrap().to_string();
    assert!(error.contains("critic.gamma"), "{error}");
}

#[test]
fn a_gradient_that_is_not_finite_is_skipped_and_counted() {
    let mut trainer = CriticTrainer::new(&plan(), 1, data(10)).unwrap();
    trainer.epoch_once();
    let before = trainer.critic().networks()[0].parameters().to_vec();
    let rewards = trainer.data.records.reward.clone();
    trainer.data.records.reward.fill(f32::NAN);
    let skipped = trainer.epoch_once().step.skipped;
    assert!(skipped > 0 && trainer.critic().networks()[0].parameters() == before, "{skipped}");
    trainer.data.records.reward = rewards;
    let next = trainer.epoch_once().step;
    assert!(next.skipped == skipped && next.loss.is_finite(), "{next:?}");
    assert!(trainer.critic().networks()[0].parameters() != before);
}
