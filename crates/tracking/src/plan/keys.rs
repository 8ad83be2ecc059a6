//! The table of plan keys: key, unit, default and meaning of every value of a [`TrackerPlan`].
//!
//! Defaults are those of the serialized default plan. Keys of the reward, of terminations and of randomisation come
//! from their declarations. The others stand in the list below, and a test compares it with the keys that a plan has.

use lifelike_sim::randomization::RandomizationSpec;
use toml::{Table, Value};

use super::{ScalingSpec, TrackerPlan};

/// One key of a plan.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PlanKey {
    /// Dotted path, as on the command line.
    pub key: String,
    /// Unit; empty where there is none.
    pub unit: String,
    /// Default, as TOML; `-` where the key is required, off or absent by default.
    pub default: String,
    /// Meaning.
    pub meaning: String,
}

/// Returns all keys of a plan, in the order of its tables.
///
/// # Errors
/// The default plan cannot be serialized.
pub fn keys() -> Result<Vec<PlanKey>, toml::ser::Error> {
    let defaults = Table::try_from(TrackerPlan::new("", &[]))?;
    let row = |key: String, unit: String, meaning: String| PlanKey {
        default: default(&defaults, &key).unwrap_or_else(|| "-".into()),
        key,
        unit,
        meaning,
    };
    let listed = |keys: &[(&str, &str, &str)]| -> Vec<PlanKey> {
        keys.iter().map(|(key, unit, meaning)| row((*key).into(), (*unit).into(), (*meaning).into())).collect()
    };
    let mut rows = listed(TRAINING);
    rows.extend(listed(ScalingSpec::KEYS));
    rows.extend(listed(INPUTS));
    rows.extend(crate::rewards::keys().into_iter().map(|(key, unit, meaning)| row(key, unit, meaning)));
    let terminations = crate::terminations::keys();
    rows.extend(terminations.into_iter().map(|(key, unit, meaning)| row(key, unit.into(), meaning)));
    rows.extend(listed(ENVIRONMENT));
    let differences = RandomizationSpec::keys().into_iter();
    rows.extend(differences.map(|(key, unit, meaning)| row(format!("randomization.{key}"), unit.into(), meaning)));
    rows.extend(listed(SURROUNDINGS));
    rows.extend(listed(LEARNING));
    Ok(rows)
}

/// Returns the default of a key: none where it has none or must be given.
fn default(defaults: &Table, key: &str) -> Option<String> {
    if ["robot", "clips"].contains(&key) {
        return None;
    }
    let (path, last) = key.rsplit_once('.').map_or((None, key), |(path, last)| (Some(path), last));
    let table = path.into_iter().flat_map(|path| path.split('.')).try_fold(defaults, |t, k| t.get(k)?.as_table())?;
    table.get(last).filter(|value| !value.is_table()).map(text)
}

/// Returns a value as a plan would give it: single precision has no more than its own digits.
fn text(value: &Value) -> String {
    match value {
        Value::Float(x) if *x == f64::from(*x as f32) => format!("{:?}", *x as f32),
        Value::Array(items) => format!("[{}]", items.iter().map(text).collect::<Vec<_>>().join(", ")),
        other => other.to_string(),
    }
}

const TRAINING: &[(&str, &str, &str)] = &[
    ("robot", "", "built-in robot by name, or the path of an MJCF or URDF file (required)"),
    (
        "clips",
        "",
        "*.motion.safetensors files, folders of them or patterns (required); [] is standing in the default pose",
    ),
    ("mirror", "", "learn from the mirror image of every clip too, by the robot's own symmetry"),
    ("prior", "", "motion prior (file or run) whose latent codes the policy sees; see inputs.latent"),
    ("init", "", "networks to begin with: a name, the folder of a run, or a controller's file"),
    (
        "teachers",
        "",
        "policies to learn from instead of from rewards (DAgger): [{ policy = FILE or run, clips = [names or patterns] }]",
    ),
    ("seed", "", "seed of everything random"),
    ("budget.steps", "steps", "environment steps over all environments after which the training ends"),
    (
        "budget.minutes",
        "min",
        "wall time of the whole run after which it ends, earlier parts of a resumed run included",
    ),
    ("checkpoint_every", "iterations", "iterations between checkpoints"),
];

const INPUTS: &[(&str, &str, &str)] = &[
    ("inputs.frame", "", "the policy sees the reference frame to reach, m_{t+1} (input M of Table 4.3)"),
    (
        "inputs.future",
        "policy steps",
        "frames further ahead that it sees, as offsets from t (inputs M5, M10 of Table 4.3)",
    ),
    ("inputs.latent", "", "size of the prior's latent code z_t (input L of Table 4.3); 0 without a prior"),
    (
        "inputs.window",
        "policy steps",
        "frames around t+1 that an encoder trained with the policy sees, as offsets from it",
    ),
    ("inputs.parts", "", "further parts of the observation that it sees, by name"),
    ("inputs.terms", "", "the whole observation by its parts, in order: the layout of another stack"),
    (
        "inputs.anchor_body",
        "",
        "body whose pose the anchor's terms compare with the reference's; the root where not said",
    ),
    ("linear_velocity", "", "the policy sees the root's linear velocity, which few robots can measure"),
    ("anchor.heading", "", "the policy sees the reference's heading against its own"),
    ("anchor.position", "", "the policy sees the reference's place on the ground against its own"),
    (
        "action.base",
        "",
        "base of joint targets: \"absolute\" (thesis), \"default_pose\", \"reference\", or \"unclamped\"",
    ),
    ("action.scale", "rad", "offset of a joint target for an output of 1; not with \"absolute\""),
];

const ENVIRONMENT: &[(&str, &str, &str)] = &[
    ("episode.seconds", "s", "longest episode"),
    (
        "episode.switch_clips",
        "",
        "at the end of a clip go on with another (thesis 4.2.2); else the episode is truncated",
    ),
    ("episode.reanchor", "", "reference re-anchoring: the reference's path follows a robot that leaves it"),
    ("episode.grace_seconds", "s", "time after a switch of clips in which errors do not end the episode"),
    ("rsi.failure_share", "1", "share of beginnings drawn by failure rate; the rest is uniform over all frames"),
    ("rsi.floor", "1", "smallest failure rate that counts, so that no segment is forgotten"),
    ("rsi.memory", "1", "weight of past iterations in the failure statistics"),
    ("rsi.joint_noise", "rad", "standard deviation of the noise on joint positions at the beginning"),
    ("rsi.velocity_noise", "m/s, rad/s", "standard deviation of the noise on the root's velocities at the beginning"),
    ("rsi.path_noise", "m", "standard deviation of the offset from the reference on the ground at the beginning"),
    ("rsi.heading_noise", "rad", "standard deviation of the heading offset from the reference at the beginning"),
    ("rsi.random_start_share", "1", "share of episodes that begin in the state of another frame than the one followed"),
    (
        "rsi.fallen_share",
        "1",
        "share of episodes that begin between the followed frame and lying anyhow on the ground: for learning to get up",
    ),
];

const SURROUNDINGS: &[(&str, &str, &str)] = &[
    ("terrain.size", "m", "length of a side of a field of hills; without [terrain] the ground is level"),
    ("terrain.spacing", "m", "distance between neighbouring heights"),
    ("terrain.amplitude", "m", "height of the hills at the high end"),
    ("terrain.wavelength", "m", "longest wavelength of the hills"),
    ("terrain.seed", "", "seed of the field"),
    ("sensors.orientation_noise", "rad", "standard deviation of the noise on the root's orientation"),
    ("sensors.linear_velocity_noise", "m/s", "standard deviation of the noise on the root's linear velocity"),
    ("sensors.angular_velocity_noise", "rad/s", "standard deviation of the noise on the root's angular velocity"),
    ("sensors.joint_position_noise", "rad", "standard deviation of the noise on joint positions"),
    ("sensors.joint_velocity_noise", "rad/s", "standard deviation of the noise on joint velocities"),
    ("sensors.observation_delay", "policy steps", "greatest delay of measurements; each episode draws its own"),
    ("sensors.action_delay", "policy steps", "greatest delay of joint targets; each episode draws its own"),
    ("curriculum.randomization.from", "1", "share of [randomization] in force until .begin"),
    ("curriculum.randomization.to", "1", "share of [randomization] in force after .end (1 where not given)"),
    (
        "curriculum.randomization.begin",
        "steps",
        "environment steps at which the share begins to move (0 where not given)",
    ),
    ("curriculum.randomization.end", "steps", "environment steps at which it arrives"),
    ("curriculum.termination.from", "1", "factor on the limits of [termination] until .begin; above 1 is forgiving"),
    ("curriculum.termination.to", "1", "factor on the limits of [termination] after .end (1 where not given)"),
    (
        "curriculum.termination.begin",
        "steps",
        "environment steps at which the factor begins to move (0 where not given)",
    ),
    ("curriculum.termination.end", "steps", "environment steps at which it arrives"),
    ("curriculum.smoothness.from", "1", "factor on the reward's penalties of actions and torques until .begin"),
    ("curriculum.smoothness.to", "1", "factor on these penalties after .end (1 where not given)"),
    (
        "curriculum.smoothness.begin",
        "steps",
        "environment steps at which the factor begins to move (0 where not given)",
    ),
    ("curriculum.smoothness.end", "steps", "environment steps at which it arrives"),
];

const LEARNING: &[(&str, &str, &str)] = &[
    ("network.actor", "", "hidden layers of the policy"),
    ("network.critic", "", "hidden layers of the value function"),
    ("network.encoder", "", "hidden layers of an encoder of inputs.window that is trained with the policy"),
    ("network.code", "", "size of that encoder's code; 0 without inputs.window"),
    ("ppo.environments", "", "environments of each process"),
    ("ppo.steps", "policy steps", "steps of each environment per iteration"),
    ("ppo.epochs", "", "passes over the rollout"),
    ("ppo.minibatch", "samples", "samples per gradient step, at most environments · steps"),
    ("ppo.clip", "1", "clip range ε of the surrogate"),
    ("ppo.gamma", "1", "discount γ"),
    ("ppo.lambda", "1", "λ of generalized advantage estimation"),
    ("ppo.target_divergence", "nat", "KL divergence per iteration that the learning rate is steered to"),
    ("ppo.learning_rate", "1", "first learning rate of the policy"),
    ("ppo.learning_rate_bounds", "1", "[least, greatest] learning rate of the policy"),
    ("ppo.critic_learning_rate", "1", "learning rate of the value function; constant"),
    ("ppo.overlap", "", "collect the next rollout while the last one is learned from"),
    ("ppo.entropy", "1", "weight of the policy's entropy"),
    (
        "ppo.averaging",
        "1",
        "share of the iterations so far over which the policy that is written is averaged; 0: the last one as it is",
    ),
    ("ppo.gradient_norm", "1", "largest norm of each network's gradient"),
    ("ppo.initial_std", "1", "standard deviation of the first policy, in units of its output"),
    ("ppo.std_bounds", "1", "[least, greatest] standard deviation of the policy"),
];

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use std::collections::BTreeSet;

    use super::*;
    use crate::plan::{Curriculum, NetworkSpec, Ramp, TeacherSpec, Termination, TerrainSpec};
    use crate::rewards::{Floors, Reward, ThesisReward};
    use lifelike_sim::randomization::PushSpec;

    /// A plan with every optional value.
    fn whole() -> TrackerPlan {
        let ramp = Some(Ramp { from: 0.0, to: 1.0, begin: 0, end: 1 });
        let mut plan = TrackerPlan::new("lima", &["a".into()]);
        (plan.prior, plan.init, plan.budget.minutes) = (Some("p".into()), Some("i".into()), Some(1.0));
        plan.teachers = vec![TeacherSpec { policy: "p".into(), clips: Vec::new() }];
        (plan.inputs.window, plan.inputs.parts) = (vec![1], vec!["a".into()]);
        (plan.inputs.terms, plan.inputs.anchor_body) = (vec!["a".into()], "a".into());
        plan.network = NetworkSpec { encoder: vec![8], code: 4, ..plan.network };
        plan.terrain = Some(TerrainSpec::default());
        plan.curriculum = Curriculum { randomization: ramp, termination: ramp, smoothness: ramp };
        let frictions = Some([0.5, 1.0]);
        plan.randomization = RandomizationSpec {
            ground_friction: frictions,
            foot_friction: frictions,
            pushes: Some(PushSpec::default()),
            ..RandomizationSpec::default()
        };
        plan.termination = termination();
        plan
    }

    /// Every rule with a limit: a plan that names them all by their declared keys.
    fn termination() -> Termination {
        let key = |key: &str| key.strip_prefix("termination.").unwrap().to_string();
        let text: String = crate::terminations::keys().iter().map(|(k, ..)| format!("{} = 1.0\n", key(k))).collect();
        toml::from_str(&text).unwrap()
    }

    fn thesis() -> Reward {
        let floors = Floors { height: 0.0, velocity: 0.0, joint_position: 0.0, joint_velocity: 0.0, effectors: 0.0 };
        let text = crate::rewards::TERMS.iter().map(|term| format!("{} = 1.0\n", term.name)).collect::<String>();
        let text = format!("{text}scale = 1.0\nterm_limit = 1.0\nfloors = {}", toml::Value::try_from(floors).unwrap());
        Reward::Thesis(toml::from_str::<ThesisReward>(&text).unwrap())
    }

    fn leaves(prefix: &str, table: &Table, found: &mut BTreeSet<String>) {
        for (key, value) in table {
            let path = if prefix.is_empty() { key.clone() } else { format!("{prefix}.{key}") };
            match value {
                Value::Table(inner) => leaves(&path, inner, found),
                _ => drop(found.insert(path)),
            }
        }
    }

    #[test]
    fn every_key_of_a_plan_is_in_the_table_once_and_nothing_else_is() {
        let mut expected = BTreeSet::new();
        for plan in [whole(), TrackerPlan { reward: thesis(), ..whole() }] {
            leaves("", &Table::try_from(plan).unwrap(), &mut expected);
        }
        let rows = keys().unwrap();
        let listed: BTreeSet<String> = rows.iter().map(|row| row.key.clone()).collect();
        let missing: Vec<_> = expected.difference(&listed).collect();
        let superfluous: Vec<_> = listed.difference(&expected).collect();
        assert!(missing.is_empty() && superfluous.is_empty(), "missing {missing:?}, superfluous {superfluous:?}");
        assert_eq!(rows.len(), listed.len(), "each key stands once");
        assert!(rows.iter().all(|row| !row.meaning.is_empty()));
    }

    #[test]
    fn defaults_are_those_of_the_plan() {
        let rows = keys().unwrap();
        let default = |key: &str| rows.iter().find(|row| row.key == key).unwrap().default.clone();
        assert_eq!(default("ppo.gamma"), "0.97");
        assert_eq!(default("ppo.learning_rate_bounds"), "[0.00002, 0.003]");
        assert_eq!(default("reward.kind"), "\"exponential\"");
        assert_eq!((default("reward.path.sharpness"), default("reward.path")), ("20.0".into(), "-".into()));
        assert_eq!((default("termination.height"), default("termination.path")), ("0.12".into(), "false".into()));
        assert_eq!((default("robot"), default("terrain.size")), ("-".into(), "-".into()));
    }
}
