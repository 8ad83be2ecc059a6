//! Curves of one family as training data without end, and test curves that are never among them.

use std::ops::Range;

use lifelike_checkpoint::rng::stream;

use super::SequencesError;
use super::data_plan::DataPlan;
use super::experiments::Experiment;
use super::families::Family;
use lifelike_representation::spline_transformer::SequencePlan;
use lifelike_representation::spline_transformer::{HeldOut, Sequences};
use lifelike_train::limits::{whole, wrong};

/// Seed of validation and test curves, the same for every run. Training with it is refused, and the streams have other
/// purposes besides, so no training curve is ever one of them.
pub const HELD_OUT_SEED: u64 = 3310;

/// A training on a family of curves (thesis 3.3.1).
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CurvesPlan {
    /// Family of the curves.
    pub family: Family,
    /// Points of each curve.
    #[serde(default = "samples")]
    pub samples: usize,
    /// Curves that the loss is watched on.
    #[serde(default = "validation")]
    pub validation: usize,
    /// Curves of the table.
    #[serde(default = "test")]
    pub test: usize,
    /// Network and training.
    pub training: SequencePlan,
}

fn samples() -> usize {
    256
}

fn validation() -> usize {
    256
}

fn test() -> usize {
    10_000
}

impl CurvesPlan {
    /// Returns the thesis' settings.
    pub fn new(family: Family) -> Self {
        let experiment = match family {
            Family::Lissajous => Experiment::Lissajous,
            Family::Hypotrochoids => Experiment::Hypotrochoids,
            Family::Bezier2 => Experiment::Bezier2,
            Family::Bezier64 => Experiment::Bezier64,
        };
        let training = experiment.plan();
        Self { family, samples: samples(), validation: validation(), test: test(), training }
    }
}

impl DataPlan for CurvesPlan {
    fn training(&self) -> &SequencePlan {
        &self.training
    }

    fn training_mut(&mut self) -> &mut SequencePlan {
        &mut self.training
    }

    fn check(&self) -> Result<(), SequencesError> {
        whole("samples", self.samples as u64, 2, 1 << 14)?;
        whole("validation", self.validation as u64, 1, 1 << 20)?;
        whole("test", self.test as u64, 1, 1 << 20)?;
        if self.training.seed == HELD_OUT_SEED {
            return Err(
                wrong("training.seed", &format!("any but {HELD_OUT_SEED}, the test curves'"), HELD_OUT_SEED).into()
            );
        }
        Ok(self.training.check()?)
    }
}

/// Curves of a plan.
#[derive(Debug, Clone)]
pub struct CurveSequences {
    family: Family,
    samples: usize,
    validation: usize,
    test: usize,
    seed: u64,
}

impl CurveSequences {
    /// # Errors
    /// A plan out of range.
    pub fn new(plan: &CurvesPlan) -> Result<Self, SequencesError> {
        plan.check()?;
        let CurvesPlan { family, samples, validation, test, .. } = *plan;
        Ok(Self { family, samples, validation, test, seed: plan.training.seed })
    }

    /// Parameters of one training curve.
    pub fn training_parameters(&self, iteration: u64, curve: u64) -> Vec<f64> {
        self.family.draw(&mut stream(self.seed, "curves.training", curve, iteration))
    }

    /// Parameters of one held-out curve.
    pub fn held_out_parameters(&self, set: HeldOut, curve: u64) -> Vec<f64> {
        let purpose = match set {
            HeldOut::Validation => "curves.validation",
            HeldOut::Test => "curves.test",
        };
        self.family.draw(&mut stream(HELD_OUT_SEED, purpose, curve, 0))
    }

    fn curves(&self, parameters: impl Iterator<Item = Vec<f64>>) -> Vec<f32> {
        // The family has drawn the parameters itself, so their number is right.
        parameters.flat_map(|p| self.family.curve(&p, self.samples).unwrap_or_default()).collect()
    }
}

impl Sequences for CurveSequences {
    fn describe(&self) -> String {
        let domain: Vec<String> =
            self.family.domain().iter().map(|(name, [low, high])| format!("{name} {low}..{high}")).collect();
        let (family, samples, seed) = (self.family, self.samples, self.seed);
        format!("{family}, {samples} points, seed {seed}, {}", domain.join(", "))
    }

    fn width(&self) -> usize {
        2
    }

    fn tokens(&self) -> usize {
        self.samples
    }

    fn batch(&self, iteration: u64, count: usize) -> Vec<f32> {
        self.curves((0..count as u64).map(|curve| self.training_parameters(iteration, curve)))
    }

    fn held_out_len(&self, set: HeldOut) -> usize {
        match set {
            HeldOut::Validation => self.validation,
            HeldOut::Test => self.test,
        }
    }

    fn held_out(&self, set: HeldOut, range: Range<usize>) -> Vec<f32> {
        self.curves(range.map(|curve| self.held_out_parameters(set, curve as u64)))
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use std::collections::HashSet;

    use super::*;

    #[test]
    fn no_test_or_validation_curve_is_ever_trained_on() {
        let bits = |p: Vec<f64>| p.into_iter().map(f64::to_bits).collect::<Vec<_>>();
        for seed in [0, 1, 3309] {
            let mut plan = CurvesPlan::new(Family::Lissajous);
            plan.training.seed = seed;
            let curves = CurveSequences::new(&plan).unwrap();
            let mut held_out = HashSet::new();
            for (set, count) in [(HeldOut::Test, 10_000), (HeldOut::Validation, 256)] {
                assert_eq!(curves.held_out_len(set), count);
                held_out.extend((0..count as u64).map(|i| bits(curves.held_out_parameters(set, i))));
            }
            assert_eq!(held_out.len(), 10_256, "nor is one in both");
            for iteration in 0..100 {
                for curve in 0..256 {
                    assert!(!held_out.contains(&bits(curves.training_parameters(iteration, curve))));
                }
            }
        }
        let mut plan = CurvesPlan::new(Family::Lissajous);
        plan.training.seed = HELD_OUT_SEED;
        let error = CurveSequences::new(&plan).unwrap_err().to_string();
        assert!(error.contains("training.seed") && error.contains("3310"), "{error}");
    }

    #[test]
    fn test_curves_do_not_depend_on_the_training_and_parts_of_a_set_are_parts_of_it() {
        let plan = CurvesPlan { samples: 8, ..CurvesPlan::new(Family::Hypotrochoids) };
        let other = CurvesPlan { training: SequencePlan { seed: 9, ..plan.training.clone() }, ..plan.clone() };
        let (one, two) = (CurveSequences::new(&plan).unwrap(), CurveSequences::new(&other).unwrap());
        assert_eq!(one.held_out(HeldOut::Test, 0..20), two.held_out(HeldOut::Test, 0..20));
        assert_eq!(one.held_out(HeldOut::Test, 5..7), one.held_out(HeldOut::Test, 0..20)[5 * 16..7 * 16]);
        assert_ne!(one.held_out(HeldOut::Test, 0..20), one.held_out(HeldOut::Validation, 0..20));
        assert_ne!(one.batch(0, 4), two.batch(0, 4));
        assert_ne!(one.batch(0, 4), one.batch(1, 4));
        assert_eq!(one.batch(3, 4), one.batch(3, 8)[..4 * 16]);
    }

    #[test]
    fn plans_are_the_thesis_by_default_and_precise_about_what_is_wrong() {
        let plan = CurvesPlan::new(Family::Bezier64);
        assert_eq!((plan.samples, plan.test, plan.training.latent, plan.training.width), (256, 10_000, 64, 128));
        assert_eq!(toml::from_str::<CurvesPlan>(&toml::to_string(&plan).unwrap()).unwrap(), plan);
        for family in Family::ALL {
            assert_eq!(CurvesPlan::new(family).training.latent, family.dimensions());
        }
        let error = CurvesPlan { samples: 1, ..plan }.check().unwrap_err().to_string();
        assert_eq!(error, "plan: samples: expected 2 to 16384, got 1");
        let error = toml::from_str::<CurvesPlan>("family = 'circle'\n[training]").unwrap_err().to_string();
        assert!(error.contains("circle") && error.contains("bezier-64"), "{error}");
    }
}
