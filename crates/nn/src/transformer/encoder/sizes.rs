//! Sizes of an encoder, and the parameters that they make.

use crate::rows::{Entry, Init};
use crate::transformer::config::NetworkError;

/// The linear maps of a layer.
pub(super) const LINEAR: [&str; 4] =
    ["attention.projection", "attention.output", "feed_forward.inner", "feed_forward.outer"];

/// Sizes of an encoder.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EncoderSizes {
    /// c: numbers of a token.
    pub width: usize,
    /// Layers.
    pub layers: usize,
    /// Heads of a layer.
    pub heads: usize,
    /// Inner width of the feed-forward part.
    pub inner: usize,
}

impl EncoderSizes {
    /// Returns the parameters, named `prefix.LAYER.PART`.
    ///
    /// # Errors
    /// A size of 0, or heads that do not divide the width.
    pub fn entries(self, prefix: &str) -> Result<Vec<Entry>, NetworkError> {
        let named = [("width", self.width), ("layers", self.layers), ("heads", self.heads), ("inner", self.inner)];
        if let Some((name, _)) = named.into_iter().find(|(_, size)| *size == 0) {
            return Err(NetworkError::Zero(name));
        }
        if !self.width.is_multiple_of(self.heads) {
            return Err(NetworkError::Heads { heads: self.heads, width: self.width });
        }
        Ok((0..self.layers).flat_map(|i| entries(&format!("{prefix}.{i}"), self)).collect())
    }
}

/// Returns inputs and outputs of the linear maps.
pub(super) fn shapes(sizes: EncoderSizes) -> [[usize; 2]; 4] {
    let EncoderSizes { width: c, inner, .. } = sizes;
    [[c, 3 * c], [c, c], [c, inner], [inner, c]]
}

/// Returns a layer's parameters, with PyTorch's initial values.
fn entries(prefix: &str, sizes: EncoderSizes) -> Vec<Entry> {
    let mut out = Vec::new();
    for (name, [inputs, outputs]) in LINEAR.into_iter().zip(shapes(sizes)) {
        let [mut weight, mut bias] = Entry::linear(&format!("{prefix}.{name}"), inputs, outputs);
        if name == LINEAR[0] {
            // Glorot & Bengio 2010.
            weight.init = Init::Uniform((6.0 / (inputs + outputs) as f64).sqrt());
        }
        if name.starts_with("attention") {
            bias.init = Init::Constant(0.0);
        }
        out.extend([weight, bias]);
    }
    for norm in ["norm_1", "norm_2"] {
        for (part, value) in [("gain", 1.0), ("bias", 0.0)] {
            let init = Init::Constant(value);
            out.push(Entry { name: format!("{prefix}.{norm}.{part}"), shape: vec![sizes.width], init });
        }
    }
    out
}
