//! What to train: typed, checked, saved with the run.

use std::path::{Path, PathBuf};

use lifelike_robot::ActionSpec;
use lifelike_robot::observation::{AnchorSpec, ReferenceSpec};
use lifelike_sim::Terrain;
use lifelike_sim::randomization::RandomizationSpec;

use super::curriculum::Curriculum;
use super::rewards::{ExponentialReward, Kernel, Reward};
use super::senses::SenseSpec;
use super::starts::StartSpec;
use crate::error::LearnError;
use crate::limits::{range, whole, wrong};

/// A tracker's training, as text. Everything but `robot` and `clips` has a default: the recipe that learns fastest.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TrackerPlan {
    /// A built-in robot's name, or the path of an MJCF or URDF file.
    pub robot: String,
    /// Clips: `*.motion.safetensors` files, folders of them, patterns. Empty: the robot stands in its default pose.
    pub clips: Vec<PathBuf>,
    /// Learn from the mirror image of every clip too, by the robot's own symmetry.
    #[serde(default)]
    pub mirror: bool,
    /// A motion prior whose latent codes the policy sees; its size must be `inputs.latent`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub prior: Option<PathBuf>,
    /// What to begin with instead of fresh networks: the folder of a run (policy, value function and what their inputs are
    /// normalised with, from its last checkpoint) or a policy file. Optimizers and learning rates begin anew.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub init: Option<PathBuf>,
    /// Seed of everything random.
    #[serde(default)]
    pub seed: u64,
    /// When to stop.
    #[serde(default)]
    pub budget: Budget,
    /// Iterations between checkpoints.
    #[serde(default = "fifty")]
    pub checkpoint_every: u64,
    /// What the policy sees of the reference.
    #[serde(default = "default_inputs")]
    pub inputs: ReferenceSpec,
    /// Whether the policy sees the root's linear velocity. Without it a policy suits robots that cannot measure it; those
    /// cannot measure `anchor.position` either.
    #[serde(default = "yes")]
    pub linear_velocity: bool,
    /// What the policy sees of its place on the reference's path.
    #[serde(default = "default_anchor")]
    pub anchor: AnchorSpec,
    /// What the policy's output means.
    #[serde(default = "default_action")]
    pub action: ActionSpec,
    /// What it is rewarded for.
    #[serde(default = "default_reward")]
    pub reward: Reward,
    /// When an episode has failed.
    #[serde(default)]
    pub termination: Termination,
    /// How long an episode is.
    #[serde(default)]
    pub episode: EpisodeSpec,
    /// Where it begins.
    #[serde(default)]
    pub starts: StartSpec,
    /// How the environments differ from the model and from each other.
    #[serde(default = "RandomizationSpec::none")]
    pub randomization: RandomizationSpec,
    /// Uneven ground; none: level ground.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub terrain: Option<TerrainSpec>,
    /// Noise and delays between robot and policy.
    #[serde(default)]
    pub senses: SenseSpec,
    /// What becomes harder while it learns.
    #[serde(default)]
    pub curriculum: Curriculum,
    /// The networks.
    #[serde(default)]
    pub network: NetworkSpec,
    /// The algorithm.
    #[serde(default)]
    pub ppo: PpoSpec,
}

/// When to stop: at whichever comes first.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Budget {
    /// Environment steps over all environments.
    pub steps: u64,
    /// Wall time of the whole run, earlier parts of a resumed run included (minutes). A run that stops by the clock ends
    /// at another step each time.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub minutes: Option<f64>,
}

impl Default for Budget {
    fn default() -> Self {
        Self { steps: 2_000_000, minutes: None }
    }
}

/// When an episode has failed. A limit that the table does not name is not applied; without the table the recipe's limits
/// are. A diverged simulation always ends the episode.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields, default = "Termination::none")]
pub struct Termination {
    /// The thesis' rule: the largest end-effector deviation (heading frame, relative to the root) ...
    #[serde(skip_serializing_if = "Option::is_none")]
    pub persistent: Option<Persistent>,
    /// Root height off by more than this (m).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub height: Option<f32>,
    /// The direction of gravity in the root's frame off by more than this angle (rad).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tilt: Option<f32>,
    /// An end effector (heading frame, relative to the root) off by more than this (m).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub effector: Option<f32>,
    /// On the ground, off the reference by more than this (m).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub path: Option<f32>,
    /// Heading off by more than this (rad).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub heading: Option<f32>,
}

/// t^p and f of Table 4.1.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Persistent {
    /// ... is above this distance (m) ...
    pub distance: f32,
    /// ... for longer than this (s).
    pub seconds: f64,
}

impl Default for Termination {
    fn default() -> Self {
        Self { persistent: None, height: Some(0.12), tilt: Some(0.7), effector: Some(0.25), path: None, heading: None }
    }
}

impl Termination {
    /// With every limit multiplied (above 1: forgiving more); times stay.
    #[must_use]
    pub fn scaled(self, factor: f64) -> Self {
        let scale = |limit: Option<f32>| limit.map(|l| (f64::from(l) * factor) as f32);
        Self {
            persistent: self.persistent.map(|p| Persistent { distance: (f64::from(p.distance) * factor) as f32, ..p }),
            height: scale(self.height),
            tilt: scale(self.tilt),
            effector: scale(self.effector),
            path: scale(self.path),
            heading: scale(self.heading),
        }
    }

    /// No limit at all: for evaluation, which has its own idea of failure.
    pub const NONE: Self =
        Self { persistent: None, height: None, tilt: None, effector: None, path: None, heading: None };

    fn none() -> Self {
        Self::NONE
    }
}

/// How long an episode is.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct EpisodeSpec {
    /// Longest episode T (s).
    pub seconds: f64,
    /// At the end of a clip, go on with another from a random frame without a reset (thesis 4.2.2); else the episode is
    /// cut there.
    pub switch_clips: bool,
    /// A robot that leaves its path, or turns off it, further than it is shown (`ANCHOR_REACH` and `ANCHOR_TURN` of
    /// [`lifelike_robot::ObservationSpec`]) draws the reference's world after it. So errors stay where they can be seen and
    /// paid for, without a reason to end the episode.
    pub leash: bool,
    /// After a switch, deviations do not end the episode for this long (s).
    pub grace_seconds: f64,
}

impl Default for EpisodeSpec {
    fn default() -> Self {
        Self { seconds: 10.0, switch_clips: false, leash: true, grace_seconds: 1.0 }
    }
}

/// A field of hills: level at one end, growing in height towards the other. Episodes begin anywhere in its middle half.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct TerrainSpec {
    /// Length of a side (m).
    pub size: f64,
    /// Distance between neighbouring heights (m).
    pub spacing: f64,
    /// Height of the hills at the high end (m).
    pub amplitude: f64,
    /// Longest wavelength of the hills (m).
    pub wavelength: f64,
    /// Which field.
    pub seed: u64,
}

impl Default for TerrainSpec {
    fn default() -> Self {
        Self { size: 80.0, spacing: 0.1, amplitude: 0.15, wavelength: 3.0, seed: 0 }
    }
}

impl TerrainSpec {
    /// The field.
    ///
    /// # Errors
    /// Sizes that give no field, or one of more than 10 000 heights a side.
    pub fn build(&self) -> Result<Terrain, LearnError> {
        let hills = Terrain::hills(self.size, self.spacing, self.amplitude, self.wavelength, self.seed)?;
        let (rows, columns) = (hills.rows(), hills.columns());
        // Episodes begin between a quarter and three quarters of the way: from level to full height.
        let share = |column: usize| (2.0 * (column as f64 / (columns - 1) as f64) - 0.5).clamp(0.0, 1.0);
        let heights = hills.heights().iter().enumerate().map(|(i, h)| h * share(i % columns)).collect();
        Ok(Terrain::new(rows, columns, self.spacing, heights)?)
    }
}

/// Sizes of the ELU networks.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct NetworkSpec {
    /// Hidden layers of the policy.
    pub actor: Vec<usize>,
    /// Hidden layers of the value function.
    pub critic: Vec<usize>,
    /// Hidden layers of an encoder of `inputs.window` that is trained with the policy.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub encoder: Vec<usize>,
    /// Size of its code.
    #[serde(skip_serializing_if = "is_zero")]
    pub code: usize,
}

#[allow(clippy::trivially_copy_pass_by_ref)] // serde hands out a reference
fn is_zero(n: &usize) -> bool {
    *n == 0
}

fn yes() -> bool {
    true
}

impl Default for NetworkSpec {
    fn default() -> Self {
        Self { actor: vec![256, 128], critic: vec![256, 128], encoder: Vec::new(), code: 0 }
    }
}

/// Proximal policy optimization (Schulman et al. 2017).
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct PpoSpec {
    /// Environments.
    pub environments: usize,
    /// Steps of each environment per iteration.
    pub steps: usize,
    /// Passes over the rollout.
    pub epochs: usize,
    /// Samples per gradient step.
    pub minibatch: usize,
    /// Clip range ε.
    pub clip: f64,
    /// Discount γ.
    pub gamma: f32,
    /// GAE's λ.
    pub lambda: f32,
    /// KL divergence per iteration that the learning rate is steered to.
    pub target_divergence: f64,
    /// First learning rate of the policy.
    pub learning_rate: f64,
    /// Its bounds.
    pub learning_rate_bounds: [f64; 2],
    /// Learning rate of the value function; constant.
    pub critic_learning_rate: f64,
    /// Collect the next rollout while the last one is learned from: what acts is one update behind.
    pub overlap: bool,
    /// Weight of the entropy.
    pub entropy: f64,
    /// Largest norm of each network's gradient.
    pub gradient_norm: f64,
    /// Standard deviation of the first policy, in units of its output.
    pub initial_std: f64,
    /// Bounds of the standard deviation.
    pub std_bounds: [f64; 2],
}

impl Default for PpoSpec {
    fn default() -> Self {
        Self {
            environments: 256,
            steps: 12,
            epochs: 4,
            minibatch: 1536,
            clip: 0.2,
            gamma: 0.97,
            lambda: 0.95,
            target_divergence: 0.05,
            learning_rate: 1e-3,
            learning_rate_bounds: [2e-5, 3e-3],
            critic_learning_rate: 1e-3,
            overlap: false,
            entropy: 0.0,
            gradient_norm: 1.0,
            initial_std: 0.4,
            std_bounds: [0.05, 1.6],
        }
    }
}

fn fifty() -> u64 {
    50
}

fn default_inputs() -> ReferenceSpec {
    // Frames further ahead cost more samples than they save (docs/results/walk.md).
    ReferenceSpec { frame: true, ..ReferenceSpec::default() }
}

fn default_anchor() -> AnchorSpec {
    AnchorSpec { heading: true, position: true }
}

fn default_action() -> ActionSpec {
    ActionSpec::Reference { scale: 0.5 }
}

/// The exponential recipe of the prototype (its sums over 20 joints and 4 end effectors as means), and the path.
fn default_reward() -> Reward {
    let kernel = |weight, sharpness| Kernel { weight, sharpness };
    Reward::Exponential(ExponentialReward {
        height: kernel(0.1, 150.0),
        orientation: kernel(0.15, 4.0),
        velocity: kernel(0.2, 4.0),
        angular_share: 0.0375,
        joint_position: kernel(0.35, 40.0),
        joint_velocity: kernel(0.1, 0.8),
        effectors: kernel(0.2, 240.0),
        heading: kernel(0.15, 10.0),
        path: kernel(0.15, 20.0),
        alive: 0.0,
        action_rate: 0.05,
        action_acceleration: 0.015,
        torque: 1e-5,
    })
}

impl TrackerPlan {
    /// A plan with every default.
    pub fn new(robot: &str, clips: &[PathBuf]) -> Self {
        Self {
            robot: robot.into(),
            clips: clips.to_vec(),
            mirror: false,
            prior: None,
            init: None,
            seed: 0,
            budget: Budget::default(),
            checkpoint_every: fifty(),
            inputs: default_inputs(),
            linear_velocity: true,
            anchor: default_anchor(),
            action: default_action(),
            reward: default_reward(),
            termination: Termination::default(),
            episode: EpisodeSpec::default(),
            starts: StartSpec::default(),
            randomization: RandomizationSpec::none(),
            terrain: None,
            senses: SenseSpec::default(),
            curriculum: Curriculum::default(),
            network: NetworkSpec::default(),
            ppo: PpoSpec::default(),
        }
    }

    /// Reads and checks a plan.
    ///
    /// # Errors
    /// [`LearnError::Io`], [`LearnError::Format`] with line and column, [`LearnError::Plan`] for a value out of range.
    pub fn read(path: &Path) -> Result<Self, LearnError> {
        let text = std::fs::read_to_string(path).map_err(LearnError::io(path))?;
        let plan: Self = toml::from_str(&text).map_err(|e| LearnError::Format {
            path: path.display().to_string(),
            expected: "a tracker plan".into(),
            got: e.to_string(),
        })?;
        plan.check()?;
        Ok(plan)
    }

    /// Whether every value is in its range.
    ///
    /// # Errors
    /// [`LearnError::Plan`] with the key, the range and the value.
    pub fn check(&self) -> Result<(), LearnError> {
        let p = &self.ppo;
        whole("budget.steps", self.budget.steps, 1, u64::MAX)?;
        if let Some(minutes) = self.budget.minutes {
            range("budget.minutes", minutes, 0.0, 1e6)?;
        }
        whole("checkpoint_every", self.checkpoint_every, 1, u64::MAX)?;
        whole("ppo.environments", p.environments as u64, 1, 1 << 20)?;
        whole("ppo.steps", p.steps as u64, 1, 4096)?;
        whole("ppo.epochs", p.epochs as u64, 1, 100)?;
        whole("ppo.minibatch", p.minibatch as u64, 2, (p.environments * p.steps) as u64)?;
        range("ppo.clip", p.clip, 1e-3, 1.0)?;
        range("ppo.gamma", p.gamma.into(), 0.0, 1.0)?;
        range("ppo.lambda", p.lambda.into(), 0.0, 1.0)?;
        range("ppo.target_divergence", p.target_divergence, 1e-6, 10.0)?;
        range("ppo.learning_rate_bounds[0]", p.learning_rate_bounds[0], 1e-9, 1.0)?;
        range("ppo.learning_rate_bounds[1]", p.learning_rate_bounds[1], p.learning_rate_bounds[0], 1.0)?;
        range("ppo.learning_rate", p.learning_rate, p.learning_rate_bounds[0], p.learning_rate_bounds[1])?;
        range("ppo.critic_learning_rate", p.critic_learning_rate, 1e-9, 1.0)?;
        range("ppo.entropy", p.entropy, 0.0, 1.0)?;
        range("ppo.gradient_norm", p.gradient_norm, 1e-6, 1e6)?;
        range("ppo.std_bounds[0]", p.std_bounds[0], 1e-6, 100.0)?;
        range("ppo.std_bounds[1]", p.std_bounds[1], p.std_bounds[0], 100.0)?;
        range("ppo.initial_std", p.initial_std, p.std_bounds[0], p.std_bounds[1])?;
        let networks = [
            ("network.actor", &self.network.actor),
            ("network.critic", &self.network.critic),
            ("network.encoder", &self.network.encoder),
        ];
        for (key, layers) in networks {
            for width in layers {
                whole(key, *width as u64, 1, 1 << 16)?;
            }
        }
        range("episode.seconds", self.episode.seconds, 0.02, 1e5)?;
        range("episode.grace_seconds", self.episode.grace_seconds, 0.0, 1e3)?;
        range("starts.failure_share", self.starts.failure_share, 0.0, 1.0)?;
        range("starts.floor", self.starts.floor, 0.0, 1.0)?;
        range("starts.memory", self.starts.memory, 0.0, 1.0)?;
        let noises = [
            ("starts.joint_noise", self.starts.joint_noise),
            ("starts.velocity_noise", self.starts.velocity_noise),
            ("starts.path_noise", self.starts.path_noise),
            ("starts.heading_noise", self.starts.heading_noise),
        ];
        for (key, noise) in noises {
            range(key, noise.into(), 0.0, 10.0)?;
        }
        self.randomization.check()?;
        if let Some(terrain) = &self.terrain {
            range("terrain.size", terrain.size, 1.0, 1000.0)?;
            range("terrain.spacing", terrain.spacing, 0.01, terrain.size)?;
            range("terrain.amplitude", terrain.amplitude, 0.0, 10.0)?;
            range("terrain.wavelength", terrain.wavelength, 4.0 * terrain.spacing, 1000.0)?;
        }
        self.senses.check()?;
        self.curriculum.check()?;
        self.check_termination()?;
        self.check_inputs()
    }

    fn check_termination(&self) -> Result<(), LearnError> {
        let t = &self.termination;
        let limits = [
            ("termination.height", t.height),
            ("termination.tilt", t.tilt),
            ("termination.effector", t.effector),
            ("termination.path", t.path),
            ("termination.heading", t.heading),
            ("termination.persistent.distance", t.persistent.map(|p| p.distance)),
        ];
        for (key, limit) in limits {
            if let Some(limit) = limit {
                range(key, limit.into(), 1e-6, 1e3)?;
            }
        }
        if let Some(p) = t.persistent {
            range("termination.persistent.seconds", p.seconds, 0.0, 1e3)?;
        }
        Ok(())
    }

    fn check_inputs(&self) -> Result<(), LearnError> {
        for offset in &self.inputs.future {
            whole("inputs.future", u64::from(*offset), 1, 1000)?;
        }
        if let Some(offset) = self.inputs.window.iter().find(|o| o.unsigned_abs() > 1000) {
            return Err(wrong("inputs.window", "offsets from -1000 to 1000 policy steps", offset));
        }
        match (self.inputs.window.is_empty(), self.network.code) {
            (true, 1..) => Err(wrong("network.code", "0 without inputs.window", self.network.code)),
            (false, 0) => Err(wrong("network.code", "the size of the code of inputs.window", 0)),
            _ => Ok(()),
        }?;
        match (&self.prior, self.inputs.latent) {
            (None, 1..) => Err(wrong("inputs.latent", "0 without a prior", self.inputs.latent)),
            (Some(_), 0) => Err(wrong("inputs.latent", "the size of the prior's latent code", 0)),
            _ => Ok(()),
        }?;
        let scale = match self.action {
            ActionSpec::Absolute => 1.0,
            ActionSpec::DefaultPose { scale } | ActionSpec::Reference { scale } => scale,
        };
        range("action.scale", scale, 1e-6, 100.0)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn a_field_rises_from_level_ground_to_its_full_height() {
        let field = TerrainSpec { size: 20.0, ..TerrainSpec::default() }.build().unwrap();
        let highest = |from: f64, to: f64| {
            let columns = field.columns() as f64;
            let inside = |i: usize| {
                ((i % field.columns()) as f64 / columns) >= from && ((i % field.columns()) as f64 / columns) < to
            };
            let heights = field.heights().iter().enumerate().filter(|(i, _)| inside(*i));
            heights.map(|(_, h)| *h).fold(0.0, f64::max)
        };
        assert_eq!(highest(0.0, 0.25), 0.0);
        assert!((0.05..0.1).contains(&highest(0.45, 0.5)), "{}", highest(0.45, 0.5));
        assert!(highest(0.8, 1.0) > 0.13);
    }

    #[test]
    fn a_short_plan_has_the_defaults_and_comes_back_from_its_own_text() {
        let plan: TrackerPlan = toml::from_str("robot = \"lima\"\nclips = [\"a.motion.safetensors\"]").unwrap();
        assert_eq!(plan, TrackerPlan::new("lima", &["a.motion.safetensors".into()]));
        plan.check().unwrap();
        assert_eq!(toml::from_str::<TrackerPlan>(&toml::to_string_pretty(&plan).unwrap()).unwrap(), plan);
        // What is switched off stays off: the run's own plan is what it is resumed with.
        let off = TrackerPlan { termination: Termination { height: Some(0.5), ..Termination::NONE }, ..plan };
        assert_eq!(toml::from_str::<TrackerPlan>(&toml::to_string_pretty(&off).unwrap()).unwrap(), off);
    }

    #[test]
    fn the_plans_that_come_with_the_project_are_good() {
        for name in ["track", "track-20", "track-56", "track-walk", "track-thesis"] {
            let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../../experiments/{name}.toml"));
            TrackerPlan::read(&path).unwrap();
        }
    }

    #[test]
    fn unknown_keys_are_refused_at_every_level() {
        for text in ["robto = 1", "[ppo]\ngama = 0.9", "[reward]\nkind = \"thesis\"\nheigth = 1", "[starts]\nx = 1"] {
            let whole = format!("robot = \"lima\"\nclips = []\n{text}");
            assert!(toml::from_str::<TrackerPlan>(&whole).is_err(), "{text}");
        }
    }

    #[test]
    fn a_value_out_of_range_is_named_with_its_range() {
        let check = |change: &dyn Fn(&mut TrackerPlan)| {
            let mut plan = TrackerPlan::new("lima", &[]);
            change(&mut plan);
            plan.check().unwrap_err().to_string()
        };
        let gamma = check(&|p| p.ppo.gamma = 1.5);
        assert!(gamma.contains("ppo.gamma") && gamma.contains("0 to 1") && gamma.contains("1.5"), "{gamma}");
        assert!(check(&|p| p.ppo.minibatch = 1_000_000).contains("2 to 3072"));
        assert!(check(&|p| p.inputs.latent = 64).contains("0 without a prior"));
        assert!(check(&|p| p.ppo.learning_rate = f64::NAN).contains("NaN"));
        assert!(check(&|p| p.termination.tilt = Some(-1.0)).contains("termination.tilt"));
    }
}
