//! Uneven ground to learn on.

use lifelike_sim::Terrain;

use crate::TrackerError;
use lifelike_train::limits::range;

/// A field of hills: level at one end, growing in height towards the other. Episodes begin anywhere in its middle half.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct TerrainSpec {
    /// Length of a side (m).
    #[schemars(extend("unit" = "m"), range(min = 1.0, max = 1000.0))]
    pub size: f64,
    /// Distance between neighbouring heights (m).
    #[schemars(extend("unit" = "m"), range(min = 0.01, max = 1000.0))]
    pub spacing: f64,
    /// Height of the hills at the high end (m).
    #[schemars(extend("unit" = "m"), range(min = 0.0, max = 10.0))]
    pub amplitude: f64,
    /// Longest wavelength of the hills (m).
    #[schemars(extend("unit" = "m"), range(min = 0.04, max = 1000.0))]
    pub wavelength: f64,
    /// Seed of the field.
    #[schemars(extend("unit" = "1"))]
    pub seed: u64,
}

impl Default for TerrainSpec {
    fn default() -> Self {
        Self { size: 80.0, spacing: 0.1, amplitude: 0.15, wavelength: 3.0, seed: 0 }
    }
}

impl TerrainSpec {
    /// Returns the field.
    ///
    /// # Errors
    /// Sizes that give no field, or one of more than 10 000 heights a side.
    pub fn build(&self) -> Result<Terrain, TrackerError> {
        let hills = Terrain::hills(self.size, self.spacing, self.amplitude, self.wavelength, self.seed)?;
        let (rows, columns) = (hills.rows(), hills.columns());
        // Episodes begin between a quarter and three quarters of the way: from level to full height.
        let share = |column: usize| (2.0 * (column as f64 / (columns - 1) as f64) - 0.5).clamp(0.0, 1.0);
        let heights = hills.heights().iter().enumerate().map(|(i, h)| h * share(i % columns)).collect();
        Ok(Terrain::new(rows, columns, self.spacing, heights)?)
    }

    /// Checks that every size is in its range.
    ///
    /// # Errors
    /// [`TrackerError::Plan`] with the key, the range and the value.
    pub fn check(&self) -> Result<(), TrackerError> {
        range("terrain.spacing", self.spacing, 0.01, self.size)?;
        Ok(range("terrain.wavelength", self.wavelength, 4.0 * self.spacing, 1000.0)?)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn a_field_rises_from_level_ground_to_its_full_height() {
        let field = TerrainSpec { size: 20.0, ..TerrainSpec::default() }.build().unwrap();
        let highest = |from: f64, to: f64| {
            let columns = field.columns() as f64;
            let inside = |i: usize| {
                ((i % field.columns()) as f64 / columns) >= from && ((i % field.columns()) as f64 / columns) < to
            };
            let heights = field.heights().iter().enumerate().filter(|(i, _)| inside(*i));
            heights.map(|(_, h)| *h).fold(0.0, f64::max)
        };
        assert_eq!(highest(0.0, 0.25), 0.0);
        assert!((0.05..0.1).contains(&highest(0.45, 0.5)), "{}", highest(0.45, 0.5));
        assert!(highest(0.8, 1.0) > 0.13);
    }
}
