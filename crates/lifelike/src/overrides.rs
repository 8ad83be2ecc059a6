//! `key=value` on the command line over a plan from a file.
//!
//! The plan is first read with all its defaults, so every valid key is known. Values are then set by their dotted path,
//! and the whole is checked again by its type. Unknown keys are refused with the known ones. A single value for a list
//! becomes a list of one. `key=` removes a value: the default is back.

use std::path::Path;

use lifelike_robot::nearest::hint;
use serde::Serialize;
use serde::de::DeserializeOwned;
use toml::{Table, Value};

use crate::error::CliError;

/// Reads a plan and applies overrides such as `ppo.gamma=0.97` or `prior="runs/prior"`.
///
/// # Errors
/// [`CliError::Input`] for a file that is no such plan (with line), or an override that does not fit; both list the keys
/// there are.
pub fn load<T: Serialize + DeserializeOwned>(path: &Path, overrides: &[String]) -> Result<T, CliError> {
    let text = std::fs::read_to_string(path).map_err(|e| CliError::Input(format!("{}: {e}", path.display())))?;
    let plan: T = toml::from_str(&text).map_err(|e| CliError::Input(format!("{}: {e}", path.display())))?;
    apply(plan, overrides)
}

/// Applies overrides to a plan.
///
/// # Errors
/// As [`load`].
pub fn apply<T: Serialize + DeserializeOwned>(plan: T, overrides: &[String]) -> Result<T, CliError> {
    if overrides.is_empty() {
        return Ok(plan);
    }
    let mut tree = Table::try_from(&plan).map_err(|e| CliError::Failed(format!("plan: {e}")))?;
    for text in overrides {
        let (key, value) = text
            .split_once('=')
            .filter(|(key, _)| !key.trim().is_empty())
            .ok_or_else(|| CliError::Usage(format!("expected key=value, got '{text}'")))?;
        let (key, value) = (key.trim(), value.trim());
        let done = if value.is_empty() { take_out(&mut tree, key) } else { put(&mut tree, key, parse(value)) };
        done.map_err(|e| CliError::Input(format!("'{text}': {e}")))?;
    }
    let said = overrides.join(" ");
    T::deserialize(Value::Table(tree)).map_err(|e| {
        let error = e.to_string();
        CliError::Input(format!("{said}: {}{}", error.trim_end(), cure(&error)))
    })
}

/// Returns what cures an error of a plan's type, from its text: the nearest key, or how a list is written.
fn cure(error: &str) -> String {
    if error.contains("expected a sequence") {
        return "; write a list as 'key=[\"a\", \"b\"]'".into();
    }
    // serde's text: unknown field `gama`, expected one of `gamma`, `epochs`
    let mut names = error.split('`').skip(1).step_by(2);
    let unknown = names.next().filter(|_| error.contains("unknown field") || error.contains("unknown variant"));
    unknown.map_or_else(String::new, |unknown| hint(unknown, names))
}

/// A TOML value; what is none is a text, so that paths need no quotes.
fn parse(value: &str) -> Value {
    let table: Result<Table, _> = format!("value = {value}").parse();
    table.ok().filter(|t| t.len() == 1).and_then(|mut t| t.remove("value")).unwrap_or_else(|| Value::from(value))
}

fn take_out(tree: &mut Table, path: &str) -> Result<(), String> {
    let (tables, last) = path.rsplit_once('.').map_or((None, path), |(tables, last)| (Some(tables), last));
    let mut tables = tables.into_iter().flat_map(|path| path.split('.'));
    let inner = tables.try_fold(tree, |table, key| table.get_mut(key)?.as_table_mut());
    let taken = inner.and_then(|table| table.remove(last));
    taken.map(|_| ()).ok_or_else(|| "nothing to take out: the plan has no such value".into())
}

fn put(tree: &mut Table, path: &str, value: Value) -> Result<(), String> {
    let (head, rest) = path.split_once('.').map_or((path, None), |(head, rest)| (head, Some(rest)));
    let Some(rest) = rest else {
        let is_list = matches!(tree.get(head), Some(Value::Array(_)));
        let value = if is_list && !value.is_array() { Value::Array(vec![value]) } else { value };
        tree.insert(head.to_string(), value);
        return Ok(());
    };
    // A key or table that is not there may still be an optional one: the plan's type decides.
    let inner = tree.entry(head).or_insert_with(|| Value::Table(Table::new()));
    if *inner == Value::Boolean(false) {
        // An optional table that is off.
        *inner = Value::Table(Table::new());
    }
    match inner {
        Value::Table(inner) => put(inner, rest, value),
        _ => Err(format!("'{head}' is a value, not a table")),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[derive(Debug, PartialEq, serde::Serialize, serde::Deserialize)]
    #[serde(deny_unknown_fields)]
    struct Ppo {
        gamma: f64,
        #[serde(default)]
        epochs: usize,
    }

    #[derive(Debug, PartialEq, serde::Serialize, serde::Deserialize)]
    #[serde(deny_unknown_fields)]
    struct Plan {
        seed: u64,
        #[serde(default)]
        clips: Vec<String>,
        #[serde(default)]
        prior: Option<String>,
        #[serde(default)]
        sizes: Option<Vec<usize>>,
        ppo: Ppo,
        #[serde(default)]
        other: Option<Ppo>,
    }

    fn plan() -> Plan {
        Plan { seed: 1, clips: Vec::new(), prior: None, sizes: None, ppo: Ppo { gamma: 0.99, epochs: 4 }, other: None }
    }

    fn with(overrides: &[&str]) -> Result<Plan, CliError> {
        apply(plan(), &overrides.iter().map(ToString::to_string).collect::<Vec<_>>())
    }

    #[test]
    fn values_are_put_where_they_belong() {
        let changed = with(&["ppo.gamma=0.9", "prior=runs/prior 1", "seed = 7", "ppo.epochs=2"]).unwrap();
        let ppo = Ppo { gamma: 0.9, epochs: 2 };
        let expected = Plan { seed: 7, prior: Some("runs/prior 1".into()), ppo, ..plan() };
        assert_eq!(changed, expected);
        assert_eq!(with(&["ppo.gamma=1"]).unwrap().ppo.gamma, 1.0, "an integer where a number is expected");
        assert_eq!(with(&["ppo={gamma=0.5,epochs=3}"]).unwrap().ppo.epochs, 3);
        assert_eq!(with(&["other.gamma=0.5", "other.epochs=3"]).unwrap().other, Some(Ppo { gamma: 0.5, epochs: 3 }));
        assert_eq!(with(&[]).unwrap(), plan());
    }

    #[test]
    fn a_list_of_one_needs_no_brackets() {
        for text in ["clips=data/mine", "clips=[\"data/mine\"]"] {
            assert_eq!(with(&[text]).unwrap().clips, ["data/mine"], "{text}");
        }
        assert_eq!(with(&["clips=[\"a\", \"b\"]"]).unwrap().clips, ["a", "b"]);
        let told = with(&["sizes=3"]).unwrap_err().to_string();
        assert!(told.ends_with("; write a list as 'key=[\"a\", \"b\"]'"), "{told}");
    }

    #[test]
    fn a_value_may_be_taken_out() {
        assert_eq!(with(&["prior=runs/a", "prior="]).unwrap(), plan());
        assert_eq!(with(&["ppo.epochs="]).unwrap().ppo.epochs, 0, "its default");
        for nothing in ["prior=", "ppo.gama=", "seed.x=", "nobody.knows="] {
            assert!(with(&[nothing]).unwrap_err().to_string().contains("nothing to take out"), "{nothing}");
        }
        assert!(with(&["seed="]).unwrap_err().to_string().contains("seed"), "what must be there");
    }

    #[test]
    fn what_does_not_exist_is_refused_with_what_does() {
        let message = |o: &str| with(&[o]).unwrap_err().to_string();
        let told = message("ppo.gama=0.9");
        assert!(told.contains("epochs") && told.ends_with("; did you mean 'gamma'?"), "{told}");
        assert!(message("pro.gamma=0.9").contains("ppo"));
        assert!(message("other.epochs=3").contains("gamma"), "an optional table is whole or not there");
        assert!(message("seed.x=1").contains("seed"));
        assert!(message("seed=-1").contains("seed"), "{}", message("seed=-1"));
        assert!(matches!(with(&["seed"]), Err(CliError::Usage(_))));
    }

    #[test]
    fn a_file_that_is_no_plan_is_told_with_its_line() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("plan.toml");
        std::fs::write(&path, "seed = 1\nspeed = 2\n[ppo]\ngamma = 1\n").unwrap();
        let message = load::<Plan>(&path, &[]).unwrap_err().to_string();
        assert!(message.contains("line 2") && message.contains("speed"), "{message}");
    }
}
