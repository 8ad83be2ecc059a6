//! The beginning of an episode, on whatever ground.

use lifelike_sim::EnvironmentParameters;

/// The beginning of an episode. Values that are `None` are drawn as the plan says.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Start {
    /// Frame of the library.
    pub frame: usize,
    /// Place of the root on the ground (m, world).
    pub position: Option<[f64; 2]>,
    /// Differences from the model.
    pub parameters: Option<EnvironmentParameters>,
}

impl Start {
    /// Returns the beginning at a frame; the rest is drawn.
    pub fn at(frame: usize) -> Self {
        Self { frame, ..Self::default() }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use std::sync::Arc;

    use super::*;
    use crate::{Environment, TrackerPlan};
    use lifelike_robot::ReferenceLibrary;
    use lifelike_sim::testing::{Followers, robot};
    use lifelike_sim::{Ground, Terrain};

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
        e.reset(&[0], Some(&[Start { position: Some([2.0, -1.0]), ..Start::default() }])).unwrap();
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
