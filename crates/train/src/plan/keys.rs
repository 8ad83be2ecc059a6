//! The table of a plan's keys.

use schemars::JsonSchema;
use serde_json::Value;

use super::{Bounds, Node, is, options, properties, text, tree};

/// One key of a plan, or one of its tables.
#[derive(Debug, Clone, PartialEq)]
pub struct PlanKey {
    /// Dotted path, as on the command line; in brackets for a table, and `[]` after the name of a list of tables.
    pub key: String,
    /// Default, as TOML; `-` where the key is required, off or absent by default.
    pub default: String,
    /// Unit; `1` for numbers without one, empty for what is no number.
    pub unit: String,
    /// Bounds of a number, or of the numbers of a list.
    pub bounds: Bounds,
    /// Names that a text may be; empty where it may be any.
    pub choices: Vec<String>,
    /// Meaning: the first paragraph of the field's doc comment, without the unit.
    pub meaning: String,
    /// True for numbers and lists of them.
    pub number: bool,
}

impl PlanKey {
    /// Returns bounds or choices, for people.
    pub fn range(&self) -> String {
        if self.choices.is_empty() { self.bounds.to_string() } else { self.choices.join(", ") }
    }
}

/// Returns all keys of a plan by name, those of a table before its tables.
pub fn keys<P: JsonSchema>() -> Vec<PlanKey> {
    let mut rows = Vec::new();
    add_table("", &tree::<P>(), None, &mut rows);
    rows
}

/// Adds the keys of a table, of whatever form it may be.
fn add_table(path: &str, node: &Node, default: Option<&Value>, rows: &mut Vec<PlanKey>) {
    let forms: Vec<&Node> = options(node).into_iter().filter(|form| properties(form).is_some()).collect();
    let mut tables = Vec::new();
    for form in &forms {
        let default = default.filter(|default| is_form(form, default));
        for (name, node) in properties(form).into_iter().flatten() {
            let Some(node) = node.as_object() else { continue };
            let key = if path.is_empty() { name.clone() } else { format!("{path}.{name}") };
            let default = default.and_then(|table| table.get(name)).or(node.get("default"));
            if let Some(table) = table(node) {
                tables.push((key, node, table, default));
            } else {
                let mut row = row(&key, node, default);
                if let (true, [choice]) = (row.meaning.is_empty(), row.choices.as_slice()) {
                    row.meaning = format!("\"{choice}\": {}", meaning(text(form, "description"), ""));
                }
                add(row, rows);
            }
        }
    }
    for (key, node, table, default) in tables {
        let (key, heading) = if is(node, "array") {
            (format!("{key}[]"), format!("[[{key}]]"))
        } else {
            (key.clone(), format!("[{key}]"))
        };
        add(PlanKey { number: false, default: "-".into(), choices: Vec::new(), ..row(&heading, node, None) }, rows);
        add_table(&key, table, default, rows);
    }
}

/// Adds a row; the same key of another form adds its choices and what is lacking.
fn add(row: PlanKey, rows: &mut Vec<PlanKey>) {
    match rows.iter_mut().find(|other| other.key == row.key) {
        None => rows.push(row),
        Some(other) => {
            if !row.choices.is_empty() {
                other.meaning += &format!("; {}", row.meaning);
            }
            other.choices.extend(row.choices);
            if other.default == "-" {
                other.default = row.default;
            }
        }
    }
}

fn row(key: &str, node: &Node, default: Option<&Value>) -> PlanKey {
    let number = |node: &Node| is(node, "number") || is(node, "integer");
    let value = |node: &Node| node.get("items").and_then(Value::as_object).is_some_and(number) || number(node);
    let choices = options(node)
        .into_iter()
        .flat_map(|node| node.get("items").and_then(Value::as_object).map_or_else(|| vec![node], options));
    let choices = choices.flat_map(|node| node.get("enum").and_then(Value::as_array).into_iter().flatten());
    let unit = text(node, "unit");
    PlanKey {
        key: key.into(),
        default: default.filter(|default| !default.is_object()).map_or_else(|| "-".into(), written),
        unit: unit.into(),
        bounds: Bounds::of(node),
        choices: choices.filter_map(Value::as_str).map(str::to_owned).collect(),
        meaning: meaning(text(node, "description"), unit),
        number: options(node).into_iter().any(value),
    }
}

/// Returns the first paragraph of a doc comment in one line, without the unit at its end.
fn meaning(doc: &str, unit: &str) -> String {
    let line = doc.split("\n\n").next().unwrap_or_default().split_whitespace().collect::<Vec<_>>().join(" ");
    let line = line.trim_end_matches('.');
    line.strip_suffix(&format!(" ({unit})")).unwrap_or(line).to_owned()
}

/// Returns the schema of a table, or of the tables of a list.
fn table(node: &Node) -> Option<&Node> {
    let items = node.get("items").and_then(Value::as_object);
    let node = items.unwrap_or(node);
    options(node).into_iter().any(|node| properties(node).is_some()).then_some(node)
}

/// Returns whether a default is of a form, by its tag.
fn is_form(form: &Node, default: &Value) -> bool {
    properties(form).into_iter().flatten().all(|(name, node)| {
        let choices = node.get("enum").and_then(Value::as_array);
        choices.is_none_or(|choices| default.get(name).is_none_or(|value| choices.contains(value)))
    })
}

/// Returns a value as TOML.
fn written(value: &Value) -> String {
    match value {
        Value::Number(number) if number.is_f64() => format!("{:?}", number.as_f64().unwrap_or_default()),
        Value::Array(items) => format!("[{}]", items.iter().map(written).collect::<Vec<_>>().join(", ")),
        other => other.to_string(),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use serde::{Deserialize, Serialize};

    #[derive(Serialize, Deserialize, JsonSchema)]
    #[serde(default)]
    struct Plan {
        /// Robot.
        robot: String,
        /// A share.
        ///
        /// Detail.
        #[schemars(extend("unit" = "1"), range(min = 0.0, max = 1.0))]
        share: f32,
        /// Time
        /// of a step (s).
        #[schemars(extend("unit" = "s"))]
        time: Option<f64>,
        /// Form.
        form: Form,
        /// Teachers.
        teachers: Vec<Teacher>,
    }

    #[derive(Serialize, Deserialize, JsonSchema)]
    #[serde(tag = "kind", rename_all = "snake_case")]
    enum Form {
        /// Nothing.
        None,
        /// Steps.
        Steps {
            /// Number of steps.
            #[schemars(extend("unit" = "1"))]
            count: usize,
        },
    }

    #[derive(Serialize, Deserialize, JsonSchema)]
    struct Teacher {
        /// File.
        file: String,
    }

    impl Default for Plan {
        fn default() -> Self {
            Self { robot: "lima".into(), share: 0.97, time: None, form: Form::Steps { count: 3 }, teachers: Vec::new() }
        }
    }

    #[test]
    fn a_table_by_hand() {
        let rows = keys::<Plan>();
        let told: Vec<[String; 5]> = rows
            .iter()
            .map(|k| [k.key.clone(), k.default.clone(), k.unit.clone(), k.range(), k.meaning.clone()])
            .collect();
        let expected = [
            ["robot", "\"lima\"", "", "", "Robot"],
            ["share", "0.97", "1", "0 to 1", "A share"],
            ["time", "-", "s", "", "Time of a step"],
            ["[form]", "-", "", "", "Form"],
            ["form.kind", "\"steps\"", "", "none, steps", "\"none\": Nothing; \"steps\": Steps"],
            ["form.count", "3", "1", "≥ 0", "Number of steps"],
            ["[[teachers]]", "-", "", "", "Teachers"],
            ["teachers[].file", "-", "", "", "File"],
        ];
        assert_eq!(told, expected);
        assert_eq!(rows.iter().filter(|row| row.number).count(), 3);
    }
}
