//! Bounds of numbers, and the check of a plan against its own.

use schemars::JsonSchema;
use serde::Serialize;
use serde_json::Value as Json;
use toml::{Table, Value};

use super::{Node, is, options, properties, tree};
use crate::limits::{PlanError, wrong};

/// Least and greatest value of a number.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Bounds {
    /// Least value.
    pub min: Option<f64>,
    /// Greatest value.
    pub max: Option<f64>,
    /// True where the value is below the greatest one.
    pub below: bool,
    /// True for whole numbers.
    pub whole: bool,
}

impl Bounds {
    /// Returns the bounds of a number's schema, or of the items of a list.
    pub(super) fn of(node: &Node) -> Self {
        let Some(node) = options(node).into_iter().find(|node| !is(node, "boolean")) else { return Self::default() };
        if let Some(items) = node.get("items").and_then(Json::as_object) {
            return Self::of(items);
        }
        let number = |key: &str| node.get(key).and_then(Json::as_f64);
        let (max, below) = (number("maximum"), number("exclusiveMaximum"));
        Self { min: number("minimum"), max: max.or(below), below: below.is_some(), whole: is(node, "integer") }
    }

    fn holds(self, value: f64) -> bool {
        let low = self.min.is_none_or(|min| min <= value);
        let high = self.max.is_none_or(|max| if self.below { value < max } else { value <= max });
        let finite = value.is_finite() || (self.min.is_none() && self.max.is_none() && !value.is_nan());
        low && high && finite
    }

    fn expected(self) -> String {
        let kind = if self.whole { "" } else { "a number from " };
        match (self.min.map(short), self.max.map(short)) {
            (Some(min), Some(max)) if self.below => format!("{kind}{min} to below {max}"),
            (Some(min), Some(max)) => format!("{kind}{min} to {max}"),
            (Some(min), None) if self.whole => format!("{min} or more"),
            (Some(min), None) => format!("a number of at least {min}"),
            (None, Some(max)) => format!("a number of at most {max}"),
            (None, None) => "a number".into(),
        }
    }
}

/// Writes a number with few digits: 0.5, 1e6.
fn short(x: f64) -> String {
    if (1e-3..1e6).contains(&x.abs()) || x == 0.0 { format!("{x}") } else { format!("{x:e}") }
}

impl std::fmt::Display for Bounds {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match (self.min.map(short), self.max.map(short)) {
            (Some(min), Some(max)) => write!(f, "{min} to {}{max}", if self.below { "below " } else { "" }),
            (Some(min), None) => write!(f, "≥ {min}"),
            (None, Some(max)) => write!(f, "≤ {max}"),
            (None, None) => Ok(()),
        }
    }
}

/// Checks every number of a plan, or of a table of one, against its declared bounds. `key` is the table's own; empty for
/// a plan. A number without bounds may be infinite.
///
/// # Errors
/// The first key out of range, with the range and the value.
pub fn check<P: JsonSchema + Serialize>(key: &str, plan: &P) -> Result<(), PlanError> {
    let plan = Value::try_from(plan).map_err(|error| wrong(key, "a plan that can be written as TOML", error))?;
    within(key, &tree::<P>(), &plan)
}

fn within(key: &str, node: &Node, value: &Value) -> Result<(), PlanError> {
    let Some(node) = options(node).into_iter().find(|node| fits(node, value)) else { return Ok(()) };
    match value {
        Value::Table(table) => {
            let Some(properties) = properties(node) else { return Ok(()) };
            for (name, value) in table {
                let below = if key.is_empty() { name.clone() } else { format!("{key}.{name}") };
                let node = properties.get(name).and_then(Json::as_object);
                node.map_or(Ok(()), |node| within(&below, node, value))?;
            }
            Ok(())
        }
        Value::Array(items) => {
            let Some(node) = node.get("items").and_then(Json::as_object) else { return Ok(()) };
            items.iter().enumerate().try_for_each(|(i, item)| within(&format!("{key}[{i}]"), node, item))
        }
        Value::Float(x) => number(key, node, *x, x),
        Value::Integer(x) => number(key, node, *x as f64, x),
        _ => Ok(()),
    }
}

fn number(key: &str, node: &Node, value: f64, shown: &dyn std::fmt::Display) -> Result<(), PlanError> {
    let bounds = Bounds::of(node);
    if bounds.holds(value) { Ok(()) } else { Err(wrong(key, &bounds.expected(), shown)) }
}

/// Returns whether a schema is the one for a value: its type, and the tag of a table with several forms.
fn fits(node: &Node, value: &Value) -> bool {
    match value {
        Value::Table(table) => is(node, "object") && properties(node).is_some_and(|own| tags_fit(own, table)),
        Value::Array(_) => is(node, "array"),
        Value::Float(_) | Value::Integer(_) => is(node, "number") || is(node, "integer"),
        _ => false,
    }
}

fn tags_fit(properties: &Node, table: &Table) -> bool {
    table.iter().all(|(key, value)| {
        let choices = properties.get(key).and_then(|node| node.get("enum")?.as_array());
        choices.is_none_or(|choices| value.as_str().is_none_or(|own| choices.iter().any(|choice| choice == own)))
    })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[derive(Serialize, JsonSchema)]
    struct Plan {
        #[schemars(range(min = 1, max = 9))]
        count: Option<usize>,
        #[schemars(inner(range(min = 0.0, max = 1.0)))]
        shares: Vec<f32>,
        limit: f64,
        form: Form,
    }

    #[derive(Clone, Copy, Serialize, JsonSchema)]
    #[serde(tag = "kind", rename_all = "snake_case")]
    enum Form {
        Small {
            #[schemars(range(max = 1.0))]
            size: f64,
        },
        Large {
            #[schemars(range(min = 10.0))]
            size: f64,
        },
    }

    #[test]
    fn numbers_out_of_range_are_named_in_options_lists_and_the_form_that_is_chosen() {
        let plan = |count, share, limit, form| Plan { count, shares: vec![0.5, share], limit, form };
        let (small, large) = (Form::Small { size: 0.5 }, Form::Large { size: 20.0 });
        for (plan, told) in [
            (plan(None, 1.0, f64::INFINITY, small), ""),
            (plan(Some(9), 0.0, -1e9, large), ""),
            (plan(Some(10), 0.0, 0.0, small), "plan: p.count: expected 1 to 9, got 10"),
            (plan(None, 1.5, 0.0, small), "plan: p.shares[1]: expected a number from 0 to 1, got 1.5"),
            (plan(None, f32::NAN, 0.0, small), "plan: p.shares[1]: expected a number from 0 to 1, got NaN"),
            (plan(None, 0.0, f64::NAN, small), "plan: p.limit: expected a number, got NaN"),
            (
                plan(None, 0.0, 0.0, Form::Small { size: 20.0 }),
                "plan: p.form.size: expected a number of at most 1, got 20",
            ),
            (
                plan(None, 0.0, 0.0, Form::Large { size: 0.5 }),
                "plan: p.form.size: expected a number of at least 10, got 0.5",
            ),
        ] {
            let error = check("p", &plan).map_err(|error| error.to_string()).err().unwrap_or_default();
            assert_eq!(error, told);
        }
    }
}
