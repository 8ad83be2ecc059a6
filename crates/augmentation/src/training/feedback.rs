//! Errors that the encoder gets of earlier steps: measured ones, or the network's own predictions in a closed loop.

use lifelike_checkpoint::rng::stream;
use rand::Rng;

use super::trainer::{AugmentationTrainer, Stretch, Told};
use crate::augmentation::Feedback;
use crate::model::{ClosedLoop, Network, Sequence, closed_loop};

impl AugmentationTrainer {
    /// Feedback to the encoder in some stretches, as [`Network::forward`] wants it.
    ///
    /// In closed-loop stretches the network runs step by step from the stretch's begin and gets its own predictions.
    /// No gradient goes through these numbers (as in scheduled sampling), while memory and attention carry gradients
    /// over the whole stretch.
    pub(super) fn fed_back(
        &self,
        network: &Network,
        number: usize,
        stretches: &[Stretch],
        rows: &[f32],
        error: &[f32],
    ) -> Vec<f32> {
        let (outputs, steps, count) = (self.inputs.selection.len(), self.plan.stretch, stretches.len());
        let mut fed_back = vec![0.0; steps * count * (outputs + 1)];
        for (i, fed) in fed_back.chunks_exact_mut(outputs + 1).enumerate() {
            if stretches[i % count].told != Told::Nothing {
                fed[..outputs].copy_from_slice(&error[i * outputs..][..outputs]);
                fed[outputs] = self.sizes.known(true);
            }
        }
        let looped: Vec<usize> = (0..count).filter(|i| stretches[*i].told == Told::Predicted).collect();
        if looped.is_empty() {
            return fed_back;
        }
        let mut rng = stream(self.plan.seed, "augmentation closed loop", number as u64, self.iteration());
        let own = self.plan.feedback.own_at(self.iteration(), self.plan.iterations);
        let mut closed = ClosedLoop::new(network.clone(), looped.len());
        let width = self.inputs.fields.len();
        for step in 0..steps {
            let at = |i: &usize| step * count + i;
            let rows: Vec<f32> = looped.iter().flat_map(|i| &rows[at(i) * width..][..width]).copied().collect();
            let out = self.plan.loss.predictions(closed.predict(&rows));
            let mut fed = Vec::with_capacity(looped.len() * (outputs + 1));
            for (i, out) in looped.iter().zip(out.chunks_exact(outputs)) {
                let slot = &mut fed_back[at(i) * (outputs + 1)..][..=outputs];
                if rng.random::<f64>() < own {
                    slot[..outputs].copy_from_slice(out);
                    slot[outputs] = self.sizes.known(false);
                }
                fed.extend_from_slice(slot);
            }
            closed.remember(&rows, &fed);
        }
        fed_back
    }

    /// Predictions of some whole sequences with the plan's feedback.
    pub(super) fn validated(&self, network: &Network, all: &[Sequence]) -> Vec<Vec<f32>> {
        let outputs = self.inputs.selection.len();
        let feedback = self.plan.feedback.validated();
        if feedback == Feedback::Predicted {
            let rows: Vec<&[f32]> = all.iter().map(|own| &own.rows[..]).collect();
            return closed_loop(network, &rows, self.sizes.known(false), |out| self.plan.loss.predictions(out));
        }
        let one = |own: &Sequence| {
            let mut fed_back = vec![0.0; own.error.len() / outputs * (outputs + 1)];
            if feedback == Feedback::Measured {
                for (fed, error) in fed_back.chunks_exact_mut(outputs + 1).zip(own.error.chunks_exact(outputs)) {
                    fed[..outputs].copy_from_slice(error);
                    fed[outputs] = self.sizes.known(true);
                }
            }
            self.plan.loss.predictions(network.forward(&own.rows, &fed_back, 1).0)
        };
        all.iter().map(one).collect()
    }
}
