//! The gradient by a weight: sums over all rows of inputs times gradients, without transposing either.
//!
//! A vector holds one channel of sixteen rows. A sum has sixteen partial sums, one per lane, over the panels from first
//! to last. At the end the lanes are added in halves. The order is the same for every instruction set.

use lifelike_simd::vectors::{f32x4, f32x8, f64x2};
use lifelike_simd::{Simd, Task, prelude::*};

use crate::panel::{Channel, GROUP, ROWS};

/// Partial sums of a sum.
const LANES: usize = 16;
/// Inputs whose sums are on their way at once, and panels that are read for all of them before others: the first-level cache
/// holds what both need.
pub(crate) const SHARE: usize = 48;
const TOGETHER: usize = 16;

/// Some rows of the gradient by a weight, of all panels.
pub(crate) struct WeightGradient<'a> {
    /// All panels, one after another.
    pub panels: &'a [Channel],
    /// Channels of a panel.
    pub channels: usize,
    /// Channel of the first input that is wanted within a panel.
    pub inputs: usize,
    /// First channel of the gradients within a panel, and the outputs.
    pub outputs: (usize, usize),
    /// The gradient by the weight from that input on, `[up to SHARE inputs, outputs]`, row-major.
    pub gradient: &'a mut [f32],
}

impl Task for WeightGradient<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        match S::f32s::LEN {
            8 => self.tiles::<S, 2, 12>(simd),
            _ => self.tiles::<S, 3, 20>(simd),
        }
    }
}

impl WeightGradient<'_> {
    /// Tiles of `I` inputs and a group of outputs, whose sums fit into registers; `N` is their number, in fours.
    #[inline(always)]
    fn tiles<S: Simd, const I: usize, const N: usize>(self, simd: S) {
        let width = self.outputs.1;
        let count = self.gradient.len() / width.max(1);
        let panels = self.panels.len() / self.channels;
        let together = self.channels * panels.div_ceil(panels.div_ceil(TOGETHER).max(1)).max(1);
        let mut lanes = [[[0.0; LANES]; N]; SHARE.div_ceil(2)];
        for output in (0..width).step_by(GROUP) {
            for (n, panels) in self.panels.chunks(together).enumerate() {
                for (input, lanes) in (0..count).step_by(I).zip(&mut lanes) {
                    // Channels come in whole groups, so a tile at the end has something to read.
                    let from = (self.inputs + input, self.outputs.0 + output);
                    for part in 0..LANES / S::f32s::LEN {
                        accumulate::<S, I, N>(simd, panels, self.channels, from, (part, n == 0), lanes);
                    }
                }
            }
            for (input, lanes) in (0..count).step_by(I).zip(&lanes) {
                let mut sums = [0.0; N];
                for (lanes, sums) in lanes.as_chunks::<4>().0.iter().zip(sums.as_chunks_mut::<4>().0) {
                    *sums = add_up(simd, lanes);
                }
                for (i, sums) in sums.as_chunks::<GROUP>().0.iter().enumerate().take((count - input).min(I)) {
                    let to = &mut self.gradient[(input + i) * width + output..(input + i + 1) * width];
                    match to.first_chunk_mut::<GROUP>() {
                        Some(to) => *to = *sums,
                        None => to.copy_from_slice(&sums[..to.len()]),
                    }
                }
            }
        }
    }
}

/// Adds what some panels give to the lanes that one vector holds, of all sums of a tile; the first panels begin them.
#[inline(always)]
fn accumulate<S: Simd, const I: usize, const N: usize>(
    simd: S,
    panels: &[Channel],
    channels: usize,
    from: (usize, usize),
    (part, first): (usize, bool),
    lanes: &mut [[f32; LANES]; N],
) {
    let lane = (part * S::f32s::LEN).min(LANES - S::f32s::LEN);
    let mut sums = [[S::f32s::splat(simd, 0.0); GROUP]; I];
    if !first {
        for i in 0..I {
            for o in 0..GROUP {
                sums[i][o] = S::f32s::from_slice(simd, &lanes[i * GROUP + o][lane..][..S::f32s::LEN]);
            }
        }
    }
    for panel in panels.chunks_exact(channels) {
        let (Some(x), Some(y)) = (panel[from.0..].first_chunk::<I>(), panel[from.1..].first_chunk::<GROUP>()) else {
            unreachable!("a tile lies within its panel")
        };
        for row in (0..ROWS).step_by(LANES) {
            let mut inputs = [S::f32s::splat(simd, 0.0); I];
            for i in 0..I {
                inputs[i] = S::f32s::from_slice(simd, &x[i][row + lane..][..S::f32s::LEN]);
            }
            for o in 0..GROUP {
                let y = S::f32s::from_slice(simd, &y[o][row + lane..][..S::f32s::LEN]);
                for i in 0..I {
                    sums[i][o] = inputs[i].mul_add_precise(y, sums[i][o]);
                }
            }
        }
    }
    for i in 0..I {
        for o in 0..GROUP {
            sums[i][o].store_slice(&mut lanes[i * GROUP + o][lane..][..S::f32s::LEN]);
        }
    }
}

/// Adds the lanes of four sums: the upper half to the lower one until one is left.
#[inline(always)]
fn add_up<S: Simd>(simd: S, lanes: &[[f32; LANES]; 4]) -> [f32; 4] {
    let quarter = |lanes: &[f32; LANES]| {
        let half = f32x8::from_slice(simd, &lanes[..8]) + f32x8::from_slice(simd, &lanes[8..]);
        let (low, high) = simd.split_f32x8(half);
        low + high
    };
    let [a, b, c, d] = [quarter(&lanes[0]), quarter(&lanes[1]), quarter(&lanes[2]), quarter(&lanes[3])];
    // a0+a2, b0+b2, a1+a3, b1+b3; and so on.
    let ab: f32x4<S> = a.zip_low(b) + a.zip_high(b);
    let cd: f32x4<S> = c.zip_low(d) + c.zip_high(d);
    let (ab, cd): (f64x2<S>, f64x2<S>) = (ab.bitcast(), cd.bitcast());
    let (even, odd): (f32x4<S>, f32x4<S>) = (ab.zip_low(cd).bitcast(), ab.zip_high(cd).bitcast());
    (even + odd).to_array()
}

/// Sums of channels over all rows, `[channels]`: the gradient by a bias.
pub(crate) struct BiasGradient<'a> {
    /// As in [`WeightGradient`].
    pub panels: &'a [Channel],
    /// As in [`WeightGradient`].
    pub channels: usize,
    /// First channel of the gradients within a panel.
    pub first: usize,
    /// The sums.
    pub gradient: &'a mut [f32],
}

impl Task for BiasGradient<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        for (four, sums) in self.gradient.chunks_mut(4).enumerate() {
            let mut lanes = [[0.0_f32; LANES]; 4];
            for (o, lanes) in lanes.iter_mut().enumerate().take(sums.len()) {
                for (part, lanes) in lanes.chunks_exact_mut(S::f32s::LEN).enumerate() {
                    let mut sum = S::f32s::splat(simd, 0.0);
                    for panel in self.panels.chunks_exact(self.channels) {
                        let channel = &panel[self.first + 4 * four + o];
                        for row in (0..ROWS).step_by(LANES) {
                            let place = row + part * S::f32s::LEN;
                            sum += S::f32s::from_slice(simd, &channel[place..][..S::f32s::LEN]);
                        }
                    }
                    sum.store_slice(lanes);
                }
            }
            sums.iter_mut().zip(add_up(simd, &lanes)).for_each(|(sum, x)| *sum = x);
        }
    }
}
