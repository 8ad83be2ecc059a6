//! The network: which words of a sentence ask for an action, and for which.

use std::collections::BTreeMap;
use std::ops::Range;

use lifelike_nn::losses::{softmax, softmax_cross_entropy};
use lifelike_nn::parameters::Parameters;
use lifelike_nn::rows::{Entry, Init, Layout, Linear};
use lifelike_nn::transformer::encoder::{Encoder, EncoderPass, EncoderSizes};
use rand::Rng;
use rand_chacha::ChaCha8Rng;

use super::sentences::Sentence;
use crate::error::LanguageError;
use crate::script::meaning::Words;

/// Numbers that are learned of each word, beside its vector.
const OWN: usize = 32;
/// Words to both sides that a word's row has.
const BESIDE: usize = 2;
/// Rows of a word: itself and its neighbours.
const WINDOW: usize = 2 * BESIDE + 1;
/// Classes of a word: it asks for nothing, begins an action, or continues one.
const TAGS: usize = 3;
/// Most words that are read at once.
pub(super) const MOST_WORDS: usize = 96;
/// Probability below which a word does not begin an action, nor end one.
const UNLIKELY: f64 = 0.02;
/// Weight of a label's probability beside that of the tags.
const LABEL: f64 = 1.0;
const SIZES: EncoderSizes = EncoderSizes { width: 256, layers: 2, heads: 8, inner: 512 };

/// Words, labels and parameters.
#[derive(Debug, Clone)]
pub(super) struct Network {
    vocabulary: BTreeMap<String, usize>,
    /// Names of actions.
    pub labels: Vec<String>,
    pub parameters: Parameters,
    vectors: &'static Words,
}

/// Words of a sentence that ask for an action, with the probability of each label.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Span {
    pub words: Range<usize>,
    /// Geometric mean of the probabilities of their tags.
    pub certainty: f32,
    /// Probability of each label.
    pub labels: Vec<f32>,
}

/// Words and numbers that are left out at random while the network learns.
#[derive(Debug)]
pub(super) struct Noise {
    pub rng: ChaCha8Rng,
    /// Share of words whose own numbers are left out.
    pub own: f32,
    /// Share of words that are left out.
    pub words: f32,
    /// Share of the numbers behind the first layer that are left out; the others are enlarged.
    pub numbers: f32,
}

impl Noise {
    /// Returns whether a word has its own numbers, and its vector.
    fn word(&mut self) -> [bool; 2] {
        let x: f32 = self.rng.random();
        [x >= self.own + self.words, x >= self.words]
    }

    fn drop_out(&mut self, numbers: &mut [f32]) {
        let larger = 1.0 / (1.0 - self.numbers);
        for x in numbers {
            *x *= if self.rng.random::<f32>() < self.numbers { 0.0 } else { larger };
        }
    }
}

/// Weights packed for many sentences.
pub(super) struct Packed {
    input: Linear,
    encoder: Encoder,
    tags: Linear,
    verbs: Linear,
}

/// Sentences of one pass, one after the other.
pub(super) struct Batch {
    lengths: Vec<usize>,
    /// Number of each word, where it has one.
    ids: Vec<Option<usize>>,
    windows: Vec<f32>,
}

struct Pass {
    input: Vec<f32>,
    hidden: Vec<f32>,
    encoder: EncoderPass,
}

/// Loss and gradient of some sentences.
pub(super) struct Lesson {
    pub loss: f64,
    pub gradient: Vec<f32>,
}

impl Network {
    /// Returns a network with first values of a seed.
    pub fn new(vocabulary: Vec<String>, labels: Vec<String>, seed: u64) -> Result<Self, LanguageError> {
        let layout = layout(vocabulary.len(), labels.len())?;
        let values = layout.init(seed, "reader");
        Ok(Self {
            vocabulary: vocabulary.into_iter().zip(0..).collect(),
            labels,
            parameters: Parameters::new(layout, values),
            vectors: Words::builtin()?,
        })
    }

    /// Returns the words that have numbers of their own, in the order of these.
    pub fn words(&self) -> Vec<&str> {
        let mut words: Vec<(&str, usize)> = self.vocabulary.iter().map(|(word, id)| (word.as_str(), *id)).collect();
        words.sort_by_key(|(_, id)| *id);
        words.into_iter().map(|(word, _)| word).collect()
    }

    /// Returns the parameters that decay: the matrices.
    pub fn decaying(&self) -> Vec<Range<usize>> {
        let entries = self.parameters.layout().entries().iter();
        entries.filter(|entry| entry.shape.len() > 1).map(|entry| self.parameters.range(&entry.name)).collect()
    }

    /// Packs the weights.
    pub fn packed(&self) -> Packed {
        let (layout, values) = (self.parameters.layout(), self.parameters.values());
        let c = SIZES.width;
        Packed {
            input: Linear::new("input", [WINDOW * self.features(), c], layout, values),
            encoder: Encoder::new(SIZES, layout, "encoder", values),
            tags: Linear::new("tags", [c, TAGS], layout, values),
            verbs: Linear::new("verbs", [2 * c, self.labels.len()], layout, values),
        }
    }

    fn features(&self) -> usize {
        self.vectors.width() + OWN
    }

    /// Lays sentences out in rows. Noise leaves out the numbers of words.
    pub fn batch<'a>(&self, sentences: impl Iterator<Item = &'a [String]>, mut noise: Option<&mut Noise>) -> Batch {
        let (width, vector) = (self.features(), self.vectors.width());
        let own = self.parameters.get("words");
        let (mut lengths, mut ids, mut windows) = (Vec::new(), Vec::new(), Vec::new());
        for words in sentences {
            let mut rows = vec![0.0_f32; words.len() * width];
            for (word, row) in words.iter().zip(rows.chunks_exact_mut(width)) {
                let [keeps_own, keeps_vector] = noise.as_mut().map_or([true; 2], |noise| noise.word());
                if keeps_vector {
                    self.vectors.add(word, &mut row[..vector]);
                }
                let id = self.vocabulary.get(word).copied().filter(|_| keeps_own);
                if let Some(id) = id {
                    row[vector..].copy_from_slice(&own[id * OWN..(id + 1) * OWN]);
                }
                ids.push(id);
            }
            for at in 0..words.len() {
                for near in 0..WINDOW {
                    match (at + near).checked_sub(BESIDE).filter(|from| *from < words.len()) {
                        Some(from) => windows.extend_from_slice(&rows[from * width..(from + 1) * width]),
                        None => windows.resize(windows.len() + width, 0.0),
                    }
                }
            }
            lengths.push(words.len());
        }
        Batch { lengths, ids, windows }
    }

    /// Returns the words of a text that ask for actions. A long one is read in parts, divided where a sentence ends.
    pub fn spans(&self, packed: &Packed, words: &[String]) -> Vec<Span> {
        let (mut from, mut out) = (0, Vec::new());
        while from < words.len() {
            let part = &words[from..words.len().min(from + MOST_WORDS)];
            let is_last = from + part.len() == words.len();
            let ends = part.iter().rposition(|word| word == "|").filter(|_| !is_last);
            let length = ends.map_or(part.len(), |end| end + 1);
            for span in self.spans_of_part(packed, &part[..length]) {
                out.push(Span { words: span.words.start + from..span.words.end + from, ..span });
            }
            from += length;
        }
        out
    }

    fn spans_of_part(&self, packed: &Packed, words: &[String]) -> Vec<Span> {
        let batch = self.batch(std::iter::once(words), None);
        let pass = packed.forward(&batch, None);
        let mut tags = packed.tags.forward(&pass.hidden);
        tags.chunks_exact_mut(TAGS).for_each(softmax);
        let n = words.len();
        let tag = |at: usize, tag: usize| f64::from(tags[at * TAGS + tag]).max(1e-9).ln();
        // Best division of the first words, by its probability: that of the tags, and of each action's label.
        let mut best: Vec<(f64, Option<Span>)> = vec![(0.0, None)];
        for end in 1..=n {
            let mut here = (best[end - 1].0 + tag(end - 1, 0), None);
            let closes = end == n || tag(end, 2).exp() < 1.0 - UNLIKELY;
            let mut inside = 0.0;
            for start in (0..end).rev().filter(|_| closes) {
                if tag(start, 1).exp() > UNLIKELY {
                    let mut labels = packed.verbs.forward(&pooled(&pass.hidden, &(start..end)));
                    softmax(&mut labels);
                    let tags = tag(start, 1) + inside;
                    let label = labels.iter().copied().fold(0.0, f32::max);
                    let score = best[start].0 + tags + LABEL * f64::from(label).ln();
                    if score > here.0 {
                        let certainty = (tags / (end - start) as f64).exp() as f32;
                        here = (score, Some(Span { words: start..end, certainty, labels }));
                    }
                }
                inside += tag(start, 2);
            }
            best.push(here);
        }
        let mut out = Vec::new();
        let mut end = n;
        while end > 0 {
            match best[end].1.take() {
                Some(span) => {
                    end = span.words.start;
                    out.push(span);
                }
                None => end -= 1,
            }
        }
        out.reverse();
        out
    }

    /// Returns the probability of each label for all words together; nothing where there are none.
    pub fn label(&self, packed: &Packed, words: &[String]) -> Option<Vec<f32>> {
        let words = &words[..words.len().min(MOST_WORDS)];
        if words.is_empty() {
            return None;
        }
        let hidden = packed.forward(&self.batch(std::iter::once(words), None), None).hidden;
        let mut row = packed.verbs.forward(&pooled(&hidden, &(0..words.len())));
        softmax(&mut row);
        Some(row)
    }

    /// Returns the likeliest label of each marked action of a sentence.
    pub fn named(&self, packed: &Packed, sentence: &Sentence) -> Vec<usize> {
        let batch = self.batch(std::iter::once(sentence.words.as_slice()), None);
        let hidden = packed.forward(&batch, None).hidden;
        let label = |(range, _): &(Range<usize>, usize)| most_likely(&packed.verbs.forward(&pooled(&hidden, range)));
        sentence.spans.iter().map(label).collect()
    }

    /// Returns the mean loss of sentences and its gradient: cross entropy of the words' tags and of the actions' labels.
    pub fn learn(
        &self,
        packed: &Packed,
        sentences: &[Sentence],
        mut noise: Option<&mut Noise>,
        smoothing: f32,
    ) -> Lesson {
        let batch = self.batch(sentences.iter().map(|one| one.words.as_slice()), noise.as_deref_mut());
        let larger = noise.as_ref().map_or(1.0, |noise| 1.0 / (1.0 - noise.numbers));
        let pass = packed.forward(&batch, noise);
        let (c, share) = (SIZES.width, 1.0 / sentences.len().max(1) as f32);
        let mut sums = vec![0.0; self.parameters.len()];
        let mut loss = 0.0;

        let mut tags = packed.tags.forward(&pass.hidden);
        let targets = sentences.iter().flat_map(Sentence::tags);
        for (row, target) in tags.chunks_exact_mut(TAGS).zip(targets) {
            loss += softmax_cross_entropy(row, target, 0.0, share * 0.3);
        }
        let mut by_hidden = packed.tags.backward(&pass.hidden, &tags, &mut sums);

        let mut from = 0;
        let mut places: Vec<(Range<usize>, usize)> = Vec::new();
        for one in sentences {
            places.extend(one.spans.iter().map(|(range, label)| (range.start + from..range.end + from, *label)));
            from += one.words.len();
        }
        let rows: Vec<f32> = places.iter().flat_map(|(range, _)| pooled(&pass.hidden, range)).collect();
        let mut labels = packed.verbs.forward(&rows);
        for (row, (_, target)) in labels.chunks_exact_mut(self.labels.len().max(1)).zip(&places) {
            loss += softmax_cross_entropy(row, *target, smoothing, share);
        }
        let by_rows = packed.verbs.backward(&rows, &labels, &mut sums);
        for ((range, _), gradient) in places.iter().zip(by_rows.chunks_exact(2 * c)) {
            spread(&pass.hidden, range, gradient, &mut by_hidden);
        }

        let by_input = packed.encoder.backward(pass.encoder, by_hidden, &mut sums);
        let by_input: Vec<f32> =
            by_input.iter().zip(&pass.input).map(|(g, x)| if *x > 0.0 { g * larger } else { 0.0 }).collect();
        let by_windows = packed.input.backward(&batch.windows, &by_input, &mut sums);
        let place = self.parameters.range("words");
        batch.add_to_words(&by_windows, self.features(), &mut sums[place]);
        Lesson { loss, gradient: sums }
    }
}

impl Packed {
    fn forward(&self, batch: &Batch, noise: Option<&mut Noise>) -> Pass {
        let mut input = self.input.forward(&batch.windows);
        input.iter_mut().for_each(|x| *x = x.max(0.0));
        if let Some(noise) = noise {
            noise.drop_out(&mut input);
        }
        let (hidden, encoder) = self.encoder.forward(input.clone(), &batch.lengths);
        Pass { input, hidden, encoder }
    }
}

impl Batch {
    /// Adds the gradient of the windows to that of the words' own numbers.
    fn add_to_words(&self, by_windows: &[f32], width: usize, sums: &mut [f32]) {
        let mut first = 0;
        for &length in &self.lengths {
            for at in 0..length {
                let window = &by_windows[(first + at) * WINDOW * width..(first + at + 1) * WINDOW * width];
                for near in 0..WINDOW {
                    let from = (at + near).checked_sub(BESIDE).filter(|from| *from < length);
                    let Some(id) = from.and_then(|from| self.ids[first + from]) else { continue };
                    let gradient = &window[(near + 1) * width - OWN..(near + 1) * width];
                    sums[id * OWN..(id + 1) * OWN].iter_mut().zip(gradient).for_each(|(sum, g)| *sum += g);
                }
            }
            first += length;
        }
    }
}

fn layout(words: usize, labels: usize) -> Result<Layout, LanguageError> {
    let broken = |e: &dyn std::fmt::Display| LanguageError::Grammar(format!("reader: {e}"));
    let features = Words::builtin()?.width() + OWN;
    let own = Entry { name: "words".into(), shape: vec![words, OWN], init: Init::Normal(0.1) };
    let mut entries = vec![own];
    entries.extend(Entry::linear("input", WINDOW * features, SIZES.width));
    entries.extend(SIZES.entries("encoder").map_err(|e| broken(&e))?);
    entries.extend(Entry::linear("tags", SIZES.width, TAGS));
    entries.extend(Entry::linear("verbs", 2 * SIZES.width, labels));
    Ok(Layout::new(entries))
}

/// Returns mean and maximum of the rows of some words.
fn pooled(hidden: &[f32], words: &Range<usize>) -> Vec<f32> {
    let c = SIZES.width;
    let (mut mean, mut most) = (vec![0.0; c], vec![f32::NEG_INFINITY; c]);
    let share = 1.0 / words.len().max(1) as f32;
    for row in hidden[words.start * c..words.end * c].chunks_exact(c) {
        for ((mean, most), x) in mean.iter_mut().zip(&mut most).zip(row) {
            *mean += x * share;
            *most = most.max(*x);
        }
    }
    mean.extend(most);
    mean
}

/// Adds the gradient by the mean and the maximum of some words' rows to that of the rows.
fn spread(hidden: &[f32], words: &Range<usize>, gradient: &[f32], by_hidden: &mut [f32]) {
    let c = SIZES.width;
    let share = 1.0 / words.len().max(1) as f32;
    for j in 0..c {
        let mut most = words.start;
        for at in words.clone() {
            by_hidden[at * c + j] += share * gradient[j];
            if hidden[at * c + j] > hidden[most * c + j] {
                most = at;
            }
        }
        by_hidden[most * c + j] += gradient[c + j];
    }
}

/// Returns the place of the largest number.
pub(super) fn most_likely(labels: &[f32]) -> usize {
    (0..labels.len()).max_by(|a, b| labels[*a].total_cmp(&labels[*b])).unwrap_or(0)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn words(text: &str) -> Vec<String> {
        text.split(' ').map(str::to_string).collect()
    }

    /// Central differences of the whole loss, along the gradient by each parameter block.
    #[test]
    fn the_gradient_is_that_of_the_loss() {
        let labels = ["walk", "wave", "bow"].map(str::to_string).to_vec();
        let mut network = Network::new(words("stroll wave and deep hand"), labels, 3).unwrap();
        let sentences = [
            Sentence { words: words("please stroll over there and wave hand"), spans: vec![(1..4, 0), (5..7, 1)] },
            Sentence { words: words("deep bow"), spans: vec![(0..2, 2)] },
        ];
        let found = network.learn(&network.packed(), &sentences, None, 0.1).gradient;
        let layout = std::sync::Arc::clone(network.parameters.layout());
        let first = network.parameters.values().to_vec();
        for entry in layout.entries() {
            let range = layout.range(&entry.name);
            let length = found[range.clone()].iter().map(|g| g * g).sum::<f32>().sqrt();
            let mut loss = |step: f32| {
                network.parameters.values_mut().copy_from_slice(&first);
                let values = &mut network.parameters.values_mut()[range.clone()];
                values.iter_mut().zip(&found[range.clone()]).for_each(|(x, g)| *x += step * g / length);
                network.learn(&network.packed(), &sentences, None, 0.1).loss
            };
            let slope = (loss(2e-3) - loss(-2e-3)) / 4e-3;
            let length = f64::from(length);
            assert!(length > 1e-3 && (slope / length - 1.0).abs() < 0.01, "{}: {slope:.4}, {length:.4}", entry.name);
        }
    }
}
