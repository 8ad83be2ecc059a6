//! The ground under the episodes: heights are measured from it, and episodes begin on it.
//!
//! References are clips of level ground. On uneven ground they are laid on what lies below their root: height by height,
//! without bending a leg, since a policy that knows nothing of the ground must make the adjustments itself.

use std::sync::Arc;

use lifelike_robot::Robot;
use lifelike_sim::{EnvironmentParameters, Simulation, Terrain};
use rand::Rng;

/// Feet begin within this share of the root's standing height of the root, seen from above.
const REACH: f64 = 0.75;

/// How an episode begins. What is `None` is drawn as the plan says.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Start {
    /// Frame of the library.
    pub frame: usize,
    /// Where the root stands (m, world).
    pub spot: Option<[f64; 2]>,
    /// What differs from the model.
    pub parameters: Option<EnvironmentParameters>,
}

impl Start {
    /// At a frame; the rest is drawn.
    pub fn at(frame: usize) -> Self {
        Self { frame, ..Self::default() }
    }
}

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

    /// How much higher than on level ground a robot must begin for its soles to be above the ground (m).
    pub fn lift(&self, [x, y]: [f64; 2]) -> f64 {
        self.terrain.as_ref().map_or(0.0, |terrain| terrain.highest(x, y, self.reach))
    }

    /// Somewhere in the inner half of the terrain (m), so that an episode does not walk off it; on level ground the origin,
    /// without drawing a number.
    pub fn spot(&self, rng: &mut impl Rng) -> [f64; 2] {
        let Some(terrain) = &self.terrain else { return [0.0; 2] };
        let mut along = |cells: usize| 0.25 * (cells - 1) as f64 * terrain.spacing() * rng.random_range(-1.0..=1.0);
        [along(terrain.columns()), along(terrain.rows())]
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::{Environment, TrackerPlan};
    use lifelike_robot::ReferenceLibrary;
    use lifelike_sim::testing::{Followers, robot};

    fn on_a_slope(n: usize) -> Environment {
        let mut simulation = Followers::new(n);
        simulation.terrain = Some(Arc::new(Terrain::from_fn(20.0, 0.1, |x, _| 0.1 * x + 3.0).unwrap()));
        let mut plan = TrackerPlan::new("post", &[]);
        plan.ppo.environments = n;
        let library = Arc::new(ReferenceLibrary::standing(&robot(), 1.0).unwrap());
        Environment::new(&plan, robot(), library, Box::new(simulation)).unwrap()
    }

    #[test]
    fn a_given_start_stands_above_the_ground_and_its_height_is_measured_from_there() {
        let mut e = on_a_slope(1);
        e.reset(&[0], Some(&[Start { spot: Some([2.0, -1.0]), ..Start::default() }])).unwrap();
        let root = &e.state().root_position;
        // The root stands at 0.5 m; the highest ground within 0.375 m of x = 2 is that of x = 2.4, on the grid.
        assert!((f64::from(root[2]) - (3.24 + 0.5 + 0.002)).abs() < 1e-4, "{root:?}");
        assert_eq!(root[..2], [2.0, -1.0]);
        let height = e.critic_rows()[e.actor_size()];
        assert!((f64::from(height) - (3.742 - 3.2)).abs() < 1e-4, "{height} above the ground below");
        assert!((e.episodes()[0].alignment.to[0] - 2.0).abs() < 0.3, "and the clip lies there too");
    }

    #[test]
    fn drawn_starts_are_spread_over_the_inner_half() {
        let e = on_a_slope(64);
        let x: Vec<f32> = e.state().root_position.chunks(3).map(|p| p[0]).collect();
        assert!(x.iter().all(|x| x.abs() <= 5.0) && x.iter().any(|x| *x < -2.0) && x.iter().any(|x| *x > 2.0), "{x:?}");
    }

    #[test]
    fn level_ground_draws_nothing() {
        let ground = Ground::of(&Followers::new(1), &robot());
        let mut rng = lifelike_checkpoint::rng::stream(1, "test", 0, 0);
        assert_eq!((ground.spot(&mut rng), ground.lift([1.0, 2.0]), ground.height(1.0, 2.0)), ([0.0; 2], 0.0, 0.0));
        assert_eq!(rng, lifelike_checkpoint::rng::stream(1, "test", 0, 0));
    }
}
