//! Generalized advantage estimation (Schulman et al. 2016), with the two ends of an episode kept apart.
//!
//! A *terminated* episode has a future value of zero. A *truncated* one was only cut (time limit, end of a clip): its
//! future value is the value function of its last state. No later error is known, so the sum of errors stops there too.

/// Discounts of [`advantages`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Discounts {
    /// γ: what the next step is worth now.
    pub gamma: f32,
    /// λ: how far the estimate looks before it trusts the value function.
    pub lambda: f32,
}

/// Advantages of every step of a rollout.
///
/// # Shapes
/// All `[steps, environments]`, step after step. `values` are V(s_t), `next_values` V(s_{t+1}) of the state that the step
/// led to, BEFORE any reset; it is ignored where `terminated`.
pub fn advantages(
    discounts: Discounts,
    environments: usize,
    rewards: &[f32],
    values: &[f32],
    next_values: &[f32],
    terminated: &[bool],
    truncated: &[bool],
) -> Vec<f32> {
    let Discounts { gamma, lambda } = discounts;
    let mut out = vec![0.0; rewards.len()];
    let mut later = vec![0.0_f32; environments];
    for start in (0..rewards.len()).step_by(environments.max(1)).rev() {
        for (n, later) in later.iter_mut().enumerate() {
            let i = start + n;
            let future = if terminated[i] { 0.0 } else { next_values[i] };
            let error = rewards[i] + gamma * future - values[i];
            let carried = if terminated[i] || truncated[i] { 0.0 } else { gamma * lambda * *later };
            *later = error + carried;
            out[i] = *later;
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    const D: Discounts = Discounts { gamma: 0.5, lambda: 0.5 };

    fn run(terminated: [bool; 3], truncated: [bool; 3]) -> Vec<f32> {
        advantages(D, 1, &[1.0, 2.0, 4.0], &[3.0, 5.0, 7.0], &[5.0, 7.0, 8.0], &terminated, &truncated)
    }

    #[test]
    fn an_unbroken_rollout_by_hand() {
        // δ2 = 4 + .5·8 − 7 = 1; δ1 = 2 + .5·7 − 5 = .5; δ0 = 1 + .5·5 − 3 = .5.
        // A2 = 1; A1 = .5 + .25·1 = .75; A0 = .5 + .25·.75 = .6875.
        assert_eq!(run([false; 3], [false; 3]), [0.6875, 0.75, 1.0]);
    }

    #[test]
    fn termination_has_no_future() {
        // δ1 = 2 − 5 = −3 and nothing is carried into it; A0 = .5 + .25·(−3) = −.25.
        assert_eq!(run([false, true, false], [false; 3]), [-0.25, -3.0, 1.0]);
    }

    #[test]
    fn truncation_keeps_the_value_of_what_was_reached_but_nothing_later() {
        // δ1 = .5 as if unbroken, A1 = .5 without A2; A0 = .5 + .25·.5 = .625.
        assert_eq!(run([false; 3], [false, true, false]), [0.625, 0.5, 1.0]);
    }

    #[test]
    fn environments_do_not_mix() {
        let one = run([false, true, false], [false; 3]);
        let both = advantages(
            D,
            2,
            &[1.0, 9.0, 2.0, 9.0, 4.0, 9.0],
            &[3.0, 0.0, 5.0, 0.0, 7.0, 0.0],
            &[5.0, 0.0, 7.0, 0.0, 8.0, 0.0],
            &[false, false, true, false, false, false],
            &[false; 6],
        );
        assert_eq!(both.iter().step_by(2).copied().collect::<Vec<_>>(), one);
        // The other: δ = 9 everywhere; A2 = 9, A1 = 9 + 2.25, A0 = 9 + .25·11.25.
        assert_eq!(both.iter().skip(1).step_by(2).copied().collect::<Vec<_>>(), [11.8125, 11.25, 9.0]);
    }
}
