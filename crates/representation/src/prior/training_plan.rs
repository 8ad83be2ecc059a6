//! Plan of a prior's training run: a robot, its clips, and one table that chooses the kind.

use std::path::PathBuf;

use super::kinds::{PriorPlan, Written};

/// A training run of a motion prior. Its keys are documented where a file has them, in `kinds.rs`.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(try_from = "Written", into = "Written")]
pub struct PriorTrainingPlan {
    /// Robot: a built-in name, or an MJCF or URDF file.
    pub robot: String,
    /// Clips to train on.
    pub clips: Vec<PathBuf>,
    /// Learning from the mirror image of every training clip too.
    pub mirror: bool,
    /// Clips that only measure the reconstruction.
    pub validation: Vec<PathBuf>,
    /// Prior, of one kind.
    pub prior: PriorPlan,
}

impl TryFrom<Written> for PriorTrainingPlan {
    type Error = String;

    fn try_from(mut written: Written) -> Result<Self, String> {
        let prior = written.take_prior()?;
        let Written { robot, clips, mirror, validation, .. } = written;
        Ok(Self { robot, clips, mirror, validation, prior })
    }
}

impl From<PriorTrainingPlan> for Written {
    fn from(plan: PriorTrainingPlan) -> Self {
        let PriorTrainingPlan { robot, clips, mirror, validation, prior } = plan;
        let mut written = Self::with_prior(prior);
        (written.robot, written.clips) = (robot, clips);
        (written.mirror, written.validation) = (mirror, validation);
        written
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
