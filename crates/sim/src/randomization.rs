//! Domain randomisation of thesis 4.2.2: masses, ground friction, joint calibration, pushes.

use lifelike_character::Role;
use lifelike_robot::Robot;
use rand::Rng;

use crate::batch::{EnvironmentParameters, Simulation};
use crate::error::SimError;

/// How much differs between environments. The default is the thesis' for the humanoid, without pushes.
///
/// As text, what is not said does not differ: TOML has no word for `None`, so only this default comes back from its own
/// text.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields, default = "RandomizationSpec::none")]
pub struct RandomizationSpec {
    /// ε_m of Table 4.1: each body's mass is scaled by a factor within 1 ± this.
    pub mass: f64,
    /// Least and greatest sliding friction of the ground; `None`: as the model says.
    pub ground_friction: Option<[f64; 2]>,
    /// ε_q of Table 4.1: each joint's encoder is off by at most this (rad). 0.2 for robots in the thesis, 0 for the
    /// humanoid.
    pub joint_offset: f64,
    /// Random pushes; `None`: none.
    pub pushes: Option<PushSpec>,
}

impl Default for RandomizationSpec {
    fn default() -> Self {
        Self { mass: 0.1, ground_friction: Some([0.4, 1.0]), joint_offset: 0.0, pushes: None }
    }
}

/// Random pushes "on the root, head, hands, and feet" (thesis 4.2.2; the numbers are ours).
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct PushSpec {
    /// The parts that are pushed; those that a robot lacks are left out.
    pub roles: Vec<Role>,
    /// Largest force, in units of the robot's weight.
    pub force: f64,
    /// Largest torque, in units of the robot's weight times one metre.
    pub torque: f64,
    /// Least and greatest duration of a push (s).
    pub duration: [f64; 2],
    /// Least and greatest pause between pushes (s).
    pub interval: [f64; 2],
}

impl Default for PushSpec {
    fn default() -> Self {
        use Role::{Head, LeftFoot, LeftHand, Pelvis, RightFoot, RightHand};
        Self {
            roles: vec![Pelvis, Head, LeftHand, RightHand, LeftFoot, RightFoot],
            force: 0.15,
            torque: 0.02,
            duration: [0.05, 0.2],
            interval: [1.0, 4.0],
        }
    }
}

impl RandomizationSpec {
    /// Nothing differs.
    pub fn none() -> Self {
        Self { mass: 0.0, ground_friction: None, joint_offset: 0.0, pushes: None }
    }

    /// Whether the numbers can be used.
    ///
    /// # Errors
    /// [`SimError::State`] naming the first that cannot.
    pub fn check(&self) -> Result<(), SimError> {
        let fail = |expected: &str, got: String| Err(SimError::State { expected: expected.to_string(), got });
        let ordered =
            |[low, high]: [f64; 2], least: f64| low.is_finite() && high.is_finite() && least <= low && low <= high;
        if !(0.0..1.0).contains(&self.mass) {
            return fail("randomization.mass from 0 to below 1", self.mass.to_string());
        }
        if let Some(range) = self.ground_friction.filter(|&range| !ordered(range, 1e-3)) {
            return fail("randomization.ground_friction as [least, greatest], at least 0.001", format!("{range:?}"));
        }
        if !(0.0..=1.0).contains(&self.joint_offset) {
            return fail("randomization.joint_offset from 0 to 1 rad", self.joint_offset.to_string());
        }
        let Some(pushes) = &self.pushes else { return Ok(()) };
        for (name, range) in [("duration", pushes.duration), ("interval", pushes.interval)] {
            if !ordered(range, 0.0) {
                return fail(&format!("randomization.pushes.{name} as [least, greatest] (s)"), format!("{range:?}"));
            }
        }
        for (name, value) in [("force", pushes.force), ("torque", pushes.torque)] {
            if !(value.is_finite() && value >= 0.0) {
                return fail(&format!("randomization.pushes.{name} of at least 0"), value.to_string());
            }
        }
        Ok(())
    }

    /// The parameters of one environment.
    pub fn sample(&self, robot: &Robot, rng: &mut impl Rng) -> EnvironmentParameters {
        let mut within = |limit: f64| (limit * rng.random_range(-1.0..=1.0)) as f32;
        let mass_scale = match self.mass {
            0.0 => Vec::new(),
            limit => robot.character.bodies.iter().map(|_| 1.0 + within(limit)).collect(),
        };
        let joint_offset = match self.joint_offset {
            0.0 => Vec::new(),
            limit => (0..robot.joints()).map(|_| within(limit)).collect(),
        };
        let ground_friction = self.ground_friction.map(|[low, high]| rng.random_range(low..=high) as f32);
        EnvironmentParameters { mass_scale, ground_friction, joint_offset, ..EnvironmentParameters::default() }
    }
}

/// One push.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Push {
    /// Index of the body.
    pub body: usize,
    /// Force at its centre of mass (N, world).
    pub force_w: [f32; 3],
    /// Torque (N m, world).
    pub torque_w: [f32; 3],
}

/// When one environment is pushed next, and how. It is part of what a checkpoint holds.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PushSchedule {
    /// Policy steps until the push begins, or, while it lasts, until it ends.
    pub steps: u32,
    /// The push that lasts now.
    pub active: Option<Push>,
}

impl PushSchedule {
    /// A schedule whose first push comes after a pause.
    pub fn new(spec: &PushSpec, control_hz: f64, rng: &mut impl Rng) -> Self {
        Self { steps: steps(spec.interval, control_hz, rng), active: None }
    }

    /// One policy step, to be called before the simulation's. Sets or ends the push of environment `id`. `rng` is drawn
    /// from only when a push begins or ends, so it must be keyed by the step.
    ///
    /// # Errors
    /// What [`Simulation::push`] fails with.
    pub fn advance(
        &mut self,
        spec: &PushSpec,
        simulation: &mut dyn Simulation,
        id: usize,
        rng: &mut impl Rng,
    ) -> Result<(), SimError> {
        if self.steps > 0 {
            self.steps -= 1;
            return Ok(());
        }
        let control_hz = simulation.robot().control_hz;
        if self.active.take().is_some() {
            simulation.clear_pushes(id);
            self.steps = steps(spec.interval, control_hz, rng);
            return Ok(());
        }
        self.steps = steps(spec.duration, control_hz, rng);
        if let Some(push) = draw(spec, simulation.robot(), rng) {
            simulation.push(id, push.body, push.force_w, push.torque_w)?;
            self.active = Some(push);
        }
        Ok(())
    }
}

fn steps([low, high]: [f64; 2], control_hz: f64, rng: &mut impl Rng) -> u32 {
    // Of the steps that `advance` counts, the one that acts is the last.
    (rng.random_range(low..=high) * control_hz).round().max(1.0) as u32 - 1
}

/// A push on one of the parts, in any direction, of any strength up to the largest.
fn draw(spec: &PushSpec, robot: &Robot, rng: &mut impl Rng) -> Option<Push> {
    let bodies: Vec<usize> =
        spec.roles.iter().filter_map(|role| robot.anatomy.places.get(role)).map(|place| place.body).collect();
    if bodies.is_empty() {
        return None;
    }
    let weight = robot.character.mass() * robot.character.gravity.norm();
    let body = bodies[rng.random_range(0..bodies.len())];
    let mut vector = |largest: f64| {
        let direction =
            nalgebra::Vector3::from(rand_distr::Distribution::<[f64; 3]>::sample(&rand_distr::UnitSphere, rng));
        let vector = direction * (largest * weight * rng.random_range(0.0..=1.0));
        [vector.x as f32, vector.y as f32, vector.z as f32]
    };
    Some(Push { body, force_w: vector(spec.force), torque_w: vector(spec.torque) })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::expect_used)]
    use super::*;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    #[test]
    fn samples_fill_the_ranges_and_stay_inside() {
        let robot = Robot::load("lima").unwrap();
        let spec = RandomizationSpec { joint_offset: 0.2, ..RandomizationSpec::default() };
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        let samples: Vec<_> = (0..200).map(|_| spec.sample(&robot, &mut rng)).collect();
        let range =
            |values: Vec<f32>| values.iter().fold((f32::MAX, f32::MIN), |(low, high), &v| (low.min(v), high.max(v)));
        let (low, high) = range(samples.iter().flat_map(|s| s.mass_scale.clone()).collect());
        assert!((0.9..0.91).contains(&low) && (1.09..=1.1).contains(&high), "mass {low} {high}");
        let (low, high) = range(samples.iter().flat_map(|s| s.joint_offset.clone()).collect());
        assert!((-0.2..-0.19).contains(&low) && (0.19..=0.2).contains(&high), "offset {low} {high}");
        let (low, high) = range(samples.iter().filter_map(|s| s.ground_friction).collect());
        assert!((0.4..0.42).contains(&low) && (0.98..=1.0).contains(&high), "friction {low} {high}");
        assert_eq!(RandomizationSpec::none().sample(&robot, &mut rng), EnvironmentParameters::default());
    }

    #[test]
    fn the_same_stream_gives_the_same_push() {
        let robot = Robot::load("lima").unwrap();
        let push = |seed| draw(&PushSpec::default(), &robot, &mut ChaCha8Rng::seed_from_u64(seed));
        assert_eq!(push(1), push(1));
        assert_ne!(push(1), push(2));
        let weight = robot.character.mass() * 9.81;
        for seed in 0..50 {
            let push = push(seed).unwrap();
            let force = nalgebra::Vector3::from(push.force_w).norm();
            assert!(f64::from(force) <= 0.15 * weight * 1.0001, "{force}");
            assert!(push.body > 0);
        }
    }

    #[test]
    fn bad_ranges_are_named() {
        let bad = RandomizationSpec { ground_friction: Some([1.0, 0.5]), ..RandomizationSpec::default() };
        assert!(bad.check().unwrap_err().to_string().contains("ground_friction"));
        let bad = RandomizationSpec { mass: 1.0, ..RandomizationSpec::default() };
        assert!(bad.check().unwrap_err().to_string().contains("mass"));
        let pushes = Some(PushSpec { duration: [f64::NAN, 1.0], ..PushSpec::default() });
        let bad = RandomizationSpec { pushes, ..RandomizationSpec::default() };
        assert!(bad.check().unwrap_err().to_string().contains("duration"));
        RandomizationSpec::default().check().unwrap();
    }
}
