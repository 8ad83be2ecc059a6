//! The Gated Residual Network: as much of a small perceptron as is of use, beside its input.

use lifelike_simd::vectorize;

use super::elementary::{elu, elu_gradient};
use super::gate::{GateAddNorm, GatePass};
use crate::rows::tile::{LANES, Lanes};
use crate::rows::{Entry, Layout, Linear, add};

/// Sizes of a Gated Residual Network.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct GatedResidualSizes {
    /// Numbers of a row.
    pub inputs: usize,
    /// Numbers between.
    pub hidden: usize,
    /// Numbers that come out.
    pub outputs: usize,
}

/// norm(skip(x) + GLU(W₁ elu(W₂ x))) (Lim et al. 2021, eqs. 2 to 4); the skip connection is x itself, or a linear map where
/// sizes differ.
#[derive(Debug, Clone)]
pub struct GatedResidual {
    hidden: usize,
    inner: Linear,
    outer: Linear,
    gate: GateAddNorm,
    skip: Option<Linear>,
}

/// Numbers that the way back needs.
#[derive(Debug, Clone)]
pub struct GatedResidualPass {
    x: Vec<f32>,
    inner: Vec<f32>,
    gate: GatePass,
}

/// Space that passes with rows side by side write into.
#[derive(Debug, Default)]
pub(super) struct Scratch {
    inner: Vec<Lanes>,
    outer: Vec<Lanes>,
    both: Vec<Lanes>,
}

impl GatedResidual {
    /// Returns its parameters, `NAME.inner`, `NAME.outer`, `NAME.gate` and perhaps `NAME.skip`.
    pub fn entries(name: &str, sizes: GatedResidualSizes) -> Vec<Entry> {
        let GatedResidualSizes { inputs, hidden, outputs } = sizes;
        let mut out = Entry::linear(&format!("{name}.inner"), inputs, hidden).to_vec();
        out.extend(Entry::linear(&format!("{name}.outer"), hidden, hidden));
        out.extend(GateAddNorm::entries(&format!("{name}.gate"), hidden, outputs));
        if inputs != outputs {
            out.extend(Entry::linear(&format!("{name}.skip"), inputs, outputs));
        }
        out
    }

    /// Packs parameters that stand as the layout says.
    pub fn new(name: &str, sizes: GatedResidualSizes, layout: &Layout, values: &[f32]) -> Self {
        let GatedResidualSizes { inputs, hidden, outputs } = sizes;
        let linear = |part: &str, shape| Linear::new(&format!("{name}.{part}"), shape, layout, values);
        Self {
            hidden,
            inner: linear("inner", [inputs, hidden]),
            outer: linear("outer", [hidden, hidden]),
            gate: GateAddNorm::new(&format!("{name}.gate"), hidden, outputs, layout, values),
            skip: (inputs != outputs).then(|| linear("skip", [inputs, outputs])),
        }
    }

    /// Goes forward.
    ///
    /// # Shapes
    /// `x: [rows, inputs]` to `[rows, outputs]`.
    pub fn forward(&self, x: Vec<f32>) -> (Vec<f32>, GatedResidualPass) {
        let inner = self.inner.forward(&x);
        let outer = self.outer.forward(&activated(&inner));
        let (out, gate) = match &self.skip {
            Some(skip) => self.gate.forward(outer, &skip.forward(&x)),
            None => self.gate.forward(outer, &x),
        };
        (out, GatedResidualPass { x, inner, gate })
    }

    /// Goes forward with rows side by side; `out` has as many lanes as numbers come out.
    #[inline(always)]
    pub(super) fn side_by_side(&self, x: &[Lanes], out: &mut [Lanes], scratch: &mut Scratch) {
        let Scratch { inner, outer, both } = scratch;
        inner.resize(self.hidden, [0.0; LANES]);
        outer.resize(self.hidden, [0.0; LANES]);
        self.inner.side_by_side(x, inner);
        for inner in inner.iter_mut() {
            for x in inner {
                *x = elu(*x);
            }
        }
        self.outer.side_by_side(inner, outer);
        match &self.skip {
            Some(skip) => skip.side_by_side(x, out),
            None => out.copy_from_slice(x),
        }
        self.gate.side_by_side(outer, out, both);
    }

    /// Adds the parameters' gradients; returns the one by x.
    pub fn backward(&self, pass: GatedResidualPass, gradient: &[f32], sums: &mut [f32]) -> Vec<f32> {
        let GatedResidualPass { x, inner, gate } = pass;
        let (by_outer, by_skip) = self.gate.backward(gate, gradient, sums);
        let mut by_inner = self.outer.backward(&activated(&inner), &by_outer, sums);
        vectorize(
            #[inline(always)]
            || by_inner.iter_mut().zip(&inner).for_each(|(gradient, x)| *gradient *= elu_gradient(*x)),
        );
        let mut by_x = self.inner.backward(&x, &by_inner, sums);
        match &self.skip {
            Some(skip) => add(&mut by_x, &skip.backward(&x, &by_skip, sums)),
            None => add(&mut by_x, &by_skip),
        }
        by_x
    }
}

fn activated(x: &[f32]) -> Vec<f32> {
    let mut out = vec![0.0; x.len()];
    vectorize(
        #[inline(always)]
        || out.iter_mut().zip(x).for_each(|(out, x)| *out = elu(*x)),
    );
    out
}
