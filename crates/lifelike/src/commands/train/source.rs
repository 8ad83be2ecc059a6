//! Arguments that all trainings share: the plan, the folder, begun or gone on with.

use std::path::{Path, PathBuf};

use lifelike_report::run::RunFolder;
use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::error::CliError;
use crate::{overrides, plans};

/// A plan and a run's folder.
#[derive(Debug, Clone, clap::Args)]
pub struct Source {
    /// The plan: a TOML file, or the name of a built-in one (`lifelike plans` lists them); with --resume the run's own is used.
    #[arg(long)]
    pub plan: Option<PathBuf>,
    /// The run's folder; runs/ and the plan's name where not given.
    #[arg(short, long)]
    pub output: Option<PathBuf>,
    /// Go on with the run in the folder.
    #[arg(long)]
    pub resume: bool,
    /// Write live.html into the run's folder: a page that follows the training while it is open in a browser.
    #[arg(long)]
    pub watch: bool,
    /// Changes to the plan, by dotted path.
    #[arg(value_name = "KEY=VALUE")]
    pub overrides: Vec<String>,
}

impl Source {
    /// The folder of the run: as given, or `runs/` and the plan's name.
    pub fn folder(&self) -> Result<PathBuf, CliError> {
        match (&self.output, self.plan.as_deref().and_then(Path::file_stem)) {
            (Some(folder), _) => Ok(folder.clone()),
            (None, Some(name)) => Ok(Path::new("runs").join(name)),
            (None, None) => Err(CliError::Usage(
                "say which run with -o FOLDER, or which plan with --plan FILE or --plan NAME of `lifelike plans`"
                    .into(),
            )),
        }
    }

    /// Returns the same with the keys of its changes by their present names.
    pub fn renamed(&self, present: impl Fn(&str) -> String) -> Self {
        let rename = |text: &String| match text.split_once('=') {
            Some((key, value)) => format!("{}={value}", present(key.trim())),
            None => text.clone(),
        };
        Self { overrides: self.overrides.iter().map(rename).collect(), ..self.clone() }
    }

    /// The plan, with its changes. One that is gone on with may be changed too.
    pub fn changeable<P: Serialize + DeserializeOwned>(&self, folder: &Path) -> Result<P, CliError> {
        match (&self.plan, self.resume) {
            (_, true) => overrides::apply(RunFolder::open(folder)?.plan()?, &self.overrides),
            (Some(path), false) => plans::load(path, &self.overrides),
            (None, false) => {
                Err(CliError::Usage("say what to train with --plan FILE, or --plan NAME of `lifelike plans`".into()))
            }
        }
    }

    /// As [`Self::changeable`], for trainings whose schedules span the whole run: a run goes on with the plan it was started with.
    pub fn fixed<P: Serialize + DeserializeOwned>(&self, folder: &Path) -> Result<P, CliError> {
        if self.resume && !self.overrides.is_empty() {
            return Err(CliError::Usage("such a run goes on with the plan it was started with".into()));
        }
        self.changeable(folder)
    }
}
