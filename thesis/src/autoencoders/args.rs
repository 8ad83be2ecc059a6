//! Arguments that all of these commands have.

use std::path::PathBuf;
use std::str::FromStr;

use lifelike_representation::RepresentationError;
use lifelike_representation::spline_transformer::Method;

use super::budget::Budget;
use lifelike::CliError;

/// Methods that are compared, and their budget.
#[derive(Debug, clap::Args)]
pub struct Shared {
    /// Methods; the thesis' three where not given.
    #[arg(long, value_delimiter = ',')]
    pub methods: Vec<Method>,
    /// Add to each column one in which every method keeps as many numbers of a sequence as the spline.
    #[arg(long, conflicts_with = "rates")]
    pub equal_numbers: bool,
    /// Only the plain baselines (mean, cubic for each channel, principal components, cubics of a frame's): no network is trained.
    #[arg(long, conflicts_with_all = ["methods", "rates"])]
    pub plain: bool,
    /// Iterations and batch size.
    #[arg(long, value_enum, default_value_t)]
    pub budget: Budget,
    /// Iterations of each run, instead of the budget's; the learning rate falls to 0 over them.
    #[arg(long)]
    pub iterations: Option<u64>,
    /// Stop each run after so many minutes, done or not; the same command goes on with it.
    #[arg(long)]
    pub minutes: Option<f64>,
    /// Learning rates to sweep, instead of the budget's one. Shows errors of validation, never of the test set.
    #[arg(long, value_delimiter = ',')]
    pub rates: Vec<f64>,
    /// Learning rate of a method, instead of the budget's; may be given for each of them.
    #[arg(long, value_name = "METHOD=RATE", value_delimiter = ',', conflicts_with = "rates")]
    pub rate: Vec<MethodRate>,
    /// Iterations over which the learning rate rises; the budget's share of them where not given, none in a sweep. A sweep may
    /// have several to compare: each rate runs with each of them.
    #[arg(long, value_delimiter = ',', value_name = "ITERATIONS")]
    pub warmup: Vec<u64>,
    /// Keys of weights and training batches: a run for each, of which the table has the mean and half the range.
    #[arg(long, value_delimiter = ',', value_name = "SEEDS", default_value = "0")]
    pub seed: Vec<u64>,
    /// Folder of the runs, of the results as JSON and of report.html.
    #[arg(short, long, value_parser = lifelike::destination::folder)]
    pub output: PathBuf,
}

impl Shared {
    /// Returns whether learning rates are swept.
    pub fn sweeps(&self) -> bool {
        !self.rates.is_empty()
    }

    /// The rates of a method's runs; none stands for the plan's.
    pub fn rates_of(&self, method: Method) -> Vec<Option<f64>> {
        match self.rate.iter().rfind(|own| own.method == method) {
            Some(own) => vec![Some(own.rate)],
            None if self.sweeps() => self.rates.iter().copied().map(Some).collect(),
            None => vec![None],
        }
    }

    /// # Errors
    /// A time that is none; warm-ups to compare outside of a sweep, whose table has no row for each.
    pub fn check(&self) -> Result<(), CliError> {
        if self.warmup.len() > 1 && !self.sweeps() {
            let text = format!("--warmup: expected one without --rates, got {}", self.warmup.len());
            return Err(CliError::Usage(text));
        }
        match self.minutes.filter(|m| !(m.is_finite() && *m > 0.0)) {
            Some(minutes) => Err(CliError::Usage(format!("--minutes: expected a number above 0, got {minutes}"))),
            None => Ok(()),
        }
    }
}

/// `METHOD=RATE`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MethodRate {
    method: Method,
    rate: f64,
}

impl FromStr for MethodRate {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (method, rate) = text.split_once('=').ok_or("expected METHOD=RATE, such as spline=0.01")?;
        let rate = rate.parse().map_err(|_| format!("expected a learning rate, got '{rate}'"))?;
        Ok(Self { method: method.parse().map_err(|e: RepresentationError| e.to_string())?, rate })
    }
}

/// Columns of a table, where these are latent dimensions.
#[derive(Debug, clap::Args)]
pub struct Latents {
    /// Latent dimensions; the thesis' where not given.
    #[arg(long, value_delimiter = ',')]
    pub latents: Vec<usize>,
}
