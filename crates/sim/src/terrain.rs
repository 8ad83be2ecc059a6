//! Uneven ground: a grid of heights about the origin.

use rand::{Rng, SeedableRng};

use crate::error::SimError;

/// Largest number of heights along one side.
const MAX_SIDE: usize = 10_000;

/// Heights on a regular grid, its middle at the world's origin. Between them the surface is made of triangles: each cell is
/// cut from its corner at the lower x and y to the opposite one, as MuJoCo's height fields are.
///
/// The points that touch it are those that touch level ground: centres of spheres, ends of capsules, corners of boxes. A ridge that is
/// narrower than a sole passes between its corners.
///
/// ```
/// use lifelike_sim::Terrain;
///
/// let slope = Terrain::from_fn(4.0, 0.1, |x, _| 0.5 * x)?;
/// assert!((slope.height(1.0, -0.5).unwrap_or(f64::NAN) - 0.5).abs() < 1e-9);
/// assert_eq!(slope.height(9.0, 0.0), None);
/// // A metre above the slope is less than a metre away from it.
/// let (distance, normal) = slope.clearance([1.0, 0.0, 1.5]);
/// assert!(distance < 1.0 && normal[0] < 0.0);
/// # Ok::<(), lifelike_sim::SimError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Terrain {
    columns: usize,
    rows: usize,
    spacing: f64,
    heights: Vec<f64>,
    top: f64,
    slant: f64,
}

/// Distance (m) to the ground outside of the grid: far from everything, and still a number to calculate with.
const NO_GROUND: f64 = 1e3;

impl Terrain {
    /// # Shapes
    /// `heights: [rows, columns]` (m): x grows along a row, y from row to row, `spacing` apart (m).
    ///
    /// # Errors
    /// [`SimError::Terrain`] for fewer than two rows or columns, another number of heights, or numbers that are not finite.
    pub fn new(rows: usize, columns: usize, spacing: f64, heights: Vec<f64>) -> Result<Self, SimError> {
        let fail = |expected: String, got: String| SimError::Terrain { expected, got };
        if !(2..=MAX_SIDE).contains(&rows) || !(2..=MAX_SIDE).contains(&columns) {
            return Err(fail(format!("from 2 to {MAX_SIDE} rows and columns"), format!("{rows} x {columns}")));
        }
        if !(spacing.is_finite() && spacing > 0.0) {
            return Err(fail("a spacing above 0 m".into(), spacing.to_string()));
        }
        if heights.len() != rows * columns {
            return Err(fail(format!("{rows} x {columns} heights"), heights.len().to_string()));
        }
        if let Some(height) = heights.iter().find(|h| !h.is_finite()) {
            return Err(fail("finite heights".into(), height.to_string()));
        }
        let top = heights.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let mut terrain = Self { columns, rows, spacing, heights, top, slant: 1.0 };
        for cell in (0..rows - 1).flat_map(|row| (0..columns - 1).map(move |column| (row, column))) {
            for upper in [true, false] {
                let [x, y] = terrain.slopes(cell, upper);
                terrain.slant = terrain.slant.max((1.0 + x * x + y * y).sqrt());
            }
        }
        Ok(terrain)
    }

    /// Heights by a function of x and y (m) over a square of `size` metres.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn from_fn(size: f64, spacing: f64, height: impl Fn(f64, f64) -> f64) -> Result<Self, SimError> {
        let n = ((size / spacing).round() as usize).saturating_add(1);
        if !(2..=MAX_SIDE).contains(&n) {
            return Err(SimError::Terrain {
                expected: format!("from 2 to {MAX_SIDE} heights a side"),
                got: n.to_string(),
            });
        }
        let at = |i: usize| (i as f64 - 0.5 * (n - 1) as f64) * spacing;
        let heights = (0..n * n).map(|i| height(at(i % n), at(i / n))).collect();
        Self::new(n, n, spacing, heights)
    }

    /// Gentle hills: a sum of waves of random direction with wavelengths from `wavelength` down to a quarter of it (m),
    /// between 0 and `amplitude` (m) high.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn hills(size: f64, spacing: f64, amplitude: f64, wavelength: f64, seed: u64) -> Result<Self, SimError> {
        const WAVES: usize = 12;
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(seed);
        let waves: Vec<[f64; 3]> = (0..WAVES)
            .map(|i| {
                let number = std::f64::consts::TAU / wavelength * 4.0_f64.powf(i as f64 / (WAVES - 1) as f64);
                let (angle, phase) = (rng.random_range(0.0..std::f64::consts::TAU), rng.random_range(0.0..6.3));
                [number * f64::cos(angle), number * f64::sin(angle), phase]
            })
            .collect();
        // Shorter waves are lower: all have the same slope.
        let raw = |x: f64, y: f64| {
            let wave = |w: &[f64; 3]| (w[0] * x + w[1] * y + w[2]).sin() / w[0].hypot(w[1]);
            waves.iter().map(wave).sum::<f64>()
        };
        let plain = Self::from_fn(size, spacing, raw)?;
        let low = plain.heights.iter().copied().fold(f64::INFINITY, f64::min);
        let scale = amplitude / (plain.top - low).max(1e-12);
        let heights = plain.heights.iter().map(|h| (h - low) * scale).collect();
        Self::new(plain.rows, plain.columns, spacing, heights)
    }

    /// Rows of heights (along y).
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Columns of heights (along x).
    pub fn columns(&self) -> usize {
        self.columns
    }

    /// Distance between neighbours (m).
    pub fn spacing(&self) -> f64 {
        self.spacing
    }

    /// Heights, `[rows, columns]` (m).
    pub fn heights(&self) -> &[f64] {
        &self.heights
    }

    /// The greatest height (m).
    pub fn top(&self) -> f64 {
        self.top
    }

    /// The largest ratio of a height above the surface to the distance from it: one over the cosine of the steepest slope.
    pub fn slant(&self) -> f64 {
        self.slant
    }

    /// Slopes along x and y of one of the two triangles of a cell.
    fn slopes(&self, (row, column): (usize, usize), upper: bool) -> [f64; 2] {
        let at = |r: usize, c: usize| self.heights[(row + r) * self.columns + column + c];
        let (low, high) = (at(0, 0), at(1, 1));
        let (x, y) = if upper { (high - at(1, 0), at(1, 0) - low) } else { (at(0, 1) - low, high - at(0, 1)) };
        [x / self.spacing, y / self.spacing]
    }

    /// Returns the greatest height within a distance of a point (m): where a robot can be put down.
    pub fn highest(&self, x: f64, y: f64, distance: f64) -> f64 {
        let range = |x: f64, n: usize| {
            let place = |x: f64| (x / self.spacing + 0.5 * (n - 1) as f64).clamp(0.0, (n - 1) as f64);
            place(x - distance).floor() as usize..=place(x + distance).ceil() as usize
        };
        range(y, self.rows)
            .flat_map(|row| range(x, self.columns).map(move |column| row * self.columns + column))
            .map(|i| self.heights[i])
            .fold(f64::NEG_INFINITY, f64::max)
    }

    /// Returns the surface's height at a point (m); `None` outside of the grid.
    pub fn height(&self, x: f64, y: f64) -> Option<f64> {
        let (below, normal) = self.clearance([x, y, 0.0]);
        (below != NO_GROUND).then(|| -below / normal[2])
    }

    /// Returns the distance of a point above the plane of the triangle below it (m), and that plane's normal. Outside of the grid there
    /// is nothing: a kilometre of it.
    pub fn clearance(&self, point: [f64; 3]) -> (f64, [f64; 3]) {
        let place = |x: f64, n: usize| x / self.spacing + 0.5 * (n - 1) as f64;
        let (x, y) = (place(point[0], self.columns), place(point[1], self.rows));
        let inside = |x: f64, n: usize| x >= 0.0 && x <= (n - 1) as f64;
        if !inside(x, self.columns) || !inside(y, self.rows) {
            return (NO_GROUND, [0.0, 0.0, 1.0]);
        }
        let (column, row) = ((x as usize).min(self.columns - 2), (y as usize).min(self.rows - 2));
        let (x, y) = (x - column as f64, y - row as f64);
        let [sx, sy] = self.slopes((row, column), y >= x);
        let upright = 1.0 / (1.0 + sx * sx + sy * sy).sqrt();
        let height = self.heights[row * self.columns + column] + (sx * x + sy * y) * self.spacing;
        ((point[2] - height) * upright, [-sx * upright, -sy * upright, upright])
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn a_slope_is_flat_everywhere() {
        let terrain = Terrain::from_fn(4.0, 0.1, |x, y| 0.3 * x - 0.2 * y + 1.0).unwrap();
        let length = (1.0_f64 + 0.09 + 0.04).sqrt();
        for (x, y) in [(0.0, 0.0), (0.51, -0.77), (-1.99, 1.99), (2.0, 2.0), (-2.0, -2.0)] {
            let (above, normal) = terrain.clearance([x, y, 0.3 * x - 0.2 * y + 1.5]);
            assert!((above - 0.5 / length).abs() < 1e-12, "{x} {y}: {above}");
            let expected = [-0.3 / length, 0.2 / length, 1.0 / length];
            assert!(normal.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12), "{normal:?}");
        }
        assert!((terrain.slant() - length).abs() < 1e-12);
        assert_eq!(terrain.clearance([2.01, 0.0, 0.0]).0, NO_GROUND);
        assert_eq!(terrain.clearance([f64::NAN, 0.0, 0.0]).0, NO_GROUND);
    }

    #[test]
    fn surfaces_have_no_gaps_between_triangles() {
        let terrain = Terrain::hills(6.0, 0.25, 0.4, 2.0, 3).unwrap();
        let height = |x: f64, y: f64| {
            let (above, normal) = terrain.clearance([x, y, 10.0]);
            let height = 10.0 - above / normal[2];
            assert!((terrain.height(x, y).unwrap() - height).abs() < 1e-12);
            height
        };
        assert_eq!(terrain.height(3.01, 0.0), None);
        let low = terrain.heights().iter().copied().fold(f64::INFINITY, f64::min);
        assert!(low.abs() < 1e-12 && (terrain.top() - 0.4).abs() < 1e-12);
        for i in 0..5000 {
            let (x, y) =
                (5.9 * ((f64::from(i) * 0.618_034) % 1.0 - 0.5), 5.9 * ((f64::from(i) * 0.414_214) % 1.0 - 0.5));
            let here = height(x, y);
            assert!((-1e-9..0.4 + 1e-9).contains(&here));
            assert!((height(x + 1e-6, y) - here).abs() < 1e-5 && (height(x, y + 1e-6) - here).abs() < 1e-5, "{x} {y}");
            assert!(here <= terrain.highest(x, y, 0.1) + 1e-12);
        }
    }

    #[test]
    fn what_cannot_be_ground_is_refused() {
        for (terrain, words) in [
            (Terrain::new(1, 5, 0.1, vec![0.0; 5]), "rows and columns"),
            (Terrain::new(2, 2, 0.1, vec![0.0; 5]), "2 x 2 heights, got 5"),
            (Terrain::new(2, 2, 0.0, vec![0.0; 4]), "spacing"),
            (Terrain::new(2, 2, 0.1, vec![0.0, 1.0, f64::NAN, 0.0]), "finite heights, got NaN"),
            (Terrain::from_fn(1e9, 0.1, |_, _| 0.0), "heights a side"),
        ] {
            let error = terrain.unwrap_err().to_string();
            assert!(error.contains(words), "{error}");
        }
    }
}
