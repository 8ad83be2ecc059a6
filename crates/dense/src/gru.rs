//! A gated recurrent unit over a window of steps (Cho et al. 2014, in the form of PyTorch's `GRU`).
//!
//! With x the inputs of a step and h the state, zero before the first step:
//!
//! r = σ(W_r x + b_r + U_r h + c_r), z = σ(W_z x + b_z + U_z h + c_z), n = tanh(W_n x + b_n + r ⊙ (U_n h + c_n)),
//! h' = n + z ⊙ (h − n).
//!
//! [`Gru`] is for rows as they come, [`PackedGru`] for panels of rows, with a pass back through all steps. Both give the same bits.

use lifelike_simd::{InstructionSet, Simd, Task, prelude::*};

use crate::elu::elu_of_vector;
use crate::panel::{Channel, ROWS, pack};
use crate::{Between, PackedPerceptron, Perceptron, Sizes};

/// Sizes of a unit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct GruSizes {
    /// Numbers of a step.
    pub inputs: usize,
    /// Numbers of the state: a multiple of [`Self::MULTIPLE`].
    pub state: usize,
    /// Steps of a window, the oldest first.
    pub steps: usize,
}

impl GruSizes {
    /// The state's size is a multiple of this, so that whole vectors hold it.
    pub const MULTIPLE: usize = 16;

    /// Returns the numbers of a window.
    pub fn window(&self) -> usize {
        self.inputs * self.steps
    }

    /// Returns the sizes of the map of the inputs, to r, z and n.
    pub fn input_map(&self) -> Sizes {
        Sizes::new(&[self.inputs, 3 * self.state])
    }

    /// Returns the sizes of the map of the state, to r, z and n.
    pub fn state_map(&self) -> Sizes {
        Sizes::new(&[self.state, 3 * self.state])
    }
}

/// Gates and next state of some numbers: r, z, n and h', from the three parts of both maps and h.
#[inline(always)]
fn cell<S: Simd>(simd: S, of_input: [S::f32s; 3], of_state: [S::f32s; 3], h: S::f32s) -> [S::f32s; 4] {
    let r = sigmoid(simd, of_input[0] + of_state[0]);
    let z = sigmoid(simd, of_input[1] + of_state[1]);
    let n = tanh(simd, r.mul_add_precise(of_state[2], of_input[2]));
    [r, z, n, z.mul_add_precise(h - n, n)]
}

/// 1 / (1 + exp(−|x|)) above zero, one less that below.
#[inline(always)]
fn sigmoid<S: Simd>(simd: S, x: S::f32s) -> S::f32s {
    let splat = |c: f32| S::f32s::splat(simd, c);
    let (zero, one) = (splat(0.0), splat(1.0));
    let power = elu_of_vector(simd, zero - x.abs()) + one;
    let above = one / (one + power);
    x.simd_lt(zero).select(power * above, above)
}

/// With e = exp(−2|x|) − 1 exactly near zero: −e / (2 + e), with the sign of x.
#[inline(always)]
fn tanh<S: Simd>(simd: S, x: S::f32s) -> S::f32s {
    let splat = |c: f32| S::f32s::splat(simd, c);
    let e = elu_of_vector(simd, splat(-2.0) * x.abs());
    let size = (splat(0.0) - e) / (splat(2.0) + e);
    x.simd_lt(splat(0.0)).select(splat(0.0) - size, size)
}

/// Memory between the steps of a [`Gru`].
#[derive(Debug, Clone, Default)]
pub struct GruMemory {
    between: Between,
    inputs: Vec<f32>,
    of_input: Vec<f32>,
    of_state: Vec<f32>,
}

/// A unit for rows as they come.
#[derive(Debug, Clone, PartialEq)]
pub struct Gru {
    sizes: GruSizes,
    input: Perceptron,
    state: Perceptron,
}

impl Gru {
    /// Takes the parameters of both maps, in the order of their [`Sizes`].
    ///
    /// # Panics
    /// There are more or fewer than the sizes say, or the state's size is no multiple of [`GruSizes::MULTIPLE`].
    pub fn new(sizes: GruSizes, input: Vec<f32>, state: Vec<f32>) -> Self {
        assert!(sizes.state.is_multiple_of(GruSizes::MULTIPLE), "size of a state");
        Self {
            sizes,
            input: Perceptron::new(sizes.input_map(), input),
            state: Perceptron::new(sizes.state_map(), state),
        }
    }

    /// Returns the sizes.
    pub fn sizes(&self) -> GruSizes {
        self.sizes
    }

    /// Returns the parameters of the map of the inputs and of that of the state.
    pub fn parameters(&self) -> [&[f32]; 2] {
        [self.input.parameters(), self.state.parameters()]
    }

    /// Writes the last states of windows, on this thread. Nothing is allocated once `memory` was used for as many rows.
    ///
    /// # Shapes
    /// `windows: [N, steps, inputs]`, the oldest step first, to `out: [N, state]`.
    ///
    /// # Panics
    /// A slice has another length.
    pub fn forward(&self, windows: &[f32], memory: &mut GruMemory, out: &mut [f32]) {
        let GruSizes { inputs, state, .. } = self.sizes;
        let width = self.sizes.window();
        let n = windows.len() / width.max(1);
        assert_eq!((windows.len(), out.len()), (n * width, n * state), "windows of a recurrent unit");
        let GruMemory { between, inputs: rows, of_input, of_state } = memory;
        of_input.resize(n * 3 * state, 0.0);
        of_state.resize(n * 3 * state, 0.0);
        out.fill(0.0);
        for step in 0..self.sizes.steps {
            rows.clear();
            rows.extend(windows.chunks_exact(width).flat_map(|window| &window[step * inputs..(step + 1) * inputs]));
            self.input.forward(rows, between, of_input);
            self.state.forward(out, between, of_state);
            let maps = of_input.chunks_exact(3 * state).zip(of_state.chunks_exact(3 * state));
            for (h, (of_input, of_state)) in out.chunks_exact_mut(state).zip(maps) {
                InstructionSet::chosen().run(Row { of_input, of_state, h });
            }
        }
    }
}

/// The next state of one row.
struct Row<'a> {
    of_input: &'a [f32],
    of_state: &'a [f32],
    h: &'a mut [f32],
}

impl Task for Row<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let (lanes, state) = (S::f32s::LEN, self.h.len());
        for at in (0..state).step_by(lanes) {
            let part = |values: &[f32], gate: usize| S::f32s::from_slice(simd, &values[gate * state + at..][..lanes]);
            let gates = |values: &[f32]| [part(values, 0), part(values, 1), part(values, 2)];
            let h = S::f32s::from_slice(simd, &self.h[at..at + lanes]);
            let [.., next] = cell(simd, gates(self.of_input), gates(self.of_state), h);
            next.store_slice(&mut self.h[at..at + lanes]);
        }
    }
}

/// A unit that learns: weights packed for the kernels, rows in panels.
///
/// A panel's memory holds, for each step, both maps' channels and the gates r, z, n; then the last state, and the loss's derivative by a
/// state.
#[derive(Debug, Clone)]
pub struct PackedGru {
    set: InstructionSet,
    sizes: GruSizes,
    input: PackedPerceptron,
    state: PackedPerceptron,
}

impl PackedGru {
    /// Packs the parameters of both maps, in the order of their [`Sizes`], one after the other.
    ///
    /// # Panics
    /// As [`Gru::new`].
    pub fn new(set: InstructionSet, sizes: GruSizes, parameters: &[f32]) -> Self {
        assert!(sizes.state.is_multiple_of(GruSizes::MULTIPLE), "size of a state");
        let (input, state) = parameters.split_at(sizes.input_map().parameters());
        Self {
            set,
            sizes,
            input: PackedPerceptron::new(set, sizes.input_map(), input),
            state: PackedPerceptron::new(set, sizes.state_map(), state),
        }
    }

    /// Packs other parameters.
    ///
    /// # Panics
    /// As [`Self::new`].
    pub fn set(&mut self, parameters: &[f32]) {
        let (input, state) = parameters.split_at(self.input.sizes().parameters());
        self.input.set(input);
        self.state.set(state);
    }

    /// Returns the sizes.
    pub fn sizes(&self) -> GruSizes {
        self.sizes
    }

    /// Channels of a step: both maps', and r, z and n.
    fn step(&self) -> usize {
        self.input.channels() + self.state.channels() + 3 * self.sizes.state
    }

    /// Returns the channels of memory that a pass forth and back over one panel takes. All must be zeros at first.
    pub fn channels(&self) -> usize {
        self.sizes.steps * self.step() + 2 * self.sizes.state
    }

    /// Computes the last states of at most [`ROWS`] windows.
    ///
    /// # Panics
    /// The panel has fewer than [`Self::channels`], or a window another length.
    pub fn forward<'a>(&self, panel: &mut [Channel], windows: impl Iterator<Item = &'a [f32]> + Clone) {
        let (inputs, first) = (self.sizes.inputs, self.input.channels());
        for step in 0..self.sizes.steps {
            let (now, after) = panel[step * self.step()..].split_at_mut(self.step());
            let (of_input, rest) = now.split_at_mut(first);
            let (of_state, gates) = rest.split_at_mut(self.state.channels());
            pack(
                windows.clone().map(|window| &window[step * inputs..(step + 1) * inputs]),
                self.input.inputs(of_input),
            );
            self.input.forward(of_input);
            self.state.forward(of_state);
            // The state stands where the next step's map reads it, and after the last step behind all.
            let next = if step + 1 < self.sizes.steps { &mut after[first..] } else { after };
            self.set.run(Gates {
                of_input: self.input.outputs(of_input),
                of_state: self.state.outputs(of_state),
                h: self.state.values_of_inputs(of_state),
                gates,
                next: &mut next[..self.sizes.state],
            });
        }
    }

    /// Returns the last states of a panel.
    pub fn outputs<'a>(&self, panel: &'a [Channel]) -> &'a [Channel] {
        &panel[self.sizes.steps * self.step()..][..self.sizes.state]
    }

    /// Returns the loss's derivative by the last states, to be written.
    pub fn by_outputs<'a>(&self, panel: &'a mut [Channel]) -> &'a mut [Channel] {
        &mut panel[self.sizes.steps * self.step() + self.sizes.state..][..self.sizes.state]
    }

    /// Computes the loss's derivative by both maps of every step from that by the last states, which is lost.
    ///
    /// # Panics
    /// The panel has fewer than [`Self::channels`].
    pub fn backward(&self, panel: &mut [Channel]) {
        let (steps, end) = panel.split_at_mut(self.sizes.steps * self.step());
        let by_h = &mut end[self.sizes.state..][..self.sizes.state];
        for (step, now) in steps.chunks_exact_mut(self.step()).enumerate().rev() {
            let (of_input, rest) = now.split_at_mut(self.input.channels());
            let (of_state, gates) = rest.split_at_mut(self.state.channels());
            self.back_through_gates(of_state, gates, by_h, self.input.by_outputs(of_input));
            if step == 0 {
                return;
            }
            self.state.backward(of_state, true);
            for (by_h, by) in by_h.iter_mut().zip(self.state.by_inputs(of_state)) {
                by_h.iter_mut().zip(by.iter()).for_each(|(sum, by)| *sum += by);
            }
        }
    }

    /// Derivatives by both maps' outputs of a step from those by its state, which become the direct part of those by
    /// the state before.
    fn back_through_gates(
        &self,
        of_state: &mut [Channel],
        gates: &[Channel],
        by_h: &mut [Channel],
        by_input: &mut [Channel],
    ) {
        let size = self.sizes.state;
        for j in 0..size {
            let (r, z, n) = (&gates[j], &gates[size + j], &gates[2 * size + j]);
            let h = self.state.values_of_inputs(of_state)[j];
            let map = self.state.outputs(of_state)[2 * size + j];
            let by_state = self.state.by_outputs(of_state);
            for row in 0..ROWS {
                let (r, z, n, by) = (r[row], z[row], n[row], by_h[j][row]);
                let by_n = by * (1.0 - z) * (1.0 - n * n);
                let by_r = by_n * map[row] * r * (1.0 - r);
                let by_z = by * (h[row] - n) * z * (1.0 - z);
                by_input[j][row] = by_r;
                by_input[size + j][row] = by_z;
                by_input[2 * size + j][row] = by_n;
                by_state[j][row] = by_r;
                by_state[size + j][row] = by_z;
                by_state[2 * size + j][row] = by_n * r;
                by_h[j][row] = by * z;
            }
        }
    }

    /// Writes the gradient by all parameters, in their order, from all panels after their passes. `channels` is the size of a panel, of which
    /// this unit's begin at `first`.
    ///
    /// # Panics
    /// A slice has another length.
    pub fn gradient(&self, panels: &[Channel], channels: usize, first: usize, gradient: &mut [f32]) {
        let mut part = vec![0.0; gradient.len()];
        gradient.fill(0.0);
        for step in 0..self.sizes.steps {
            let at = first + step * self.step();
            let (input, state) = part.split_at_mut(self.input.sizes().parameters());
            self.input.gradient(panels, channels, at, input);
            self.state.gradient(panels, channels, at + self.input.channels(), state);
            gradient.iter_mut().zip(&part).for_each(|(sum, part)| *sum += part);
        }
    }
}

/// The gates and the next state of a panel.
struct Gates<'a> {
    of_input: &'a [Channel],
    of_state: &'a [Channel],
    h: &'a [Channel],
    gates: &'a mut [Channel],
    next: &'a mut [Channel],
}

impl Task for Gates<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let (lanes, size) = (S::f32s::LEN, self.next.len());
        for j in 0..size {
            for at in (0..ROWS).step_by(lanes) {
                let load = |channel: &Channel| S::f32s::from_slice(simd, &channel[at..at + lanes]);
                let three = |channels: &[Channel]| [0, 1, 2].map(|gate| load(&channels[gate * size + j]));
                let [r, z, n, next] = cell(simd, three(self.of_input), three(self.of_state), load(&self.h[j]));
                for (gate, value) in [r, z, n].into_iter().enumerate() {
                    value.store_slice(&mut self.gates[gate * size + j][at..at + lanes]);
                }
                next.store_slice(&mut self.next[j][at..at + lanes]);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::unpack;

    const SIZES: GruSizes = GruSizes { inputs: 5, state: 16, steps: 4 };

    fn numbers(count: usize, step: usize, scale: f32) -> Vec<f32> {
        (0..count).map(|i| (((i * step) % 97) as f32 - 48.0) * scale).collect()
    }

    fn parameters() -> Vec<f32> {
        numbers(SIZES.input_map().parameters() + SIZES.state_map().parameters(), 37, 8e-3)
    }

    fn unit() -> Gru {
        let (all, split) = (parameters(), SIZES.input_map().parameters());
        Gru::new(SIZES, all[..split].to_vec(), all[split..].to_vec())
    }

    /// The equations of the module's page in double precision.
    fn exact(parameters: &[f64], window: &[f64]) -> Vec<f64> {
        let GruSizes { inputs, state, steps } = SIZES;
        let (of_input, of_state) = parameters.split_at(SIZES.input_map().parameters());
        let sigmoid = |x: f64| 1.0 / (1.0 + (-x).exp());
        let map = |weights: &[f64], x: &[f64], out: usize| {
            let sum: f64 = x.iter().enumerate().map(|(i, x)| x * weights[i * 3 * state + out]).sum();
            sum + weights[x.len() * 3 * state + out]
        };
        let mut h = vec![0.0; state];
        for step in 0..steps {
            let x = &window[step * inputs..(step + 1) * inputs];
            let next = (0..state).map(|j| {
                let (a, b) = (
                    |gate: usize| map(of_input, x, gate * state + j),
                    |gate: usize| map(of_state, &h, gate * state + j),
                );
                let (r, z) = (sigmoid(a(0) + b(0)), sigmoid(a(1) + b(1)));
                let n = (a(2) + r * b(2)).tanh();
                n + z * (h[j] - n)
            });
            h = next.collect();
        }
        h
    }

    #[test]
    fn states_are_those_of_the_equations_and_panels_give_the_same_bits_on_every_instruction_set() {
        let rows = numbers(53 * SIZES.window(), 11, 0.04);
        let mut states = vec![f32::NAN; 53 * SIZES.state];
        unit().forward(&rows, &mut GruMemory::default(), &mut states);
        let wide = |x: &[f32]| x.iter().map(|x| f64::from(*x)).collect::<Vec<f64>>();
        for (window, state) in rows.chunks_exact(SIZES.window()).zip(states.chunks_exact(SIZES.state)) {
            for (got, exact) in state.iter().zip(exact(&wide(&parameters()), &wide(window))) {
                assert!((f64::from(*got) - exact).abs() < 2e-6, "{got} {exact}");
            }
        }
        for set in InstructionSet::available() {
            let packed = PackedGru::new(set, SIZES, &parameters());
            let mut got = vec![0.0; states.len()];
            for (rows, got) in rows.chunks(ROWS * SIZES.window()).zip(got.chunks_mut(ROWS * SIZES.state)) {
                let mut panel = vec![Channel::ZERO; packed.channels()];
                packed.forward(&mut panel, rows.chunks_exact(SIZES.window()));
                unpack(packed.outputs(&panel), got);
            }
            assert!(got.iter().zip(&states).all(|(a, b)| a.to_bits() == b.to_bits()), "{set}");
        }
    }

    #[test]
    fn gradients_through_all_steps_are_those_of_finite_differences_also_in_memory_that_was_used() {
        let (rows, by) = (numbers(50 * SIZES.window(), 11, 0.04), numbers(50 * SIZES.state, 7, 0.05));
        let packed = PackedGru::new(InstructionSet::chosen(), SIZES, &parameters());
        let mut panels = vec![Channel::ZERO; 2 * packed.channels()];
        let mut gradient = vec![f32::NAN; parameters().len()];
        for _ in 0..2 {
            let parts = rows.chunks(ROWS * SIZES.window()).zip(by.chunks(ROWS * SIZES.state));
            for (panel, (rows, by)) in panels.chunks_exact_mut(packed.channels()).zip(parts) {
                packed.forward(panel, rows.chunks_exact(SIZES.window()));
                pack(by.chunks_exact(SIZES.state), packed.by_outputs(panel));
                packed.backward(panel);
            }
            packed.gradient(&panels, packed.channels(), 0, &mut gradient);
        }
        let wide = |x: &[f32]| x.iter().map(|x| f64::from(*x)).collect::<Vec<f64>>();
        let loss = |parameters: &[f64]| -> f64 {
            let pairs = rows.chunks_exact(SIZES.window()).zip(by.chunks_exact(SIZES.state));
            let weighed = pairs.map(|(rows, by)| {
                let states = exact(parameters, &wide(rows));
                states.iter().zip(by).map(|(state, by)| state * f64::from(*by)).sum::<f64>()
            });
            weighed.sum()
        };
        let scale = gradient.iter().fold(0.0_f32, |most, x| most.max(x.abs()));
        for at in (0..gradient.len()).step_by(7) {
            let moved = |by: f64| {
                let mut parameters = wide(&parameters());
                parameters[at] += by;
                loss(&parameters)
            };
            let slope = (moved(1e-5) - moved(-1e-5)) / 2e-5;
            assert!(
                (slope - f64::from(gradient[at])).abs() < 1e-5 * f64::from(scale),
                "{at}: {slope} {}",
                gradient[at]
            );
        }
    }
}
