//! The terms by hand arithmetic.
#![allow(clippy::unwrap_used)]

use lifelike_motion::FeatureLayout;

use super::*;

fn layout() -> FeatureLayout {
    FeatureLayout { joints: vec!["knee".into(), "hip".into()], end_effectors: vec!["foot".into()] }
}

/// h, R = 1, v, q, q̇, p.
fn rest() -> Vec<f32> {
    let mut f = vec![0.0; layout().size()];
    f[1] = 1.0;
    f[5] = 1.0;
    f
}

const STILL: ActionCost<'_> =
    ActionCost { action: &[0.0; 2], previous: &[0.0; 2], oldest: &[0.0; 2], scale: 1.0, torque_squared: 0.0 };

/// Without the terms that are not in the thesis, as in a plan that does not name them.
fn table_4_1() -> ThesisReward {
    let text = "height = 0.5\norientation = 1.0\nvelocity = 2.0\njoint_position = 7.0\njoint_velocity = 0.1\n\
        effectors = 1.0\nalive = 30.0\naction_rate = 1.5\naction_acceleration = 0.45\ntorque = 1e-4\n\
        scale = 1.0\nterm_limit = inf\n\
        floors = { height = 0.0, velocity = 0.0, joint_position = 0.0, joint_velocity = 0.0, effectors = 0.0 }";
    toml::from_str(text).unwrap()
}

fn inputs<'a>(
    layout: &'a FeatureLayout,
    simulated: &'a [f32],
    reference: &'a [f32],
    divisor: &'a [f32],
) -> RewardInputs<'a> {
    RewardInputs {
        layout,
        simulated,
        reference,
        divisor,
        heading: 0.0,
        path: 0.0,
        slip_square: 0.0,
        missed_swings: 0.0,
        cost: STILL,
    }
}

fn term(terms: &TermValues, name: &str) -> f32 {
    TERMS.iter().position(|t| t.name == name).map_or(f32::NAN, |i| terms[i])
}

#[test]
fn a_curriculum_of_smoothness_scales_the_penalties_and_nothing_else() {
    let mut values = [1.0; TERMS.len()];
    scale_penalties(&mut values, 0.5);
    let scaled: Vec<_> = TERMS.iter().zip(values).filter(|(_, v)| *v != 1.0).map(|(term, _)| term.name).collect();
    assert_eq!(scaled, ["action_rate", "action_acceleration", "torque"]);
}

#[test]
fn norms_are_sums_over_components_or_their_means() {
    let layout = layout();
    let (reference, divisor) = (rest(), vec![1.0; layout.size()]);
    // One standard deviation off in every normalised feature; the orientation is exact.
    let simulated: Vec<f32> = rest()
        .iter()
        .enumerate()
        .map(|(i, x)| if FeatureLayout::ORIENTATION.contains(&i) { *x } else { x + 1.0 })
        .collect();
    let tracking = |norm: Norm| -> f32 {
        let terms = ThesisReward { norm, ..table_4_1() }.terms(&inputs(&layout, &simulated, &reference, &divisor));
        ["height", "velocity", "joint_position", "joint_velocity", "effectors"]
            .map(|name| term(&terms, name))
            .iter()
            .sum()
    };
    // 1 height, 6 velocities, 2 joints, 2 joint velocities, 3 coordinates of a foot.
    assert!((tracking(Norm::Sum) + 0.5 + 2.0 * 6.0 + 7.0 * 2.0 + 0.1 * 2.0 + 3.0).abs() < 1e-4);
    assert!((tracking(Norm::Mean) + 0.5 + 2.0 + 7.0 + 0.1 + 1.0).abs() < 1e-4);
}

#[test]
fn the_thesis_terms_by_hand() {
    let layout = layout();
    let reference = rest();
    let mut simulated = rest();
    simulated[0] = 0.2; // height error 0.2
    simulated[7] = 0.5; // vx error 0.5
    simulated[13] = 0.1; // knee error 0.1
    simulated[16] = 2.0; // hip velocity error 2
    simulated[18] = 0.3; // foot error 0.3 in y
    let mut divisor = vec![1.0; layout.size()];
    divisor[0] = 0.1;
    divisor[13] = 0.5;
    let cost = ActionCost {
        action: &[0.6, 0.0],
        previous: &[0.2, 0.0],
        oldest: &[0.0, 0.4],
        scale: 0.5,
        torque_squared: 400.0,
    };
    let inputs = inputs(&layout, &simulated, &reference, &divisor);
    let terms = Reward::Thesis(table_4_1()).terms(&RewardInputs { heading: 1.0, path: 1.0, cost, ..inputs });
    let expected = [
        ("height", -0.5 * 4.0),
        ("orientation", 0.0),
        ("velocity", -2.0 * 0.25),
        ("joint_position", -7.0 * 0.04),
        ("joint_velocity", -0.1 * 4.0),
        ("effectors", -0.09),
        ("alive", 30.0),
        ("heading", 0.0),
        ("path", 0.0),
        ("action_rate", -1.5 * 0.04),
        // (0.3 − 0.2 + 0)² + (0 − 0 + 0.2)²
        ("action_acceleration", -0.45 * (0.01 + 0.04)),
        ("torque", -0.04),
    ];
    for (name, value) in expected {
        assert!((term(&terms, name) - value).abs() < 1e-5, "{name}: {} not {value}", term(&terms, name));
    }
}

#[test]
fn a_quarter_turn_is_four_in_the_frobenius_norm() {
    // ‖R − R'‖²_F = 4 (1 − cos φ) for an angle φ; the third column counts: without it the answer for a turn about x
    // would be 2.
    let mut turned = rest();
    turned[FeatureLayout::ORIENTATION].copy_from_slice(&[1.0, 0.0, 0.0, 0.0, 0.0, 1.0]);
    let square = inputs(&layout(), &turned, &rest(), &[]).orientation_square();
    assert!((square - 4.0).abs() < 1e-6, "{square}");
}

#[test]
fn height_counts_only_when_upright_and_the_posture_only_when_both_are_near_one() {
    let joint_position = Kernel::new(0.0, 5.0);
    let reward = Reward::Exponential(ExponentialReward { get_up: 2.0, joint_position, ..ExponentialReward::default() });
    let (layout, mut reference) = (layout(), rest());
    reference[0] = 0.8;
    let value = |height: f32, columns: [f32; 6], knee: f32| {
        let mut simulated = reference.clone();
        (simulated[0], simulated[13]) = (height, knee);
        simulated[FeatureLayout::ORIENTATION].copy_from_slice(&columns);
        term(&reward.terms(&inputs(&layout, &simulated, &reference, &[])), "get_up")
    };
    let upright = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    // Leaning forward by an angle with cosine 0.6 and sine 0.8.
    let leaning = [0.6, 0.0, -0.8, 0.0, 1.0, 0.0];
    let lying = [0.0, 0.0, -1.0, 0.0, 1.0, 0.0];
    let head_down = [-1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    let cases = [
        (0.8, upright, 0.0, 4.0),
        // One of two joints is 0.4 rad off.
        (0.8, upright, 0.4, 2.0 + 2.0 * (-0.4_f32).exp()),
        (0.4, upright, 0.0, 2.0 * (0.5 + 0.5_f32.powi(8))),
        (0.4, leaning, 0.0, 2.0 * (0.3 + 0.3_f32.powi(8))),
        (0.8, lying, 0.0, 0.0),
        (0.8, head_down, 0.0, 0.0),
        (1.0, upright, 0.0, 4.0),
    ];
    for (height, columns, knee, expected) in cases {
        let got = value(height, columns, knee);
        assert!((got - expected).abs() < 1e-5, "{height} {columns:?} {knee}: {got} not {expected}");
    }
}

#[test]
fn a_reward_without_a_limit_is_read_back_from_a_checkpoint() {
    let reward = table_4_1();
    assert_eq!(reward.term_limit, f32::INFINITY);
    let mut checkpoint = lifelike_checkpoint::Checkpoint::new();
    checkpoint.set_meta("reward", &reward).unwrap();
    assert_eq!(checkpoint.meta::<ThesisReward>("reward").unwrap(), reward);
}

#[test]
fn a_term_limit_bounds_each_term_and_scale_multiplies_all() {
    let layout = layout();
    let mut simulated = rest();
    simulated[13] = 10.0;
    let reference = rest();
    let reward = ThesisReward { term_limit: 5.0, scale: 0.5, ..table_4_1() };
    let divisor = vec![1.0; layout.size()];
    let terms = Reward::Thesis(reward).terms(&inputs(&layout, &simulated, &reference, &divisor));
    assert_eq!((term(&terms, "joint_position"), term(&terms, "alive")), (-2.5, 15.0));
}

#[test]
fn floors_raise_small_deviations_and_leave_the_orientation_alone() {
    let floors = Floors { height: 0.1, velocity: 1.0, joint_position: 0.5, joint_velocity: 3.0, effectors: 0.12 };
    let mut deviation = vec![0.01; layout().size()];
    deviation[7] = 2.0;
    let out = floors.apply(&layout(), &deviation);
    assert_eq!((out[0], out[1], out[7], out[8], out[13], out[15], out[17]), (0.1, 1.0, 2.0, 1.0, 0.5, 3.0, 0.12));
}

#[test]
fn the_exponential_terms_by_hand() {
    let k = Kernel::new;
    let reward = Reward::Exponential(ExponentialReward {
        height: k(0.1, 150.0),
        orientation: k(0.15, 4.0),
        velocity: k(0.2, 4.0),
        angular_share: 0.5,
        joint_position: k(0.35, 40.0),
        joint_velocity: k(0.1, 0.8),
        effectors: k(0.2, 160.0),
        heading: k(0.3, 2.0),
        path: k(0.4, 3.0),
        alive: 0.05,
        slip: 0.2,
        swing: 0.3,
        ..ExponentialReward::default()
    });
    let layout = layout();
    let reference = rest();
    let best = reward.terms(&inputs(&layout, &reference, &reference, &[]));
    assert!((best.iter().sum::<f32>() - 1.85).abs() < 1e-6, "all kernels at their weight");
    let mut simulated = rest();
    simulated[0] = 0.1;
    simulated[7] = 0.5;
    simulated[10] = 1.0;
    simulated[13] = 0.2;
    simulated[15] = 1.0;
    simulated[17] = 0.1;
    let cost = ActionCost { action: &[1.0, 0.0], torque_squared: 100.0, ..STILL };
    let inputs = inputs(&layout, &simulated, &reference, &[]);
    let terms =
        reward.terms(&RewardInputs { heading: 0.5, path: 2.0, slip_square: 0.3, missed_swings: 2.0, cost, ..inputs });
    let e = |x: f32| x.exp();
    let expected = [
        ("height", 0.1 * e(-1.5)),
        ("velocity", 0.2 * e(-4.0 * (0.25 + 0.5))),
        ("joint_position", 0.35 * e(-40.0 * 0.02)),
        ("joint_velocity", 0.1 * e(-0.8 * 0.5)),
        ("effectors", 0.2 * e(-1.6)),
        ("heading", 0.3 * e(-0.5)),
        ("path", 0.4 * e(-12.0)),
        ("alive", 0.05),
        ("slip", -0.06),
        ("swing", -0.6),
        ("action_rate", -0.05),
        ("action_acceleration", -0.015),
        ("torque", -1e-3),
    ];
    for (name, value) in expected {
        assert!((term(&terms, name) - value).abs() < 1e-6, "{name}: {} not {value}", term(&terms, name));
    }
}

#[test]
fn a_plan_of_before_paths_were_rewarded_still_has_a_reward() {
    let text = "kind = \"thesis\"\nheight = 0.0\norientation = 1.0\nvelocity = 2.0\njoint_position = 7.0\n\
        joint_velocity = 0.1\neffectors = 1.0\nalive = 30.0\naction_rate = 1.5\naction_acceleration = 0.45\n\
        torque = 1e-4\nscale = 0.02\nterm_limit = 150.0\n\
        floors = { height = 0.1, velocity = 1.0, joint_position = 0.5, joint_velocity = 3.0, effectors = 0.12 }";
    let reward: Result<Reward, _> = toml::from_str(text);
    assert!(matches!(reward, Ok(Reward::Thesis(r)) if r.path == 0.0 && r.heading == 0.0 && r.alive == 30.0));
}

#[test]
fn sums_of_any_length_are_those_in_double_precision_within_rounding() {
    for n in [0, 1, 7, 8, 9, 31, 32, 200] {
        let values =
            |shift: usize| -> Vec<f32> { (0..n).map(|i| ((i * 37 + shift) % 23) as f32 * 0.3 - 3.0).collect() };
        let (x, y) = (values(1), values(5));
        let exact: f64 = x.iter().zip(&y).map(|(x, y)| (f64::from(*x) - f64::from(*y)).powi(2)).sum();
        assert!((f64::from(squared_distance(&x, &y)) - exact).abs() <= 1e-6 * exact, "{n}");
    }
}
