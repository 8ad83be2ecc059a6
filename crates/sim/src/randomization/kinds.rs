//! Kinds of randomisation: their ranges, how they shrink, how they are drawn.

use lifelike_robot::Robot;
use rand::Rng;

use super::pushes::PushSpec;
use crate::batch::EnvironmentParameters;
use crate::error::SimError;

/// Number of values that a robot needs.
type Count = fn(&Robot) -> usize;

/// Destination of drawn values.
type Assign = fn(&mut EnvironmentParameters, Vec<f32>);

/// Meaning of the value `V` of a key in a plan.
pub(super) trait Kind<V> {
    /// Puts unit and range of the value into the schema of its key.
    fn declare(&self, key: &mut schemars::Schema);

    /// Refuses a value out of range, naming its key.
    fn check(&self, name: &str, value: &V) -> Result<(), SimError>;

    /// The value with its deviation from the model shrunk to a share.
    fn scaled(&self, value: &V, share: f64) -> V;

    /// Draws and assigns; what does not differ draws nothing.
    fn sample(&self, value: &V, robot: &Robot, rng: &mut impl Rng, parameters: &mut EnvironmentParameters);
}

/// Bodies of a robot, the world included.
pub(super) fn bodies(robot: &Robot) -> usize {
    robot.character.bodies.len()
}

/// Scalar joints of a robot.
pub(super) fn joints(robot: &Robot) -> usize {
    robot.joints()
}

pub(super) fn refused<T>(name: &str, expected: &str, got: &dyn std::fmt::Debug) -> Result<T, SimError> {
    Err(SimError::State { expected: format!("randomization.{name} {expected}"), got: format!("{got:?}") })
}

/// Two finite numbers in order, none below a bound.
pub(super) fn ordered([low, high]: [f64; 2], bound: f64) -> bool {
    low.is_finite() && high.is_finite() && bound <= low && low <= high
}

/// Values within a distance of the model's own.
pub(super) struct Deviation {
    /// The value that changes nothing.
    center: f64,
    /// The greatest distance, and its unit; `None`: a factor, for which it is 1, excluded.
    limit: Option<(f64, &'static str)>,
    count: Count,
    assign: Assign,
}

impl Deviation {
    /// Factors about one.
    pub fn factor(count: Count, assign: Assign) -> Self {
        Self { center: 1.0, limit: None, count, assign }
    }

    /// Offsets about zero of at most `limit`.
    pub fn offset(limit: f64, unit: &'static str, count: Count, assign: Assign) -> Self {
        Self { center: 0.0, limit: Some((limit, unit)), count, assign }
    }
}

impl Kind<f64> for Deviation {
    fn declare(&self, key: &mut schemars::Schema) {
        let (limit, unit, most) = match self.limit {
            None => (1.0, "1", "exclusiveMaximum"),
            Some((limit, unit)) => (limit, unit, "maximum"),
        };
        key.insert("unit".into(), unit.into());
        key.insert("minimum".into(), 0.0.into());
        key.insert(most.into(), limit.into());
    }

    fn check(&self, name: &str, value: &f64) -> Result<(), SimError> {
        match self.limit {
            None if !(0.0..1.0).contains(value) => refused(name, "from 0 to below 1", value),
            Some((limit, unit)) if !(0.0..=limit).contains(value) => {
                refused(name, &format!("from 0 to {limit} {unit}"), value)
            }
            _ => Ok(()),
        }
    }

    fn scaled(&self, value: &f64, share: f64) -> f64 {
        share * value
    }

    fn sample(&self, value: &f64, robot: &Robot, rng: &mut impl Rng, parameters: &mut EnvironmentParameters) {
        if *value > 0.0 {
            let draw = |_| (self.center + value * rng.random_range(-1.0..=1.0)) as f32;
            (self.assign)(parameters, (0..(self.count)(robot)).map(draw).collect());
        }
    }
}

/// Least friction.
const LEAST_FRICTION: f64 = 1e-3;

/// Frictions from a range.
pub(super) struct FrictionRange(pub Count, pub Assign);

impl Kind<Option<[f64; 2]>> for FrictionRange {
    fn declare(&self, key: &mut schemars::Schema) {
        key.insert("unit".into(), "1".into());
        if let Some(items) = key.get_mut("items") {
            items["minimum"] = LEAST_FRICTION.into();
        }
    }

    fn check(&self, name: &str, value: &Option<[f64; 2]>) -> Result<(), SimError> {
        match value {
            Some(range) if !ordered(*range, LEAST_FRICTION) => {
                refused(name, "as [least, greatest], at least 0.001", range)
            }
            _ => Ok(()),
        }
    }

    fn scaled(&self, value: &Option<[f64; 2]>, share: f64) -> Option<[f64; 2]> {
        value.map(|[low, high]| [high + share * (low - high), high]).filter(|_| share > 0.0)
    }

    fn sample(
        &self,
        value: &Option<[f64; 2]>,
        robot: &Robot,
        rng: &mut impl Rng,
        parameters: &mut EnvironmentParameters,
    ) {
        if let Some([low, high]) = *value {
            let draw = |_| rng.random_range(low..=high) as f32;
            (self.1)(parameters, (0..(self.0)(robot)).map(draw).collect());
        }
    }
}

/// Pushes: drawn step by step ([`super::PushSchedule`]), not with the parameters.
pub(super) struct Pushes;

impl Kind<Option<PushSpec>> for Pushes {
    /// [`PushSpec`] declares its own.
    fn declare(&self, _: &mut schemars::Schema) {}

    fn check(&self, name: &str, value: &Option<PushSpec>) -> Result<(), SimError> {
        let Some(pushes) = value else { return Ok(()) };
        for (key, range) in [("duration", pushes.duration), ("interval", pushes.interval)] {
            if !ordered(range, 0.0) {
                return refused(&format!("{name}.{key}"), "as [least, greatest] (s)", &range);
            }
        }
        for (key, value) in [("force", pushes.force), ("torque", pushes.torque)] {
            if !(value.is_finite() && value >= 0.0) {
                return refused(&format!("{name}.{key}"), "of at least 0", &value);
            }
        }
        Ok(())
    }

    fn scaled(&self, value: &Option<PushSpec>, share: f64) -> Option<PushSpec> {
        let pushes = value.clone().filter(|_| share > 0.0);
        pushes.map(|p| PushSpec { force: share * p.force, torque: share * p.torque, ..p })
    }

    fn sample(&self, _: &Option<PushSpec>, _: &Robot, _: &mut impl Rng, _: &mut EnvironmentParameters) {}
}
