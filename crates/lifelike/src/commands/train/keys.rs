//! `--keys` and `--schema` of every training: the keys of its plan, for people and for editors.

use lifelike_report::{Cell, Column, Table};
use lifelike_train::plan::{self, PlanKey};
use schemars::JsonSchema;
use serde_json::{Value, json};

use super::source::Source;
use crate::error::CliError;
use crate::output::Output;

/// Prints what `source` asks for about the plan `P`. Returns false where it asks for nothing.
pub fn describe<P: JsonSchema>(source: &Source, output: &Output) -> Result<bool, CliError> {
    if source.schema {
        let schema = plan::schema::<P>();
        output.result(&schema, || format!("{schema:#}\n"))?;
    } else if source.keys {
        let keys = plan::keys::<P>();
        output.result(&keys.iter().map(value).collect::<Vec<_>>(), || text(&keys))?;
    }
    Ok(source.schema || source.keys)
}

fn value(key: &PlanKey) -> Value {
    json!({
        "key": key.key, "default": key.default, "unit": key.unit, "min": key.bounds.min, "max": key.bounds.max,
        "choices": key.choices, "meaning": key.meaning,
    })
}

fn text(keys: &[PlanKey]) -> String {
    let mut table = Table::new("Keys", ["key", "default", "unit", "meaning"].map(Column::text).into());
    // A column more would break keys in two where a terminal is narrow.
    let row = |k: &PlanKey| {
        let range = Some(k.range()).filter(|range| !range.is_empty());
        let meaning = range.map_or_else(|| k.meaning.clone(), |range| format!("{} ({range})", k.meaning));
        [&k.key, &k.default, &k.unit, &meaning].map(Cell::text).into()
    };
    table.rows = keys.iter().map(row).collect();
    crate::output::fitted(&table)
        + "\nGive them as KEY=VALUE on the command line, or in a plan's file: `lifelike plans NAME > my.toml` begins one. \
           KEY= takes a value out of a plan. --schema prints the same for editors.\n"
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use std::collections::BTreeSet;

    use lifelike_generation::align::AlignPlan;
    use lifelike_generation::evaluator::EvaluatorTrainingPlan;
    use lifelike_generation::training::GeneratorPlan;
    use lifelike_representation::motion_spline::MotionSplinePlan;
    use lifelike_representation::prior::PriorTrainingPlan;
    use lifelike_tracking::TrackerPlan;
    use lifelike_tracking::get_up::GetUpPlan;
    use serde::Serialize;
    use serde::de::DeserializeOwned;
    use toml::{Table as Toml, Value as TomlValue};

    use super::*;
    use crate::commands::cotrain::plan::CotrainPlan;
    use crate::commands::train::augmentation::AugmentationTrainingPlan;
    use crate::commands::train::critic::CriticTrainingPlan;
    use crate::plans::builtin;

    /// A training: the keys of its plan, and those of its built-in plans as they are saved with a run.
    struct Training {
        command: &'static str,
        keys: Vec<PlanKey>,
        plans: Vec<(&'static str, BTreeSet<String>)>,
    }

    fn training<P: JsonSchema + Serialize + DeserializeOwned>(command: &'static str) -> Training {
        let plans = builtin().filter(|plan| plan.command() == command).map(|plan| {
            let read: P = toml::from_str(plan.text).unwrap_or_else(|error| panic!("{}: {error}", plan.name));
            plan::check("", &read).unwrap_or_else(|error| panic!("{}: {error}", plan.name));
            let mut leaves = BTreeSet::new();
            add_leaves("", &Toml::try_from(&read).unwrap(), &mut leaves);
            (plan.name, leaves)
        });
        Training { command, keys: plan::keys::<P>(), plans: plans.collect() }
    }

    fn add_leaves(prefix: &str, table: &Toml, leaves: &mut BTreeSet<String>) {
        for (key, value) in table {
            let path = if prefix.is_empty() { key.clone() } else { format!("{prefix}.{key}") };
            match value {
                TomlValue::Table(inner) => add_leaves(&path, inner, leaves),
                _ => drop(leaves.insert(path)),
            }
        }
    }

    /// Returns all trainings of the program.
    fn all() -> Vec<Training> {
        vec![
            training::<TrackerPlan>("train tracker"),
            training::<PriorTrainingPlan>("train prior"),
            training::<MotionSplinePlan>("train spline"),
            training::<CriticTrainingPlan>("train critic"),
            training::<GeneratorPlan>("train generator"),
            training::<EvaluatorTrainingPlan>("train evaluator"),
            training::<AugmentationTrainingPlan>("train augmentation"),
            training::<GetUpPlan>("train get-up"),
            training::<AlignPlan>("align"),
            training::<CotrainPlan>("cotrain"),
        ]
    }

    #[test]
    fn every_number_of_every_plan_has_a_unit_and_every_key_a_short_meaning() {
        let units = [
            "1",
            "m",
            "s",
            "rad",
            "kg",
            "Hz",
            "min",
            "nat",
            "m/s",
            "rad/s",
            "m/s, rad/s",
            "weight",
            "weight · m",
            "steps",
            "policy steps",
            "iterations",
            "epochs",
            "samples",
            "windows",
            "sequences",
            "motions",
            "pairs",
            "rows",
            "frames",
            "stretches",
            "m²",
            "1/m²",
            "1/(m²/s²)",
            "1/rad²",
            "1/(rad²/s²)",
            "1/(N² m²)",
        ];
        let mut wrong = Vec::new();
        for Training { command, keys, .. } in all() {
            for key in keys {
                let mut refuse =
                    |what: &str| wrong.push(format!("{command} {}: {what}: '{}' '{}'", key.key, key.unit, key.meaning));
                if key.number && !units.contains(&key.unit.as_str()) {
                    refuse("no unit");
                }
                if key.meaning.is_empty() {
                    refuse("no meaning");
                }
                for meaning in key.meaning.split("; \"") {
                    let first = meaning.split([' ', ',']).next().unwrap();
                    if meaning.split_whitespace().count() > 25 || meaning.contains("[`") {
                        refuse("more than 25 words, or a link");
                    }
                    if ["What", "How", "Where", "Whether", "Who", "Its", "If", "True", "Returns"].contains(&first) {
                        refuse("no noun phrase");
                    }
                }
                // A unit that the documentation names is the declared one.
                let named = key.meaning.rsplit_once(" (").map(|(_, unit)| unit.trim_end_matches(')'));
                if named.is_some_and(|named| key.meaning.ends_with(')') && units.contains(&named)) {
                    refuse("another unit in the documentation");
                }
            }
        }
        assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    }

    #[test]
    fn every_key_of_a_built_in_plan_is_declared_once() {
        for Training { command, keys, plans } in all() {
            let declared: BTreeSet<&str> = keys.iter().map(|key| key.key.as_str()).collect();
            assert_eq!(declared.len(), keys.len(), "{command}");
            assert!(!plans.is_empty(), "{command}: a plan comes with the program");
            for (name, leaves) in plans {
                // A list of tables is declared as such, and its tables' keys after it.
                let missing: Vec<_> = leaves
                    .iter()
                    .filter(|key| !declared.contains(key.as_str()) && !declared.contains(format!("[[{key}]]").as_str()))
                    .filter(|key| !declared.contains(format!("[{key}]").as_str()))
                    .collect();
                assert!(missing.is_empty(), "{command}, {name}: {missing:?}");
            }
        }
    }

    #[test]
    fn a_number_out_of_range_is_refused_with_its_path() {
        let text = builtin().find(|plan| plan.name == "critic").unwrap().text;
        let mut plan: CriticTrainingPlan = toml::from_str(text).unwrap();
        plan.critic.gamma = 1.5;
        let error = plan.check().unwrap_err().to_string();
        assert_eq!(error, "plan: critic.gamma: expected a number from 0 to 0.9999, got 1.5");
    }
}
