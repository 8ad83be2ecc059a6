//! Adam (Kingma & Ba 2015) and RAdam (Liu et al. 2020), with PyTorch's formulas and defaults, and Muon beside Adam.
//!
//! The moments stand in rows like the parameters'. They are saved bit for bit by name, so a resumed run continues as if it had not
//! stopped.

use std::ops::Range;

use lifelike_checkpoint::{Checkpoint, CheckpointError};
use lifelike_dense::{AdamStep, Slices, norm};
use lifelike_simd::InstructionSet;

use crate::muon;
use crate::rows::Layout;

/// Update rule.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Rule {
    /// Kingma & Ba 2015, Algorithm 1.
    Adam,
    /// Liu et al. 2020, Algorithm 2: plain momentum until the variance of the adaptive step is tractable, rectified after.
    Radam,
    /// Jordan et al. 2024: matrices of transformer and residual blocks by their orthogonalized momentum, everything else by Adam.
    Muon,
}

/// Constants of the optimizer; the learning rate is an argument of [`Adam::step`].
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AdamConfig {
    /// Adam, RAdam or Muon.
    pub rule: Rule,
    /// Decay of the first moment.
    pub beta_1: f64,
    /// Decay of the second moment.
    pub beta_2: f64,
    /// Added to the root of the second moment.
    pub epsilon: f64,
}

impl AdamConfig {
    /// Returns PyTorch's defaults for Adam: β = (0.9, 0.999), ε = 1e-8.
    pub fn adam() -> Self {
        Self { rule: Rule::Adam, beta_1: 0.9, beta_2: 0.999, epsilon: 1e-8 }
    }

    /// Returns PyTorch's defaults for RAdam, the same numbers.
    pub fn radam() -> Self {
        Self { rule: Rule::Radam, ..Self::adam() }
    }
}

/// Gradient of one step, and how far it may go.
#[derive(Debug, Clone, Copy)]
pub struct Descent<'a> {
    /// Derivative of the loss by each parameter.
    pub gradient: &'a [f32],
    /// Bound on the gradient's norm, as PyTorch's `clip_grad_norm_`: it is scaled by `max_norm / (norm + 1e-6)` where that is below one.
    pub max_norm: f64,
    /// Learning rate.
    pub rate: f64,
}

/// Outcome of a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stepped {
    /// Norm of the gradient before clipping.
    pub norm: f64,
    /// False where the norm was not finite: then neither parameters nor moments have changed.
    pub taken: bool,
}

/// The optimizer with its state, for one row of parameters.
#[derive(Debug, Clone, PartialEq)]
pub struct Adam {
    config: AdamConfig,
    steps: u64,
    /// First moments. Those of Muon's matrices are their momentum.
    first: Vec<f32>,
    /// Second moments. Muon leaves a matrix' at 0.
    second: Vec<f32>,
}

impl Adam {
    /// Returns an optimizer of `count` parameters that has not stepped yet.
    pub fn new(config: AdamConfig, count: usize) -> Self {
        Self { config, steps: 0, first: vec![0.0; count], second: vec![0.0; count] }
    }

    /// Returns the constants.
    pub fn config(&self) -> AdamConfig {
        self.config
    }

    /// Returns the steps taken, and both moments.
    pub fn state(&self) -> (u64, [&[f32]; 2]) {
        (self.steps, [&self.first, &self.second])
    }

    /// Takes one step, unless the gradient is not finite.
    ///
    /// # Panics
    /// Parameters or gradient of another number than the optimizer's.
    pub fn step(&mut self, layout: &Layout, values: &mut [f32], descent: Descent<'_>) -> Stepped {
        let Descent { gradient, max_norm, rate } = descent;
        assert_eq!((values.len(), gradient.len()), (self.first.len(), self.first.len()), "sizes of a step");
        let norm = norm(InstructionSet::chosen(), gradient);
        if !norm.is_finite() {
            return Stepped { norm, taken: false };
        }
        self.steps += 1;
        let scale = (max_norm / (norm + 1e-6)).min(1.0);
        match self.config.rule {
            Rule::Adam => self.adam(0..values.len(), values, gradient, scale, rate),
            Rule::Radam => self.radam(values, gradient, scale as f32, rate),
            Rule::Muon => self.muon(layout, values, gradient, scale, rate),
        }
        Stepped { norm, taken: true }
    }

    fn adam(&mut self, range: Range<usize>, values: &mut [f32], gradient: &[f32], scale: f64, rate: f64) {
        let AdamConfig { beta_1, beta_2, epsilon, .. } = self.config;
        let slices = Slices {
            values: &mut values[range.clone()],
            gradient: &gradient[range.clone()],
            first: &mut self.first[range.clone()],
            second: &mut self.second[range],
        };
        AdamStep { beta_1, beta_2, epsilon, step: self.steps, rate, scale }.take(InstructionSet::chosen(), slices);
    }

    fn radam(&mut self, values: &mut [f32], gradient: &[f32], scale: f32, rate: f64) {
        let AdamConfig { beta_1, beta_2, epsilon, .. } = self.config;
        let t = self.steps as f64;
        let bias_1 = 1.0 - beta_1.powf(t);
        let rectified = rectification(beta_2, t).map(|r| (rate / bias_1 * (1.0 - beta_2.powf(t)).sqrt() * r) as f32);
        let plain = (rate / bias_1) as f32;
        let [keep_1, take_1] = [beta_1 as f32, (1.0 - beta_1) as f32];
        let [keep_2, take_2] = [beta_2 as f32, (1.0 - beta_2) as f32];
        let moments = self.first.iter_mut().zip(&mut self.second);
        for ((value, gradient), (first, second)) in values.iter_mut().zip(gradient).zip(moments) {
            let gradient = gradient * scale;
            *first = *first * keep_1 + gradient * take_1;
            *second = *second * keep_2 + gradient * gradient * take_2;
            *value -= match rectified {
                Some(rate) => *first / (second.sqrt() + epsilon as f32) * rate,
                None => *first * plain,
            };
        }
    }

    fn muon(&mut self, layout: &Layout, values: &mut [f32], gradient: &[f32], scale: f64, rate: f64) {
        let mut matrices = Vec::new();
        for entry in layout.entries() {
            let range = layout.range(&entry.name);
            match muon::matrix(&entry.name, &entry.shape) {
                Some(shape) => {
                    let gathered =
                        muon::gathered(&mut self.first[range.clone()], &gradient[range.clone()], scale as f32);
                    matrices.push((range, shape, gathered));
                }
                None => self.adam(range, values, gradient, scale, rate),
            }
        }
        for (range, step) in muon::steps(matrices) {
            values[range].iter_mut().zip(step).for_each(|(value, step)| *value -= step * rate as f32);
        }
    }

    /// Writes the moments under `prefix`, exact bits, by the parameters' names.
    ///
    /// # Errors
    /// A name is taken.
    pub fn save_into(&self, layout: &Layout, checkpoint: &mut Checkpoint, prefix: &str) -> Result<(), CheckpointError> {
        for entry in layout.entries() {
            let (range, name) = (layout.range(&entry.name), format!("{prefix}.{}", entry.name));
            checkpoint.put_u64(&format!("{name}.step"), &[1], vec![self.steps])?;
            checkpoint.put_f32(&format!("{name}.first"), &[range.len()], self.first[range.clone()].to_vec())?;
            checkpoint.put_f32(&format!("{name}.second"), &[range.len()], self.second[range].to_vec())?;
        }
        Ok(())
    }

    /// Reads the moments of parameters back.
    ///
    /// # Errors
    /// Moments that are missing, or of another size than the parameter.
    pub fn load_from(
        config: AdamConfig,
        layout: &Layout,
        checkpoint: &Checkpoint,
        prefix: &str,
    ) -> Result<Self, CheckpointError> {
        let mut adam = Self::new(config, layout.len());
        for entry in layout.entries() {
            let (range, name) = (layout.range(&entry.name), format!("{prefix}.{}", entry.name));
            adam.steps = checkpoint.u64s(&format!("{name}.step"), &[1])?[0];
            let moments = |part: &str| checkpoint.f32s(&format!("{name}.{part}"), &[range.len()]);
            adam.first[range.clone()].copy_from_slice(&moments("first")?);
            adam.second[range.clone()].copy_from_slice(&moments("second")?);
        }
        Ok(adam)
    }
}

/// Returns the rectification term r_t, or `None` while the variance of the adaptive learning rate is intractable. That
/// is ρ_t ≤ 5, the bound PyTorch uses; the paper's is 4.
fn rectification(beta_2: f64, t: f64) -> Option<f64> {
    let rho_inf = 2.0 / (1.0 - beta_2) - 1.0;
    let power = beta_2.powf(t);
    let rho = rho_inf - 2.0 * t * power / (1.0 - power);
    (rho > 5.0).then(|| ((rho - 4.0) * (rho - 2.0) * rho_inf / ((rho_inf - 4.0) * (rho_inf - 2.0) * rho)).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_gradient_that_is_not_finite_changes_nothing() {
        let layout = Layout::of_shapes(vec![("blocks.p".into(), vec![2, 2]), ("bias".into(), vec![2])]);
        for rule in [Rule::Adam, Rule::Radam, Rule::Muon] {
            let config = AdamConfig { rule, ..AdamConfig::adam() };
            let mut adam = Adam::new(config, layout.len());
            let mut values = vec![0.5; 6];
            let first = Descent { gradient: &[0.1; 6], max_norm: 1.0, rate: 1e-3 };
            assert!(adam.step(&layout, &mut values, first).taken);
            let before = (adam.clone(), values.clone());
            for wrong in [f32::NAN, f32::INFINITY] {
                let gradient = [0.1, wrong, 0.1, 0.1, 0.1, 0.1];
                let stepped = adam.step(&layout, &mut values, Descent { gradient: &gradient, ..first });
                assert!(!stepped.taken && !stepped.norm.is_finite(), "{stepped:?}");
            }
            assert_eq!((adam, values), before);
        }
    }
}
