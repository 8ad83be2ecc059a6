//! Training a sequence autoencoder in a folder, with a progress bar and Ctrl-C: for splines, spline priors and their benches.

use std::ops::ControlFlow;
use std::path::Path;
use std::sync::atomic::Ordering;
use std::time::Instant;

use lifelike_nn::device::Device;
use lifelike_representation::spline_transformer::{SequenceMetrics, SequencePlan, SequenceTrainer, Sequences, run};
use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::error::CliError;
use crate::interrupt;
use crate::output::Output;
use crate::progress::Progress;

/// What is trained, and for how long.
pub struct Training<'a, P> {
    /// The run's folder; a run of the same plan in it is gone on with.
    pub folder: &'a Path,
    /// What plan.toml holds.
    pub plan: &'a P,
    /// The training in it.
    pub training: &'a SequencePlan,
    /// Where the network learns.
    pub device: &'a Device,
    /// After which it is stopped, done or not.
    pub minutes: Option<f64>,
}

impl<P: Serialize + DeserializeOwned + PartialEq> Training<'_, P> {
    /// Trains until the plan is done, the minutes are over, or Ctrl-C; and whether it was Ctrl-C.
    pub fn run<S: Sequences>(
        &self,
        data: S,
        output: &Output,
        words: impl Fn(&SequenceMetrics) -> String,
    ) -> Result<(SequenceTrainer<S>, bool), CliError> {
        let stop = interrupt::flag()?;
        let total = self.training.iterations;
        let mut progress = Progress::new(output, "training", total);
        let (began, mut interrupted) = (Instant::now(), false);
        let trainer = run::train(self.folder, self.plan, self.training, data, self.device, |now| {
            progress.update(now.iteration, total, || words(now));
            interrupted = stop.load(Ordering::SeqCst);
            let late = self.minutes.is_some_and(|minutes| began.elapsed().as_secs_f64() > 60.0 * minutes);
            if interrupted || late { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        })?;
        progress.finish();
        Ok((trainer, interrupted))
    }
}
