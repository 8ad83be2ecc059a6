//! Settings of principal components, a table of a TOML file.

use lifelike_train::limits::whole;

use crate::RepresentationError;
use crate::prior::kind::KindPlan;
use crate::prior::window_plan::WindowPlan;

/// Settings of a prior of principal components.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct PcaPlan {
    /// The windows: those of [`crate::prior::vae::VaePlan`], by the same names.
    pub windows: WindowPlan,
    /// d_z, the number of components.
    pub latent: usize,
    /// Iterations of the subspace; the error of what is kept falls geometrically with them.
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
        self.windows.check()?;
        whole("latent", self.latent as u64, 1, 4096)?;
        Ok(whole("iterations", self.iterations, 1, 10_000)?)
    }
}
