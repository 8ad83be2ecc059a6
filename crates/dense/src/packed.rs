//! A perceptron that learns, or acts for many: weights packed for the kernels, rows in panels.

use lifelike_simd::InstructionSet;
use rayon::prelude::*;

use crate::layer::{Group, Layer, Then};
use crate::panel::{Channel, GROUP, ROWS, pack, padded, unpack};
use crate::perceptron::Sizes;
use crate::weight_gradient::{BiasGradient, SHARE, WeightGradient};

/// Weights of a [`crate::Perceptron`] in the order in which products read them, forth and back.
///
/// A pass over a panel of [`ROWS`] rows happens within [`Self::channels`] channels of memory that the caller keeps: the rows'
/// inputs, the values of every layer, and the loss's derivative by each of them. Panels are independent of one another;
/// [`Self::gradient`] then sums over all of them, in their order.
#[derive(Debug, Clone)]
pub struct PackedPerceptron {
    set: InstructionSet,
    sizes: Sizes,
    layers: Vec<PackedLayer>,
}

#[derive(Debug, Clone)]
struct PackedLayer {
    /// `[groups of outputs][inputs]`.
    forth: Vec<Group>,
    /// `[groups of inputs][outputs]`.
    back: Vec<Group>,
    /// Filled up with zeros.
    bias: Vec<f32>,
    /// First channel in a panel of: its inputs, its outputs, the derivatives by its inputs, those by its outputs.
    inputs: usize,
    outputs: usize,
    by_inputs: usize,
    by_outputs: usize,
}

impl PackedPerceptron {
    /// Packs parameters, in the order of [`Sizes`], for these instructions.
    ///
    /// # Panics
    /// There are more or fewer than the sizes say.
    pub fn new(set: InstructionSet, sizes: Sizes, parameters: &[f32]) -> Self {
        let values: usize = padded(sizes.inputs()) + sizes.layers().iter().map(|l| padded(l.outputs)).sum::<usize>();
        let mut first = 0;
        let layers = sizes.layers().iter().map(|layer| {
            let (inputs, outputs) = (first, first + padded(layer.inputs));
            first = outputs;
            PackedLayer {
                forth: vec![[0.0; GROUP]; padded(layer.outputs) / GROUP * layer.inputs],
                back: vec![[0.0; GROUP]; padded(layer.inputs) / GROUP * layer.outputs],
                bias: vec![0.0; padded(layer.outputs)],
                inputs,
                outputs,
                by_inputs: values + inputs,
                by_outputs: values + outputs,
            }
        });
        let mut packed = Self { set, layers: layers.collect(), sizes };
        packed.set(parameters);
        packed
    }

    /// Packs other parameters.
    ///
    /// # Panics
    /// As [`Self::new`].
    pub fn set(&mut self, parameters: &[f32]) {
        assert_eq!(parameters.len(), self.sizes.parameters(), "parameters of a perceptron");
        for (layer, packed) in self.sizes.layers().iter().zip(&mut self.layers) {
            let (weight, width) = (&parameters[layer.weight()], layer.outputs);
            packed.bias[..width].copy_from_slice(&parameters[layer.bias()]);
            packed.forth.par_chunks_mut(layer.inputs).enumerate().for_each(|(g, groups)| {
                for (group, row) in groups.iter_mut().zip(weight.chunks_exact(width)) {
                    let row = &row[g * GROUP..];
                    match row.first_chunk() {
                        Some(whole) => *group = *whole,
                        None => group[..row.len()].copy_from_slice(row),
                    }
                }
            });
            packed.back.par_chunks_mut(width).zip(weight.par_chunks(GROUP * width)).for_each(|(groups, rows)| {
                for (i, row) in rows.chunks_exact(width).enumerate() {
                    groups.iter_mut().zip(row).for_each(|(group, w)| group[i] = *w);
                }
            });
        }
    }

    /// Returns the sizes.
    pub fn sizes(&self) -> &Sizes {
        &self.sizes
    }

    /// Returns the channels of memory that a pass forth and back over one panel takes. All must be zeros at first.
    pub fn channels(&self) -> usize {
        2 * (padded(self.sizes.inputs()) + self.sizes.layers().iter().map(|l| padded(l.outputs)).sum::<usize>())
    }

    /// Returns the inputs of a panel, to be written.
    pub fn inputs<'a>(&self, panel: &'a mut [Channel]) -> &'a mut [Channel] {
        &mut panel[..self.sizes.inputs()]
    }

    /// Returns the inputs of a panel as they were written.
    pub fn values_of_inputs<'a>(&self, panel: &'a [Channel]) -> &'a [Channel] {
        &panel[..self.sizes.inputs()]
    }

    /// Returns the outputs of a panel.
    pub fn outputs<'a>(&self, panel: &'a [Channel]) -> &'a [Channel] {
        &panel[self.last().outputs..][..self.sizes.outputs()]
    }

    /// Returns the loss's derivative by the outputs, to be written.
    pub fn by_outputs<'a>(&self, panel: &'a mut [Channel]) -> &'a mut [Channel] {
        &mut panel[self.last().by_outputs..][..self.sizes.outputs()]
    }

    /// Returns the loss's derivative by the inputs.
    pub fn by_inputs<'a>(&self, panel: &'a [Channel]) -> &'a [Channel] {
        &panel[self.layers[0].by_inputs..][..self.sizes.inputs()]
    }

    fn last(&self) -> &PackedLayer {
        &self.layers[self.layers.len() - 1]
    }

    /// Computes a panel's outputs from its inputs.
    ///
    /// # Panics
    /// The panel has fewer than [`Self::channels`].
    pub fn forward(&self, panel: &mut [Channel]) {
        for (i, (layer, packed)) in self.sizes.layers().iter().zip(&self.layers).enumerate() {
            let (input, output) = panel[packed.inputs..].split_at_mut(padded(layer.inputs));
            let then = if i + 1 < self.layers.len() { Then::Elu(&packed.bias) } else { Then::Bias(&packed.bias) };
            self.set.run(Layer {
                weight: &packed.forth,
                input: &input[..layer.inputs],
                output: &mut output[..padded(layer.outputs)],
                rows: ROWS,
                then,
            });
        }
    }

    /// Computes the loss's derivative by every layer's values from that by the outputs; by the inputs too where another
    /// network's values are (`through`).
    ///
    /// # Panics
    /// The panel has fewer than [`Self::channels`].
    pub fn backward(&self, panel: &mut [Channel], through: bool) {
        let half = panel.len() / 2;
        let (values, by) = panel.split_at_mut(half);
        for (i, (layer, packed)) in self.sizes.layers().iter().zip(&self.layers).enumerate().rev() {
            if i == 0 && !through {
                return;
            }
            let (output, input) = by[packed.inputs..].split_at_mut(padded(layer.inputs));
            let values = &values[packed.inputs..][..padded(layer.inputs)];
            self.set.run(Layer {
                weight: &packed.back,
                input: &input[..layer.outputs],
                output,
                rows: ROWS,
                then: if i == 0 { Then::Keep } else { Then::Slope(values) },
            });
        }
    }

    /// Writes the gradient by all parameters, in their order, from all panels after their passes. `channels` is the size
    /// of a panel, of which this network's begin at `first`: others may share the memory.
    ///
    /// # Panics
    /// A slice has another length.
    pub fn gradient(&self, panels: &[Channel], channels: usize, first: usize, gradient: &mut [f32]) {
        assert!(first + self.channels() <= channels, "channels of a panel");
        assert_eq!((panels.len() % channels, gradient.len()), (0, self.sizes.parameters()), "gradient of a perceptron");
        let mut parts = Vec::new();
        let mut rest = gradient;
        for (layer, packed) in self.sizes.layers().iter().zip(&self.layers) {
            let (weight, after) = rest.split_at_mut(layer.weight().len());
            let (bias, after) = after.split_at_mut(layer.outputs);
            rest = after;
            parts.push((bias, None, *layer, packed));
            let shares = weight.chunks_mut(SHARE * layer.outputs).enumerate();
            parts.extend(shares.map(|(i, share)| (share, Some(i * SHARE), *layer, packed)));
        }
        parts.into_par_iter().with_max_len(1).for_each(|(gradient, input, layer, packed)| match input {
            None => self.set.run(BiasGradient { panels, channels, first: first + packed.by_outputs, gradient }),
            Some(input) => {
                let (inputs, outputs) = (first + packed.inputs + input, (first + packed.by_outputs, layer.outputs));
                self.set.run(WeightGradient { panels, channels, inputs, outputs, gradient });
            }
        });
    }

    /// Writes the outputs of many rows, on all threads.
    ///
    /// # Shapes
    /// `rows: [N, inputs]` to `out: [N, outputs]`.
    ///
    /// # Panics
    /// A slice has another length.
    pub fn forward_many(&self, rows: &[f32], out: &mut [f32]) {
        let (i, o) = (self.sizes.inputs(), self.sizes.outputs());
        assert_eq!((rows.len() % i, out.len()), (0, rows.len() / i * o), "rows of a perceptron");
        let widest = self.sizes.layers().iter().map(|l| padded(l.inputs).max(padded(l.outputs))).max().unwrap_or(0);
        let memory = || vec![Channel::ZERO; 2 * widest];
        rows.par_chunks(ROWS * i).zip(out.par_chunks_mut(ROWS * o)).for_each_init(memory, |memory, (rows, out)| {
            let (mut from, mut to) = memory.split_at_mut(widest);
            pack(rows.chunks_exact(i), &mut from[..i]);
            for (n, (layer, packed)) in self.sizes.layers().iter().zip(&self.layers).enumerate() {
                let then = if n + 1 < self.layers.len() { Then::Elu(&packed.bias) } else { Then::Bias(&packed.bias) };
                let (input, output) = (&from[..layer.inputs], &mut to[..padded(layer.outputs)]);
                self.set.run(Layer { weight: &packed.forth, input, output, rows: rows.len() / i, then });
                std::mem::swap(&mut from, &mut to);
            }
            unpack(&from[..o], out);
        });
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::{Between, Perceptron};

    fn numbers(count: usize, step: usize, scale: f32) -> Vec<f32> {
        (0..count).map(|i| (((i * step) % 97) as f32 - 48.0) * scale).collect()
    }

    fn bits(values: &[f32]) -> Vec<u32> {
        values.iter().map(|x| x.to_bits()).collect()
    }

    /// The gradient of the sum of outputs times `by`, and of the same by each input.
    fn gradients(set: InstructionSet, sizes: &Sizes, parameters: &[f32], rows: &[f32], by: &[f32]) -> [Vec<f32>; 3] {
        let (i, o) = (sizes.inputs(), sizes.outputs());
        let network = PackedPerceptron::new(set, sizes.clone(), parameters);
        let mut panels = vec![Channel::ZERO; (rows.len() / i).div_ceil(ROWS) * network.channels()];
        let (mut outputs, mut by_rows) = (vec![0.0; by.len()], vec![0.0; rows.len()]);
        for (n, panel) in panels.chunks_exact_mut(network.channels()).enumerate() {
            let part = |width: usize, all: usize| n * ROWS * width..((n + 1) * ROWS * width).min(all);
            pack(rows[part(i, rows.len())].chunks_exact(i), network.inputs(panel));
            network.forward(panel);
            pack(by[part(o, by.len())].chunks_exact(o), network.by_outputs(panel));
            network.backward(panel, true);
            unpack(network.outputs(panel), &mut outputs[part(o, by.len())]);
            unpack(network.by_inputs(panel), &mut by_rows[part(i, rows.len())]);
        }
        let mut gradient = vec![f32::NAN; parameters.len()];
        network.gradient(&panels, network.channels(), 0, &mut gradient);
        [outputs, by_rows, gradient]
    }

    #[test]
    fn rows_in_panels_and_rows_as_they_come_give_the_same_bits_on_every_instruction_set() {
        for widths in [&[31, 40, 23][..], &[7, 5], &[1, 3, 1], &[60, 65, 129, 2]] {
            let sizes = Sizes::new(widths);
            let parameters = numbers(sizes.parameters(), 37, 4e-3);
            for n in [1, 3, 20, 48, 131] {
                let rows = numbers(n * sizes.inputs(), 11, 0.03);
                let plain = Perceptron::new(sizes.clone(), parameters.clone());
                let mut expected = vec![f32::NAN; n * sizes.outputs()];
                plain.forward(&rows, &mut Between::default(), &mut expected);
                let mut got = vec![f32::NAN; expected.len()];
                plain.forward_many(&rows, &mut got);
                assert_eq!(bits(&got), bits(&expected), "{widths:?}, {n} rows");
                for set in InstructionSet::available() {
                    PackedPerceptron::new(set, sizes.clone(), &parameters).forward_many(&rows, &mut got);
                    assert_eq!(bits(&got), bits(&expected), "{widths:?}, {n} rows, {set}");
                }
            }
        }
    }

    /// The same passes in double precision, as they stand in a textbook.
    fn exact(sizes: &Sizes, parameters: &[f32], rows: &[f32], by: &[f32]) -> [Vec<f64>; 2] {
        let wide = |x: &[f32]| x.iter().map(|x| f64::from(*x)).collect::<Vec<f64>>();
        let (layers, last) = (sizes.layers(), sizes.layers().len() - 1);
        let (p, n) = (wide(parameters), rows.len() / sizes.inputs());
        let mut values = vec![wide(rows)];
        for (l, layer) in layers.iter().enumerate() {
            let (w, b, x) = (&p[layer.weight()], &p[layer.bias()], &values[l]);
            let at = |r: usize, j: usize| {
                let sum: f64 = (0..layer.inputs).map(|i| x[r * layer.inputs + i] * w[i * layer.outputs + j]).sum();
                let y = sum + b[j];
                if l == last || y > 0.0 { y } else { y.exp_m1() }
            };
            values.push((0..n * layer.outputs).map(|i| at(i / layer.outputs, i % layer.outputs)).collect());
        }
        let (mut gradient, mut by) = (vec![0.0; p.len()], wide(by));
        for (l, layer) in layers.iter().enumerate().rev() {
            let (w, x) = (&p[layer.weight()], &values[l]);
            let mut before = vec![0.0; x.len()];
            for r in 0..n {
                for j in 0..layer.outputs {
                    let by = by[r * layer.outputs + j];
                    gradient[layer.bias().start + j] += by;
                    for i in 0..layer.inputs {
                        gradient[layer.weight().start + i * layer.outputs + j] += by * x[r * layer.inputs + i];
                        before[r * layer.inputs + i] += by * w[i * layer.outputs + j];
                    }
                }
            }
            if l > 0 {
                before.iter_mut().zip(x).for_each(|(by, h)| *by *= h.min(0.0) + 1.0);
            }
            by = before;
        }
        [by, gradient]
    }

    #[test]
    fn gradients_are_the_exact_ones_and_the_same_bits_on_every_instruction_set_and_number_of_threads() {
        for (widths, n) in [(&[31, 40, 23][..], 100), (&[5, 5], 7), (&[1, 3, 1], 49), (&[60, 130, 65, 2], 500)] {
            let sizes = Sizes::new(widths);
            let parameters = numbers(sizes.parameters(), 37, 4e-3);
            let rows = numbers(n * sizes.inputs(), 11, 0.03);
            let by = numbers(n * sizes.outputs(), 7, 0.05);
            let expected = exact(&sizes, &parameters, &rows, &by);
            let first = gradients(InstructionSet::best(), &sizes, &parameters, &rows, &by);
            for (got, expected) in first[1..].iter().zip(&expected) {
                let scale = expected.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
                let off = got.iter().zip(expected).map(|(g, e)| (f64::from(*g) - e).abs()).fold(0.0, f64::max);
                assert!(off <= 1e-6 * scale, "{widths:?}: {off:e} of {scale:e}");
            }
            for set in InstructionSet::available() {
                for threads in [1, 3] {
                    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
                    let got = pool.install(|| gradients(set, &sizes, &parameters, &rows, &by));
                    for (got, first) in got.iter().zip(&first) {
                        assert_eq!(bits(got), bits(first), "{widths:?}, {set}, {threads} threads");
                    }
                }
            }
        }
    }
}
