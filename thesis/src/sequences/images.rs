//! Images as sequences of patches (thesis 3.3.2).

use std::ops::Range;
use std::sync::Arc;

use lifelike_checkpoint::rng::stream;
use lifelike_nn::transformer::patches;
use rand::Rng;

use super::SequencesError;
use super::data_plan::DataPlan;
use super::experiments::Experiment;
use super::image_folder::ImageFolder;
use lifelike_representation::spline_transformer::SequencePlan;
use lifelike_representation::spline_transformer::{HeldOut, Sequences};
use lifelike_train::limits::{whole, wrong};

/// A training on images.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ImagesPlan {
    /// PS: side of a patch (pixels).
    #[serde(default = "patch")]
    pub patch: usize,
    /// Images of `train/` that the loss is watched on, evenly among the others and never trained on.
    #[serde(default = "validation")]
    pub validation: usize,
    /// Images of the table at most, evenly of `test/`.
    #[serde(default = "test")]
    pub test: usize,
    /// Network and training.
    pub training: SequencePlan,
}

fn patch() -> usize {
    4
}

fn validation() -> usize {
    500
}

fn test() -> usize {
    10_000
}

impl ImagesPlan {
    /// Returns the thesis' settings for CIFAR-10, with a latent dimension.
    pub fn new(latent: usize) -> Self {
        let training = SequencePlan { latent, ..Experiment::Cifar10.plan() };
        Self { patch: patch(), validation: validation(), test: test(), training }
    }
}

impl DataPlan for ImagesPlan {
    fn training(&self) -> &SequencePlan {
        &self.training
    }

    fn training_mut(&mut self) -> &mut SequencePlan {
        &mut self.training
    }

    fn check(&self) -> Result<(), SequencesError> {
        whole("patch", self.patch as u64, 1, 1024)?;
        whole("validation", self.validation as u64, 1, 1 << 20)?;
        whole("test", self.test as u64, 1, 1 << 20)?;
        Ok(self.training.check()?)
    }
}

/// Images of a plan: patches row by row, each with its pixels row by row and red, green and blue innermost, from 0 to 1.
#[derive(Debug, Clone)]
pub struct ImageSequences {
    plan: ImagesPlan,
    images: Arc<ImageFolder>,
    /// Index in an image of each number of a sequence.
    order: Vec<usize>,
    training: Vec<usize>,
    validation: Vec<usize>,
    test: Vec<usize>,
}

impl ImageSequences {
    /// # Errors
    /// A plan out of range, patches that do not tile the images, or nothing left to train on.
    pub fn new(plan: &ImagesPlan, images: Arc<ImageFolder>) -> Result<Self, SequencesError> {
        plan.check()?;
        let order = patches::order(plan.patch, images.size, ImageFolder::CHANNELS)
            .map_err(|e| wrong("patch", "one whose squares tile the images", e))?;
        let count = images.train.len();
        if plan.validation >= count {
            let expected = format!("fewer than the {count} images of train/");
            return Err(wrong("validation", &expected, plan.validation).into());
        }
        let validation = evenly(count, plan.validation);
        let training = (0..count).filter(|i| validation.binary_search(i).is_err()).collect();
        let test = evenly(images.test.len(), plan.test);
        Ok(Self { plan: plan.clone(), images, order, training, validation, test })
    }

    /// Returns the image of a sequence, as bytes; what lies outside of 0 to 1 becomes 0 or 1.
    ///
    /// # Shapes
    /// `[tokens, width]` to `[rows, columns, 3]`.
    pub fn picture(&self, sequence: &[f32]) -> Vec<u8> {
        let mut rgb = vec![0; self.order.len()];
        for (at, x) in self.order.iter().zip(sequence) {
            // A cast of a float keeps within the bytes' range.
            rgb[*at] = (255.0 * x).round() as u8;
        }
        rgb
    }

    /// Rows and columns.
    pub fn size(&self) -> [usize; 2] {
        self.images.size
    }

    fn sequence<'a>(&'a self, image: &'a [u8]) -> impl Iterator<Item = f32> + 'a {
        self.order.iter().map(|at| f32::from(image[*at]) / 255.0)
    }
}

/// `wanted` of `count`, at most all, at even distances.
fn evenly(count: usize, wanted: usize) -> Vec<usize> {
    let wanted = wanted.min(count);
    (0..wanted).map(|i| i * count / wanted).collect()
}

impl Sequences for ImageSequences {
    fn describe(&self) -> String {
        let ([rows, columns], digest) = (self.images.size, &self.images.digest);
        let (train, patch, held, seed) =
            (self.images.train.len(), self.plan.patch, self.validation.len(), self.plan.training.seed);
        format!("{train} images of {columns} x {rows}, {digest}, {held} held out, patches of {patch}, seed {seed}")
    }

    fn width(&self) -> usize {
        self.plan.patch * self.plan.patch * ImageFolder::CHANNELS
    }

    fn tokens(&self) -> usize {
        self.order.len() / self.width()
    }

    fn batch(&self, iteration: u64, count: usize) -> Vec<f32> {
        let seed = self.plan.training.seed;
        let draw = |i| stream(seed, "images.training", i, iteration).random_range(0..self.training.len());
        (0..count as u64).flat_map(|i| self.sequence(&self.images.train[self.training[draw(i)]])).collect()
    }

    fn held_out_len(&self, set: HeldOut) -> usize {
        match set {
            HeldOut::Validation => self.validation.len(),
            HeldOut::Test => self.test.len(),
        }
    }

    fn held_out(&self, set: HeldOut, range: Range<usize>) -> Vec<f32> {
        let (images, which) = match set {
            HeldOut::Validation => (&self.images.train, &self.validation),
            HeldOut::Test => (&self.images.test, &self.test),
        };
        which[range].iter().flat_map(|i| self.sequence(&images[*i])).collect()
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use std::collections::BTreeSet;

    use super::*;

    /// Images of 2 x 4 pixels whose numbers count from the image's own number on.
    fn folder(train: u8, test: u8) -> Arc<ImageFolder> {
        let image = |first: u8| (0..24).map(|i| first + i).collect();
        let (train, test) = ((0..train).map(image).collect(), (100..100 + test).map(image).collect());
        Arc::new(ImageFolder { size: [2, 4], train, test, digest: "d".into() })
    }

    fn plan() -> ImagesPlan {
        ImagesPlan { patch: 2, validation: 3, test: 4, ..ImagesPlan::new(32) }
    }

    #[test]
    fn pixels_stand_patch_by_patch_and_come_back() {
        let images = ImageSequences::new(&plan(), folder(10, 8)).unwrap();
        assert_eq!((images.tokens(), images.width()), (2, 12));
        // Test image 0 counts from 100: row 0 to 111, row 1 from 112. The second patch begins at pixel (0, 2).
        let numbers: Vec<f32> = images.held_out(HeldOut::Test, 0..1).iter().map(|x| x * 255.0).collect();
        let expected = [
            100, 101, 102, 103, 104, 105, 112, 113, 114, 115, 116, 117, 106, 107, 108, 109, 110, 111, 118, 119, 120,
            121, 122, 123,
        ];
        assert!(numbers.iter().zip(expected).all(|(x, e)| (x - e as f32).abs() < 1e-4), "{numbers:?}");
        assert_eq!(images.picture(&images.held_out(HeldOut::Test, 0..1)), (100..124).collect::<Vec<u8>>());
        assert_eq!(images.picture(&[-3.0, 7.0, f32::NAN])[..3], [0, 255, 0]);
    }

    #[test]
    fn validation_is_a_fixed_part_of_train_that_is_never_trained_on() {
        let images = ImageSequences::new(&plan(), folder(10, 8)).unwrap();
        let firsts = |x: Vec<f32>| x.chunks(24).map(|x| (255.0 * x[0]).round() as u8).collect::<BTreeSet<u8>>();
        assert_eq!(firsts(images.held_out(HeldOut::Validation, 0..3)), [0, 3, 6].into());
        assert_eq!(firsts(images.held_out(HeldOut::Test, 0..4)), [100, 102, 104, 106].into());
        assert_eq!(firsts(images.batch(0, 300)), [1, 2, 4, 5, 7, 8, 9].into());
        assert_eq!(images.batch(3, 4), images.batch(3, 8)[..4 * 24]);
        assert_ne!(images.batch(3, 8), images.batch(4, 8));
    }

    #[test]
    fn what_does_not_fit_is_refused_with_its_key() {
        let error = |plan: &ImagesPlan| ImageSequences::new(plan, folder(10, 8)).unwrap_err().to_string();
        let text = error(&ImagesPlan { patch: 3, ..plan() });
        assert!(text.starts_with("plan: patch: expected one whose") && text.contains("2 x 4"), "{text}");
        let text = error(&ImagesPlan { validation: 10, ..plan() });
        assert_eq!(text, "plan: validation: expected fewer than the 10 images of train/, got 10");
        assert_eq!(error(&ImagesPlan { test: 0, ..plan() }), "plan: test: expected 1 to 1048576, got 0");
        let whole = ImagesPlan::new(64);
        assert_eq!((whole.patch, whole.test, whole.training.latent, whole.training.batch), (4, 10_000, 64, 512));
        assert_eq!(toml::from_str::<ImagesPlan>(&toml::to_string(&whole).unwrap()).unwrap(), whole);
    }
}
