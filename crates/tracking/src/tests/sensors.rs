//! Contracts of the sensor model: noise and delays.

use super::*;

fn one(sensors: SensorSpec) -> Environment {
    let mut p = exact(plan(1));
    p.termination = Termination::NONE;
    p.sensors = sensors;
    environment(&p)
}

/// Rows of the policy and of the value function over some steps of one environment that follows a wild clip.
fn rows(e: &mut Environment, steps: usize) -> Vec<(Vec<f32>, Vec<f32>)> {
    e.reset(&[0], Some(&[Start::at(150)])).unwrap();
    let mut rows = vec![(e.actor_rows().to_vec(), e.critic_rows().to_vec())];
    for _ in 0..steps {
        e.step(&[0.3, -0.2], &mut StepOutcome::default()).unwrap();
        rows.push((e.actor_rows().to_vec(), e.critic_rows().to_vec()));
    }
    rows
}

#[test]
fn noise_is_on_what_is_measured_and_never_on_what_the_value_function_sees() {
    let noisy = SensorSpec { joint_position_noise: 0.1, ..SensorSpec::default() };
    let (mut clean, mut noised) = (one(SensorSpec::default()), one(noisy));
    let (clean_rows, noised_rows) = (rows(&mut clean, 200), rows(&mut noised, 200));
    let mut errors = Vec::new();
    for ((actor, critic), (told, truth)) in clean_rows.iter().zip(&noised_rows) {
        assert_eq!(critic, truth);
        for Part { name, range, .. } in clean.observation().parts() {
            if name == "joint_position" {
                errors.extend(range.map(|i| f64::from(told[i] - actor[i])));
            } else {
                assert_eq!(actor[range.clone()], told[range], "{name}");
            }
        }
    }
    // 402 samples: the deviation is known to 3.5%, the mean to 0.005.
    let mean = errors.iter().sum::<f64>() / errors.len() as f64;
    let deviation = (errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64).sqrt();
    assert!(mean.abs() < 0.02 && (deviation - 0.1).abs() < 0.015, "{mean} {deviation}");
}

#[test]
fn what_is_measured_is_seen_late_and_the_reference_on_time() {
    let mut late = one(SensorSpec { observation_delay: 3, ..SensorSpec::default() });
    let mut seen = std::collections::BTreeSet::new();
    for _ in 0..20 {
        let told = rows(&mut late, 12);
        let delay = late.episodes()[0].observation_delay as usize;
        seen.insert(delay);
        for t in 0..told.len() {
            let truth = &told[t.saturating_sub(delay)].1;
            for Part { name, range, .. } in late.observation().parts() {
                let measured = !(name.starts_with("reference") || name.contains("action"));
                let expected = if measured { &truth[range.clone()] } else { &told[t].1[range.clone()] };
                assert_eq!(&told[t].0[range], expected, "{name} at {t}, {delay} late");
            }
        }
    }
    assert_eq!(seen.into_iter().collect::<Vec<_>>(), [0, 1, 2, 3]);
}

#[test]
fn a_history_is_the_policys_own_earlier_rows_with_their_noise_and_delay() {
    let mut p = exact(plan(1));
    p.termination = Termination::NONE;
    p.sensors = SensorSpec { joint_velocity_noise: 0.1, observation_delay: 2, ..SensorSpec::default() };
    let plain = environment(&p);
    p.inputs.history = 3;
    let mut e = environment(&p);
    let spec = e.observation().clone();
    let (remembered, own) = (spec.remembered(), spec.size() - spec.history_size());
    // It is behind the others, and the value function does not see it.
    assert_eq!((own, e.critic_size()), (plain.actor_size(), plain.critic_size()));
    let told = rows(&mut e, 12);
    for (t, (row, _)) in told.iter().enumerate() {
        for (k, seen) in row[own..].chunks_exact(remembered.len()).enumerate() {
            let then = &told[(t + k).saturating_sub(3)].0;
            let expected: Vec<f32> = remembered.iter().map(|&number| then[number]).collect();
            assert_eq!(seen, expected, "step {t}, {} before", 3 - k);
        }
    }
    assert_ne!(told[11].0[own..][..remembered.len()], told[11].0[spec.size() - remembered.len()..]);
}

#[test]
fn targets_reach_the_motors_late() {
    let run = |action_delay: u32, actions: [f32; 6]| {
        let mut p = exact(plan(1));
        p.termination = Termination::NONE;
        p.action = ActionSpec::Absolute;
        p.sensors.action_delay = action_delay;
        let mut e = environment(&p);
        e.reset(&[0], Some(&[Start::at(150)])).unwrap();
        // The delay is drawn: again, until it is the greatest.
        while e.episodes()[0].action_delay != u64::from(action_delay) {
            e.reset(&[0], Some(&[Start::at(150)])).unwrap();
        }
        actions.map(|a| {
            e.step(&[a, -a], &mut StepOutcome::default()).unwrap();
            e.state().joint_position.clone()
        })
    };
    assert_eq!(run(2, [0.3, 0.9, 0.9, 0.9, 0.9, 0.9]), run(0, [0.3, 0.3, 0.3, 0.9, 0.9, 0.9]));
}

#[test]
fn a_policy_without_linear_velocity_never_sees_it() {
    let mut p = exact(plan(1));
    p.linear_velocity = false;
    let mut e = environment(&p);
    assert!(e.observation().parts().iter().all(|part| part.name != "root_linear_velocity_h"));
    let (before, all) = (e.actor_size(), environment(&exact(plan(1))).actor_size());
    assert_eq!(before + 3, all);
    e.reset(&[0], Some(&[Start::at(40)])).unwrap();
    assert_eq!(part(&e, e.actor_rows(), "joint_position"), library(&robot()).joints_at(40));
}
