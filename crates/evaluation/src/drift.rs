//! Position and heading of the root against the reference.

use lifelike_character::rotation::heading_angle;

use super::rollout::{Rollout, Snapshot};

/// Drift over an episode.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Drift {
    /// Mean distance of the roots on the ground (m).
    pub position_mean: f64,
    /// The same at the last frame that counts (m).
    pub position_end: f64,
    /// Mean absolute difference of headings (deg).
    pub heading_mean: f64,
    /// The same at the last frame that counts (deg).
    pub heading_end: f64,
}

/// The drift of a rollout; NaN where no frame counts.
pub fn drift(rollout: &Rollout) -> Drift {
    let positions: Vec<f64> = rollout.pairs().map(|(r, s)| on_the_ground(r, s)).collect();
    let headings: Vec<f64> = rollout.pairs().map(|(r, s)| heading_difference(r, s).to_degrees()).collect();
    Drift {
        position_mean: super::accuracy::mean(positions.iter().copied()),
        position_end: positions.last().copied().unwrap_or(f64::NAN),
        heading_mean: super::accuracy::mean(headings.iter().copied()),
        heading_end: headings.last().copied().unwrap_or(f64::NAN),
    }
}

fn on_the_ground(reference: &Snapshot, simulated: &Snapshot) -> f64 {
    (reference.root_position - simulated.root_position).xy().norm()
}

/// Absolute difference of headings (rad), the short way round.
fn heading_difference(reference: &Snapshot, simulated: &Snapshot) -> f64 {
    let d = heading_angle(&simulated.root_orientation) - heading_angle(&reference.root_orientation);
    (d - std::f64::consts::TAU * (d / std::f64::consts::TAU).round()).abs()
}

#[cfg(test)]
mod tests {
    use lifelike_character::Vec3;

    use super::super::rollout::example::{rollout, snapshot};
    use super::*;

    #[test]
    fn by_hand() {
        // Physics stays while the reference walks 1 m/s ahead: 0.1, 0.2, 0.3 m.
        // Headings 3.1 and -3.1 rad: 2 pi - 6.2 apart, the short way.
        let r = rollout(
            4,
            |t| snapshot(Vec3::new(t, 0.0, 1.0), 3.1, 0.0),
            |_| snapshot(Vec3::new(0.0, 0.0, 0.5), -3.1, 0.0),
        );
        let d = drift(&r);
        assert!((d.position_mean - 0.2).abs() < 1e-12 && (d.position_end - 0.3).abs() < 1e-12, "{d:?}");
        let expected = (std::f64::consts::TAU - 6.2).to_degrees();
        assert!((d.heading_mean - expected).abs() < 1e-9 && (d.heading_end - expected).abs() < 1e-9, "{d:?}");
    }
}
