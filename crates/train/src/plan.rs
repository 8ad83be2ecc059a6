//! Plans declared once: the table of keys, the JSON Schema and the range check of a plan follow from its type.
//!
//! A field's doc comment is the key's meaning: its first paragraph is the row of the table, the rest is detail.
//! `extend("unit" = "m")` is its unit (`"1"`: none) and `range(...)` its bounds. Defaults are those of serde.
//!
//! ```
//! use lifelike_train::plan;
//!
//! #[derive(serde::Serialize, schemars::JsonSchema)]
//! struct Throw {
//!     /// Height of the hand (m).
//!     #[schemars(extend("unit" = "m"), range(min = 0.0, max = 3.0))]
//!     height: f64,
//! }
//!
//! let row = &plan::keys::<Throw>()[0];
//! assert_eq!((row.key.as_str(), row.unit.as_str(), row.meaning.as_str()), ("height", "m", "Height of the hand"));
//! let error = plan::check("throw", &Throw { height: 4.0 }).unwrap_err();
//! assert_eq!(error.to_string(), "plan: throw.height: expected a number from 0 to 3, got 4");
//! ```

mod bounds;
mod keys;

use schemars::JsonSchema;
use schemars::generate::SchemaSettings;
use schemars::transform::{ReplaceConstValue, Transform};
use serde_json::{Map, Value};

pub use bounds::{Bounds, check};
pub use keys::{PlanKey, keys};

/// A JSON Schema, or a part of one.
type Node = Map<String, Value>;

/// Returns the JSON Schema of a plan (draft 7 without references), for editors that complete and check TOML.
pub fn schema<P: JsonSchema>() -> Value {
    let mut root = tree::<P>();
    name_units(&mut root);
    Value::Object(root)
}

/// Returns the schema of a plan in one piece, as TOML has it: without null.
fn tree<P: JsonSchema>() -> Node {
    let inline = |settings: &mut SchemaSettings| settings.inline_subschemas = true;
    let mut schema = SchemaSettings::draft07().with(inline).into_generator().into_root_schema_for::<P>();
    ReplaceConstValue::default().transform(&mut schema);
    let mut root = schema.as_object().cloned().unwrap_or_default();
    remove_null(&mut root);
    root
}

/// Calls a function on every schema below a schema.
fn each_below(node: &mut Node, act: fn(&mut Node)) {
    for (key, value) in node.iter_mut() {
        let below: Vec<&mut Value> = match (key.as_str(), value) {
            ("properties", Value::Object(properties)) => properties.values_mut().collect(),
            ("oneOf" | "anyOf", Value::Array(items)) => items.iter_mut().collect(),
            ("items", value) => vec![value],
            _ => continue,
        };
        below.into_iter().filter_map(Value::as_object_mut).for_each(act);
    }
}

/// Removes null, which TOML lacks, and writes numbers of single precision with their own digits.
fn remove_null(node: &mut Node) {
    each_below(node, remove_null);
    for key in ["type", "enum"] {
        if let Some(Value::Array(kinds)) = node.get_mut(key) {
            kinds.retain(|kind| !kind.is_null() && kind != "null");
            if let ("type", [one]) = (key, kinds.as_slice()) {
                let one = one.clone();
                node.insert("type".into(), one);
            }
        }
    }
    if let Some(Value::Array(mut options)) = node.remove("anyOf") {
        options.retain(|option| option["type"] != "null");
        match options.as_mut_slice() {
            // The field's own meaning and default count, not those of its type.
            [Value::Object(only)] => std::mem::take(only).into_iter().for_each(|(key, value)| {
                node.entry(key).or_insert(value);
            }),
            _ => drop(node.insert("anyOf".into(), options.into())),
        }
    }
    match node.get_mut("default") {
        Some(Value::Null) => drop(node.remove("default")),
        Some(default) => shorten(default),
        None => {}
    }
}

fn shorten(value: &mut Value) {
    match value {
        Value::Number(number) => {
            let wide = number.as_f64().filter(|wide| number.is_f64() && f64::from(*wide as f32) == *wide);
            if let Some(short) = wide.and_then(|wide| format!("{}", wide as f32).parse::<f64>().ok()) {
                *value = short.into();
            }
        }
        Value::Array(items) => items.iter_mut().for_each(shorten),
        Value::Object(table) => {
            table.retain(|_, value| !value.is_null());
            table.values_mut().for_each(shorten);
        }
        _ => {}
    }
}

/// Writes units into descriptions, which editors show.
fn name_units(node: &mut Node) {
    each_below(node, name_units);
    let unit = node.get("unit").and_then(Value::as_str).filter(|unit| *unit != "1").map(str::to_owned);
    if let (Some(unit), Some(Value::String(description))) = (unit, node.get_mut("description")) {
        *description += &format!("\n\nUnit: {unit}");
    }
}

/// Returns the tables or values that a schema accepts, one of which holds: its variants, or itself.
fn options(node: &Node) -> Vec<&Node> {
    let variants = node.get("oneOf").or(node.get("anyOf")).and_then(Value::as_array);
    variants
        .map_or_else(|| vec![node], |variants| variants.iter().filter_map(Value::as_object).flat_map(options).collect())
}

/// Returns the properties of a table.
fn properties(node: &Node) -> Option<&Node> {
    node.get("properties")?.as_object()
}

/// Returns true where a schema is of this type of JSON.
fn is(node: &Node, kind: &str) -> bool {
    node.get("type").is_some_and(|own| own == kind)
}

fn text<'a>(node: &'a Node, key: &str) -> &'a str {
    node.get(key).and_then(Value::as_str).unwrap_or_default()
}
