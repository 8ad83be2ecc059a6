//! Plan of a prior's training run: a robot, its clips, and one table that chooses the kind.

use std::path::PathBuf;

use super::kinds::{PriorPlan, Written};

/// A training run of a motion prior, as its TOML file has it.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(try_from = "Written", into = "Written")]
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
    /// The prior: the table of its kind. A plan without any is a β-VAE's with all defaults.
    pub prior: PriorPlan,
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
