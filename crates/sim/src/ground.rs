//! The ground under episodes: heights are measured from it, and episodes begin on it.
//!
//! References are clips of level ground. On uneven ground they are laid on what lies below their root: height by height,
//! without bending a leg, since a policy that knows nothing of the ground must make the adjustments itself.

use std::sync::Arc;

use lifelike_robot::Robot;
use rand::Rng;

use crate::{Simulation, Terrain};

/// Feet begin within this share of the root's standing height of the root, seen from above.
const REACH: f64 = 0.75;

/// Level ground at height 0, or a terrain.
#[derive(Debug, Clone)]
pub struct Ground {
    terrain: Option<Arc<Terrain>>,
    reach: f64,
}

impl Ground {
    /// The ground of a simulation.
    pub fn of(simulation: &dyn Simulation, robot: &Robot) -> Self {
        let root = robot.character.root_joint().map_or(0.0, |joint| robot.default_position()[joint.q_index + 2]);
        Self { terrain: simulation.terrain().cloned(), reach: REACH * root.abs() }
    }

    /// Height of the ground at a place (m); 0 beside the terrain, where there is none to measure from.
    pub fn height(&self, x: f64, y: f64) -> f64 {
        self.terrain.as_ref().and_then(|terrain| terrain.height(x, y)).unwrap_or(0.0)
    }

    /// Returns the height, beyond that on level ground, at which a robot must begin for its soles to be above the
    /// ground (m).
    pub fn lift(&self, [x, y]: [f64; 2]) -> f64 {
        self.terrain.as_ref().map_or(0.0, |terrain| terrain.highest(x, y, self.reach))
    }

    /// Somewhere in the inner half of the terrain (m), so that an episode does not walk off it. On level ground the
    /// origin, without drawing a number.
    pub fn spot(&self, rng: &mut impl Rng) -> [f64; 2] {
        let Some(terrain) = &self.terrain else { return [0.0; 2] };
        let mut along = |cells: usize| 0.25 * (cells - 1) as f64 * terrain.spacing() * rng.random_range(-1.0..=1.0);
        [along(terrain.columns()), along(terrain.rows())]
    }
}
