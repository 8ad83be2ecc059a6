//! `lifelike train tracker --keys`: every key of a plan with its default, unit and meaning.

use serde::Serialize;

use crate::error::CliError;
use crate::output::{Output, table};

/// Lines of `key = default # unit: meaning`.
const TRACKER: &str = include_str!("tracker_keys.toml");

/// A key of a plan.
#[derive(Debug, Serialize)]
struct PlanKey {
    key: &'static str,
    default: &'static str,
    unit: &'static str,
    about: &'static str,
}

/// Prints the keys of a tracker's plan.
pub fn tracker(output: &Output) -> Result<(), CliError> {
    let keys: Vec<PlanKey> = keys().collect();
    output.result(&keys, || {
        let row = |k: &PlanKey| [k.key, k.default, k.unit, k.about].map(str::to_string).to_vec();
        let rows: Vec<Vec<String>> = keys.iter().map(row).collect();
        table(&["key", "default or example", "unit", "meaning"], &rows)
            + "\nGiven as KEY=VALUE on the command line, or in a plan's file; see docs/training-a-new-robot.md for which to change first.\n"
    })
}

fn keys() -> impl Iterator<Item = PlanKey> {
    TRACKER.lines().filter(|line| !line.starts_with('#')).filter_map(|line| {
        let (key, rest) = line.split_once(" = ")?;
        let (default, comment) = rest.rsplit_once(" # ")?;
        let (unit, about) = comment.split_once(": ")?;
        Some(PlanKey { key, default, unit, about })
    })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::overrides;
    use lifelike_tracking::TrackerPlan;
    use toml::{Table, Value};

    /// Dotted keys of a tree, with their values.
    fn leaves(tree: &Table, at: &str, found: &mut Vec<(String, Value)>) {
        for (key, value) in tree {
            let key = if at.is_empty() { key.clone() } else { format!("{at}.{key}") };
            match value {
                Value::Table(inner) => leaves(inner, &key, found),
                value => found.push((key, value.clone())),
            }
        }
    }

    /// Numbers of single precision come with digits that nobody wrote.
    fn same(a: &Value, b: &Value) -> bool {
        match (a, b) {
            (Value::Float(a), Value::Float(b)) => (a - b).abs() <= 1e-6 * a.abs(),
            (Value::Array(a), Value::Array(b)) => a.len() == b.len() && a.iter().zip(b).all(|(a, b)| same(a, b)),
            _ => a == b,
        }
    }

    #[test]
    fn every_default_is_told_as_it_is() {
        let plan = TrackerPlan::new("lima", &["builtin".into()]);
        let mut defaults = Vec::new();
        leaves(&Table::try_from(&plan).unwrap(), "", &mut defaults);
        let told: Table = TRACKER.parse().unwrap();
        let mut values = Vec::new();
        leaves(&told, "", &mut values);
        for (key, default) in defaults {
            let (_, value) = values.iter().find(|(k, _)| *k == key).unwrap_or_else(|| panic!("{key} is not told"));
            assert!(same(value, &default), "{key}: {value} is told, {default} is the default");
        }
        assert_eq!(
            keys().count(),
            TRACKER.lines().filter(|line| !line.starts_with('#')).count(),
            "a line has no meaning"
        );
    }

    #[test]
    fn every_key_is_one() {
        let plan = TrackerPlan::new("lima", &["builtin".into()]);
        for key in keys() {
            overrides::apply(plan.clone(), &[format!("{}={}", key.key, key.default)]).unwrap();
        }
    }
}
