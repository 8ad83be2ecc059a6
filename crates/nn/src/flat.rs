//! A module's parameters as plain numbers in one row, with gradient and Adam's moments beside them: what the kernels of
//! `lifelike_dense` learn with on a CPU.

use std::ops::Range;

use burn::module::{Module, ModuleMapper, Param};
use burn::tensor::{Tensor, TensorData};
use lifelike_dense::{AdamStep, Slices, norm};
use lifelike_simd::InstructionSet;

use crate::adam::{Adam, Rule};
use crate::numbers::{Row, Unreadable};

/// All of a module's parameters, one after another in the module's own order.
#[derive(Debug, Clone)]
pub struct Flat {
    parts: Vec<Part>,
    values: Vec<f32>,
    /// The gradient by each of them, to be written before a step.
    pub gradient: Vec<f32>,
    first: Vec<f32>,
    second: Vec<f32>,
}

/// One parameter.
#[derive(Debug, Clone)]
struct Part {
    name: String,
    range: Range<usize>,
    /// Steps of the optimizer that it has seen.
    steps: u64,
}

impl Flat {
    /// Takes the parameters out of a module and their moments out of its optimizer.
    ///
    /// # Errors
    /// Tensor data that cannot be read from the device.
    pub fn of<M: Module>(module: &M, adam: &Adam) -> Result<Self, Unreadable> {
        let Row { places, values } = Row::of(module)?;
        let (mut first, mut second) = (vec![0.0; values.len()], vec![0.0; values.len()]);
        let mut parts = Vec::with_capacity(places.len());
        for (name, range) in places {
            let steps = adam.write_moments(&name, &mut first[range.clone()], &mut second[range.clone()])?;
            parts.push(Part { name, range, steps });
        }
        Ok(Self { parts, gradient: vec![0.0; values.len()], values, first, second })
    }

    /// Returns the module with these parameters; the optimizer gets the moments.
    pub fn into_module<M: Module>(self, module: M, adam: &mut Adam) -> M {
        for part in &self.parts {
            let range = part.range.clone();
            adam.set_moments(&part.name, part.steps, &self.first[range.clone()], &self.second[range]);
        }
        module.map(&mut Replace { values: &self.values, next: 0 })
    }

    /// Returns where the parameters stand whose names begin with a prefix; they are neighbours in a module.
    pub fn range(&self, prefix: &str) -> Range<usize> {
        let mut of = self.parts.iter().filter(|part| part.name.starts_with(prefix)).map(|part| part.range.clone());
        let first = of.next().unwrap_or(0..0);
        first.start..of.next_back().map_or(first.end, |last| last.end)
    }

    /// Returns the parameters.
    pub fn values(&self) -> &[f32] {
        &self.values
    }

    /// Returns the parameters, to be changed.
    pub fn values_mut(&mut self) -> &mut [f32] {
        &mut self.values
    }

    /// Takes one step of the optimizer with the gradient, clipped as by [`crate::gradients::Gradients::clip_norm`]. Returns the
    /// norm before; `None` when it was not finite, and nothing has changed.
    ///
    /// # Panics
    /// The optimizer is not Adam.
    pub fn step(&mut self, adam: &Adam, max_norm: f64, rate: f64) -> Option<f64> {
        let (set, config) = (InstructionSet::chosen(), adam.config());
        assert_eq!(config.rule, Rule::Adam, "the rule of an optimizer on plain numbers");
        let norm = norm(set, &self.gradient);
        if !norm.is_finite() {
            return None;
        }
        let scale = (max_norm / (norm + 1e-6)).min(1.0);
        // As a rule all have seen as many steps: one sweep.
        for parts in self.parts.chunk_by_mut(|a, b| a.steps == b.steps) {
            let range = parts[0].range.start..parts[parts.len() - 1].range.end;
            parts.iter_mut().for_each(|part| part.steps += 1);
            let step = AdamStep {
                beta_1: config.beta_1,
                beta_2: config.beta_2,
                epsilon: config.epsilon,
                step: parts[0].steps,
                rate,
                scale,
            };
            let slices = Slices {
                values: &mut self.values[range.clone()],
                gradient: &self.gradient[range.clone()],
                first: &mut self.first[range.clone()],
                second: &mut self.second[range],
            };
            step.take(set, slices);
        }
        Some(norm)
    }
}

struct Replace<'a> {
    values: &'a [f32],
    next: usize,
}

impl ModuleMapper for Replace<'_> {
    fn map_float<const D: usize>(&mut self, param: Param<Tensor<D>>) -> Param<Tensor<D>> {
        param.map(|tensor| {
            let (shape, tracked, autodiff) = (tensor.dims(), tensor.is_require_grad(), tensor.is_autodiff());
            let values = &self.values[self.next..self.next + tensor.shape().num_elements()];
            self.next += values.len();
            let device = tensor.device().inner();
            let next = Tensor::from_data(TensorData::new(values.to_vec(), shape), &device);
            if autodiff { next.autodiff().set_require_grad(tracked) } else { next }
        })
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::adam::AdamConfig;
    use crate::device;
    use crate::gradients::Gradients;
    use crate::mlp::MlpConfig;
    use lifelike_checkpoint::Checkpoint;

    fn saved(adam: &Adam) -> Vec<u8> {
        let mut file = Checkpoint::default();
        adam.save_into(&mut file, "adam").unwrap();
        file.to_bytes().unwrap()
    }

    /// Steps with clipping and without, back to tensors in the middle: values and moments are those of the tensors' optimizer.
    #[test]
    fn steps_are_those_of_the_tensors_optimizer() {
        let module = MlpConfig::new(9, &[40], 7).init(1, "test", &device::inference());
        let (mut tensors, mut tensors_adam) = (module.clone(), Adam::new(AdamConfig::adam()));
        let (mut plain, mut plain_adam) = (module, Adam::new(AdamConfig::adam()));
        for step in 0..4 {
            let mut flat = Flat::of(&plain, &plain_adam).unwrap();
            assert_eq!(flat.range("layers.1"), 400..687);
            let values: Vec<f32> = (0..687).map(|i| ((i * 31 + step * 7) % 83) as f32 * 2e-3 - 0.08).collect();
            flat.gradient.copy_from_slice(&values);
            let max_norm = if step % 2 == 0 { 0.5 } else { 100.0 };
            let norm = flat.step(&plain_adam, max_norm, 1e-3).unwrap();
            plain = flat.into_module(plain, &mut plain_adam);

            let mut gradients = Gradients::default();
            let mut next = 0;
            for (name, shape) in crate::names::parameters(&tensors) {
                let part = &values[next..next + shape.iter().product::<usize>()];
                next += part.len();
                let data = TensorData::new(part.to_vec(), [part.len()]);
                gradients.insert(name, Tensor::from_data(data, &device::inference()));
            }
            let expected = gradients.clip_norm(max_norm).unwrap();
            assert!((norm - expected).abs() < 1e-6 * expected, "{norm} {expected}");
            tensors = tensors_adam.step(tensors, gradients, 1e-3);
        }
        let (got, expected) = (Flat::of(&plain, &plain_adam).unwrap(), Flat::of(&tensors, &tensors_adam).unwrap());
        // The norm's last bits, and so the factor's, depend on the order of its sum.
        let close = |got: &[f32], expected: &[f32], relative: f32, least: f32| {
            for (got, expected) in got.iter().zip(expected) {
                assert!((got - expected).abs() <= relative * expected.abs().max(least), "{got} {expected}");
            }
        };
        close(&got.values, &expected.values, 2e-7, 1e-2);
        close(&got.first, &expected.first, 1e-6, 1e-3);
        close(&got.second, &expected.second, 1e-6, 1e-7);
        assert!(expected.first.iter().any(|x| x.abs() > 1e-3) && expected.second.iter().any(|x| *x > 1e-7));
        assert_eq!(saved(&plain_adam).len(), saved(&tensors_adam).len());
    }

    #[test]
    fn a_gradient_that_is_not_finite_changes_nothing() {
        let module = MlpConfig::new(3, &[4], 2).init(1, "test", &device::inference());
        let adam = Adam::new(AdamConfig::adam());
        let mut flat = Flat::of(&module, &adam).unwrap();
        let before = flat.values.clone();
        flat.gradient[3] = f32::NAN;
        assert_eq!(flat.step(&adam, 1.0, 1e-3), None);
        assert_eq!(flat.values, before);
    }
}
