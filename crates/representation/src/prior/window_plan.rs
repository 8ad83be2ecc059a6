//! Windows that a motion prior is trained on and encodes, whatever its kind.

use lifelike_motion::window::WindowSpec;

use super::statistics::StdFloors;
use crate::RepresentationError;
use lifelike_train::plan;

/// Settings that priors of every kind have in common.
///
/// ```
/// use lifelike_representation::prior::WindowPlan;
///
/// // The thesis' 61 samples over one second, and a window of two seconds.
/// assert_eq!(WindowPlan::default().window().len(), 61);
/// let longer = WindowPlan { window_seconds: 2.0, ..WindowPlan::default() };
/// assert_eq!(longer.window().dt, 2.0 / 60.0);
/// assert!(WindowPlan { half_width: 0, ..WindowPlan::default() }.check().is_err());
/// ```
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct WindowPlan {
    /// Seed of the choice of clips that are held out.
    #[schemars(extend("unit" = "1"))]
    pub seed: u64,
    /// Frame rate of the clips' frames, the control rate (Hz).
    #[schemars(extend("unit" = "Hz"), range(min = 1.0, max = 1000.0))]
    pub frame_rate: f64,
    /// W of eq. 4.2: a window has 2W + 1 samples.
    #[schemars(extend("unit" = "1"), range(min = 1, max = 500))]
    pub half_width: usize,
    /// Time that a window covers (s).
    ///
    /// The thesis' 61 frames cover 1 s, so samples are 1/60 s apart. Frames at another rate (50 Hz here) are
    /// interpolated at t + k/60 s for k = -30..30, rotations by slerp.
    #[schemars(extend("unit" = "s"), range(min = 0.02, max = 20.0))]
    pub window_seconds: f64,
    /// Share of the clips that is held out for the report.
    ///
    /// Chosen by [`super::split`].
    #[schemars(extend("unit" = "1"), range(min = 0.0, max = 0.9))]
    pub held_out: f64,
    /// Smallest standard deviations that features are divided by.
    pub floors: StdFloors,
}

impl Default for WindowPlan {
    fn default() -> Self {
        let floors = StdFloors::default();
        Self { seed: 0, frame_rate: 50.0, half_width: 30, window_seconds: 1.0, held_out: 0.1, floors }
    }
}

impl WindowPlan {
    /// Checks every range.
    ///
    /// # Errors
    /// The first key out of range.
    pub fn check(&self) -> Result<(), RepresentationError> {
        Ok(plan::check("", self)?)
    }

    /// Returns the window in time.
    pub fn window(&self) -> WindowSpec {
        WindowSpec { half_width: self.half_width, dt: self.window_seconds / (2 * self.half_width) as f64 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sixty_one_samples_cover_one_second() {
        let window = WindowPlan::default().window();
        assert_eq!(window.len(), 61);
        assert!((window.dt - 1.0 / 60.0).abs() < 1e-15);
    }
}
