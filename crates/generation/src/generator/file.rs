//! The file `*.generator.safetensors`: names, rate, statistics, vocabulary, weights, and where they come from.

use std::path::Path;

use lifelike_checkpoint::Checkpoint;
use lifelike_nn::rows::Layout;
use lifelike_robot::Robot;
use lifelike_robot::controller::RobotDescription;

use super::sample::MIN_SECONDS;
use crate::denoiser::DenoiserSizes;
use crate::representation::{RepresentationSpec, Standardizer};
use crate::space::SpaceKind;
use crate::text::duration::Durations;
use crate::text::familiarity::KnownCaptions;
use crate::text::pieces::WordPieces;
use crate::training::{GeneratorPlan, TrainingData};
use crate::{FromInput, GenerationError};

/// Version of the file's layout.
const VERSION: u32 = 1;
/// Most captions that are kept for [`KnownCaptions`].
const MAX_CAPTIONS: usize = 2000;
/// In files.
const KEY: &str = "generator";

/// Everything about a generator but its numbers.
#[derive(Debug, Clone, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GeneratorHeader {
    /// Version of the file's layout.
    pub version: u32,
    /// Robot that it makes motion for.
    pub robot: String,
    /// [`RobotDescription::digest`] of that robot.
    pub robot_digest: String,
    /// Rows of the motion.
    pub spec: RepresentationSpec,
    /// Tokens of the network.
    pub space: SpaceKind,
    /// Sizes of the network.
    pub sizes: DenoiserSizes,
    /// D: steps of the cosine schedule.
    pub diffusion_steps: usize,
    /// Vocabulary.
    pub pieces: WordPieces,
    /// Captions that it was trained on, thinned.
    pub known: KnownCaptions,
    /// Longest motion that it was trained on (s).
    pub max_seconds: f64,
    /// Durations that sentences ask for; nothing in files of before.
    #[serde(default)]
    pub durations: Durations,
    /// The median duration of what it was trained on (s).
    pub median_seconds: f64,
    /// Terms of use of the motion that it was trained on.
    pub licences: Vec<String>,
    /// Training iterations.
    pub iterations: u64,
    /// Motion that it was trained on, with a digest.
    pub data: String,
}

impl GeneratorHeader {
    pub(crate) fn new(
        plan: &GeneratorPlan,
        data: &TrainingData,
        sizes: DenoiserSizes,
        (robot, digest): &(String, String),
        iterations: u64,
    ) -> Self {
        Self {
            version: VERSION,
            robot: robot.clone(),
            robot_digest: digest.clone(),
            spec: data.space.spec().clone(),
            space: plan.space,
            sizes,
            diffusion_steps: plan.diffusion_steps,
            pieces: data.pieces.clone(),
            known: KnownCaptions::learn(data.captions.iter().map(String::as_str), MAX_CAPTIONS),
            max_seconds: plan.max_seconds,
            durations: data.durations.clone(),
            median_seconds: data.median_seconds,
            licences: data.licences.clone(),
            iterations,
            data: data.describe(),
        }
    }
}

/// A trained generator.
#[derive(Debug, Clone)]
pub struct Generator {
    header: GeneratorHeader,
    pub(super) standardizer: Standardizer,
    pub(super) layout: Layout,
    pub(super) values: Vec<f32>,
}

impl Generator {
    pub(crate) fn new(header: GeneratorHeader, standardizer: Standardizer, layout: Layout, values: Vec<f32>) -> Self {
        Self { header, standardizer, layout, values }
    }

    /// Returns what the file says about it.
    pub fn header(&self) -> &GeneratorHeader {
        &self.header
    }

    /// Returns the duration of a sentence's motion where none is asked for (s): what its words say, or the median of what
    /// was trained on.
    pub fn seconds(&self, prompt: &str) -> f64 {
        let header = &self.header;
        let seconds = header.durations.seconds(prompt).unwrap_or(header.median_seconds);
        seconds.clamp(MIN_SECONDS, header.max_seconds.max(MIN_SECONDS))
    }

    /// Returns the statistics of its tokens.
    pub fn standardizer(&self) -> &Standardizer {
        &self.standardizer
    }

    /// Returns the parameters of its network, in the order of its layout.
    pub(crate) fn values(&self) -> &[f32] {
        &self.values
    }

    /// Returns the same generator with other weights, those after this number of iterations.
    pub(crate) fn with(mut self, values: Vec<f32>, iterations: u64) -> Self {
        (self.values, self.header.iterations) = (values, iterations);
        self
    }

    /// Saves it.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn save(&self, path: &Path) -> Result<(), GenerationError> {
        let mut file = Checkpoint::new();
        file.set_meta(KEY, &self.header)?;
        let width = self.header.sizes.motion;
        file.put_f32("standardizer.mean", &[width], self.standardizer.mean.clone())?;
        file.put_f32("standardizer.std", &[width], self.standardizer.std.clone())?;
        self.layout.save_into(&mut file, "network", &self.values)?;
        Ok(file.save(path)?)
    }

    /// Loads one.
    ///
    /// # Errors
    /// A file that is none, of another version, or of sizes that do not fit each other.
    pub fn load(path: &Path) -> Result<Self, GenerationError> {
        let file = Checkpoint::load(path)?;
        let header: GeneratorHeader = file.meta(KEY)?;
        if header.version != VERSION {
            let what = format!("{}: version", path.display());
            return Err(GenerationError::mismatch(what, VERSION, header.version));
        }
        header.spec.check()?;
        let width = header.sizes.motion;
        let layout = header.sizes.layout()?;
        let values = layout.load_from(&file, "network")?;
        let standardizer = Standardizer {
            mean: file.f32s("standardizer.mean", &[width])?,
            std: file.f32s("standardizer.std", &[width])?,
        };
        let generator = Self { header, standardizer, layout, values };
        let expected = generator.space().width();
        if expected != width || generator.header.diffusion_steps == 0 {
            return Err(GenerationError::mismatch(format!("{}: numbers of a token", path.display()), expected, width));
        }
        Ok(generator)
    }

    /// Checks that it makes motion for this robot.
    ///
    /// # Errors
    /// [`GenerationError::Input`] for a robot with other joints. Other gains or limits are only warned about: they
    /// change what the robot can do, not what the motion means.
    pub fn check_robot(&self, robot: &Robot) -> Result<(), GenerationError> {
        let (own, theirs) = (&self.header.spec.joint_names, &robot.layout.joints);
        if own.len() != theirs.len() || theirs.iter().any(|joint| !own.contains(joint)) {
            let expected = format!("'{}' with its {} joints", self.header.robot, own.len());
            let got = format!("'{}' with {} (train one for it: lifelike train generator)", robot.name, theirs.len());
            return Err(GenerationError::mismatch("robot of the generator", expected, got));
        }
        if RobotDescription::of(robot).digest != self.header.robot_digest {
            tracing::warn!("the generator was trained for another version of '{}'", self.header.robot);
        }
        Ok(())
    }
}
