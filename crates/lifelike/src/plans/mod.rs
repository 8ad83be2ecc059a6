//! Plans: by name, for those that come with the program, or from a file, with `key=value` changes.
//!
//! A plan's own relative paths are resolved in the folder of its file, then in its parent, then in the working
//! directory ([`paths`]). A plan therefore means the same in every working directory. Paths in changes are relative to
//! the working directory.

mod builtin;
mod paths;

use std::path::{Path, PathBuf};

use lifelike_robot::nearest::hint;
use serde::Serialize;
use serde::de::DeserializeOwned;
use toml::{Table, Value};

use crate::error::CliError;
use crate::overrides;

pub use builtin::{BuiltinPlan, builtin};
pub use paths::located;

/// The folder by which built-in plans are called too, as in `experiments/track.toml`.
const SHIPPED: &str = "experiments";

/// A plan as text.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PlanText {
    /// The name or file that messages give.
    pub source: String,
    /// The text.
    pub text: String,
    /// The folder of its file; none for a built-in plan.
    pub folder: Option<PathBuf>,
}

/// Reads the text of a plan: of a file, else of the built-in plan of this name (`track` or `experiments/track.toml`).
///
/// # Errors
/// [`CliError::Input`] for a file that cannot be read, and for a name that is neither, with the names there are.
pub fn find(name_or_path: &Path) -> Result<PlanText, CliError> {
    let shown = name_or_path.display().to_string();
    if name_or_path.is_file() {
        let text = std::fs::read_to_string(name_or_path).map_err(|e| CliError::Input(format!("{shown}: {e}")))?;
        let folder = Some(name_or_path.parent().unwrap_or(Path::new("")).to_path_buf());
        return Ok(PlanText { source: shown, text, folder });
    }
    let shipped = name_or_path.strip_prefix(SHIPPED).unwrap_or(name_or_path);
    let name = shipped.to_string_lossy();
    let name = name.strip_suffix(".toml").filter(|_| shipped != name_or_path).unwrap_or(&name);
    match builtin().find(|plan| plan.name == name) {
        Some(plan) => Ok(PlanText { source: format!("plan '{name}'"), text: plan.text.into(), folder: None }),
        None => {
            let names: Vec<&str> = builtin().map(|plan| plan.name).collect();
            let near = hint(name, names.iter().copied());
            Err(CliError::Input(format!(
                "expected a plan's file or the name of a built-in plan ({}), got '{shown}'{near}",
                names.join(", ")
            )))
        }
    }
}

/// Reads a plan by [`find`], with its paths located, and applies changes such as `ppo.gamma=0.97`.
///
/// # Errors
/// As [`find`] and [`overrides::apply`]. [`CliError::Input`] with line and column for a text that is no such plan. The
/// same, with how to get them, for clips and networks that are missing.
pub fn load<T: Serialize + DeserializeOwned>(name_or_path: &Path, changes: &[String]) -> Result<T, CliError> {
    let plan = find(name_or_path)?;
    let wrong = |error: &dyn std::fmt::Display| CliError::Input(format!("{}: {error}", plan.source));
    let read: T = toml::from_str(&plan.text).map_err(|e| wrong(&e))?;
    let mut tree = Table::try_from(&read).map_err(|e| wrong(&e))?;
    if let Some(folder) = &plan.folder {
        paths::locate_all(&mut tree, folder);
    }
    let read = T::deserialize(Value::Table(tree)).map_err(|e| wrong(&e))?;
    let changed = overrides::apply(read, changes)?;
    let mut tree = Table::try_from(&changed).map_err(|e| wrong(&e))?;
    paths::name_networks(&mut tree)?;
    paths::check(&tree, &plan.source)?;
    T::deserialize(Value::Table(tree)).map_err(|e| wrong(&e))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn a_built_in_plan_has_two_names_and_others_are_refused_with_those_there_are() {
        for name in ["track", "experiments/track.toml"] {
            // No such file from where tests of this crate run but the second, which is the same text.
            let plan = find(Path::new(name)).unwrap();
            assert!(plan.text.contains("builtin"), "{plan:?}");
        }
        for unknown in ["trakc", "track.toml", "other/track.toml", "experiments/trakc.toml"] {
            let error = find(Path::new(unknown)).unwrap_err().to_string();
            assert!(error.contains(unknown) && error.contains("track-walk"), "{error}");
        }
    }
}
