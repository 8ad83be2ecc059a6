//! Linear maps of rows, and their gradients, inside of one thread.

use std::ops::Range;

use lifelike_simd::vectorize;

use super::layout::Layout;
use super::tile::{self, LANES, Lanes, View, pack, padded};

/// Rows that are multiplied at a time: they and a panel of the weight stay in the nearest cache.
const BLOCK: usize = 96;
/// Rows whose part of a weight's gradient is summed in registers.
const DEEP: usize = 192;

/// A weight in the order in which products read it, forth and back.
#[derive(Debug, Clone)]
pub struct PackedWeight {
    inputs: usize,
    outputs: usize,
    forth: Vec<[f32; LANES]>,
    back: Vec<[f32; LANES]>,
}

impl PackedWeight {
    /// Packs a weight, `[inputs, outputs]`.
    pub fn new(weight: &[f32], [inputs, outputs]: [usize; 2]) -> Self {
        let (mut forth, mut back) = (Vec::new(), Vec::new());
        vectorize(
            #[inline(always)]
            || {
                pack(&mut forth, inputs, outputs, View::rows(weight, outputs), 1.0);
                pack(&mut back, outputs, inputs, View::columns(weight, outputs), 1.0);
            },
        );
        Self { inputs, outputs, forth, back }
    }

    /// Returns x · weight + bias.
    ///
    /// # Shapes
    /// `x: [rows, inputs]`, `bias: [outputs]` to `[rows, outputs]`.
    pub fn forward(&self, x: &[f32], bias: &[f32]) -> Vec<f32> {
        let mut out = multiply(x, self.inputs, &self.forth, self.outputs);
        add_bias(&mut out, bias);
        out
    }

    /// Returns the gradient by x, `[rows, inputs]`, from the one by the output, `[rows, outputs]`.
    pub fn by_input(&self, gradient: &[f32]) -> Vec<f32> {
        multiply(gradient, self.outputs, &self.back, self.inputs)
    }
}

/// Adds a bias to each row.
fn add_bias(rows: &mut [f32], bias: &[f32]) {
    if bias.is_empty() {
        return;
    }
    vectorize(
        #[inline(always)]
        || {
            for row in rows.chunks_exact_mut(bias.len()) {
                row.iter_mut().zip(bias).for_each(|(y, bias)| *y += bias);
            }
        },
    );
}

/// Returns rows of `k` numbers times panels of `m` columns.
fn multiply(x: &[f32], k: usize, panels: &[[f32; LANES]], m: usize) -> Vec<f32> {
    let (rows, wide) = (x.len() / k.max(1), padded(m));
    let mut out = vec![0.0; rows * wide];
    vectorize(
        #[inline(always)]
        || {
            for (out, x) in out.chunks_mut((BLOCK * wide).max(1)).zip(x.chunks((BLOCK * k).max(1))) {
                tile::product(out, x.len() / k, View::rows(x, k), panels, k);
            }
        },
    );
    if wide > m {
        for row in 1..rows {
            out.copy_within(row * wide..row * wide + m, row * m);
        }
        out.truncate(rows * m);
    }
    out
}

/// Adds xᵀ · gradient to a weight's gradient.
///
/// # Shapes
/// `x: [rows, inputs]`, `gradient: [rows, outputs]`, `sum: [inputs, outputs]`.
pub fn weight_gradient(x: &[f32], gradient: &[f32], [inputs, outputs]: [usize; 2], sum: &mut [f32]) {
    let wide = padded(outputs);
    let (mut panels, mut part) = (Vec::new(), vec![0.0; inputs * wide]);
    let blocks = x.chunks((DEEP * inputs).max(1)).zip(gradient.chunks((DEEP * outputs).max(1)));
    vectorize(
        #[inline(always)]
        || {
            for (x, gradient) in blocks {
                let rows = x.len() / inputs;
                pack(&mut panels, rows, outputs, View::rows(gradient, outputs), 1.0);
                tile::product(&mut part, inputs, View::columns(x, inputs), &panels, rows);
                for (sum, part) in sum.chunks_exact_mut(outputs).zip(part.chunks_exact(wide)) {
                    sum.iter_mut().zip(part).for_each(|(sum, x)| *sum += x);
                }
            }
        },
    );
}

/// Adds the sum of rows to a bias' gradient.
///
/// # Shapes
/// `gradient: [rows, outputs]`, `sum: [outputs]`.
pub fn bias_gradient(gradient: &[f32], sum: &mut [f32]) {
    vectorize(
        #[inline(always)]
        || {
            for row in gradient.chunks_exact(sum.len().max(1)) {
                sum.iter_mut().zip(row).for_each(|(sum, x)| *sum += x);
            }
        },
    );
}

/// Adds numbers to numbers.
pub fn add(to: &mut [f32], what: &[f32]) {
    vectorize(
        #[inline(always)]
        || to.iter_mut().zip(what).for_each(|(to, what)| *to += what),
    );
}

/// A linear map x · weight + bias, packed once for many passes, that knows where its parameters stand.
#[derive(Debug, Clone)]
pub struct Linear {
    shape: [usize; 2],
    weight: PackedWeight,
    /// The weight as it stands in the row of parameters.
    plain: Vec<f32>,
    /// Empty where the map has none.
    bias: Vec<f32>,
    /// Places of weight and bias in rows of parameters and gradients.
    places: [Range<usize>; 2],
}

impl Linear {
    /// Packs the map `[inputs, outputs]` of the parameters `NAME.weight` and `NAME.bias` ([`Entry::linear`](super::Entry::linear)).
    pub fn new(name: &str, shape: [usize; 2], layout: &Layout, values: &[f32]) -> Self {
        Self::of([layout.range(&format!("{name}.weight")), layout.range(&format!("{name}.bias"))], shape, values)
    }

    /// Packs a map without bias, whose weight is the parameter of this name.
    pub fn without_bias(weight: &str, shape: [usize; 2], layout: &Layout, values: &[f32]) -> Self {
        Self::of([layout.range(weight), 0..0], shape, values)
    }

    fn of(places: [Range<usize>; 2], shape: [usize; 2], values: &[f32]) -> Self {
        let [plain, bias] = places.clone().map(|place| values[place].to_vec());
        Self { shape, weight: PackedWeight::new(&plain, shape), plain, bias, places }
    }

    /// Returns the numbers of a row that comes out.
    pub fn outputs(&self) -> usize {
        self.shape[1]
    }

    /// Returns x · weight + bias, `[rows, outputs]`.
    pub fn forward(&self, x: &[f32]) -> Vec<f32> {
        self.weight.forward(x, &self.bias)
    }

    /// Returns x · weight + bias of as many rows as there are lanes, side by side: what few and narrow rows gain from, whose products
    /// leave most of a panel empty.
    ///
    /// # Shapes
    /// `x: [inputs]` lanes, `out: [outputs]` lanes.
    pub(crate) fn side_by_side(&self, x: &[Lanes], out: &mut [Lanes]) {
        // (x W)ᵀ = Wᵀ xᵀ, and the lanes are xᵀ.
        let left = View::columns(&self.plain, self.shape[1]);
        let rows = out.len();
        tile::product(out.as_flattened_mut(), rows, left, x, x.len());
        vectorize(
            #[inline(always)]
            || {
                for (out, bias) in out.iter_mut().zip(&self.bias) {
                    for out in out {
                        *out += bias;
                    }
                }
            },
        );
    }

    /// Returns the gradient by x from the one by the output.
    pub fn by_input(&self, gradient: &[f32]) -> Vec<f32> {
        self.weight.by_input(gradient)
    }

    /// Adds the gradients of the parameters to a row of gradients.
    pub fn learn(&self, x: &[f32], gradient: &[f32], sums: &mut [f32]) {
        let [weight, bias] = &self.places;
        weight_gradient(x, gradient, self.shape, &mut sums[weight.clone()]);
        if !bias.is_empty() {
            bias_gradient(gradient, &mut sums[bias.clone()]);
        }
    }

    /// Adds the gradients of the parameters; returns the gradient by x.
    pub fn backward(&self, x: &[f32], gradient: &[f32], sums: &mut [f32]) -> Vec<f32> {
        self.learn(x, gradient, sums);
        self.by_input(gradient)
    }
}
