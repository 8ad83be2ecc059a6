//! Interpretable multi-head attention (Lim et al. 2021, eqs. 13 to 16) of the present step over the last K steps and itself.

use lifelike_simd::vectorize;

use crate::rows::elementary::{dot, exp};
use crate::rows::tile::LANES;
use crate::rows::{Entry, Layout, Linear};

/// Sizes of [`HistoryAttention`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct HistorySizes {
    /// c: numbers of a row.
    pub width: usize,
    /// Heads, which share their values; they divide the width.
    pub heads: usize,
    /// K: steps that are looked back on.
    pub steps: usize,
}

impl HistorySizes {
    /// Numbers of a head's query and key, and of the values.
    fn head(self) -> usize {
        self.width / self.heads
    }
}

/// Attention with queries and keys for each head and one value for all. The mean of the heads' weights therefore says
/// which step counted (Fig. 2.11 of the thesis).
///
/// Past and present are different rows: what was, with its error, and what is, whose error is not yet known. Step t looks at
/// the past rows t - K to t - 1 and at its own present row.
#[derive(Debug, Clone)]
pub struct HistoryAttention {
    sizes: HistorySizes,
    query: Linear,
    key: Linear,
    value: Linear,
    output: Linear,
}

/// Numbers that the way back needs.
#[derive(Debug, Clone)]
pub struct AttentionPass {
    sequences: usize,
    past: Vec<f32>,
    present: Vec<f32>,
    query: Vec<f32>,
    /// Keys and values of the past.
    before: KeyValue,
    /// Keys and values of the present.
    own: KeyValue,
    mixed: Vec<f32>,
}

/// Keys `[rows, c]` and values `[rows, c / heads]` of rows: what remembers a past step.
#[derive(Debug, Clone, PartialEq)]
pub struct KeyValue {
    /// Keys.
    pub key: Vec<f32>,
    /// Values.
    pub value: Vec<f32>,
}

/// One sequence's keys and values, each number's steps side by side.
struct Turned {
    key: Vec<f32>,
    value: Vec<f32>,
    steps: usize,
}

impl Turned {
    fn new(rows: &KeyValue, sizes: HistorySizes, sequence: usize, sequences: usize) -> Self {
        let turn = |rows: &[f32], width: usize| {
            let steps = rows.len() / (width * sequences);
            let mut out = vec![0.0; steps * width];
            for (t, row) in rows.chunks_exact(width).skip(sequence).step_by(sequences).enumerate() {
                row.iter().enumerate().for_each(|(i, x)| out[i * steps + t] = *x);
            }
            out
        };
        let (key, value) = (turn(&rows.key, sizes.width), turn(&rows.value, sizes.head()));
        Self { steps: key.len() / sizes.width, key, value }
    }

    fn zeros(steps: usize, sizes: HistorySizes) -> Self {
        Self { key: vec![0.0; steps * sizes.width], value: vec![0.0; steps * sizes.head()], steps }
    }

    /// Adds itself to rows.
    fn add_to(&self, rows: &mut KeyValue, sizes: HistorySizes, sequence: usize, sequences: usize) {
        let add = |turned: &[f32], rows: &mut [f32], width: usize| {
            for (t, row) in rows.chunks_exact_mut(width).skip(sequence).step_by(sequences).enumerate() {
                row.iter_mut().enumerate().for_each(|(i, x)| *x += turned[i * self.steps + t]);
            }
        };
        add(&self.key, &mut rows.key, sizes.width);
        add(&self.value, &mut rows.value, sizes.head());
    }

    /// One number's last n steps before t.
    #[inline(always)]
    fn window<'a>(&self, numbers: &'a [f32], i: usize, t: usize, n: usize) -> &'a [f32] {
        &numbers[i * self.steps + t - n..][..n]
    }

    #[inline(always)]
    fn window_mut(steps: usize, numbers: &mut [f32], i: usize, t: usize, n: usize) -> &mut [f32] {
        &mut numbers[i * steps + t - n..][..n]
    }
}

/// Memory of one sequence's weights.
struct Scratch {
    /// Of one head; the present step's own stands last.
    weights: Vec<f32>,
    /// The mean over the heads.
    mean: Vec<f32>,
    by_mean: Vec<f32>,
    by: Vec<f32>,
}

impl Scratch {
    fn new(steps: usize) -> Self {
        let zeros = vec![0.0; steps + 1];
        Self { weights: zeros.clone(), mean: zeros.clone(), by_mean: zeros.clone(), by: zeros }
    }
}

impl HistoryAttention {
    /// Returns its parameters: `NAME.query`, `NAME.key`, `NAME.value` and `NAME.output`.
    pub fn entries(name: &str, sizes: HistorySizes) -> Vec<Entry> {
        let shapes = Self::shapes(sizes);
        shapes.into_iter().flat_map(|(part, [i, o])| Entry::linear(&format!("{name}.{part}"), i, o)).collect()
    }

    fn shapes(sizes: HistorySizes) -> [(&'static str, [usize; 2]); 4] {
        let (c, d) = (sizes.width, sizes.head());
        [("query", [c, c]), ("key", [c, c]), ("value", [c, d]), ("output", [d, c])]
    }

    /// Packs parameters that stand as the layout says.
    pub fn new(name: &str, sizes: HistorySizes, layout: &Layout, values: &[f32]) -> Self {
        let [query, key, value, output] =
            Self::shapes(sizes).map(|(part, shape)| Linear::new(&format!("{name}.{part}"), shape, layout, values));
        Self { sizes, query, key, value, output }
    }

    /// Returns keys and values of rows.
    pub fn remember(&self, rows: &[f32]) -> KeyValue {
        KeyValue { key: self.key.forward(rows), value: self.value.forward(rows) }
    }

    /// Goes forward through sequences of one length.
    ///
    /// # Shapes
    /// `past`, `present`: `[steps, sequences, c]` to `[steps, sequences, c]`.
    pub fn forward(&self, past: Vec<f32>, present: Vec<f32>, sequences: usize) -> (Vec<f32>, AttentionPass) {
        let query = self.query.forward(&present);
        let (before, own) = (self.remember(&past), self.remember(&present));
        let mut mixed = vec![0.0; own.value.len()];
        self.each_step(&query, &before, &own, sequences, |row, turned, t, mean| {
            self.mix(turned, t, mean, &own, row, &mut mixed);
        });
        let out = self.output.forward(&mixed);
        (out, AttentionPass { sequences, past, present, query, before, own, mixed })
    }

    /// Returns the mean weight of each step, from the one before (0) to K steps before (K - 1), and last the present
    /// one's own. Over the rows that have K steps before them.
    pub fn profile(&self, pass: &AttentionPass) -> Vec<f64> {
        let k = self.sizes.steps;
        let (mut sums, mut rows) = (vec![0.0; k + 1], 0.0_f64);
        self.each_step(&pass.query, &pass.before, &pass.own, pass.sequences, |_, _, _, mean| {
            if mean.len() == k + 1 {
                rows += 1.0;
                mean[..k].iter().rev().chain(&mean[k..]).zip(&mut sums).for_each(|(w, sum)| *sum += f64::from(*w));
            }
        });
        sums.iter_mut().for_each(|sum| *sum /= rows.max(1.0));
        sums
    }

    /// Attends from one step of each of some rows to that row's records, the oldest first; for passes step by step.
    ///
    /// # Shapes
    /// `present: [rows, c]`; `past(row)` gives at most K pairs of a key `[c]` and a value `[c / heads]`.
    pub fn step<'a, I>(&self, present: &[f32], past: impl Fn(usize) -> I) -> Vec<f32>
    where
        I: Iterator<Item = (&'a [f32], &'a [f32])>,
    {
        let (c, d, heads) = (self.sizes.width, self.sizes.head(), self.sizes.heads);
        let scale = (d as f32).powf(-0.5);
        let (query, own) = (self.query.forward(present), self.remember(present));
        let mut mixed = vec![0.0; own.value.len()];
        // Column by column, so that all steps are scored side by side.
        let stride = self.sizes.steps + 1;
        let (mut keys, mut values) = (vec![0.0_f32; c * stride], vec![0.0_f32; d * stride]);
        let (mut scores, mut weights) = (vec![0.0_f32; stride], vec![0.0_f32; stride]);
        for (row, mixed) in mixed.chunks_exact_mut(d).enumerate() {
            let query = &query[row * c..][..c];
            let mut count = 0;
            let mut put = |key: &[f32], value: &[f32]| {
                let place = |columns: &mut [f32], numbers: &[f32]| {
                    columns[count..].iter_mut().step_by(stride).zip(numbers).for_each(|(slot, x)| *slot = *x);
                };
                place(&mut keys, key);
                place(&mut values, value);
                count += 1;
            };
            past(row).for_each(|(key, value)| put(key, value));
            put(&own.key[row * c..][..c], &own.value[row * d..][..d]);
            let (scores, weights) = (&mut scores[..count], &mut weights[..count]);
            vectorize(
                #[inline(always)]
                || {
                    weights.fill(0.0);
                    for head in 0..heads {
                        scores.fill(0.0);
                        for i in head * d..(head + 1) * d {
                            let query = scale * query[i];
                            let keys = &keys[i * stride..][..scores.len()];
                            scores.iter_mut().zip(keys).for_each(|(score, key)| *score += query * key);
                        }
                        softmax(scores);
                        weights.iter_mut().zip(&*scores).for_each(|(sum, x)| *sum += x);
                    }
                    // Heads share their values, so their weights can be summed first.
                    for (mixed, values) in mixed.iter_mut().zip(values.chunks_exact(stride)) {
                        *mixed = dot(weights, &values[..weights.len()]) / heads as f32;
                    }
                },
            );
        }
        self.output.forward(&mixed)
    }

    /// Adds the parameters' gradients; returns those by past and present.
    pub fn backward(&self, pass: AttentionPass, gradient: &[f32], sums: &mut [f32]) -> (Vec<f32>, Vec<f32>) {
        let AttentionPass { sequences, past, present, query, before, own, mixed } = pass;
        let sizes = self.sizes;
        let by_mixed = self.output.backward(&mixed, gradient, sums);
        let zeros = |like: &KeyValue| KeyValue { key: vec![0.0; like.key.len()], value: vec![0.0; like.value.len()] };
        let (mut by_query, mut by_before, mut by_own) = (vec![0.0; query.len()], zeros(&before), zeros(&own));
        for sequence in 0..sequences {
            let turned = Turned::new(&before, sizes, sequence, sequences);
            let mut by_turned = Turned::zeros(turned.steps, sizes);
            let mut scratch = Scratch::new(sizes.steps);
            vectorize(
                #[inline(always)]
                || {
                    for t in 0..turned.steps {
                        let row = t * sequences + sequence;
                        let context = Step { sizes, row, t, turned: &turned, own: &own, query: &query };
                        context.backward(&mut scratch, &by_mixed, &mut by_turned, &mut by_query, &mut by_own);
                    }
                },
            );
            by_turned.add_to(&mut by_before, sizes, sequence, sequences);
        }
        let mut by_present = self.query.backward(&present, &by_query, sums);
        crate::rows::add(&mut by_present, &self.key.backward(&present, &by_own.key, sums));
        crate::rows::add(&mut by_present, &self.value.backward(&present, &by_own.value, sums));
        let mut by_past = self.key.backward(&past, &by_before.key, sums);
        crate::rows::add(&mut by_past, &self.value.backward(&past, &by_before.value, sums));
        (by_past, by_present)
    }

    /// Calls `job(row, keys and values, t, mean weights)` for every step of every sequence.
    fn each_step(
        &self,
        query: &[f32],
        before: &KeyValue,
        own: &KeyValue,
        sequences: usize,
        mut job: impl FnMut(usize, &Turned, usize, &[f32]),
    ) {
        for sequence in 0..sequences {
            let turned = Turned::new(before, self.sizes, sequence, sequences);
            let mut scratch = Scratch::new(self.sizes.steps);
            for t in 0..turned.steps {
                let row = t * sequences + sequence;
                let context = Step { sizes: self.sizes, row, t, turned: &turned, own, query };
                vectorize(
                    #[inline(always)]
                    || context.weigh(&mut scratch),
                );
                job(row, &turned, t, &scratch.mean[..context.n() + 1]);
            }
        }
    }

    /// Writes Σ w v of one step.
    fn mix(&self, turned: &Turned, t: usize, mean: &[f32], own: &KeyValue, row: usize, mixed: &mut [f32]) {
        let (d, n) = (self.sizes.head(), mean.len() - 1);
        vectorize(
            #[inline(always)]
            || {
                for (i, mixed) in mixed[row * d..][..d].iter_mut().enumerate() {
                    *mixed = dot(&mean[..n], turned.window(&turned.value, i, t, n)) + mean[n] * own.value[row * d + i];
                }
            },
        );
    }
}

/// One step of one sequence.
struct Step<'a> {
    sizes: HistorySizes,
    row: usize,
    t: usize,
    turned: &'a Turned,
    own: &'a KeyValue,
    query: &'a [f32],
}

impl Step<'_> {
    /// Steps that it looks back on.
    #[inline(always)]
    fn n(&self) -> usize {
        self.t.min(self.sizes.steps)
    }

    /// One head's weights.
    #[inline(always)]
    fn head(&self, head: usize, weights: &mut [f32]) {
        let Self { sizes, row, t, turned, own, query } = *self;
        let (n, d) = (self.n(), sizes.head());
        let scale = (d as f32).powf(-0.5);
        weights.fill(0.0);
        for i in head * d..(head + 1) * d {
            let q = scale * query[row * sizes.width + i];
            let keys = turned.window(&turned.key, i, t, n);
            weights[..n].iter_mut().zip(keys).for_each(|(w, key)| *w += q * key);
            weights[n] += q * own.key[row * sizes.width + i];
        }
        softmax(weights);
    }

    /// The mean of the heads' weights.
    #[inline(always)]
    fn weigh(&self, scratch: &mut Scratch) {
        let n = self.n();
        scratch.mean[..=n].fill(0.0);
        let share = 1.0 / self.sizes.heads as f32;
        for head in 0..self.sizes.heads {
            self.head(head, &mut scratch.weights[..=n]);
            scratch.mean[..=n].iter_mut().zip(&scratch.weights).for_each(|(mean, w)| *mean += share * w);
        }
    }

    #[inline(always)]
    fn backward(
        &self,
        scratch: &mut Scratch,
        by_mixed: &[f32],
        by_turned: &mut Turned,
        by_query: &mut [f32],
        by_own: &mut KeyValue,
    ) {
        let Self { sizes, row, t, turned, own, query } = *self;
        let (n, c, d) = (self.n(), sizes.width, sizes.head());
        let (scale, share, steps) = ((d as f32).powf(-0.5), 1.0 / sizes.heads as f32, turned.steps);
        self.weigh(scratch);
        let Scratch { weights, mean, by_mean, by } = scratch;
        let (weights, mean, by_mean, by) = (&mut weights[..=n], &mean[..=n], &mut by_mean[..=n], &mut by[..=n]);
        by_mean.fill(0.0);
        for i in 0..d {
            let dy = by_mixed[row * d + i];
            let values = turned.window(&turned.value, i, t, n);
            let by_values = Turned::window_mut(steps, &mut by_turned.value, i, t, n);
            for (((by, value), by_value), w) in by_mean.iter_mut().zip(values).zip(by_values).zip(mean) {
                *by += dy * value;
                *by_value += dy * w;
            }
            by_mean[n] += dy * own.value[row * d + i];
            by_own.value[row * d + i] += dy * mean[n];
        }
        for head in 0..sizes.heads {
            self.head(head, weights);
            let along = dot(weights, by_mean);
            for ((by, w), by_mean) in by.iter_mut().zip(&*weights).zip(&*by_mean) {
                *by = share * w * (by_mean - along);
            }
            for i in head * d..(head + 1) * d {
                let q = scale * query[row * c + i];
                let keys = turned.window(&turned.key, i, t, n);
                by_query[row * c + i] = scale * (dot(&by[..n], keys) + by[n] * own.key[row * c + i]);
                let by_keys = Turned::window_mut(steps, &mut by_turned.key, i, t, n);
                by_keys.iter_mut().zip(&*by).for_each(|(by_key, by)| *by_key += q * by);
                by_own.key[row * c + i] += q * by[n];
            }
        }
    }
}

#[inline(always)]
fn softmax(x: &mut [f32]) {
    let most = x.iter().fold(f32::MIN, |most, x| if *x > most { *x } else { most });
    for x in x.iter_mut() {
        *x = exp(*x - most);
    }
    let sum = {
        let mut sums = [0.0_f32; LANES];
        let (lanes, rest) = x.as_chunks::<LANES>();
        lanes.iter().for_each(|lanes| sums.iter_mut().zip(lanes).for_each(|(sum, x)| *sum += x));
        sums.iter().sum::<f32>() + rest.iter().sum::<f32>()
    };
    let share = 1.0 / sum;
    x.iter_mut().for_each(|x| *x *= share);
}
