//! One layer on one panel: the product of a packed weight, and what follows it while the numbers are still in registers.

use lifelike_simd::{Simd, Task, prelude::*};

use crate::elu::{elu_of_vector, slope_of_vector};
use crate::panel::{Channel, GROUP, ROWS};

/// One number of each of the channels of a group: what a packed weight is made of.
pub(crate) type Group = [f32; GROUP];

/// Operation after the product.
#[derive(Clone, Copy)]
pub(crate) enum Then<'a> {
    /// Nothing.
    Keep,
    /// The bias, `[outputs]` filled up with zeros.
    Bias(&'a [f32]),
    /// The bias and the ELU.
    Elu(&'a [f32]),
    /// Times the derivative of the ELU whose values these are, `[outputs]`.
    Slope(&'a [Channel]),
}

/// Sums of weights times channels. Each is accumulated over the inputs from the first to the last with fused multiply-adds,
/// whatever the instruction set.
pub(crate) struct Layer<'a> {
    /// `[groups of outputs][inputs]`.
    pub weight: &'a [Group],
    /// `[inputs]`.
    pub input: &'a [Channel],
    /// `[outputs]`, whole groups.
    pub output: &'a mut [Channel],
    /// Rows that matter; the others may be left as they are.
    pub rows: usize,
    /// Operation after it.
    pub then: Then<'a>,
}

impl Task for Layer<'_> {
    type Output = ();

    /// Tiles of [`GROUP`] outputs and as many vectors of rows as registers hold the sums of: 18 of 32 registers of 512 bits (a
    /// panel's rows), 12 of 16 of 256 (a third of them), 24 of 32 of 128 (a third).
    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        match S::f32s::LEN {
            16 => self.tiles::<S, 3>(simd),
            8 => self.tiles::<S, 2>(simd),
            _ => self.tiles::<S, 4>(simd),
        }
    }
}

impl Layer<'_> {
    #[inline(always)]
    fn tiles<S: Simd, const V: usize>(self, simd: S) {
        let Self { weight, input, output, rows, then } = self;
        assert_eq!(weight.len(), output.len() / GROUP * input.len(), "a weight's groups");
        for (g, out) in output.as_chunks_mut::<GROUP>().0.iter_mut().enumerate() {
            let weight = &weight[g * input.len()..(g + 1) * input.len()];
            let mut row = 0;
            while row < rows {
                let at = At { channel: g * GROUP, row };
                if rows - row > (V - 1) * S::f32s::LEN {
                    tile::<S, V>(simd, weight, input, out, at, then);
                    row += V * S::f32s::LEN;
                } else {
                    tile::<S, 1>(simd, weight, input, out, at, then);
                    row += S::f32s::LEN;
                }
            }
        }
    }
}

/// First output and row of a tile.
#[derive(Clone, Copy)]
struct At {
    channel: usize,
    row: usize,
}

/// The channels of a group in `V` vectors of rows.
#[inline(always)]
fn tile<S: Simd, const V: usize>(
    simd: S,
    weight: &[Group],
    input: &[Channel],
    out: &mut [Channel; GROUP],
    at: At,
    then: Then<'_>,
) {
    // Said once here, no access below needs a check.
    let row = at.row.min(ROWS - V * S::f32s::LEN);
    let mut sums = [[S::f32s::splat(simd, 0.0); V]; GROUP];
    for (w, x) in weight.iter().zip(input) {
        let mut vectors = [S::f32s::splat(simd, 0.0); V];
        for v in 0..V {
            vectors[v] = S::f32s::from_slice(simd, &x[row + v * S::f32s::LEN..][..S::f32s::LEN]);
        }
        for c in 0..GROUP {
            let w = S::f32s::splat(simd, w[c]);
            for v in 0..V {
                sums[c][v] = w.mul_add_precise(vectors[v], sums[c][v]);
            }
        }
    }
    for c in 0..GROUP {
        let channel = at.channel + c;
        for v in 0..V {
            let place = row + v * S::f32s::LEN;
            let sum = sums[c][v];
            let result = match then {
                Then::Keep => sum,
                Then::Bias(bias) => sum + S::f32s::splat(simd, bias[channel]),
                Then::Elu(bias) => elu_of_vector(simd, sum + S::f32s::splat(simd, bias[channel])),
                Then::Slope(values) => {
                    let h = S::f32s::from_slice(simd, &values[channel][place..][..S::f32s::LEN]);
                    sum * slope_of_vector(simd, h)
                }
            };
            result.store_slice(&mut out[c][place..][..S::f32s::LEN]);
        }
    }
}
