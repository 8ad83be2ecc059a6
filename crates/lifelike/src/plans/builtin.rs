//! The plans of `experiments/`, in the program.

/// A plan that comes with the program.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BuiltinPlan {
    /// Name, as `--plan` takes it.
    pub name: &'static str,
    /// TOML with comments.
    pub text: &'static str,
}

/// The name tells the command: `track-...` is for `train tracker`.
const KINDS: [(&str, &str); 10] = [
    ("track", "train tracker"),
    ("prior", "train prior"),
    ("spline", "train spline"),
    ("critic", "train critic"),
    ("generator", "train generator"),
    ("align", "align"),
    ("cotrain", "cotrain"),
    ("evaluator", "train evaluator"),
    ("augmentation", "train augmentation"),
    ("get", "train get-up"),
];

macro_rules! plans {
    ($($name:literal),* $(,)?) => {
        [$(BuiltinPlan { name: $name, text: include_str!(concat!("../../experiments/", $name, ".toml")) }),*]
    };
}

/// Returns the built-in plans, in the order of their use.
pub fn builtin() -> impl Iterator<Item = BuiltinPlan> {
    plans![
        "track",
        "track-walk",
        "track-20",
        "track-56",
        "track-all",
        "track-long",
        "track-g1",
        "track-g1-long",
        "track-beyondmimic",
        "track-deploy",
        "track-wbc",
        "track-humanoid",
        "prior",
        "prior-lima",
        "prior-spline",
        "spline",
        "spline-lima",
        "critic",
        "generator",
        "generator-g1",
        "align",
        "cotrain",
        "cotrain-g1",
        "evaluator",
        "augmentation",
        "get-up",
    ]
    .into_iter()
}

impl BuiltinPlan {
    /// Returns the command that the plan is for.
    pub fn command(&self) -> &'static str {
        let kind = self.name.split('-').next().unwrap_or_default();
        KINDS.iter().find(|(prefix, _)| *prefix == kind).map_or("", |(_, command)| command)
    }

    /// Returns the first sentence of its comments.
    pub fn about(&self) -> String {
        let comments = self.text.lines().map_while(|line| line.strip_prefix('#')).map(str::trim);
        let text = comments.take_while(|line| !line.is_empty()).collect::<Vec<_>>().join(" ");
        let end = [". ", ": "].iter().filter_map(|stop| text.find(stop)).min();
        text[..end.unwrap_or(text.len())].trim_end_matches('.').to_string()
    }

    /// Returns whether it needs no files but those of the program.
    pub fn stands_alone(&self) -> bool {
        self.text.lines().any(|line| line.starts_with("clips = [\"builtin\"]"))
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn every_plan_of_the_folder_is_in_the_program_and_says_what_it_is_for() {
        let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("experiments");
        let files: BTreeSet<String> = std::fs::read_dir(folder)
            .unwrap()
            .filter_map(|entry| Some(entry.unwrap().file_name().to_str()?.strip_suffix(".toml")?.to_string()))
            .collect();
        assert_eq!(builtin().map(|plan| plan.name.to_string()).collect::<BTreeSet<_>>(), files);
        for plan in builtin() {
            assert!(!plan.command().is_empty(), "{}", plan.name);
            assert!((20..160).contains(&plan.about().len()), "{}: {}", plan.name, plan.about());
        }
    }

    #[test]
    fn there_is_a_plan_of_each_kind_for_whoever_has_no_data() {
        for name in ["track", "prior", "spline"] {
            assert!(builtin().any(|plan| plan.name == name && plan.stands_alone()), "{name}");
        }
    }
}
