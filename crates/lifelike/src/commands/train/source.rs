//! Arguments that all trainings share: the plan, the folder, begun or gone on with.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use lifelike_report::run::RunFolder;
use serde::Serialize;
use serde::de::DeserializeOwned;
use toml::{Table, Value};

use crate::error::CliError;
use crate::{overrides, plans};

/// A plan and a run's folder.
#[derive(Debug, Clone, Default, clap::Args)]
pub struct Source {
    /// The plan: a TOML file, or the name of a built-in one (`lifelike plans` lists them); with --resume the run's own is used.
    #[arg(long)]
    pub plan: Option<PathBuf>,
    /// The run's folder; runs/ and the plan's name where not given.
    #[arg(short, long, value_parser = crate::destination::folder)]
    pub output: Option<PathBuf>,
    /// Go on with the run in the folder.
    #[arg(long)]
    pub resume: bool,
    /// Write live.html into the run's folder: a page that follows the training while it is open in a browser.
    #[arg(long)]
    pub watch: bool,
    /// Print the resolved plan, train for a few seconds, report speed, memory and total time, and write nothing.
    #[arg(long, conflicts_with_all = ["resume", "watch"])]
    pub dry_run: bool,
    /// The robot, in place of the plan's: a name, or an MJCF or URDF file.
    #[arg(short, long, conflicts_with = "resume")]
    pub robot: Option<String>,
    /// Print every key of a plan with its default, unit, range and meaning, and stop.
    #[arg(long)]
    pub keys: bool,
    /// Print the JSON Schema of a plan, by which editors complete and check it, and stop.
    #[arg(long, conflicts_with = "keys")]
    pub schema: bool,
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

    /// Returns all changes to the plan: those of the options, then those by dotted path.
    fn changes(&self) -> Vec<String> {
        let robot = self.robot.iter().map(|robot| format!("robot={robot}"));
        robot.chain(self.overrides.iter().cloned()).collect()
    }

    /// Returns the plan with its changes. On resume it is the run's own plan, which may be changed by dotted path.
    ///
    /// # Errors
    /// As [`plans::load`]; [`CliError::Input`] where `--plan` names another plan than that of the run to resume.
    pub fn changeable<P: Serialize + DeserializeOwned>(&self, folder: &Path) -> Result<P, CliError> {
        match (&self.plan, self.resume) {
            (Some(path), true) => {
                let own: P = RunFolder::open(folder)?.plan()?;
                let own = overrides::apply(own, &self.overrides)?;
                require_same(&plans::load::<P>(path, &self.overrides)?, &own, path, folder)?;
                Ok(own)
            }
            (None, true) => overrides::apply(RunFolder::open(folder)?.plan()?, &self.overrides),
            (Some(path), false) => plans::load(path, &self.changes()),
            (None, false) => {
                Err(CliError::Usage("say what to train with --plan FILE, or --plan NAME of `lifelike plans`".into()))
            }
        }
    }

    /// As [`Self::changeable`], for trainings whose schedules span the whole run: a run resumes with the plan it was started with.
    ///
    /// # Errors
    /// As [`Self::changeable`]; [`CliError::Usage`] for changes on resume.
    pub fn fixed<P: Serialize + DeserializeOwned>(&self, folder: &Path) -> Result<P, CliError> {
        if self.resume && !self.overrides.is_empty() {
            return Err(CliError::Usage(format!(
                "expected no changes with --resume, got '{}': this kind of training resumes with the plan it was started with",
                self.overrides.join(" ")
            )));
        }
        self.changeable(folder)
    }

    /// Opens the run to resume, or creates the folder of a new one; for a dry run, a temporary folder.
    ///
    /// # Errors
    /// As [`RunFolder::open`] and [`RunFolder::create`].
    pub fn run<P: Serialize>(&self, folder: &Path, plan: &P) -> Result<Run, CliError> {
        if self.resume {
            return Ok(RunFolder::open(folder)?.into());
        }
        self.new_run(folder, plan, |folder| Ok(RunFolder::create(folder, plan)?))
    }

    /// As [`Self::run`], for trainings that the same command resumes without `--resume`.
    ///
    /// # Errors
    /// As [`RunFolder::open_or_create`].
    pub fn run_or_resume<P>(&self, folder: &Path, plan: &P) -> Result<Run, CliError>
    where
        P: Serialize + DeserializeOwned + PartialEq,
    {
        self.new_run(folder, plan, |folder| Ok(RunFolder::open_or_create(folder, plan)?))
    }

    fn new_run<P: Serialize>(
        &self,
        folder: &Path,
        plan: &P,
        create: impl FnOnce(&Path) -> Result<RunFolder, CliError>,
    ) -> Result<Run, CliError> {
        if !self.dry_run {
            return Ok(create(folder)?.into());
        }
        RunFolder::require_new(folder)?;
        let temporary = tempfile::tempdir().map_err(|e| CliError::Failed(format!("temporary folder: {e}")))?;
        Ok(Run { folder: RunFolder::create(temporary.path().join("run"), plan)?, rehearsal: Some(temporary) })
    }
}

/// The folder in which a training runs.
#[derive(Debug)]
pub struct Run {
    folder: RunFolder,
    /// The temporary folder of a dry run; removed with this value.
    rehearsal: Option<tempfile::TempDir>,
}

impl Run {
    /// Returns whether this is a dry run.
    pub fn is_rehearsal(&self) -> bool {
        self.rehearsal.is_some()
    }
}

impl From<RunFolder> for Run {
    fn from(folder: RunFolder) -> Self {
        Self { folder, rehearsal: None }
    }
}

impl std::ops::Deref for Run {
    type Target = RunFolder;

    fn deref(&self) -> &RunFolder {
        &self.folder
    }
}

/// Refuses a plan that is not the one a run was started with, naming the first keys that differ.
fn require_same<P: Serialize>(named: &P, own: &P, path: &Path, folder: &Path) -> Result<(), CliError> {
    let flat = |plan: &P| {
        let mut keys = BTreeMap::new();
        let tree = Table::try_from(plan).map_err(|e| CliError::Failed(format!("plan: {e}")))?;
        flatten("", &Value::Table(tree), &mut keys);
        Ok::<_, CliError>(keys)
    };
    let (named, own) = (flat(named)?, flat(own)?);
    let keys: BTreeSet<&String> =
        named.keys().chain(own.keys()).filter(|key| named.get(*key) != own.get(*key)).collect();
    if keys.is_empty() {
        return Ok(());
    }
    let value = |keys: &BTreeMap<String, String>, key: &str| keys.get(key).map_or("none", String::as_str).to_string();
    let lines = keys
        .iter()
        .take(MOST_DIFFERENCES)
        .map(|key| format!("\n  {key}: {} in the run, {} in the plan", value(&own, key), value(&named, key)));
    let more = keys.len().saturating_sub(MOST_DIFFERENCES);
    let more = if more > 0 { format!("\n  and {more} more") } else { String::new() };
    Err(CliError::Input(format!(
        "{}: expected the plan that the run was started with, got '{}', which differs:{}{more}\n\
         leave --plan out to resume with the run's own plan, or name another folder with -o",
        folder.display(),
        path.display(),
        lines.collect::<String>()
    )))
}

/// Most differing keys that a refusal lists.
const MOST_DIFFERENCES: usize = 5;

/// Collects the values of a tree by dotted path.
fn flatten(prefix: &str, value: &Value, keys: &mut BTreeMap<String, String>) {
    match value {
        Value::Table(table) => {
            for (key, value) in table {
                let path = if prefix.is_empty() { key.clone() } else { format!("{prefix}.{key}") };
                flatten(&path, value, keys);
            }
        }
        value => drop(keys.insert(prefix.into(), value.to_string())),
    }
}
