//! Dynamic similarity: the numbers of a plan, written for a robot of one size, for a robot of another.
//!
//! Robots of the same shape move alike when lengths go with the leg ℓ, times with √(ℓ/g) and forces with the weight.
//! Sources are Alexander and Jayes 1983, and Hof 1996, "Scaling gait data to body size". The table of plan keys has
//! the unit of every number, and the unit says how the number goes with size. A new reward or limit is scaled by being
//! declared. Penalties, which are sums over joints, count for as many joints as the plan was written for. Properties
//! of the world and the sensors (terrain, noise) and choices (lengths of episodes, budgets) stay.

use lifelike_robot::Robot;
use lifelike_train::plan::keys;
use toml::{Table, Value};

use super::TrackerPlan;
use crate::rewards::TERMS;
use crate::{FromInput, TrackerError};

/// Tables of a plan whose numbers go with the robot's size.
const TABLES: [&str; 4] = ["reward", "termination", "rsi", "randomization"];

/// The robot for which a plan's numbers were chosen; they are scaled from it to the plan's robot.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ScalingSpec {
    /// Scaling of `[reward]`, `[termination]`, `[rsi]` and `[randomization]` to the robot, each number by its unit.
    pub enabled: bool,
    /// Length of the stretched leg, hip to ankle, of the robot that the numbers were chosen for (m).
    #[schemars(extend("unit" = "m"), range(min = 1e-3, max = 1e3))]
    pub leg: f64,
    /// Mass of that robot (kg).
    #[schemars(extend("unit" = "kg"), range(min = 1e-3, max = 1e6))]
    pub mass: f64,
    /// Number of its joints, over which penalties are sums.
    #[schemars(extend("unit" = "1"), range(min = 1, max = 10_000))]
    pub joints: usize,
}

impl ScalingSpec {
    /// Returns what the plan's numbers are multiplied with for a robot.
    pub fn factors(&self, robot: &Robot) -> Factors {
        match robot.leg_length() {
            Some(leg) if self.enabled => Factors {
                length: leg / self.leg,
                force: robot.character.mass() / self.mass,
                joints: self.joints as f64 / robot.joints().max(1) as f64,
            },
            _ => Factors::ONE,
        }
    }
}

impl Default for ScalingSpec {
    fn default() -> Self {
        Self { enabled: true, leg: 0.4, mass: 16.2, joints: 20 }
    }
}

/// Sizes of one robot against those of another, both on Earth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Factors {
    /// Factor on lengths.
    pub length: f64,
    /// Factor on forces.
    pub force: f64,
    /// Factor on sums over joints.
    pub joints: f64,
}

impl Factors {
    /// Nothing changes.
    pub const ONE: Self = Self { length: 1.0, force: 1.0, joints: 1.0 };

    /// True where nothing changes, up to the rounding of the two sizes.
    pub fn are_one(&self) -> bool {
        [self.length, self.force, self.joints].iter().all(|factor| (factor - 1.0).abs() < 1e-6)
    }

    /// Returns the factor on a number of this unit; 1 for one that stands for several units at once.
    ///
    /// ```
    /// use lifelike_tracking::plan::scaling::Factors;
    /// let twice = Factors { length: 2.0, force: 8.0, joints: 1.0 };
    /// assert_eq!(twice.of("1/m²"), Some(0.25));
    /// assert_eq!(twice.of("N m"), Some(16.0));
    /// assert_eq!(twice.of("furlong"), None);
    /// ```
    pub fn of(&self, unit: &str) -> Option<f64> {
        if unit.contains(',') {
            return Some(1.0);
        }
        if let Some(below) = unit.strip_prefix("1/") {
            return Some(1.0 / self.of(below.trim_start_matches('(').trim_end_matches(')'))?);
        }
        let (above, below) = unit.split_once('/').unwrap_or((unit, ""));
        Some(self.product(above)? / self.product(below)?)
    }

    fn product(&self, unit: &str) -> Option<f64> {
        unit.split([' ', '·']).filter(|word| !word.is_empty()).try_fold(1.0, |product, word| {
            let (symbol, power) = word.strip_suffix('²').map_or((word, 1), |symbol| (symbol, 2));
            let factor: f64 = match symbol {
                "m" => self.length,
                "s" => self.length.sqrt(),
                "N" => self.force,
                // Multiples of the robot's own weight have the size in them already.
                "rad" | "1" | "weight" => 1.0,
                _ => return None,
            };
            Some(product * factor.powi(power))
        })
    }
}

impl TrackerPlan {
    /// Returns the plan with its numbers for a robot of that size: what holds in the environments.
    ///
    /// # Errors
    /// [`TrackerError::Input`] where the plan cannot be written or read again.
    pub fn scaled_to(&self, robot: &Robot) -> Result<Self, TrackerError> {
        let factors = self.scaling.factors(robot);
        if factors.are_one() {
            return Ok(self.clone());
        }
        let unreadable = |got: String| {
            TrackerError::format("plan", format!("numbers that can be scaled to robot '{}'", robot.name), got)
        };
        let mut table = Table::try_from(self).map_err(|e| unreadable(e.to_string()))?;
        for key in keys::<Self>() {
            let path: Vec<&str> = key.key.split('.').collect();
            if !TABLES.contains(&path[0]) || !key.number {
                continue;
            }
            let sum = path[0] == "reward" && TERMS.iter().any(|term| term.penalty && path[1] == term.name);
            let Some(factor) = factors.of(&key.unit) else { continue };
            if let Some(value) = at(&mut table, &path) {
                multiply(value, factor * if sum { factors.joints } else { 1.0 });
            }
        }
        let plan: Self = table.try_into().map_err(|e: toml::de::Error| unreadable(e.to_string()))?;
        plan.check()?;
        Ok(plan)
    }
}

/// Returns the value at a path, if the plan has it.
fn at<'a>(table: &'a mut Table, path: &[&str]) -> Option<&'a mut Value> {
    let (first, rest) = path.split_first()?;
    let value = table.get_mut(*first)?;
    if rest.is_empty() { Some(value) } else { at(value.as_table_mut()?, rest) }
}

fn multiply(value: &mut Value, factor: f64) {
    match value {
        Value::Float(x) => *x *= factor,
        Value::Array(items) => items.iter_mut().for_each(|item| multiply(item, factor)),
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::rewards::{ExponentialReward, Reward};
    use crate::terminations::{Persistent, Termination};
    use lifelike_sim::randomization::PushSpec;

    const TWICE: Factors = Factors { length: 4.0, force: 64.0, joints: 0.5 };

    #[test]
    fn every_unit_of_the_scaled_tables_is_known() {
        for key in keys::<TrackerPlan>() {
            if key.number && TABLES.iter().any(|table| key.key.starts_with(&format!("{table}."))) {
                assert!(TWICE.of(&key.unit).is_some(), "{}: '{}'", key.key, key.unit);
            }
        }
    }

    #[test]
    fn units_go_as_dynamic_similarity_says() {
        let of = |unit| TWICE.of(unit).unwrap();
        // Twice as fast on four times the length: time 2, speed 2, angular velocity 1/2.
        assert_eq!((of("m"), of("s"), of("1/(m²/s²)"), of("rad/s")), (4.0, 2.0, 0.25, 0.5));
        assert_eq!((of("1/(N² m²)"), of("weight · m"), of("m/s, rad/s"), of("")), (1.0 / 65536.0, 4.0, 1.0, 1.0));
    }

    #[test]
    fn the_humanoid_has_lengths_torques_and_penalties_of_its_own_size() {
        let robot = Robot::load("humanoid").unwrap();
        let mut plan = TrackerPlan::new("humanoid", &[]);
        plan.termination.persistent = Some(Persistent { distance: 0.3, seconds: 1.0 });
        plan.randomization.pushes = Some(PushSpec::default());
        let scaled = plan.scaled_to(&robot).unwrap();
        let (length, weight) = (robot.leg_length().unwrap() / 0.4, 75.0 / 16.2);
        let close =
            |got: f32, expected: f64| assert!((f64::from(got) / expected - 1.0).abs() < 1e-5, "{got} {expected}");
        let Reward::Exponential(reward) = scaled.reward else { panic!("another form") };
        close(reward.path.sharpness, 20.0 / (length * length));
        close(reward.velocity.sharpness, 4.0 / length);
        close(reward.joint_velocity.sharpness, 0.8 * length);
        close(reward.angular_share, 0.0375 * length * length);
        close(reward.torque, 1e-5 / (weight * length).powi(2) * 20.0 / 36.0);
        close(reward.action_rate, 0.05 * 20.0 / 36.0);
        let kept = ExponentialReward::default();
        assert_eq!((reward.height.weight, reward.heading), (kept.height.weight, kept.heading));
        close(scaled.termination.height.unwrap(), 0.12 * length);
        assert_eq!(scaled.termination.tilt, Termination::default().tilt);
        close(scaled.termination.persistent.unwrap().seconds as f32, length.sqrt());
        close(scaled.rsi.path_noise, 0.03 * length);
        let (pushes, own) = (scaled.randomization.pushes.unwrap(), PushSpec::default());
        assert_eq!(pushes.force, own.force);
        assert!((pushes.torque / own.torque - length).abs() < 1e-12);
        assert!((pushes.interval[1] / own.interval[1] - length.sqrt()).abs() < 1e-12);
        let (episode, sensors) = (scaled.episode, scaled.sensors);
        assert_eq!((episode, sensors), (plan.episode, plan.sensors));
    }

    #[test]
    fn numbers_stay_for_the_robot_that_they_were_chosen_for_and_where_scaling_is_off() {
        let (lima, humanoid) = (Robot::load("lima").unwrap(), Robot::load("humanoid").unwrap());
        let mut plan = TrackerPlan::new("lima", &[]);
        assert_eq!(plan.scaled_to(&lima).unwrap(), plan);
        plan.scaling.enabled = false;
        assert_eq!(plan.scaled_to(&humanoid).unwrap(), plan);
    }
}
