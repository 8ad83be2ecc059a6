//! Losses that are minimised (thesis 2.4.2 and 2.5.4).

use lifelike_sim::trace::Selected;

use crate::model::{Frame, Inputs, Scales};

/// Kinds of losses (Fig. 2.12).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum LossKind {
    /// |Δs - Δs̄|.
    L1,
    /// L1, and |d/dt θ(Δs) - θ̇(Δs)| (eq. 2.3).
    #[default]
    Physics,
    /// The pinball loss of the 10%, 50% and 90% quantiles.
    Quantile,
}

/// Quantiles of [`LossKind::Quantile`]; the one in the middle is the prediction.
const QUANTILES: [f32; 3] = [0.1, 0.5, 0.9];

impl LossKind {
    /// Returns how many numbers the network makes for each output.
    pub fn quantiles(self) -> usize {
        if self == Self::Quantile { QUANTILES.len() } else { 1 }
    }

    /// Returns the predictions among the network's numbers.
    pub fn predictions(self, out: Vec<f32>) -> Vec<f32> {
        match self {
            Self::Quantile => out.into_iter().skip(QUANTILES.len() / 2).step_by(QUANTILES.len()).collect(),
            Self::L1 | Self::Physics => out,
        }
    }
}

/// A loss for one class' outputs.
#[derive(Debug, Clone, PartialEq)]
pub struct Loss {
    kind: LossKind,
    outputs: usize,
    /// Outputs that are a position and its velocity, and what a position's change over two steps is in units of the velocity.
    pairs: Vec<(usize, usize, f32)>,
    weight: f32,
}

impl Loss {
    /// Returns the loss; positions and velocities are found by their names (`position_x`, `velocity_x`).
    pub fn new(kind: LossKind, inputs: &Inputs, scales: &Scales, weight: f64) -> Self {
        let named = |name: &str| inputs.selection.iter().position(|row| row.measured == name);
        let pair = |(p, row): (usize, &Selected)| {
            let v = named(&row.measured.replacen("position", "velocity", 1)).filter(|v| *v != p)?;
            Some((p, v, scales.error[p] * inputs.rate as f32 / (2.0 * scales.error[v])))
        };
        let pairs = match kind {
            // In axes that turn, a place's change is not its velocity.
            LossKind::Physics if inputs.frame == Frame::Parent && named("position_x").is_some() => Vec::new(),
            LossKind::Physics => inputs.selection.iter().enumerate().filter_map(pair).collect(),
            LossKind::L1 | LossKind::Quantile => Vec::new(),
        };
        Self { kind, outputs: inputs.selection.len(), pairs, weight: weight as f32 }
    }

    /// Returns the loss of some sequences, as a sum, and its gradient.
    ///
    /// # Shapes
    /// `out: [steps, sequences, outputs · quantiles]`, `error: [steps, sequences, outputs]`.
    pub fn of(&self, out: &[f32], error: &[f32], sequences: usize) -> (f64, Vec<f32>) {
        let mut gradient = vec![0.0; out.len()];
        let mut sum = 0.0_f64;
        if self.kind == LossKind::Quantile {
            let numbers = out.as_chunks::<3>().0.iter().zip(error);
            for ((out, error), gradient) in numbers.zip(gradient.as_chunks_mut::<3>().0) {
                for ((out, quantile), gradient) in out.iter().zip(QUANTILES).zip(gradient) {
                    let missing = error - out;
                    sum += f64::from((quantile * missing).max((quantile - 1.0) * missing));
                    *gradient = if missing > 0.0 { -quantile } else { 1.0 - quantile };
                }
            }
            return (sum, gradient);
        }
        for ((out, error), gradient) in out.iter().zip(error).zip(&mut gradient) {
            sum += f64::from((out - error).abs());
            *gradient = sign(out - error);
        }
        // Central differences: a one-sided one would be half a step late.
        let (row, steps) = (sequences * self.outputs, out.len() / (sequences * self.outputs).max(1));
        for step in 1..steps.saturating_sub(1) {
            for sequence in 0..sequences {
                for &(p, v, factor) in &self.pairs {
                    let at = |step: usize, output: usize| step * row + sequence * self.outputs + output;
                    let (before, after, velocity) = (at(step - 1, p), at(step + 1, p), at(step, v));
                    let difference = factor * (out[after] - out[before]) - out[velocity];
                    sum += f64::from(self.weight * difference.abs());
                    let slope = self.weight * sign(difference);
                    gradient[after] += slope * factor;
                    gradient[before] -= slope * factor;
                    gradient[velocity] -= slope;
                }
            }
        }
        (sum, gradient)
    }
}

/// The sign; 0 of 0.
fn sign(x: f32) -> f32 {
    if x == 0.0 { 0.0 } else { x.signum() }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use lifelike_sim::trace::{BlockTrace, Columns};

    use super::*;

    fn loss(kind: LossKind) -> Loss {
        let three = [0.0, 1.0, 2.0];
        let mut block = BlockTrace {
            simulated: Columns::new(&[("position", &three), ("velocity", &three)]),
            measured: Columns::new(&[("position", &three), ("velocity", &three)]),
            ..BlockTrace::default()
        };
        block.selection = block.by_name();
        let inputs = Inputs::of(&block, 10.0, &[], &[]).unwrap();
        Loss::new(kind, &inputs, &Scales { mean: vec![], std: vec![], error: vec![0.2, 0.5] }, 0.7)
    }

    /// Steps, sequences and outputs of 5 x 2 x 2 numbers that no two terms have a kink at.
    fn numbers(seed: f32, count: usize) -> Vec<f32> {
        (0..count).map(|i| ((i as f32 + seed) * 1.7).sin()).collect()
    }

    #[test]
    fn the_gradient_is_the_derivative() {
        for kind in [LossKind::L1, LossKind::Physics, LossKind::Quantile] {
            let (loss, mut out, error) = (loss(kind), numbers(0.3, 20 * kind.quantiles()), numbers(5.1, 20));
            let (_, gradient) = loss.of(&out, &error, 2);
            for i in 0..out.len() {
                let (own, step) = (out[i], 1e-3);
                out[i] = own + step;
                let more = loss.of(&out, &error, 2).0;
                out[i] = own - step;
                let less = loss.of(&out, &error, 2).0;
                out[i] = own;
                let expected = (more - less) / (2.0 * f64::from(step));
                assert!((expected - f64::from(gradient[i])).abs() < 5e-3, "{kind:?} {i}: {expected} {}", gradient[i]);
            }
        }
    }

    #[test]
    fn a_position_whose_change_is_its_velocity_costs_nothing() {
        let loss = loss(LossKind::Physics);
        // One sequence: 0.2 p is a ramp of 0.1 rad a step at 10 Hz, so 0.5 v is 1 rad/s.
        let out: Vec<f32> = (0..6).flat_map(|i| [0.5 * i as f32, 2.0]).collect();
        assert!(loss.of(&out, &out, 1).0 < 1e-5);
        let wrong: Vec<f32> = (0..6).flat_map(|i| [0.5 * i as f32, 1.0]).collect();
        // Four inner steps, each off by 1, weight 0.7.
        assert!((loss.of(&wrong, &wrong, 1).0 - 2.8).abs() < 1e-5);
    }
}
