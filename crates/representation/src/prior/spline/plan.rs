//! Settings of a spline prior and of its training, a table of a TOML file.

use crate::RepresentationError;
use crate::prior::kind::KindPlan;
use crate::prior::window_plan::WindowPlan;
use crate::spline_transformer::SequencePlan;

/// Settings of a spline prior: which windows, and what encodes them.
#[derive(Debug, Clone, PartialEq, Default, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct SplinePriorPlan {
    /// Windows to train on.
    pub windows: WindowPlan,
    /// Network and its training.
    ///
    /// z_t has `latent` numbers for each control point: 4 of 16 by default, as many as the β-VAE's 64. The row of
    /// thesis Table A.1 for motion (of other data) is `heads = 8`, `width = 128`, `batch = 1024`, `learning_rate =
    /// 3e-4`. The baselines of chapter 3 have one control point, so d_z is their `latent`.
    pub training: SequencePlan,
}

impl KindPlan for SplinePriorPlan {
    fn windows(&self) -> &WindowPlan {
        &self.windows
    }

    /// Returns the numbers of all control points together.
    fn latent_size(&self) -> usize {
        self.training.method.tokens().control_points() * self.training.latent
    }

    fn describe_code(&self) -> String {
        let SequencePlan { method, latent, .. } = self.training;
        format!(
            "{} control points of {latent}, by their mean and standard deviation ({method})",
            self.latent_size() / latent
        )
    }

    fn check(&self) -> Result<(), RepresentationError> {
        self.windows.check()?;
        self.training.check()
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::prior::vae::VaePlan;
    use crate::spline_transformer::Method;

    #[test]
    fn a_code_is_as_large_as_the_vaes_and_of_the_same_windows() {
        let (plan, vae) = (SplinePriorPlan::default(), VaePlan::default());
        assert_eq!((plan.latent_size(), plan.windows), (vae.latent, vae.windows));
        let training = SequencePlan { method: Method::AlibiCat, latent: 64, ..SequencePlan::default() };
        assert_eq!(SplinePriorPlan { training, ..plan }.latent_size(), 64);
    }

    #[test]
    fn a_plan_survives_toml_and_what_is_wrong_is_refused() {
        let plan = SplinePriorPlan::default();
        assert_eq!(toml::from_str::<SplinePriorPlan>(&toml::to_string(&plan).unwrap()).unwrap(), plan);
        assert_eq!(toml::from_str::<SplinePriorPlan>("").unwrap(), plan);
        assert!(toml::from_str::<SplinePriorPlan>("channels = 3").is_err());
        for bad in ["[windows]\nhalf_width = 0", "[windows]\nheld_out = 1.0", "[training]\nlatent = 0"] {
            assert!(toml::from_str::<SplinePriorPlan>(bad).unwrap().check().is_err(), "{bad}");
        }
    }
}
