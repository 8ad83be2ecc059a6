//! Sizes of the network, and which of its parts are there.

use lifelike_nn::fusion::{
    GateAddNorm, GatedResidual, GatedResidualSizes, HistoryAttention, HistorySizes, Lstm, SelectionSizes,
    VariableSelection,
};
use lifelike_nn::rows::{Entry, Layout};
use lifelike_train::limits::{PlanError, wrong};
use lifelike_train::plan;

/// Layer between the selection of variables and attention (thesis 2.5.4).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Backbone {
    /// Nothing.
    None,
    /// Two layers with ReLU.
    Dense,
    /// An LSTM over the history and a step of another for the present, beside a skip connection.
    #[default]
    Lstm,
}

/// Sizes of the network.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct SatSizes {
    /// Size of a row: state, forces, references. The training sets it.
    #[schemars(extend("unit" = "1"))]
    pub inputs: usize,
    /// Size of Δs, predicted and fed back. The training sets it.
    #[schemars(extend("unit" = "1"))]
    pub outputs: usize,
    /// Numbers that come out for each output: more than one for the quantile loss. The training sets it.
    #[schemars(extend("unit" = "1"), range(min = 1, max = 99))]
    pub quantiles: usize,
    /// Size of the embedding of a variable.
    #[schemars(extend("unit" = "1"), range(min = 1, max = 256))]
    pub embedding: usize,
    /// Width of all layers.
    #[schemars(extend("unit" = "1"), range(min = 1, max = 1024))]
    pub width: usize,
    /// Number of attention heads; a divisor of the width.
    #[schemars(extend("unit" = "1"), range(min = 1, max = 64))]
    pub heads: usize,
    /// Number K of past steps that the network sees.
    #[schemars(extend("unit" = "steps"), range(min = 1, max = 4096))]
    pub history: usize,
    /// Layer before attention.
    pub backbone: Backbone,
    /// Attention over the past steps.
    pub attention: bool,
    /// Addition of the measured error of the step before to the output: the network predicts its change.
    ///
    /// False is the thesis' form: errors are inputs of the encoder, measured and predicted ones alike.
    pub carry: bool,
}

impl Default for SatSizes {
    fn default() -> Self {
        Self {
            inputs: 0,
            outputs: 0,
            quantiles: 1,
            embedding: 4,
            width: 16,
            heads: 4,
            history: 128,
            backbone: Backbone::Lstm,
            attention: true,
            carry: true,
        }
    }
}

impl SatSizes {
    /// Checks the sizes that a plan sets.
    ///
    /// # Errors
    /// The key, its range and the value.
    pub fn check(&self) -> Result<(), PlanError> {
        plan::check("model", self)?;
        if !self.width.is_multiple_of(self.heads) {
            return Err(wrong("model.heads", &format!("a divisor of the width {}", self.width), self.heads));
        }
        if self.backbone != Backbone::Lstm && !self.attention {
            return Err(wrong("model.attention", "true where there is no LSTM: nothing would look back", false));
        }
        Ok(())
    }

    /// Returns the number beside an error that is fed back: 1 where it was measured. A predicted one is -1; without `carry` the encoder
    /// cannot tell them apart, as in the thesis.
    pub fn known(self, measured: bool) -> f32 {
        if measured || !self.carry { 1.0 } else { -1.0 }
    }

    /// Variables of the encoder: the row, Δs of that step, and whether it is known.
    pub(super) fn encoder(self) -> SelectionSizes {
        let Self { inputs, outputs, embedding, width, .. } = self;
        SelectionSizes { variables: inputs + outputs + 1, embedding, width }
    }

    /// Variables of the decoder: the row.
    pub(super) fn decoder(self) -> SelectionSizes {
        let Self { inputs, embedding, width, .. } = self;
        SelectionSizes { variables: inputs, embedding, width }
    }

    pub(super) fn attention(self) -> HistorySizes {
        HistorySizes { width: self.width, heads: self.heads, steps: self.history }
    }

    pub(super) fn residual(self) -> GatedResidualSizes {
        GatedResidualSizes { inputs: self.width, hidden: self.width, outputs: self.width }
    }

    /// Returns names and places of the parameters.
    pub fn layout(self) -> Layout {
        let c = self.width;
        let mut entries: Vec<Entry> = VariableSelection::entries("encoder.selection", self.encoder());
        entries.extend(VariableSelection::entries("decoder.selection", self.decoder()));
        match self.backbone {
            Backbone::None => {}
            Backbone::Dense => {
                for name in ["dense.0", "dense.1"] {
                    entries.extend(Entry::linear(name, c, c));
                }
            }
            Backbone::Lstm => {
                entries.extend(Lstm::entries("encoder.lstm", c, c));
                entries.extend(Lstm::entries("decoder.lstm", c, c));
                entries.extend(GateAddNorm::entries("lstm_gate", c, c));
            }
        }
        if self.attention {
            entries.extend(HistoryAttention::entries("attention", self.attention()));
            entries.extend(GateAddNorm::entries("attention_gate", c, c));
            entries.extend(GatedResidual::entries("residual", self.residual()));
            entries.extend(GateAddNorm::entries("output_gate", c, c));
        }
        entries.extend(Entry::linear("output", c, self.outputs * self.quantiles));
        Layout::new(entries)
    }
}
