//! The critic's perceptron in the kernels of the CPU.

use lifelike_checkpoint::rng::stream;
use lifelike_dense::{Channel, PackedPerceptron, ROWS, Sizes, pack, unpack};
use lifelike_nn::init::orthogonal;
use lifelike_simd::InstructionSet;
use rayon::prelude::*;

use super::windows::PaddedRows;

/// A perceptron from windows to one value within bounds.
///
/// Rewards are bounded, so is what they can sum to. Without bounds the network goes on linearly where no motion was, and
/// promises most for what is least like motion.
#[derive(Debug, Clone)]
pub struct CriticNetwork {
    parameters: Vec<f32>,
    packed: PackedPerceptron,
    bounds: Bounds,
}

/// Least and greatest value: v = middle + half · tanh(y / half) of the perceptron's output y.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Bounds {
    /// Least value.
    pub low: f32,
    /// Greatest value.
    pub high: f32,
}

impl Bounds {
    /// Returns the bounds of discounted sums of rewards between two.
    pub fn of_rewards(rewards: &[f32], gamma: f64) -> Self {
        let [low, high] = rewards.iter().fold([0.0_f32; 2], |[low, high], r| [low.min(*r), high.max(*r)]);
        let sum = |reward: f32| (f64::from(reward) / (1.0 - gamma)) as f32;
        // Rewards that are all zero still need some width.
        Self { low: sum(low), high: sum(high).max(sum(low) + 1e-3) }
    }

    fn half(self) -> f32 {
        0.5 * (self.high - self.low)
    }

    fn middle(self) -> f32 {
        0.5 * (self.high + self.low)
    }

    /// Returns the value of an output.
    pub fn value(self, y: f32) -> f32 {
        self.middle() + self.half() * (y / self.half()).tanh()
    }

    /// Returns the output of a value inside.
    fn output(self, value: f32) -> f32 {
        let inside = ((value - self.middle()) / self.half()).clamp(-0.99, 0.99);
        self.half() * inside.atanh()
    }

    /// Returns the derivative of a value by its output.
    fn slope(self, value: f32) -> f32 {
        1.0 - ((value - self.middle()) / self.half()).powi(2)
    }
}

impl CriticNetwork {
    /// Returns the sizes of a network.
    pub fn sizes(inputs: usize, hidden: &[usize]) -> Sizes {
        Sizes::new(&[&[inputs], hidden, &[1]].concat())
    }

    /// Takes parameters, in the order of `sizes`.
    ///
    /// # Panics
    /// There are more or fewer than the sizes say.
    pub fn new(sizes: Sizes, parameters: Vec<f32>, bounds: Bounds) -> Self {
        let packed = PackedPerceptron::new(InstructionSet::chosen(), sizes, &parameters);
        Self { parameters, packed, bounds }
    }

    /// Returns the bounds of its values.
    pub fn bounds(&self) -> Bounds {
        self.bounds
    }

    /// Returns a network with orthogonal weights whose output is near `level` at first.
    pub fn init(sizes: Sizes, seed: u64, level: f32, bounds: Bounds) -> Self {
        let mut parameters = vec![0.0; sizes.parameters()];
        let last = sizes.layers().len() - 1;
        for (l, layer) in sizes.layers().iter().enumerate() {
            let gain = if l == last { 0.1 } else { std::f64::consts::SQRT_2 };
            let weight = orthogonal(&mut stream(seed, "critic", l as u64, 0), layer.inputs, layer.outputs, gain);
            parameters[layer.weight()].copy_from_slice(&weight);
        }
        if let Some(bias) = parameters.last_mut() {
            *bias = bounds.output(level);
        }
        Self::new(sizes, parameters, bounds)
    }

    /// Returns the parameters.
    pub fn parameters(&self) -> &[f32] {
        &self.parameters
    }

    /// Changes the parameters.
    pub fn update<T>(&mut self, change: impl FnOnce(&mut [f32]) -> T) -> T {
        let changed = change(&mut self.parameters);
        self.packed.set(&self.parameters);
        changed
    }

    /// Returns the layers' sizes.
    pub fn layers(&self) -> &Sizes {
        self.packed.sizes()
    }

    /// Returns the value at every row of a motion.
    pub fn values(&self, motion: &PaddedRows) -> Vec<f32> {
        let mut values = vec![0.0; motion.len()];
        let memory = || vec![Channel::ZERO; self.packed.channels()];
        values.par_chunks_mut(ROWS).enumerate().for_each_init(memory, |panel, (i, values)| {
            self.forward(panel, (i * ROWS..i * ROWS + values.len()).map(|row| motion.window(row)), values);
        });
        values
    }

    /// Returns the value at every row, and the gradient of their sum with these weights by the padded rows.
    pub fn gradient(&self, motion: &PaddedRows, width: usize, weights: &[f32]) -> (Vec<f32>, Vec<f32>) {
        let mut values = vec![0.0; motion.len()];
        let size = motion.window_size();
        let parts: Vec<Vec<f32>> = values
            .par_chunks_mut(ROWS)
            .zip(weights.par_chunks(ROWS))
            .enumerate()
            .map_init(
                || vec![Channel::ZERO; self.packed.channels()],
                |panel, (i, (values, weights))| {
                    self.forward(panel, (i * ROWS..i * ROWS + values.len()).map(|row| motion.window(row)), values);
                    self.backward(panel, values, weights, true);
                    let mut windows = vec![0.0; values.len() * size];
                    unpack(self.packed.by_inputs(panel), &mut windows);
                    let mut part = vec![0.0; (values.len() - 1) * width + size];
                    for (r, window) in windows.chunks_exact(size).enumerate() {
                        part[r * width..][..size].iter_mut().zip(window).for_each(|(sum, x)| *sum += x);
                    }
                    part
                },
            )
            .collect();
        // Panels overlap: they are summed in their order.
        let mut by = vec![0.0; motion.len().saturating_sub(1) * width + size];
        for (i, part) in parts.iter().enumerate() {
            by[i * ROWS * width..][..part.len()].iter_mut().zip(part).for_each(|(sum, x)| *sum += x);
        }
        (values, by)
    }

    /// Computes the values of at most [`ROWS`] windows in a panel's memory.
    pub fn forward<'a>(&self, panel: &mut [Channel], windows: impl Iterator<Item = &'a [f32]>, values: &mut [f32]) {
        pack(windows, self.packed.inputs(panel));
        self.packed.forward(panel);
        unpack(self.packed.outputs(panel), values);
        values.iter_mut().for_each(|value| *value = self.bounds.value(*value));
    }

    /// Computes the derivatives by every layer of a panel, by the inputs too where asked for, from the values and the
    /// derivatives by them.
    pub fn backward(&self, panel: &mut [Channel], values: &[f32], by_values: &[f32], through: bool) {
        let by: Vec<f32> = values.iter().zip(by_values).map(|(v, by)| by * self.bounds.slope(*v)).collect();
        pack(by.chunks_exact(1), self.packed.by_outputs(panel));
        self.packed.backward(panel, through);
    }

    /// Returns the channels of a panel.
    pub fn channels(&self) -> usize {
        self.packed.channels()
    }

    /// Writes the gradient by all parameters, from all panels.
    pub fn by_parameters(&self, panels: &[Channel], gradient: &mut [f32]) {
        self.packed.gradient(panels, self.packed.channels(), 0, gradient);
    }
}
