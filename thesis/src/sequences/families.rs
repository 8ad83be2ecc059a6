//! The families of curves of thesis 3.3.1: a few parameters each, which determine the curve.
//!
//! The thesis names the families and their number of parameters, which is the latent dimension. It draws parameters "in
//! a pre-determined domain" that it does not state. The domains here are ours, so numbers are comparable in kind with
//! Table 3.1, not in data. Every curve is within about [-1.25, 1.25]², and parameters are drawn uniformly and
//! independently. The curve is a continuous function of them without a seam: an angle over the full circle would need
//! two latent numbers.

use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::fmt;
use std::str::FromStr;

use rand::Rng;

use super::SequencesError;
use lifelike_train::limits::wrong;

/// A family of plane curves.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Family {
    /// x = sin(a t + δ), y = sin(b t) for t from 0 to 2π. Frequencies need not be whole, so most curves are open.
    Lissajous,
    /// A point at distance p of the centre of a circle of radius r that rolls inside of one of radius R. It begins at
    /// the rolling circle's angle φ, once around: x = (R − r) cos θ + p cos α, y = (R − r) sin θ − p sin α with α = (R
    /// − r)/r (θ − φ) − φ for θ from φ to φ + 2π: the curve of φ = 0, turned by φ.
    Hypotrochoids,
    /// A quadratic Bézier curve from (−1, 0) to (1, 0): its middle control point is free.
    #[serde(rename = "bezier-2")]
    Bezier2,
    /// A Bézier curve of degree 31: all of its 32 control points are free.
    #[serde(rename = "bezier-64")]
    Bezier64,
}

impl Family {
    /// In Table 3.1's order.
    pub const ALL: [Self; 4] = [Self::Lissajous, Self::Hypotrochoids, Self::Bezier2, Self::Bezier64];

    /// Returns its name on the command line and in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Lissajous => "lissajous",
            Self::Hypotrochoids => "hypotrochoids",
            Self::Bezier2 => "bezier-2",
            Self::Bezier64 => "bezier-64",
        }
    }

    /// Returns its name in Table 3.1.
    pub fn title(self) -> &'static str {
        match self {
            Self::Lissajous => "Lissajous (3D)",
            Self::Hypotrochoids => "Hypotrochoids (4D)",
            Self::Bezier2 => "Bézier (2D)",
            Self::Bezier64 => "Bézier (64D)",
        }
    }

    /// Returns the domain: name of each parameter, and the interval that it is drawn of, uniformly.
    pub fn domain(self) -> Vec<(&'static str, [f64; 2])> {
        match self {
            Self::Lissajous => vec![("a", [1.0, 4.0]), ("b", [1.0, 4.0]), ("delta", [0.0, PI])],
            Self::Hypotrochoids => {
                vec![("R", [0.6, 1.0]), ("r", [0.15, 0.4]), ("p", [0.1, 0.4]), ("phi", [0.0, FRAC_PI_2])]
            }
            Self::Bezier2 => vec![("control", [-1.0, 1.0]); 2],
            Self::Bezier64 => vec![("control", [-1.0, 1.0]); 64],
        }
    }

    /// Returns d: how many parameters a curve has.
    pub fn dimensions(self) -> usize {
        self.domain().len()
    }

    /// Parameters of one curve.
    pub fn draw(self, rng: &mut impl Rng) -> Vec<f64> {
        self.domain().into_iter().map(|(_, [low, high])| rng.random_range(low..=high)).collect()
    }

    /// Returns the point at `t`, from 0 at the beginning to 1 at the end.
    ///
    /// # Errors
    /// Another number of parameters.
    pub fn point(self, parameters: &[f64], t: f64) -> Result<[f64; 2], SequencesError> {
        match (self, parameters) {
            (Self::Lissajous, &[a, b, delta]) => Ok([(a * TAU * t + delta).sin(), (b * TAU * t).sin()]),
            (Self::Hypotrochoids, &[outer, inner, pen, phi]) => {
                let arm = outer - inner;
                let (theta, alpha) = (TAU * t + phi, arm / inner * TAU * t - phi);
                Ok([arm * theta.cos() + pen * alpha.cos(), arm * theta.sin() - pen * alpha.sin()])
            }
            (Self::Bezier2, &[x, y]) => Ok(bezier(&[-1.0, 0.0, x, y, 1.0, 0.0], t)),
            (Self::Bezier64, all) if all.len() == 64 => Ok(bezier(all, t)),
            (_, other) => Err(wrong(
                &format!("parameters of {}", self.name()),
                &format!("{} numbers", self.dimensions()),
                other.len(),
            )
            .into()),
        }
    }

    /// Returns `samples` points, evenly in the parameter from the first to the last: (x, y) one after another.
    ///
    /// # Errors
    /// Another number of parameters.
    pub fn curve(self, parameters: &[f64], samples: usize) -> Result<Vec<f32>, SequencesError> {
        let last = samples.saturating_sub(1).max(1) as f64;
        let mut numbers = Vec::with_capacity(2 * samples);
        for i in 0..samples {
            numbers.extend(self.point(parameters, i as f64 / last)?.map(|x| x as f32));
        }
        Ok(numbers)
    }
}

/// Returns the Bézier curve of control points (x, y), by Bernstein's polynomials: C(n, i) tⁱ (1 − t)ⁿ⁻ⁱ.
fn bezier(control: &[f64], t: f64) -> [f64; 2] {
    let n = control.len() / 2 - 1;
    let (mut binomial, mut point) = (1.0, [0.0; 2]);
    for i in 0..=n {
        let weight = binomial * t.powi(i as i32) * (1.0 - t).powi((n - i) as i32);
        point[0] += weight * control[2 * i];
        point[1] += weight * control[2 * i + 1];
        binomial *= (n - i) as f64 / (i + 1) as f64;
    }
    point
}

impl fmt::Display for Family {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Family {
    type Err = SequencesError;

    fn from_str(text: &str) -> Result<Self, SequencesError> {
        let names = Self::ALL.map(Self::name).join(", ");
        let found = Self::ALL.into_iter().find(|family| family.name() == text);
        Ok(found.ok_or_else(|| wrong("family", &format!("one of {names}"), format!("'{text}'")))?)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    /// A float64 expression of a few operations.
    const ROUNDING: f64 = 1e-12;

    #[track_caller]
    fn at(family: Family, parameters: &[f64], t: f64, expected: [f64; 2]) {
        let got = family.point(parameters, t).unwrap();
        assert!((0..2).all(|i| (got[i] - expected[i]).abs() < ROUNDING), "{family} at {t}: {got:?}, not {expected:?}");
    }

    #[test]
    fn lissajous_by_hand() {
        // a : b = 1 : 2 and a quarter of a turn ahead.
        at(Family::Lissajous, &[1.0, 2.0, FRAC_PI_2], 0.0, [1.0, 0.0]);
        at(Family::Lissajous, &[1.0, 2.0, FRAC_PI_2], 0.125, [0.5_f64.sqrt(), 1.0]);
        at(Family::Lissajous, &[1.0, 2.0, FRAC_PI_2], 0.5, [-1.0, 0.0]);
        // A circle.
        at(Family::Lissajous, &[1.0, 1.0, FRAC_PI_2], 1.0 / 12.0, [0.75_f64.sqrt(), 0.5]);
    }

    #[test]
    fn hypotrochoids_by_hand() {
        // R = 2 r gives an ellipse of half axes r + p and r − p.
        let ellipse = [0.8, 0.4, 0.1, 0.0];
        at(Family::Hypotrochoids, &ellipse, 0.0, [0.5, 0.0]);
        at(Family::Hypotrochoids, &ellipse, 0.25, [0.0, 0.3]);
        at(Family::Hypotrochoids, &ellipse, 0.5, [-0.5, 0.0]);
        // R = 4 r and p = r: the astroid R (cos³, sin³).
        let eighth = 0.5_f64.powf(1.5);
        at(Family::Hypotrochoids, &[1.0, 0.25, 0.25, 0.0], 0.125, [eighth, eighth]);
        // φ turns the whole curve.
        at(Family::Hypotrochoids, &[0.8, 0.4, 0.1, FRAC_PI_2], 0.0, [0.0, 0.5]);
        at(Family::Hypotrochoids, &[0.8, 0.4, 0.1, FRAC_PI_2], 0.25, [-0.3, 0.0]);
    }

    #[test]
    fn bezier_curves_by_hand() {
        // (1 − t)² a + 2 t (1 − t) b + t² c.
        at(Family::Bezier2, &[0.4, 0.8], 0.0, [-1.0, 0.0]);
        at(Family::Bezier2, &[0.4, 0.8], 0.5, [0.2, 0.4]);
        at(Family::Bezier2, &[0.4, 0.8], 0.25, [-0.5625 + 0.15 + 0.0625, 0.3]);
        // Degree 31: ends are control points; points on a line, evenly, give that line.
        let line: Vec<f64> = (0..32).flat_map(|i| [f64::from(i) / 31.0, 1.0 - f64::from(i) / 15.5]).collect();
        at(Family::Bezier64, &line, 0.3, [0.3, 0.4]);
        let mut one = vec![0.0; 64];
        one[2] = 1.0;
        at(Family::Bezier64, &one, 0.5, [31.0 / 2.0_f64.powi(31), 0.0]);
        one[62] = -0.5;
        at(Family::Bezier64, &one, 1.0, [-0.5, 0.0]);
    }

    #[test]
    fn curves_of_the_domains_stay_near_the_unit_square_and_use_it() {
        for family in Family::ALL {
            let mut rng = lifelike_checkpoint::rng::stream(1, "test", 0, 0);
            let mut largest = 0.0_f32;
            for _ in 0..500 {
                let curve = family.curve(&family.draw(&mut rng), 64).unwrap();
                assert_eq!(curve.len(), 128);
                largest = curve.iter().fold(largest, |m, x| m.max(x.abs()));
            }
            assert!((0.9..=1.25).contains(&largest), "{family}: {largest}");
        }
    }

    #[test]
    fn latent_dimensions_are_those_of_the_table_and_names_are_read_back() {
        assert_eq!(Family::ALL.map(Family::dimensions), [3, 4, 2, 64]);
        for family in Family::ALL {
            assert_eq!(family.name().parse::<Family>().unwrap(), family);
            assert_eq!(serde_json::to_value(family).unwrap(), family.name());
        }
        let error = "spirals".parse::<Family>().unwrap_err().to_string();
        assert!(error.contains("hypotrochoids") && error.contains("'spirals'"), "{error}");
        let error = Family::Lissajous.point(&[1.0], 0.0).unwrap_err().to_string();
        assert!(error.contains("3 numbers, got 1"), "{error}");
    }
}
