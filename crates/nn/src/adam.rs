//! Adam (Kingma & Ba 2015) and RAdam (Liu et al. 2020), with PyTorch's formulas and defaults, and Muon beside Adam.
//!
//! State is kept by parameter name and saved bit for bit, so a resumed run continues as if it had not stopped.

use std::collections::{BTreeMap, BTreeSet};

use burn::module::{Module, ModuleMapper, Param};
use burn::tensor::{Device, Tensor, TensorData};

use crate::checkpoint::ModuleCheckpoint;
use crate::gradients::Gradients;
use crate::muon;
use crate::names::{Path, parameters};
use crate::numbers::{Unreadable, read};
use lifelike_checkpoint::{Checkpoint, CheckpointError};

/// Update rule.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
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

/// First and second moment of one parameter, flattened, and the steps it has seen. Muon leaves a matrix' second moment at 0.
#[derive(Debug, Clone)]
struct Moments {
    step: u64,
    first: Tensor<1>,
    second: Tensor<1>,
}

impl Moments {
    /// Those of a parameter that has seen no gradient yet.
    fn before(gradient: &Tensor<1>) -> Self {
        Self { step: 0, first: gradient.zeros_like(), second: gradient.zeros_like() }
    }
}

/// The optimizer with its state.
#[derive(Debug, Clone)]
pub struct Adam {
    config: AdamConfig,
    moments: BTreeMap<String, Moments>,
}

impl Adam {
    /// Returns an optimizer that has not stepped yet.
    pub fn new(config: AdamConfig) -> Self {
        Self { config, moments: BTreeMap::new() }
    }

    /// Returns the constants.
    pub fn config(&self) -> AdamConfig {
        self.config
    }

    /// Moves its state to another device.
    #[must_use]
    pub fn to_device(mut self, device: &Device) -> Self {
        for moments in self.moments.values_mut() {
            moments.first = moments.first.clone().to_device(device);
            moments.second = moments.second.clone().to_device(device);
        }
        self
    }

    /// Returns one step with learning rate `rate`. Parameters without a gradient stay as they are.
    pub fn step<M: Module>(&mut self, module: M, mut gradients: Gradients, rate: f64) -> M {
        let orthogonal = match self.config.rule {
            Rule::Adam | Rule::Radam => BTreeSet::new(),
            Rule::Muon => self.orthogonalize(&module, &mut gradients),
        };
        module.map(&mut Update { path: Path::default(), adam: self, orthogonal, gradients, rate })
    }

    /// Puts Muon's steps for a rate of 1 in the place of its matrices' gradients; returns their names.
    fn orthogonalize<M: Module>(&mut self, module: &M, gradients: &mut Gradients) -> BTreeSet<String> {
        let mut gathered = Vec::new();
        for (name, shape) in parameters(module) {
            let Some(shape) = muon::matrix(&name, &shape) else { continue };
            let Some(gradient) = gradients.take(&name) else { continue };
            let moments = self.moments.entry(name.clone()).or_insert_with(|| Moments::before(&gradient));
            moments.step += 1;
            gathered.push((name, shape, muon::gathered(&mut moments.first, gradient)));
        }
        let steps = muon::steps(gathered);
        let names = steps.keys().cloned().collect();
        steps.into_iter().for_each(|(name, step)| gradients.insert(name, step));
        names
    }

    fn update(&mut self, name: String, value: Tensor<1>, gradient: Tensor<1>, rate: f64) -> Tensor<1> {
        let c = self.config;
        let mut moments = self.moments.remove(&name).unwrap_or_else(|| Moments::before(&gradient));
        moments.step += 1;
        let t = moments.step as f64;
        moments.first = moments.first.mul_scalar(c.beta_1).add(gradient.clone().mul_scalar(1.0 - c.beta_1));
        moments.second = moments.second.mul_scalar(c.beta_2).add(gradient.square().mul_scalar(1.0 - c.beta_2));
        let bias_1 = 1.0 - c.beta_1.powf(t);
        let bias_2 = 1.0 - c.beta_2.powf(t);
        let first = moments.first.clone();
        let root = |second: Tensor<1>| second.sqrt();
        let change = match c.rule {
            Rule::Adam | Rule::Muon => {
                let denominator = root(moments.second.clone()).div_scalar(bias_2.sqrt()).add_scalar(c.epsilon);
                first.div(denominator).mul_scalar(rate / bias_1)
            }
            Rule::Radam => match rectification(c.beta_2, t) {
                Some(r) => {
                    let denominator = root(moments.second.clone()).add_scalar(c.epsilon);
                    first.div(denominator).mul_scalar(rate / bias_1 * bias_2.sqrt() * r)
                }
                None => first.mul_scalar(rate / bias_1),
            },
        };
        self.moments.insert(name, moments);
        value.sub(change)
    }

    /// Writes a parameter's moments; returns the steps that it has seen, without which there are none.
    pub(crate) fn write_moments(&self, name: &str, first: &mut [f32], second: &mut [f32]) -> Result<u64, Unreadable> {
        let Some(moments) = self.moments.get(name) else { return Ok(0) };
        first.copy_from_slice(&read(moments.first.clone())?);
        second.copy_from_slice(&read(moments.second.clone())?);
        Ok(moments.step)
    }

    /// Takes the moments of a parameter that is on the CPU. Without a step there are none.
    pub(crate) fn set_moments(&mut self, name: &str, step: u64, first: &[f32], second: &[f32]) {
        let tensor = |x: &[f32]| Tensor::from_data(TensorData::new(x.to_vec(), [x.len()]), &crate::device::inference());
        if step > 0 {
            self.moments.insert(name.to_owned(), Moments { step, first: tensor(first), second: tensor(second) });
        }
    }

    /// Writes the moments under `prefix` (exact bits).
    pub fn save_into(&self, checkpoint: &mut Checkpoint, prefix: &str) -> Result<(), CheckpointError> {
        for (name, m) in &self.moments {
            checkpoint.put_u64(&format!("{prefix}.{name}.step"), &[1], vec![m.step])?;
            checkpoint.put_tensor(&format!("{prefix}.{name}.first"), &m.first)?;
            checkpoint.put_tensor(&format!("{prefix}.{name}.second"), &m.second)?;
        }
        Ok(())
    }

    /// Reads the moments of `module`'s parameters back. A parameter that had never had a gradient when the checkpoint
    /// was written has no moments there and starts without.
    ///
    /// # Errors
    /// Moments of another size than the parameter, or only some of the three entries of one parameter.
    pub fn load_from<M: Module>(
        config: AdamConfig,
        checkpoint: &Checkpoint,
        prefix: &str,
        module: &M,
    ) -> Result<Self, CheckpointError> {
        let device = module.devices().first().cloned().unwrap_or_else(crate::device::inference).inner();
        let mut moments = BTreeMap::new();
        for (name, shape) in parameters(module) {
            let key = |part: &str| format!("{prefix}.{name}.{part}");
            if !checkpoint.contains(&key("step")) {
                continue;
            }
            let count: usize = shape.iter().product();
            let read = |part: &str| checkpoint.tensor::<1>(&key(part), [count], &device);
            let (first, second) = (read("first")?, read("second")?);
            let step = checkpoint.u64s(&key("step"), &[1])?[0];
            moments.insert(name, Moments { step, first, second });
        }
        Ok(Self { config, moments })
    }
}

/// Returns the rectification term r_t, or `None` while the variance of the adaptive learning rate is intractable (ρ_t ≤ 5, the
/// bound PyTorch uses; the paper's is 4).
fn rectification(beta_2: f64, t: f64) -> Option<f64> {
    let rho_inf = 2.0 / (1.0 - beta_2) - 1.0;
    let power = beta_2.powf(t);
    let rho = rho_inf - 2.0 * t * power / (1.0 - power);
    (rho > 5.0).then(|| ((rho - 4.0) * (rho - 2.0) * rho_inf / ((rho_inf - 4.0) * (rho_inf - 2.0) * rho)).sqrt())
}

struct Update<'a> {
    path: Path,
    adam: &'a mut Adam,
    /// Those whose gradients are Muon's steps.
    orthogonal: BTreeSet<String>,
    gradients: Gradients,
    rate: f64,
}

impl ModuleMapper for Update<'_> {
    fn enter_module(&mut self, name: &str, _: &str) {
        self.path.enter(name);
    }
    fn exit_module(&mut self, _: &str, _: &str) {
        self.path.exit();
    }
    fn map_float<const D: usize>(&mut self, param: Param<Tensor<D>>) -> Param<Tensor<D>> {
        let name = self.path.name();
        let Some(gradient) = self.gradients.take(&name) else { return param };
        param.map(|tensor| {
            let (shape, tracked, autodiff) = (tensor.shape(), tensor.is_require_grad(), tensor.is_autodiff());
            let count = shape.num_elements();
            let flat = tensor.without_autodiff().reshape([count]);
            let next = match self.orthogonal.contains(&name) {
                true => flat.sub(gradient.mul_scalar(self.rate)),
                false => self.adam.update(name, flat, gradient, self.rate),
            };
            let next: Tensor<D> = next.reshape(shape);
            if autodiff { next.autodiff().set_require_grad(tracked) } else { next }
        })
    }
}
