//! Plan of a prior's training run: a robot, its clips, and one table that chooses the kind.

use std::fmt;
use std::path::PathBuf;

use serde::de::{Error, MapAccess, Visitor};
use serde::ser::SerializeStruct;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::kinds::PriorPlan;
use super::vae::VaePlan;

/// A training run of a motion prior, as its TOML file has it.
#[derive(Debug, Clone, PartialEq)]
pub struct PriorTrainingPlan {
    /// A built-in robot's name, or its MJCF or URDF file.
    pub robot: String,
    /// Clips to train on: files, folders, patterns. Captured motion and keyframes are retargeted to the robot.
    pub clips: Vec<PathBuf>,
    /// Learn from the mirror image of every training clip too, by the robot's own symmetry.
    pub mirror: bool,
    /// Clips that are never trained on, nor any of their names: the reconstruction is measured on them along the way, and at the end.
    /// They take the place of the share `held_out`.
    pub validation: Vec<PathBuf>,
    /// The prior: the table of its kind ([`PriorPlan::TABLES`]). A plan without any is a β-VAE's with all defaults.
    pub prior: PriorPlan,
}

/// Keys beside the kinds' tables.
const KEYS: [&str; 4] = ["robot", "clips", "mirror", "validation"];

impl Serialize for PriorTrainingPlan {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut plan = serializer.serialize_struct("PriorTrainingPlan", KEYS.len() + 1)?;
        plan.serialize_field("robot", &self.robot)?;
        plan.serialize_field("clips", &self.clips)?;
        plan.serialize_field("mirror", &self.mirror)?;
        plan.serialize_field("validation", &self.validation)?;
        self.prior.serialize_into(&mut plan)?;
        plan.end()
    }
}

impl<'de> Deserialize<'de> for PriorTrainingPlan {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_map(PlanVisitor)
    }
}

/// A key of the plan. Refused while it is read, so that the message has its line.
struct Key(String);

impl<'de> Deserialize<'de> for Key {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let key = String::deserialize(deserializer)?;
        let known: Vec<&str> = KEYS.into_iter().chain(PriorPlan::TABLES.iter().map(|(table, _)| *table)).collect();
        if known.contains(&key.as_str()) {
            return Ok(Self(key));
        }
        let known: Vec<String> = known.into_iter().map(|key| format!("`{key}`")).collect();
        Err(D::Error::custom(format!("unknown field `{key}`, expected one of {}", known.join(", "))))
    }
}

struct PlanVisitor;

impl<'de> Visitor<'de> for PlanVisitor {
    type Value = PriorTrainingPlan;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a plan of a motion prior")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<PriorTrainingPlan, A::Error> {
        let (mut robot, mut clips, mut mirror, mut validation, mut prior) = (None, None, false, Vec::new(), None);
        while let Some(Key(key)) = map.next_key()? {
            match key.as_str() {
                "robot" => robot = Some(map.next_value()?),
                "clips" => clips = Some(map.next_value()?),
                "mirror" => mirror = map.next_value()?,
                "validation" => validation = map.next_value()?,
                table => {
                    let found = PriorPlan::next_value(table, &mut map)?;
                    if prior.is_some() {
                        let tables = PriorPlan::TABLES.iter().map(|(table, title)| format!("[{table}] ({title})"));
                        let tables = tables.collect::<Vec<_>>().join(", ");
                        return Err(A::Error::custom(format!("expected one table of {tables}, got two")));
                    }
                    prior = found;
                }
            }
        }
        Ok(PriorTrainingPlan {
            robot: robot.ok_or_else(|| A::Error::missing_field(KEYS[0]))?,
            clips: clips.ok_or_else(|| A::Error::missing_field(KEYS[1]))?,
            mirror,
            validation,
            prior: prior.unwrap_or_else(|| VaePlan::default().into()),
        })
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn plan(text: &str) -> Result<PriorTrainingPlan, toml::de::Error> {
        toml::from_str(&format!("robot = \"lima\"\nclips = []\n{text}"))
    }

    #[test]
    fn a_plan_has_one_kind_and_comes_back_from_its_own_text() {
        for text in [
            "",
            "mirror = true\nvalidation = [\"aside\"]\n[prior]\nlinear_path = true",
            "[spline]",
            "[spline.training]\nlatent = 8",
            "[pca]\nlatent = 8",
        ] {
            let plan = plan(text).unwrap();
            assert_eq!(toml::from_str::<PriorTrainingPlan>(&toml::to_string_pretty(&plan).unwrap()).unwrap(), plan);
            assert_eq!(matches!(plan.prior, PriorPlan::Spline(_)), text.contains("spline"), "{text}");
        }
    }

    #[test]
    fn what_is_wrong_is_named_with_its_line() {
        let told = |text: &str| plan(text).unwrap_err().to_string();
        let both = told("[prior]\n[spline]");
        assert!(
            both.contains("[spline] (a Spline-based Transformer), [pca] (principal components), got two"),
            "{both}"
        );
        let unknown = told("[splien]");
        assert!(unknown.contains("line 3") && unknown.contains("unknown field `splien`"), "{unknown}");
        assert!(unknown.contains("`robot`, `clips`, `mirror`, `validation`, `prior`, `spline`"), "{unknown}");
        let inside = told("[prior]\nlatent = 64\nchanels = 8");
        assert!(inside.contains("line 5") && inside.contains("unknown field `chanels`"), "{inside}");
        let missing = toml::from_str::<PriorTrainingPlan>("clips = []").unwrap_err().to_string();
        assert!(missing.contains("missing field `robot`"), "{missing}");
        let wrong = plan("[spline.training]\nwidth = 63").unwrap().prior.check().unwrap_err().to_string();
        assert!(wrong.contains("heads: expected a divisor of the width 63"), "{wrong}");
    }
}
