//! Domain randomisation of thesis 4.2.2: masses, ground friction, joint calibration, pushes; and what robots of the same
//! kind differ in beyond that: centres of mass, armature, damping, gains, motor strength.

use lifelike_character::Role;
use lifelike_robot::Robot;
use rand::Rng;

use crate::batch::EnvironmentParameters;
use crate::error::SimError;
use crate::simulation::Simulation;

/// How much differs between environments. The default is the thesis' for the humanoid, without pushes.
///
/// As text, what is not said does not differ: TOML has no word for `None`, so only this default comes back from its own
/// text.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields, default = "RandomizationSpec::none")]
pub struct RandomizationSpec {
    /// ε_m of Table 4.1: each body's mass is scaled by a factor within 1 ± this.
    pub mass: f64,
    /// Each body's centre of mass is off by at most this along each axis (m).
    pub center_of_mass: f64,
    /// Least and greatest sliding friction of the ground; `None`: as the model says.
    pub ground_friction: Option<[f64; 2]>,
    /// Least and greatest sliding friction of the ground below each foot, drawn for each foot ("the local ground plane",
    /// thesis 4.2.2); `None`: that of the ground.
    pub foot_friction: Option<[f64; 2]>,
    /// Each joint's armature (rotor inertia) is scaled by a factor within 1 ± this.
    pub armature: f64,
    /// Likewise its damping.
    pub damping: f64,
    /// Likewise its actuator's gains κ_P and κ_D, each by itself.
    pub gains: f64,
    /// Likewise its motor's torque, the limit included.
    pub strength: f64,
    /// ε_q of Table 4.1: each joint's encoder is off by at most this (rad). 0.2 for robots in the thesis, 0 for the
    /// humanoid.
    pub joint_offset: f64,
    /// Random pushes; `None`: none.
    pub pushes: Option<PushSpec>,
}

impl Default for RandomizationSpec {
    fn default() -> Self {
        Self { mass: 0.1, ground_friction: Some([0.4, 1.0]), ..Self::none() }
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
        Self {
            mass: 0.0,
            center_of_mass: 0.0,
            ground_friction: None,
            foot_friction: None,
            armature: 0.0,
            damping: 0.0,
            gains: 0.0,
            strength: 0.0,
            joint_offset: 0.0,
            pushes: None,
        }
    }

    /// Whether the numbers can be used.
    ///
    /// # Errors
    /// [`SimError::State`] naming the first that cannot.
    pub fn check(&self) -> Result<(), SimError> {
        let fail = |expected: &str, got: String| Err(SimError::State { expected: expected.to_string(), got });
        let ordered =
            |[low, high]: [f64; 2], least: f64| low.is_finite() && high.is_finite() && least <= low && low <= high;
        for (name, share) in [
            ("mass", self.mass),
            ("armature", self.armature),
            ("damping", self.damping),
            ("gains", self.gains),
            ("strength", self.strength),
        ] {
            if !(0.0..1.0).contains(&share) {
                return fail(&format!("randomization.{name} from 0 to below 1"), share.to_string());
            }
        }
        for (name, range) in [("ground_friction", self.ground_friction), ("foot_friction", self.foot_friction)] {
            if let Some(range) = range.filter(|&range| !ordered(range, 1e-3)) {
                let expected = format!("randomization.{name} as [least, greatest], at least 0.001");
                return fail(&expected, format!("{range:?}"));
            }
        }
        if !(0.0..=0.2).contains(&self.center_of_mass) {
            return fail("randomization.center_of_mass from 0 to 0.2 m", self.center_of_mass.to_string());
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

    /// The same with every deviation from the model shrunk to this share of it (0: none, 1: all): frictions towards that
    /// of the model, which is taken to be the greatest of their range.
    #[must_use]
    pub fn scaled(&self, share: f64) -> Self {
        let towards = |range: Option<[f64; 2]>| range.map(|[low, high]| [high + share * (low - high), high]);
        let pushes = self.pushes.clone().filter(|_| share > 0.0);
        Self {
            mass: share * self.mass,
            center_of_mass: share * self.center_of_mass,
            ground_friction: towards(self.ground_friction).filter(|_| share > 0.0),
            foot_friction: towards(self.foot_friction).filter(|_| share > 0.0),
            armature: share * self.armature,
            damping: share * self.damping,
            gains: share * self.gains,
            strength: share * self.strength,
            joint_offset: share * self.joint_offset,
            pushes: pushes.map(|p| PushSpec { force: share * p.force, torque: share * p.torque, ..p }),
        }
    }

    /// The parameters of one environment.
    pub fn sample(&self, robot: &Robot, rng: &mut impl Rng) -> EnvironmentParameters {
        let (bodies, joints, feet) = (robot.character.bodies.len(), robot.joints(), robot.anatomy.soles.len());
        let mass_scale = around(1.0, self.mass, bodies, rng);
        let joint_offset = around(0.0, self.joint_offset, joints, rng);
        let between = |[low, high]: [f64; 2], rng: &mut dyn rand::RngCore| rng.random_range(low..=high) as f32;
        let ground_friction = self.ground_friction.map(|range| between(range, rng));
        // What was there before these were added keeps its place in the stream, and so old plans their numbers.
        let offsets = around(0.0, self.center_of_mass, 3 * bodies, rng);
        EnvironmentParameters {
            mass_scale,
            joint_offset,
            ground_friction,
            com_offset: offsets.chunks_exact(3).map(|o| [o[0], o[1], o[2]]).collect(),
            foot_friction: self
                .foot_friction
                .map_or_else(Vec::new, |range| (0..feet).map(|_| between(range, rng)).collect()),
            armature_scale: around(1.0, self.armature, joints, rng),
            damping_scale: around(1.0, self.damping, joints, rng),
            kp_scale: around(1.0, self.gains, joints, rng),
            kd_scale: around(1.0, self.gains, joints, rng),
            strength_scale: around(1.0, self.strength, joints, rng),
            ..EnvironmentParameters::default()
        }
    }
}

/// `n` numbers within a distance of a middle; none at all for no distance.
fn around(middle: f64, limit: f64, n: usize, rng: &mut impl Rng) -> Vec<f32> {
    let n = if limit > 0.0 { n } else { 0 };
    (0..n).map(|_| (middle + limit * rng.random_range(-1.0..=1.0)) as f32).collect()
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
        let spec = RandomizationSpec {
            joint_offset: 0.2,
            center_of_mass: 0.01,
            foot_friction: Some([0.2, 0.9]),
            strength: 0.3,
            gains: 0.1,
            ..RandomizationSpec::default()
        };
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
        let (low, high) = range(samples.iter().flat_map(|s| s.foot_friction.clone()).collect());
        assert!((0.2..0.21).contains(&low) && (0.89..=0.9).contains(&high), "foot friction {low} {high}");
        assert!(samples.iter().all(|s| s.foot_friction.len() == 2 && s.armature_scale.is_empty()));
        let (low, high) = range(samples.iter().flat_map(|s| s.strength_scale.clone()).collect());
        assert!((0.7..0.705).contains(&low) && (1.295..=1.3).contains(&high), "strength {low} {high}");
        let (low, high) = range(samples.iter().flat_map(|s| s.com_offset.concat()).collect());
        assert!((-0.01..-0.0099).contains(&low) && (0.0099..=0.01).contains(&high), "centre of mass {low} {high}");
        assert!(samples.iter().all(|s| s.kp_scale != s.kd_scale));
        assert_eq!(RandomizationSpec::none().sample(&robot, &mut rng), EnvironmentParameters::default());
    }

    #[test]
    fn a_share_of_the_randomisation_is_that_share_of_every_deviation() {
        let pushes = Some(PushSpec::default());
        let whole = RandomizationSpec { strength: 0.2, pushes, ..RandomizationSpec::default() };
        assert_eq!(whole.scaled(1.0), whole);
        assert_eq!(whole.scaled(0.0), RandomizationSpec::none());
        let half = whole.scaled(0.5);
        assert_eq!((half.mass, half.strength, half.ground_friction), (0.05, 0.1, Some([0.7, 1.0])));
        half.check().unwrap();
        assert_eq!(half.pushes.map(|p| p.force), whole.pushes.map(|p| 0.5 * p.force));
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
