//! Domain randomisation of thesis 4.2.2: masses, ground friction, joint calibration, pushes; and what robots of the same
//! kind differ in beyond that: centres of mass, armature, damping, gains, motor strength.
//!
//! Each kind is declared once, as an entry of the table below: its key in plans, its range, how it is scaled and drawn, and
//! the parameters that it changes.

mod kinds;
mod pushes;

use lifelike_robot::Robot;
use rand::Rng;

use crate::batch::EnvironmentParameters;
use crate::error::SimError;
use kinds::{Deviation, FrictionRange, Kind, Pushes, bodies, joints};
pub use pushes::{Push, PushSchedule, PushSpec};

/// Declares the kinds of randomisation in the order in which they are drawn. An entry at the end leaves the draws of all
/// before it as they were, and so old plans their numbers.
macro_rules! randomizations {
    ($($(#[doc = $doc:literal])+ $name:ident: $value:ty = $kind:expr;)+) => {
        /// Differences between environments. The default is the thesis' for the humanoid, without pushes.
        ///
        /// As text, what is not said does not differ: TOML has no word for `None`, so only this default comes back from its
        /// own text.
        ///
        /// ```
        /// use lifelike_robot::Robot;
        /// use lifelike_sim::randomization::RandomizationSpec;
        /// use rand::SeedableRng;
        ///
        /// let spec = RandomizationSpec { joint_offset: 0.02, ..RandomizationSpec::default() };
        /// spec.check()?;
        /// let mut stream = rand_chacha::ChaCha8Rng::seed_from_u64(7);
        /// let parameters = spec.scaled(0.5).sample(&Robot::load("lima")?, &mut stream);
        /// assert!(parameters.mass_scale.iter().all(|x| (0.95..=1.05).contains(x)));
        /// assert!(parameters.joint_offset.iter().all(|x| x.abs() <= 0.01));
        /// # Ok::<(), Box<dyn std::error::Error>>(())
        /// ```
        #[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
        #[serde(deny_unknown_fields, default = "RandomizationSpec::none")]
        #[schemars(transform = Self::declare)]
        pub struct RandomizationSpec {
            $($(#[doc = $doc])+ pub $name: $value,)+
        }

        impl RandomizationSpec {
            /// Nothing differs.
            pub fn none() -> Self {
                Self { $($name: <$value>::default(),)+ }
            }

            /// Puts unit and range of every value into the schema of plans.
            fn declare(table: &mut schemars::Schema) {
                $(
                    let key = table.pointer_mut(concat!("/properties/", stringify!($name)));
                    if let Some(key) = key.and_then(|key| key.try_into().ok()) {
                        $kind.declare(key);
                    }
                )+
            }

            /// Refuses numbers that cannot be used.
            ///
            /// # Errors
            /// [`SimError::State`] naming the first that cannot.
            pub fn check(&self) -> Result<(), SimError> {
                $($kind.check(stringify!($name), &self.$name)?;)+
                Ok(())
            }

            /// Returns the same with every deviation from the model shrunk to this share of it (0: none, 1: all): frictions
            /// towards that of the model, which is taken to be the greatest of their range.
            #[must_use]
            pub fn scaled(&self, share: f64) -> Self {
                Self { $($name: $kind.scaled(&self.$name, share),)+ }
            }

            /// Draws the parameters of one environment.
            pub fn sample(&self, robot: &Robot, rng: &mut impl Rng) -> EnvironmentParameters {
                let mut parameters = EnvironmentParameters::default();
                $($kind.sample(&self.$name, robot, rng, &mut parameters);)+
                parameters
            }
        }
    };
}

randomizations! {
    /// ε_m of Table 4.1: each body's mass is scaled by a factor within 1 ± this.
    mass: f64 = Deviation::factor(bodies, |p, x| p.mass_scale = x);

    /// ε_q of Table 4.1: each joint's encoder is off by at most this (rad).
    ///
    /// 0.2 for robots in the thesis, 0 for the humanoid.
    joint_offset: f64 = Deviation::offset(1.0, "rad", joints, |p, x| p.joint_offset = x);

    /// Least and greatest sliding friction of the ground; the model's where not given.
    ground_friction: Option<[f64; 2]> = FrictionRange(|_| 1, |p, x| p.ground_friction = x.first().copied());

    /// Each body's centre of mass is off by at most this along each axis (m).
    center_of_mass: f64 = Deviation::offset(0.2, "m", |r| 3 * bodies(r), |p, x| {
        p.com_offset = x.chunks_exact(3).map(|o| [o[0], o[1], o[2]]).collect();
    });

    /// Least and greatest sliding friction of the ground below each foot, each drawn for itself (thesis 4.2.2).
    ///
    /// "The local ground plane"; `None`: that of the ground.
    foot_friction: Option<[f64; 2]> = FrictionRange(|r| r.anatomy.soles.len(), |p, x| p.foot_friction = x);

    /// Each joint's armature (rotor inertia) is scaled by a factor within 1 ± this.
    armature: f64 = Deviation::factor(joints, |p, x| p.armature_scale = x);

    /// Each joint's damping is scaled by a factor within 1 ± this.
    damping: f64 = Deviation::factor(joints, |p, x| p.damping_scale = x);

    /// Each actuator's gains κ_P and κ_D are scaled by factors within 1 ± this, each by itself.
    gains: f64 = Deviation::factor(|r| 2 * joints(r), |p, mut x| {
        p.kd_scale = x.split_off(x.len() / 2);
        p.kp_scale = x;
    });

    /// Each motor's torque, its limit included, is scaled by a factor within 1 ± this.
    strength: f64 = Deviation::factor(joints, |p, x| p.strength_scale = x);

    /// Random pushes.
    pushes: Option<PushSpec> = Pushes;
}

impl Default for RandomizationSpec {
    fn default() -> Self {
        Self { mass: 0.1, ground_friction: Some([0.4, 1.0]), ..Self::none() }
    }
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

    /// Plans of before give the numbers of before: drawn by the code that this one took the place of.
    #[test]
    #[allow(clippy::needless_update)] // kinds that come later are off here
    fn the_draws_of_a_seed_never_change() {
        let robot = Robot::load("lima").unwrap();
        let full = RandomizationSpec {
            mass: 0.2,
            joint_offset: 0.05,
            ground_friction: Some([0.4, 1.0]),
            center_of_mass: 0.01,
            foot_friction: Some([0.3, 1.0]),
            armature: 0.1,
            damping: 0.2,
            gains: 0.3,
            strength: 0.4,
            pushes: Some(PushSpec::default()),
            ..RandomizationSpec::none()
        };
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let p = full.sample(&robot, &mut rng);
        assert_eq!((p.mass_scale[0], *p.mass_scale.last().unwrap()), (0.960_994_24, 0.992_120_9));
        assert_eq!((p.joint_offset[0], p.ground_friction), (-0.010_266_556, Some(0.939_764_6)));
        assert_eq!(p.com_offset[0], [-0.002_413_853_8, -0.000_463_256_35, 0.008_443_779]);
        assert_eq!(*p.com_offset.last().unwrap(), [0.006_178_295_2, 0.000_176_783_53, -0.009_562_477]);
        assert_eq!(p.foot_friction, [0.520_188_6, 0.842_163]);
        assert_eq!((p.armature_scale[0], p.damping_scale[0]), (1.096_849_3, 1.105_257_9));
        assert_eq!((p.kp_scale[0], p.kd_scale[0]), (1.162_458_7, 0.802_976_25));
        assert_eq!((p.strength_scale[0], *p.strength_scale.last().unwrap()), (1.091_712_4, 1.393_712_3));
        assert_eq!(rng.random::<u64>(), 1_529_322_883_871_593_655, "as many draws");

        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let p = RandomizationSpec::default().sample(&robot, &mut rng);
        assert_eq!((p.mass_scale[0], p.ground_friction), (0.980_497_1, Some(0.638_400_7)));
        assert_eq!(rng.random::<u64>(), 252_675_064_631_575_638, "what does not differ draws nothing");
    }

    #[test]
    fn keys_and_defaults_of_plans_stay() {
        let text = "mass = 0.1\nground_friction = [0.4, 1.0]\ncenter_of_mass = 0.01\nfoot_friction = [0.3, 1.0]\n\
                    armature = 0.1\ndamping = 0.1\ngains = 0.1\nstrength = 0.1\njoint_offset = 0.02\n[pushes]\nforce = 0.2\n";
        let spec: RandomizationSpec = toml::from_str(text).unwrap();
        assert_eq!((spec.strength, spec.pushes.unwrap().torque), (0.1, PushSpec::default().torque));
        assert_eq!(toml::from_str::<RandomizationSpec>("").unwrap(), RandomizationSpec::none());
        assert!(toml::from_str::<RandomizationSpec>("weight = 0.1").unwrap_err().to_string().contains("weight"));
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
