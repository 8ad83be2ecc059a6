//! Strands of many hairstyles as training data, tested on hairstyles that are never trained on (thesis 3.3.4).

use std::ops::Range;

use lifelike_character::Vec3;
use lifelike_checkpoint::rng::stream;
use rand::Rng;

use super::SequencesError;
use super::data_plan::DataPlan;
use super::experiments::Experiment;
use super::hairstyles::{Hairstyle, Strand};
use super::roughness::Roughness;
use lifelike_representation::spline_transformer::SequencePlan;
use lifelike_representation::spline_transformer::{HeldOut, Sequences};
use lifelike_train::limits::{range, whole};

/// Hairstyles of the table, and as many that the loss is watched on.
const HELD_OUT_STYLES: usize = 10;
/// Key of all hairstyles and their strands: one data set for every run, whatever its seed. A run's seed chooses among them.
const DATA_SEED: u64 = 3340;

/// A training on strands of hair.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StrandsPlan {
    /// Hairstyles. The first 10 are the test's, the next 10 the validation's, the others are trained on.
    #[serde(default = "hairstyles")]
    pub hairstyles: usize,
    /// Strands of each hairstyle that is trained on.
    #[serde(default = "strands")]
    pub strands: usize,
    /// Points of each strand.
    #[serde(default = "points")]
    pub points: usize,
    /// Roughness of the strands: deviation of their direction by flyaway waves and kinks (rad). 0: as smooth as the hairstyles say.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub roughness: f64,
    /// Strands of each hairstyle that the loss is watched on.
    #[serde(default = "validation")]
    pub validation: usize,
    /// Strands of each hairstyle of the table.
    #[serde(default = "strands")]
    pub test: usize,
    /// Network and training.
    pub training: SequencePlan,
}

#[allow(clippy::trivially_copy_pass_by_ref)] // what serde calls it with
fn is_zero(x: &f64) -> bool {
    *x == 0.0
}

fn hairstyles() -> usize {
    343
}

fn strands() -> usize {
    10_000
}

fn points() -> usize {
    100
}

fn validation() -> usize {
    25
}

impl StrandsPlan {
    /// Returns the thesis' settings, with a latent dimension.
    pub fn new(latent: usize) -> Self {
        let training = SequencePlan { latent, ..Experiment::Strands.plan() };
        let (hairstyles, strands, points, validation) = (hairstyles(), strands(), points(), validation());
        Self { hairstyles, strands, points, roughness: 0.0, validation, test: strands, training }
    }
}

impl DataPlan for StrandsPlan {
    fn training(&self) -> &SequencePlan {
        &self.training
    }

    fn training_mut(&mut self) -> &mut SequencePlan {
        &mut self.training
    }

    fn check(&self) -> Result<(), SequencesError> {
        whole("hairstyles", self.hairstyles as u64, 2 * HELD_OUT_STYLES as u64 + 1, 1 << 20)?;
        whole("strands", self.strands as u64, 1, 1 << 30)?;
        whole("points", self.points as u64, 2, 1 << 14)?;
        range("roughness", self.roughness, 0.0, 2.0)?;
        whole("validation", self.validation as u64, 1, 1 << 20)?;
        whole("test", self.test as u64, 1, 1 << 20)?;
        Ok(self.training.check()?)
    }
}

/// Strands of a plan, in decimetres.
#[derive(Debug, Clone)]
pub struct StrandSequences {
    plan: StrandsPlan,
    styles: Vec<Hairstyle>,
}

impl StrandSequences {
    /// Units of the numbers in a metre: the network works in decimetres, so that they are around 1.
    pub const PER_METRE: f64 = 10.0;

    /// # Errors
    /// A plan out of range.
    pub fn new(plan: &StrandsPlan) -> Result<Self, SequencesError> {
        plan.check()?;
        let draw = |style| Hairstyle::draw(&mut stream(DATA_SEED, "strands.hairstyle", style, 0));
        Ok(Self { plan: plan.clone(), styles: (0..plan.hairstyles as u64).map(draw).collect() })
    }

    /// Returns one strand of the data set.
    fn strand(&self, style: usize, strand: usize) -> Strand {
        self.styles[style].strand(&mut stream(DATA_SEED, "strands.strand", style as u64, strand as u64))
    }

    /// Returns the points of one strand, roughened where the plan says so.
    fn points(&self, style: usize, strand: usize) -> Vec<Vec3> {
        let own = self.strand(style, strand);
        let mut points = own.points(self.plan.points);
        if self.plan.roughness > 0.0 {
            // A stream of its own: the smooth strand is the same one.
            let mut rng = stream(DATA_SEED, "strands.roughness", style as u64, strand as u64);
            Roughness::draw(self.plan.roughness, own.length, &mut rng).apply(&mut points, own.length);
        }
        points
    }

    /// Returns the hairstyle and strand of one training sequence.
    fn training(&self, iteration: u64, i: u64) -> (usize, usize) {
        let mut rng = stream(self.plan.training.seed, "strands.training", i, iteration);
        let style = rng.random_range(2 * HELD_OUT_STYLES..self.plan.hairstyles);
        (style, rng.random_range(0..self.plan.strands))
    }

    /// Returns the hairstyle and strand of one held-out sequence: the hairstyles take turns.
    fn held_out_at(set: HeldOut, i: usize) -> (usize, usize) {
        let first = match set {
            HeldOut::Test => 0,
            HeldOut::Validation => HELD_OUT_STYLES,
        };
        (first + i % HELD_OUT_STYLES, i / HELD_OUT_STYLES)
    }

    fn rows(&self, which: impl Iterator<Item = (usize, usize)>) -> Vec<f32> {
        let points = |(style, strand)| self.points(style, strand);
        which.flat_map(points).flat_map(|p| [p.x, p.y, p.z].map(|x| (Self::PER_METRE * x) as f32)).collect()
    }
}

impl Sequences for StrandSequences {
    fn describe(&self) -> String {
        let StrandsPlan { hairstyles, strands, points, .. } = self.plan;
        let rough = match self.plan.roughness {
            0.0 => String::new(),
            roughness => format!(", roughness {roughness}"),
        };
        format!(
            "{hairstyles} hairstyles of {strands} strands, {points} points{rough}, seed {}",
            self.plan.training.seed
        )
    }

    fn width(&self) -> usize {
        3
    }

    fn tokens(&self) -> usize {
        self.plan.points
    }

    fn batch(&self, iteration: u64, count: usize) -> Vec<f32> {
        self.rows((0..count as u64).map(|i| self.training(iteration, i)))
    }

    fn held_out_len(&self, set: HeldOut) -> usize {
        HELD_OUT_STYLES
            * match set {
                HeldOut::Validation => self.plan.validation,
                HeldOut::Test => self.plan.test,
            }
    }

    fn held_out(&self, set: HeldOut, range: Range<usize>) -> Vec<f32> {
        self.rows(range.map(|i| Self::held_out_at(set, i)))
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use std::collections::BTreeSet;

    use lifelike_representation::spline_transformer::Plain;

    use super::*;

    #[test]
    fn no_hairstyle_is_in_two_sets() {
        let data = StrandSequences::new(&StrandsPlan::new(8)).unwrap();
        let of = |set| (0..data.held_out_len(set)).map(|i| StrandSequences::held_out_at(set, i).0).collect();
        let (test, validation): (BTreeSet<usize>, BTreeSet<usize>) = (of(HeldOut::Test), of(HeldOut::Validation));
        let training: BTreeSet<usize> =
            (0..100).flat_map(|it| (0..128).map(move |i| (it, i))).map(|(it, i)| data.training(it, i).0).collect();
        assert_eq!((test.len(), validation.len(), training.len()), (10, 10, 323));
        assert!(test.is_disjoint(&validation) && test.is_disjoint(&training) && validation.is_disjoint(&training));
        // Other numbers mean other hair.
        let lengths: BTreeSet<u64> = data.styles.iter().map(|s| s.length.to_bits()).collect();
        assert_eq!(lengths.len(), 343);
    }

    #[test]
    fn a_runs_seed_chooses_strands_and_makes_none() {
        let plan = StrandsPlan { points: 5, test: 3, ..StrandsPlan::new(8) };
        let other = StrandsPlan { training: SequencePlan { seed: 9, ..plan.training.clone() }, ..plan.clone() };
        let (one, two) = (StrandSequences::new(&plan).unwrap(), StrandSequences::new(&other).unwrap());
        assert_eq!(one.held_out(HeldOut::Test, 0..30), two.held_out(HeldOut::Test, 0..30));
        assert_eq!(one.held_out(HeldOut::Test, 12..14), one.held_out(HeldOut::Test, 0..30)[12 * 15..14 * 15]);
        assert_ne!(one.batch(0, 4), two.batch(0, 4));
        assert_ne!(one.batch(0, 4), one.batch(1, 4));
        assert_eq!(one.batch(3, 4), one.batch(3, 8)[..4 * 15]);
        // Roots at the origin, tips a length away at most.
        for strand in one.batch(0, 50).chunks(15) {
            assert_eq!(strand[..3], [0.0; 3]);
            assert!(strand[12..].iter().all(|x| x.abs() < 5.5), "{strand:?}");
        }
    }

    /// By components alone, with 32 numbers: rough strands leave more than 2 mm of a coordinate, smooth ones less than 1.
    #[test]
    fn roughness_leaves_components_a_visible_error_and_0_is_the_smooth_data() {
        let plan = StrandsPlan { test: 20, ..StrandsPlan::new(8) };
        let rough = StrandsPlan { roughness: 1.0, ..plan.clone() };
        let data = [&plan, &rough].map(|plan| StrandSequences::new(plan).unwrap());
        let smooth = StrandSequences::new(&StrandsPlan { roughness: 0.0, ..plan.clone() }).unwrap();
        assert_eq!(data[0].held_out(HeldOut::Test, 0..3), smooth.held_out(HeldOut::Test, 0..3));
        assert!(data[1].describe().contains("roughness 1") && !data[0].describe().contains("rough"));
        assert!(!toml::to_string(&plan).unwrap().contains("rough"), "old plans go on");
        let left = data.each_ref().map(|data| {
            let plain = Plain::all(data, 8, &[32]).unwrap();
            let components = plain.iter().find(|own| own.numbers == 32 && own.name == "PCA").unwrap();
            let x = data.held_out(HeldOut::Test, 0..200);
            let y = components.reconstruct(&x).unwrap();
            let squares: f64 = x.iter().zip(&y).map(|(a, b)| f64::from(a - b).powi(2)).sum();
            (squares / x.len() as f64).sqrt() / StrandSequences::PER_METRE
        });
        assert!(left[0] < 1e-3 && left[1] > 2e-3, "{left:?} m");
    }

    #[test]
    fn plans_are_the_thesis_by_default_and_precise_about_what_is_wrong() {
        let plan = StrandsPlan::new(16);
        assert_eq!((plan.hairstyles, plan.strands, plan.points, plan.training.latent), (343, 10_000, 100, 16));
        assert_eq!(toml::from_str::<StrandsPlan>(&toml::to_string(&plan).unwrap()).unwrap(), plan);
        let error = StrandsPlan { hairstyles: 20, ..plan }.check().unwrap_err().to_string();
        assert_eq!(error, "plan: hairstyles: expected 21 to 1048576, got 20");
    }
}
