//! The Variable Selection Network: how much each input counts at this step.

use std::ops::Range;

use lifelike_simd::vectorize;

use super::gated_residual::{GatedResidual, GatedResidualPass, GatedResidualSizes, Scratch};
use crate::rows::elementary::exp;
use crate::rows::tile::{LANES, Lanes};
use crate::rows::{Entry, Init, Layout};

/// Sizes of a Variable Selection Network.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SelectionSizes {
    /// V: variables, each one number of a row.
    pub variables: usize,
    /// e: numbers that a variable is embedded in.
    pub embedding: usize,
    /// c: numbers that come out.
    pub width: usize,
}

/// Σ w_v ξ_v (Lim et al. 2021, eqs. 6 to 8): every variable through a Gated Residual Network of its own, weighted by the softmax
/// of one that sees all of them.
#[derive(Debug, Clone)]
pub struct VariableSelection {
    sizes: SelectionSizes,
    weight: Vec<f32>,
    bias: Vec<f32>,
    /// Range of weights and biases of the embedding, one after the other.
    embedding: Range<usize>,
    all: GatedResidual,
    single: Vec<GatedResidual>,
}

/// Result of the selection.
#[derive(Debug, Clone)]
pub struct Selected {
    /// Rows, `[rows, c]`.
    pub rows: Vec<f32>,
    /// Weights of the variables, `[rows, V]`, each row's sum 1.
    pub weights: Vec<f32>,
    /// Numbers that the way back needs.
    pub pass: SelectionPass,
}

/// Numbers that the way back needs.
#[derive(Debug, Clone)]
pub struct SelectionPass {
    x: Vec<f32>,
    weights: Vec<f32>,
    all: GatedResidualPass,
    single: Vec<(Vec<f32>, GatedResidualPass)>,
}

impl SelectionSizes {
    fn all(self) -> GatedResidualSizes {
        let Self { variables, embedding, width } = self;
        GatedResidualSizes { inputs: variables * embedding, hidden: width, outputs: variables }
    }

    fn single(self) -> GatedResidualSizes {
        let Self { embedding, width, .. } = self;
        GatedResidualSizes { inputs: embedding, hidden: embedding, outputs: width }
    }
}

impl VariableSelection {
    /// Returns its parameters: `NAME.embedding.weight` and `.bias` `[V, e]`, `NAME.all` and `NAME.VARIABLE`.
    pub fn entries(name: &str, sizes: SelectionSizes) -> Vec<Entry> {
        let mut out = Vec::new();
        for part in ["weight", "bias"] {
            // One input each, so PyTorch's bound is 1.
            let shape = vec![sizes.variables, sizes.embedding];
            out.push(Entry { name: format!("{name}.embedding.{part}"), shape, init: Init::Uniform(1.0) });
        }
        out.extend(GatedResidual::entries(&format!("{name}.all"), sizes.all()));
        for v in 0..sizes.variables {
            out.extend(GatedResidual::entries(&format!("{name}.{v}"), sizes.single()));
        }
        out
    }

    /// Packs parameters that stand as the layout says.
    pub fn new(name: &str, sizes: SelectionSizes, layout: &Layout, values: &[f32]) -> Self {
        let weight = layout.range(&format!("{name}.embedding.weight"));
        let bias = layout.range(&format!("{name}.embedding.bias"));
        let single = |v: usize| GatedResidual::new(&format!("{name}.{v}"), sizes.single(), layout, values);
        Self {
            weight: values[weight.clone()].to_vec(),
            bias: values[bias.clone()].to_vec(),
            embedding: weight.start..bias.end,
            all: GatedResidual::new(&format!("{name}.all"), sizes.all(), layout, values),
            single: (0..sizes.variables).map(single).collect(),
            sizes,
        }
    }

    /// Goes forward.
    ///
    /// # Shapes
    /// `x: [rows, V]`.
    pub fn forward(&self, x: Vec<f32>) -> Selected {
        let SelectionSizes { variables, embedding: e, width: c } = self.sizes;
        let numbers = variables * e;
        let rows = x.len() / variables;
        let mut embedded = vec![0.0; rows * numbers];
        vectorize(
            #[inline(always)]
            || {
                for (embedded, x) in embedded.chunks_exact_mut(numbers).zip(x.chunks_exact(variables)) {
                    let parameters = self.weight.chunks_exact(e).zip(self.bias.chunks_exact(e));
                    for ((embedded, x), (weight, bias)) in embedded.chunks_exact_mut(e).zip(x).zip(parameters) {
                        for ((y, weight), bias) in embedded.iter_mut().zip(weight).zip(bias) {
                            *y = x * weight + bias;
                        }
                    }
                }
            },
        );
        let single: Vec<_> = self
            .single
            .iter()
            .enumerate()
            .map(|(v, one)| one.forward(column(&embedded, numbers, v * e..(v + 1) * e)))
            .collect();
        let (mut weights, all) = self.all.forward(embedded);
        let mut out = vec![0.0; rows * c];
        vectorize(
            #[inline(always)]
            || {
                for weights in weights.chunks_exact_mut(variables) {
                    softmax(weights);
                }
                for (v, (values, _)) in single.iter().enumerate() {
                    for ((out, values), weights) in
                        out.chunks_exact_mut(c).zip(values.chunks_exact(c)).zip(weights.chunks_exact(variables))
                    {
                        let weight = weights[v];
                        out.iter_mut().zip(values).for_each(|(out, x)| *out += weight * x);
                    }
                }
            },
        );
        Selected { rows: out, weights: weights.clone(), pass: SelectionPass { x, weights, all, single } }
    }

    /// Returns what [`Self::forward`] does, to the last digits, without what the way back needs and several times as fast: sixteen rows
    /// go through the network side by side.
    ///
    /// # Shapes
    /// `x: [rows, V]` to `[rows, c]`.
    pub fn select(&self, x: &[f32]) -> Vec<f32> {
        let SelectionSizes { variables, embedding: e, width: c } = self.sizes;
        let mut out = vec![0.0; x.len() / variables * c];
        let mut scratch = Scratch::default();
        let mut embedded = vec![[0.0_f32; LANES]; variables * e];
        let (mut weights, mut single) = (vec![[0.0_f32; LANES]; variables], vec![[0.0_f32; LANES]; c]);
        let mut sum = vec![[0.0_f32; LANES]; c];
        vectorize(
            #[inline(always)]
            || {
                for (x, out) in x.chunks(LANES * variables).zip(out.chunks_mut(LANES * c)) {
                    for (v, embedded) in embedded.chunks_exact_mut(e).enumerate() {
                        let mut column = [0.0_f32; LANES];
                        for (slot, x) in column.iter_mut().zip(x[v..].iter().step_by(variables)) {
                            *slot = *x;
                        }
                        let parameters = self.weight[v * e..].iter().zip(&self.bias[v * e..]);
                        for (y, (weight, bias)) in embedded.iter_mut().zip(parameters) {
                            for (y, x) in y.iter_mut().zip(&column) {
                                *y = x * weight + bias;
                            }
                        }
                    }
                    self.all.side_by_side(&embedded, &mut weights, &mut scratch);
                    softmax_side_by_side(&mut weights);
                    sum.fill([0.0; LANES]);
                    for ((one, weights), x) in self.single.iter().zip(&weights).zip(embedded.chunks_exact(e)) {
                        one.side_by_side(x, &mut single, &mut scratch);
                        for (sum, x) in sum.iter_mut().zip(&single) {
                            for ((sum, x), weight) in sum.iter_mut().zip(x).zip(weights) {
                                *sum += weight * x;
                            }
                        }
                    }
                    for (row, out) in out.chunks_exact_mut(c).enumerate() {
                        out.iter_mut().zip(&sum).for_each(|(out, sum)| *out = sum[row]);
                    }
                }
            },
        );
        out
    }

    /// Adds the parameters' gradients; returns the one by x.
    pub fn backward(&self, pass: SelectionPass, gradient: &[f32], sums: &mut [f32]) -> Vec<f32> {
        let SelectionSizes { variables, embedding: e, width: c } = self.sizes;
        let SelectionPass { x, weights, all, single } = pass;
        let (numbers, rows) = (variables * e, x.len() / variables);
        let mut by_weights = vec![0.0; weights.len()];
        let mut by_embedded = vec![0.0; rows * numbers];
        for (v, (mut values, pass)) in single.into_iter().enumerate() {
            vectorize(
                #[inline(always)]
                || {
                    for (row, values) in values.chunks_exact_mut(c).enumerate() {
                        let (weight, gradient) = (weights[row * variables + v], &gradient[row * c..][..c]);
                        let mut along = 0.0;
                        for (x, gradient) in values.iter_mut().zip(gradient) {
                            along += *x * gradient;
                            *x = weight * gradient;
                        }
                        by_weights[row * variables + v] = along;
                    }
                },
            );
            let by = self.single[v].backward(pass, &values, sums);
            for (all, by) in by_embedded.chunks_exact_mut(numbers).zip(by.chunks_exact(e)) {
                all[v * e..(v + 1) * e].copy_from_slice(by);
            }
        }
        for (by, weights) in by_weights.chunks_exact_mut(variables).zip(weights.chunks_exact(variables)) {
            let along: f32 = by.iter().zip(weights).map(|(by, w)| by * w).sum();
            by.iter_mut().zip(weights).for_each(|(by, w)| *by = w * (*by - along));
        }
        crate::rows::add(&mut by_embedded, &self.all.backward(all, &by_weights, sums));
        let (by_weight, by_bias) = sums[self.embedding.clone()].split_at_mut(numbers);
        let mut by_x = vec![0.0; x.len()];
        vectorize(
            #[inline(always)]
            || {
                for ((by, x), by_x) in by_embedded
                    .chunks_exact(numbers)
                    .zip(x.chunks_exact(variables))
                    .zip(by_x.chunks_exact_mut(variables))
                {
                    for (v, by_x) in by_x.iter_mut().enumerate() {
                        for i in v * e..(v + 1) * e {
                            by_weight[i] += x[v] * by[i];
                            by_bias[i] += by[i];
                            *by_x += self.weight[i] * by[i];
                        }
                    }
                }
            },
        );
        by_x
    }
}

/// Returns some columns of rows.
fn column(rows: &[f32], width: usize, columns: Range<usize>) -> Vec<f32> {
    rows.chunks_exact(width).flat_map(|row| &row[columns.clone()]).copied().collect()
}

#[inline(always)]
fn softmax_side_by_side(x: &mut [Lanes]) {
    let (mut most, mut sum) = ([f32::MIN; LANES], [0.0_f32; LANES]);
    for x in &*x {
        for (most, x) in most.iter_mut().zip(x) {
            *most = if *x > *most { *x } else { *most };
        }
    }
    for x in x.iter_mut() {
        for ((x, most), sum) in x.iter_mut().zip(&most).zip(&mut sum) {
            *x = exp(*x - most);
            *sum += *x;
        }
    }
    for x in x {
        for (x, sum) in x.iter_mut().zip(&sum) {
            *x /= sum;
        }
    }
}

#[inline(always)]
fn softmax(x: &mut [f32]) {
    let most = x.iter().fold(f32::MIN, |most, x| most.max(*x));
    let mut sum = 0.0;
    for x in x.iter_mut() {
        *x = exp(*x - most);
        sum += *x;
    }
    x.iter_mut().for_each(|x| *x /= sum);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn side_by_side_is_the_same() {
        // Widths below, at and above a panel's; rows that do not fill the lanes.
        for (variables, embedding, width, rows) in [(3, 2, 5, 1), (7, 4, 16, 16), (9, 8, 32, 37), (1, 16, 16, 5)] {
            let sizes = SelectionSizes { variables, embedding, width };
            let layout = Layout::new(VariableSelection::entries("v", sizes));
            let selection = VariableSelection::new("v", sizes, &layout, &layout.init(1, "side by side"));
            let x: Vec<f32> = (0..rows * variables).map(|i| (i as f32 * 0.7).sin() * 2.0).collect();
            let expected = selection.forward(x.clone()).rows;
            let got = selection.select(&x);
            assert_eq!(got.len(), expected.len());
            let off = got.iter().zip(&expected).fold(0.0_f32, |most, (a, b)| most.max((a - b).abs()));
            assert!(off < 1e-5, "{sizes:?}: {off}");
        }
    }
}
