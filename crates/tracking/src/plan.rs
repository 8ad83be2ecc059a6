//! The plan of a training: typed, checked, saved with the run.

pub mod curriculum;
pub mod scaling;
pub mod sensors;
mod teachers;
pub mod terrain;

use std::path::{Path, PathBuf};

use lifelike_robot::ActionSpec;
use lifelike_robot::observation::{AnchorSpec, ReferenceSpec};
use lifelike_sim::randomization::RandomizationSpec;

pub use self::curriculum::{Curriculum, Ramp};
pub use self::scaling::ScalingSpec;
pub use self::sensors::SensorSpec;
pub use self::teachers::TeacherSpec;
pub(crate) use self::teachers::teachers_of;
pub use self::terrain::TerrainSpec;
pub use crate::reference::RsiSpec;
use crate::rewards::Reward;
pub use crate::terminations::{Persistent, Termination};
use crate::{FromInput, TrackerError};
use lifelike_train::limits::wrong;
use lifelike_train::plan;
pub use lifelike_train::ppo::{NetworkSpec, PpoSpec};

/// A tracker's training, as text. Everything but `robot` and `clips` has a default: the recipe that learns fastest.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TrackerPlan {
    /// Robot: a built-in name, or an MJCF or URDF file.
    pub robot: String,
    /// Clips to learn from: files, folders or patterns; none: the robot stands in its default pose.
    pub clips: Vec<PathBuf>,
    /// Learning from the mirror image of every clip too, by the robot's own symmetry.
    #[serde(default)]
    pub mirror: bool,
    /// Motion prior (file or run) whose latent codes the policy sees; its size is `inputs.latent`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub prior: Option<PathBuf>,
    /// Networks to begin with: a name, the folder of a run, or a controller's file.
    ///
    /// Policy, value function and normalization of their inputs are taken. Optimizers and learning rates begin anew.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub init: Option<PathBuf>,
    /// Policies to imitate instead of maximizing rewards (DAgger, Ross et al. 2011).
    ///
    /// The policy acts and learns the teachers' actions. The value function learns from rewards all the same, for a
    /// training that begins with the result (`init`).
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub teachers: Vec<TeacherSpec>,
    /// Seed of everything random.
    #[serde(default)]
    #[schemars(extend("unit" = "1"))]
    pub seed: u64,
    /// Limits of steps and time.
    #[serde(default)]
    pub budget: Budget,
    /// Iterations between checkpoints.
    #[serde(default = "fifty")]
    #[schemars(extend("unit" = "iterations"), range(min = 1))]
    pub checkpoint_every: u64,
    /// Robot for which the plan's numbers were chosen; they are scaled from it to the plan's robot.
    #[serde(default)]
    pub scaling: ScalingSpec,
    /// The policy's inputs from the reference.
    #[serde(default = "default_inputs")]
    pub inputs: ReferenceSpec,
    /// The policy sees the root's linear velocity, which few robots can measure.
    ///
    /// Robots that cannot measure it cannot measure `anchor.position` either.
    #[serde(default = "yes")]
    pub linear_velocity: bool,
    /// Inputs about the robot's place on the reference's path.
    #[serde(default = "default_anchor")]
    pub anchor: AnchorSpec,
    /// Meaning of the policy's outputs.
    #[serde(default = "default_action")]
    pub action: ActionSpec,
    /// The reward.
    #[serde(default)]
    pub reward: Reward,
    /// The rules by which an episode fails.
    #[serde(default)]
    pub termination: Termination,
    /// Length of an episode.
    #[serde(default)]
    pub episode: EpisodeSpec,
    /// Reference-state initialization: the states in which episodes begin.
    #[serde(default)]
    pub rsi: RsiSpec,
    /// Differences of the environments from the model and from each other.
    #[serde(default = "RandomizationSpec::none")]
    pub randomization: RandomizationSpec,
    /// Uneven ground; none: level ground.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub terrain: Option<TerrainSpec>,
    /// Noise and delays between robot and policy.
    #[serde(default)]
    pub sensors: SensorSpec,
    /// Difficulties that grow while the policy learns.
    #[serde(default)]
    pub curriculum: Curriculum,
    /// The networks.
    #[serde(default)]
    pub network: NetworkSpec,
    /// The algorithm.
    #[serde(default)]
    pub ppo: PpoSpec,
}

/// Limits of a training, which stops at whichever comes first.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Budget {
    /// Environment steps over all environments after which the training ends.
    #[schemars(extend("unit" = "steps"), range(min = 1))]
    pub steps: u64,
    /// Wall time after which the training ends, earlier parts of a resumed run included.
    ///
    /// A run that stops by the clock ends at another step each time.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("unit" = "min"), range(min = 0.0, max = 1e6))]
    pub minutes: Option<f64>,
}

impl Default for Budget {
    fn default() -> Self {
        Self { steps: 2_000_000, minutes: None }
    }
}

/// Length of an episode, and its course at the end of a clip.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct EpisodeSpec {
    /// Longest episode T (s).
    #[schemars(extend("unit" = "s"), range(min = 0.02, max = 1e5))]
    pub seconds: f64,
    /// Continuation with another clip at the end of a clip (thesis 4.2.2); otherwise the episode is truncated.
    pub switch_clips: bool,
    /// Reference re-anchoring: the reference's path follows a robot that leaves it.
    ///
    /// The limits are `ANCHOR_REACH` and `ANCHOR_TURN` of [`lifelike_robot::ObservationSpec`]. Errors stay where the
    /// policy sees them, without a reason to end the episode.
    pub reanchor: bool,
    /// Time after a switch of clips in which errors do not end the episode (s).
    #[schemars(extend("unit" = "s"), range(min = 0.0, max = 1e3))]
    pub grace_seconds: f64,
}

impl Default for EpisodeSpec {
    fn default() -> Self {
        Self { seconds: 10.0, switch_clips: false, reanchor: true, grace_seconds: 1.0 }
    }
}

fn yes() -> bool {
    true
}

fn fifty() -> u64 {
    50
}

fn default_inputs() -> ReferenceSpec {
    // Frames further ahead cost more samples than they save (docs/results/tracking-changes.md).
    ReferenceSpec { frame: true, ..ReferenceSpec::default() }
}

fn default_anchor() -> AnchorSpec {
    AnchorSpec { heading: true, position: true }
}

fn default_action() -> ActionSpec {
    ActionSpec::Reference { scale: 0.5 }
}

impl TrackerPlan {
    /// Returns the plan of the environment as a controller has it (TOML): without clips and networks, which are files of
    /// one machine, and without the budget.
    ///
    /// # Errors
    /// A number that TOML cannot hold.
    pub fn as_environment(&self, robot: &str) -> Result<String, toml::ser::Error> {
        let environment = Self {
            robot: robot.into(),
            clips: Vec::new(),
            prior: None,
            init: None,
            teachers: Vec::new(),
            budget: Budget::default(),
            checkpoint_every: fifty(),
            ..self.clone()
        };
        toml::to_string(&environment)
    }

    /// Returns a plan with every default.
    pub fn new(robot: &str, clips: &[PathBuf]) -> Self {
        Self {
            robot: robot.into(),
            clips: clips.to_vec(),
            mirror: false,
            prior: None,
            init: None,
            teachers: Vec::new(),
            seed: 0,
            budget: Budget::default(),
            checkpoint_every: fifty(),
            scaling: ScalingSpec::default(),
            inputs: default_inputs(),
            linear_velocity: true,
            anchor: default_anchor(),
            action: default_action(),
            reward: Reward::default(),
            termination: Termination::default(),
            episode: EpisodeSpec::default(),
            rsi: RsiSpec::default(),
            randomization: RandomizationSpec::none(),
            terrain: None,
            sensors: SensorSpec::default(),
            curriculum: Curriculum::default(),
            network: NetworkSpec::default(),
            ppo: PpoSpec::default(),
        }
    }

    /// Reads and checks a plan.
    ///
    /// # Errors
    /// [`TrackerError::Input`] with line and column, [`TrackerError::Plan`] for a value out of range.
    pub fn read(path: &Path) -> Result<Self, TrackerError> {
        let text = std::fs::read_to_string(path).map_err(TrackerError::io(path))?;
        let plan: Self =
            toml::from_str(&text).map_err(|e| TrackerError::format(path.display(), "a tracker plan", e))?;
        plan.check()?;
        Ok(plan)
    }

    /// Checks that every value is in its range.
    ///
    /// # Errors
    /// [`TrackerError::Plan`] with the key, the range and the value.
    pub fn check(&self) -> Result<(), TrackerError> {
        plan::check("", self)?;
        self.ppo.check()?;
        self.randomization.check()?;
        self.terrain.map_or(Ok(()), |terrain| terrain.check())?;
        self.curriculum.check()?;
        self.teachers.iter().try_for_each(TeacherSpec::check)?;
        self.check_inputs()
    }

    fn check_inputs(&self) -> Result<(), TrackerError> {
        match (self.inputs.window.is_empty(), self.network.code) {
            (true, 1..) => Err(wrong("network.code", "0 without inputs.window", self.network.code)),
            (false, 0) => Err(wrong("network.code", "the size of the code of inputs.window", 0)),
            (false, _) if self.inputs.history > 0 => {
                Err(wrong("inputs.history", "0 beside inputs.window", self.inputs.history))
            }
            _ => Ok(()),
        }?;
        if self.network.memory > 0 && self.inputs.history == 0 {
            return Err(wrong("network.memory", "0 without inputs.history", self.network.memory).into());
        }
        match (&self.prior, self.inputs.latent) {
            (None, 1..) => Err(wrong("inputs.latent", "0 without a prior", self.inputs.latent)),
            (Some(_), 0) => Err(wrong("inputs.latent", "the size of the prior's latent code", 0)),
            _ => Ok(()),
        }?;
        self.check_terms()
    }

    /// Checks that a layout by terms is the only one.
    fn check_terms(&self) -> Result<(), TrackerError> {
        let ReferenceSpec { future, latent, window, history, parts, terms, .. } = &self.inputs;
        let others = [
            ("inputs.future", !future.is_empty()),
            ("inputs.latent", *latent > 0),
            ("inputs.window", !window.is_empty()),
            ("inputs.history", *history > 0),
            ("inputs.parts", !parts.is_empty()),
        ];
        match others.into_iter().find(|(_, other)| *other && !terms.is_empty()) {
            Some((key, _)) => {
                Err(wrong(key, "none beside inputs.terms, which is the whole observation", "some").into())
            }
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

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
    fn a_reward_that_is_no_number_is_refused_by_its_key() {
        let check = |reward: &str| {
            let text = format!("robot = \"lima\"\nclips = []\n[reward]\nkind = \"exponential\"\n{reward}");
            toml::from_str::<TrackerPlan>(&text).unwrap().check().map_err(|error| error.to_string())
        };
        for (reward, key) in [
            ("slip = nan", "reward.slip"),
            ("slip = -inf", "reward.slip"),
            ("angular_share = nan", "reward.angular_share"),
            ("height = { weight = nan, sharpness = 150.0 }", "reward.height.weight"),
        ] {
            let error = check(reward).unwrap_err();
            assert!(error.contains(key) && error.contains("-1e6 to 1e6"), "{error}");
        }
        check("slip = 2.0").unwrap();
    }

    #[test]
    fn a_plan_may_name_a_few_terms_of_the_reward() {
        let text = "robot = \"lima\"\nclips = []\n[reward]\nkind = \"exponential\"\nslip = 2.0";
        let plan: TrackerPlan = toml::from_str(text).unwrap();
        let named = crate::rewards::ExponentialReward { slip: 2.0, ..Default::default() };
        assert_eq!(plan.reward, Reward::Exponential(named));
    }

    #[test]
    fn the_plans_that_come_with_the_project_are_good() {
        for name in
            ["track", "track-20", "track-56", "track-all", "track-long", "track-g1", "track-g1-long", "track-walk"]
        {
            let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../../experiments/{name}.toml"));
            TrackerPlan::read(&path).unwrap();
        }
    }

    #[test]
    fn unknown_keys_are_refused_at_every_level() {
        for text in ["robto = 1", "[ppo]\ngama = 0.9", "[reward]\nkind = \"thesis\"\nheigth = 1", "[rsi]\nx = 1"] {
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
