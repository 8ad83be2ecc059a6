//! Settings of principal components, a table of a TOML file.

use lifelike_train::plan;

use crate::RepresentationError;
use crate::prior::kind::KindPlan;
use crate::prior::window_plan::WindowPlan;

/// Settings of a prior of principal components.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct PcaPlan {
    /// Windows to train on.
    pub windows: WindowPlan,
    /// Size d_z of the latent code, the number of components.
    #[schemars(extend("unit" = "1"), range(min = 1, max = 4096))]
    pub latent: usize,
    /// Iterations of the subspace; the reconstruction error falls geometrically with them.
    #[schemars(extend("unit" = "iterations"), range(min = 1, max = 10_000))]
    pub iterations: u64,
}

impl Default for PcaPlan {
    fn default() -> Self {
        Self { windows: WindowPlan::default(), latent: 64, iterations: Self::ITERATIONS }
    }
}

impl PcaPlan {
    /// Iterations after which another does not change the reconstruction of real motion by a hundredth of a degree.
    pub(in crate::prior) const ITERATIONS: u64 = 12;
}

impl KindPlan for PcaPlan {
    fn windows(&self) -> &WindowPlan {
        &self.windows
    }

    fn latent_size(&self) -> usize {
        self.latent
    }

    fn describe_code(&self) -> String {
        format!("{} principal components by their standard deviations", self.latent)
    }

    fn check(&self) -> Result<(), RepresentationError> {
        Ok(plan::check("", self)?)
    }
}
