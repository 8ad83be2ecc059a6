//! Families of clips: rows of their own in the tables of an evaluation, such as HumanTracker's.

use std::path::Path;

use lifelike_evaluation::Evaluation;
use lifelike_robot::profile::glob;

use crate::error::CliError;

/// Names of families, and the patterns of their clips' names, in the file's order.
#[derive(Debug, PartialEq)]
pub struct Families(Vec<(String, Vec<String>)>);

impl Families {
    /// Reads a file of families: lines of a name and patterns, `*` for anything; `#` begins a comment. A name may have several lines.
    pub fn read(path: &Path) -> Result<Self, CliError> {
        let text = std::fs::read_to_string(path).map_err(|e| CliError::Input(format!("{}: {e}", path.display())))?;
        Self::parse(&text).map_err(|error| CliError::Input(format!("{}:{error}", path.display())))
    }

    fn parse(text: &str) -> Result<Self, String> {
        let mut families: Vec<(String, Vec<String>)> = Vec::new();
        for (number, line) in text.lines().enumerate() {
            let mut words = line.split('#').next().unwrap_or_default().split_whitespace().map(str::to_owned);
            let Some(name) = words.next() else { continue };
            let patterns: Vec<String> = words.collect();
            if patterns.is_empty() {
                return Err(format!("{}: expected patterns of clip names after '{name}', got none", number + 1));
            }
            match families.iter_mut().find(|(known, _)| *known == name) {
                Some((_, all)) => all.extend(patterns),
                None => families.push((name, patterns)),
            }
        }
        if families.is_empty() {
            Err("1: expected lines of a family and patterns, got none".into())
        } else {
            Ok(Self(families))
        }
    }

    /// Returns the first family that has a pattern for a clip.
    fn of(&self, clip: &str) -> Option<&str> {
        let family = self.0.iter().find(|(_, patterns)| patterns.iter().any(|pattern| glob(pattern, clip)));
        family.map(|(name, _)| name.as_str())
    }

    /// Adds the families' scores to an evaluation; clips of none are named in a warning.
    pub fn group(&self, evaluation: &mut Evaluation) {
        for (name, _) in &self.0 {
            evaluation.group(name, |clip| self.of(clip) == Some(name));
        }
        let none: Vec<&str> =
            evaluation.clips.iter().map(|c| c.clip.as_str()).filter(|c| self.of(c).is_none()).collect();
        if !none.is_empty() {
            tracing::warn!("--families: {} clips are in no family: {}", none.len(), none.join(", "));
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn a_clip_is_of_the_first_family_that_names_it() {
        let families = Families::parse(
            "# on the ground\nGround *crawl* *getup*  # more\nDaily 0[78]\nGround 13_01\nDaily *walk*\n",
        )
        .unwrap();
        assert_eq!(families.of("humanoid3d_crawl"), Some("Ground"));
        assert_eq!(families.of("13_01"), Some("Ground"));
        assert_eq!((families.of("crawl_walk"), families.of("walk")), (Some("Ground"), Some("Daily")));
        assert_eq!(families.of("07"), None, "only a star stands for anything");
        assert_eq!(
            Families::parse("\nGround\n").unwrap_err(),
            "2: expected patterns of clip names after 'Ground', got none"
        );
        assert!(Families::parse("# nothing\n").is_err());
    }

    #[test]
    fn our_own_families_have_hum_trackers_names() {
        let text = include_str!("../../experiments/families.txt");
        let families = Families::parse(text).unwrap();
        let names: Vec<&str> = families.0.iter().map(|(name, _)| name.as_str()).collect();
        assert_eq!(names, ["Ground", "Interaction", "HighlyDynamic", "Daily"]);
        for (clip, family) in [
            ("humanoid3d_crawl", "Ground"),
            ("13_01", "Ground"),
            ("06_03", "Interaction"),
            ("humanoid3d_backflip", "HighlyDynamic"),
            ("05_12", "HighlyDynamic"),
            ("135_04", "HighlyDynamic"),
            ("07_01", "Daily"),
            ("dataset-1_bow_proud_001", "Daily"),
        ] {
            assert_eq!(families.of(clip), Some(family), "{clip}");
        }
    }
}
