//! Arguments that all of these commands have.

use std::path::PathBuf;

use lifelike_learn::representation::spline_transformer::Method;

use super::budget::Budget;
use crate::commands::train::hardware::Networks;
use crate::error::CliError;

/// What is compared, and how much is spent on it.
#[derive(Debug, clap::Args)]
pub struct Shared {
    /// Methods; all where not given.
    #[arg(long, value_delimiter = ',')]
    pub methods: Vec<Method>,
    /// How long, and how large a batch.
    #[arg(long, value_enum, default_value_t)]
    pub budget: Budget,
    /// Iterations of each run, instead of the budget's; the learning rate falls to 0 over them.
    #[arg(long)]
    pub iterations: Option<u64>,
    /// Stop each run after so many minutes, done or not; the same command goes on with it.
    #[arg(long)]
    pub minutes: Option<f64>,
    /// Learning rates to sweep, instead of the thesis' one.
    #[arg(long, value_delimiter = ',')]
    pub rates: Vec<f64>,
    /// Iterations over which the learning rate rises.
    #[arg(long)]
    pub warmup: Option<u64>,
    /// Key of weights and training batches.
    #[arg(long, default_value_t = 0)]
    pub seed: u64,
    /// Folder of the runs, of the results as JSON and of report.html.
    #[arg(short, long)]
    pub output: PathBuf,
    #[command(flatten)]
    pub networks: Networks,
}

impl Shared {
    /// Whether learning rates are swept.
    pub fn sweeps(&self) -> bool {
        !self.rates.is_empty()
    }

    /// # Errors
    /// A time that is none.
    pub fn check(&self) -> Result<(), CliError> {
        match self.minutes.filter(|m| !(m.is_finite() && *m > 0.0)) {
            Some(minutes) => Err(CliError::Usage(format!("--minutes: expected a number above 0, got {minutes}"))),
            None => Ok(()),
        }
    }
}

/// Which columns, where these are latent dimensions.
#[derive(Debug, clap::Args)]
pub struct Latents {
    /// Latent dimensions; the thesis' where not given.
    #[arg(long, value_delimiter = ',')]
    pub latents: Vec<usize>,
}
