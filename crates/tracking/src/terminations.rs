//! Terminations: the rules by which an episode fails.
//!
//! A rule is declared once, in the list at the end of this file: cause, plan key, type and unit of its limit, default and
//! measured error. Its key in `[termination]`, range check, share in the curriculum, cause, metric (`Termination/<key>`)
//! and row in the table of plan keys follow from there. Rules are tried in the order of the list.

use lifelike_train::plan;

use crate::TrackerError;
use crate::tracking_error::TrackingError;

/// A limit of a rule, as a plan gives it.
trait Limit: Copy {
    /// Returns true when the error, or the time for which it has lasted (s), is beyond the limit.
    fn exceeded(self, error: f32, lasted: f64) -> bool;

    /// Returns the limit with its distance or angle multiplied.
    fn scaled(self, factor: f64) -> Self;
}

impl Limit for f32 {
    fn exceeded(self, error: f32, _lasted: f64) -> bool {
        error > self
    }

    fn scaled(self, factor: f64) -> Self {
        (f64::from(self) * factor) as f32
    }
}

/// A limit that ends the episode only when it is exceeded for some time: t^p and f of Table 4.1.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Persistent {
    /// Largest error of any end effector without consequence, t^p (m).
    #[schemars(extend("unit" = "m"), range(min = 1e-6, max = 1e3))]
    pub distance: f32,
    /// Longest time above it, f (s).
    #[schemars(extend("unit" = "s"), range(min = 0.0, max = 1e3))]
    pub seconds: f64,
}

impl Limit for Persistent {
    fn exceeded(self, _error: f32, lasted: f64) -> bool {
        lasted > self.seconds
    }

    fn scaled(self, factor: f64) -> Self {
        Self { distance: self.distance.scaled(factor), ..self }
    }
}

/// A limit in a plan: its value, or `false` for a rule that is off. A rule is off by being said to be, never by not being named:
/// who gives one limit does not lose the others.
mod limit_or_false {
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    #[derive(serde::Serialize, serde::Deserialize)]
    #[serde(untagged, expecting = "a limit, or false for none")]
    enum Written<L> {
        Switch(bool),
        Limit(L),
    }

    pub fn serialize<L: Serialize + Copy, S: Serializer>(limit: &Option<L>, to: S) -> Result<S::Ok, S::Error> {
        limit.map_or(Written::Switch(false), Written::Limit).serialize(to)
    }

    pub fn deserialize<'de, L: Deserialize<'de>, D: Deserializer<'de>>(from: D) -> Result<Option<L>, D::Error> {
        match Written::deserialize(from)? {
            Written::Limit(limit) => Ok(Some(limit)),
            Written::Switch(false) => Ok(None),
            Written::Switch(true) => Err(serde::de::Error::custom("expected a limit, or false for none, got true")),
        }
    }
}

/// Puts `false`, and the range of a limit that is a number, into the schema of the rules.
fn put_ranges(rules: &mut schemars::Schema) {
    let rules = rules.get_mut("properties").and_then(|rules| rules.as_object_mut());
    for rule in rules.into_iter().flat_map(|rules| rules.values_mut()).filter_map(|rule| rule.as_object_mut()) {
        let mut limit = schemars::Schema::default();
        for key in ["type", "format", "properties", "required", "additionalProperties"] {
            rule.remove(key).into_iter().for_each(|value| drop(limit.insert(key.into(), value)));
        }
        if limit.get("properties").is_none() {
            limit.insert("minimum".into(), 1e-6.into());
            limit.insert("maximum".into(), 1e3.into());
        }
        let off = schemars::json_schema!({ "type": "boolean", "enum": [false] });
        rule.insert("anyOf".into(), vec![limit.to_value(), off.to_value()].into());
    }
}

macro_rules! terminations {
    ($($(#[doc = $doc:literal])+ $cause:ident, $key:ident: $limit:ty = $default:expr, $unit:literal, $error:expr;)+) => {
        /// The rules by which an episode fails. A limit that the table does not name is the default one; `false` turns a rule
        /// off. A diverged simulation always ends the episode.
        #[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
        #[serde(deny_unknown_fields, default)]
        #[schemars(transform = put_ranges)]
        pub struct Termination {
            $(
                $(#[doc = $doc])+
                #[serde(serialize_with = "limit_or_false::serialize", deserialize_with = "limit_or_false::deserialize")]
                #[schemars(extend("unit" = $unit))]
                pub $key: Option<$limit>,
            )+
        }

        impl Default for Termination {
            fn default() -> Self {
                Self { $($key: $default,)+ }
            }
        }

        impl Termination {
            /// No limit at all: for evaluation, which has its own definition of a fall.
            pub const NONE: Self = Self { $($key: None,)+ };

            /// Returns the rules with every limit multiplied (above 1: forgiving more); times stay.
            #[must_use]
            pub fn scaled(self, factor: f64) -> Self {
                Self { $($key: self.$key.map(|limit| limit.scaled(factor)),)+ }
            }

            /// Checks that every limit is in its range.
            ///
            /// # Errors
            /// [`TrackerError::Plan`] with the key, the range and the value.
            pub fn check(&self) -> Result<(), TrackerError> {
                Ok(plan::check("termination", self)?)
            }

            /// Returns the first rule that is broken. `lasted` is the time for which the error of the persistent rule has
            /// been above its distance (s).
            pub fn exceeded(&self, error: &TrackingError, lasted: f64) -> Option<Cause> {
                $(
                    let measured: fn(&TrackingError) -> f32 = $error;
                    if self.$key.is_some_and(|limit| limit.exceeded(measured(error), lasted)) {
                        return Some(Cause::$cause);
                    }
                )+
                None
            }
        }

        /// Reason for which an episode ended before its time.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
        pub enum Cause {
            /// The state became non-finite.
            Diverged,
            $($(#[doc = $doc])+ $cause,)+
        }

        impl Cause {
            /// All causes.
            pub const ALL: &[Self] = &[Self::Diverged, $(Self::$cause),+];

            /// Returns its name in the metrics.
            pub fn name(self) -> &'static str {
                match self {
                    Self::Diverged => "diverged",
                    $(Self::$cause => stringify!($key),)+
                }
            }
        }
    };
}

terminations! {
    /// Largest error of the root's height.
    Height, height: f32 = Some(0.12), "m", |error| error.height;
    /// Largest angle between the directions of gravity in the root's frame.
    Tilt, tilt: f32 = Some(0.7), "rad", |error| error.tilt;
    /// Largest error of any end effector (heading frame, relative to the root).
    Effector, effector: f32 = Some(0.25), "m", |error| error.effector;
    /// Largest error of any end effector that may last: the thesis' rule.
    Persistent, persistent: Persistent = None, "", |error| error.effector;
    /// Largest distance from the reference on the ground.
    Path, path: f32 = None, "m", |error| error.path;
    /// Largest heading error.
    Heading, heading: f32 = None, "rad", |error| error.heading;
}

impl Cause {
    /// Returns its place in [`Self::ALL`].
    pub fn index(self) -> usize {
        self as usize
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn a_plan_that_gives_one_limit_keeps_the_others_and_false_turns_one_off() {
        let named: Termination = toml::from_str("path = 0.5\ntilt = false").unwrap();
        assert_eq!(named, Termination { path: Some(0.5), tilt: None, ..Termination::default() });
        assert_eq!(toml::from_str::<Termination>(&toml::to_string(&named).unwrap()).unwrap(), named);
        assert_eq!(toml::from_str::<Termination>("").unwrap(), Termination::default());
        for (wrong, part) in [("path = true", "got true"), ("path = \"no\"", "or false for none")] {
            let error = toml::from_str::<Termination>(wrong).unwrap_err().to_string();
            assert!(error.contains(part), "{error}");
        }
    }

    #[test]
    fn only_given_limits_apply_and_the_persistent_one_waits() {
        let error = TrackingError { height: 9.0, tilt: 0.1, effector: 0.4, path: 0.0, heading: 0.0, joints: 0.0 };
        assert_eq!(Termination::NONE.exceeded(&error, 0.0), None);
        let tight = Termination { effector: Some(0.3), ..Termination::NONE };
        assert_eq!(tight.exceeded(&error, 0.0), Some(Cause::Effector));
        let thesis = Termination { persistent: Some(Persistent { distance: 0.3, seconds: 3.0 }), ..Termination::NONE };
        assert_eq!((thesis.exceeded(&error, 3.0), thesis.exceeded(&error, 3.02)), (None, Some(Cause::Persistent)));
    }

    #[test]
    fn every_cause_has_its_metric_and_its_place() {
        let names: Vec<_> = Cause::ALL.iter().map(|cause| cause.name()).collect();
        assert_eq!(names[..7], ["diverged", "height", "tilt", "effector", "persistent", "path", "heading"]);
        assert!(Cause::ALL.iter().enumerate().all(|(i, cause)| cause.index() == i));
    }

    #[test]
    fn a_forgiving_curriculum_scales_distances_and_angles_but_not_times() {
        let persistent = Some(Persistent { distance: 0.3, seconds: 3.0 });
        let scaled = Termination { persistent, ..Termination::default() }.scaled(2.0);
        assert_eq!((scaled.height, scaled.tilt, scaled.path), (Some(0.24), Some(1.4), None));
        assert_eq!(scaled.persistent, Some(Persistent { distance: 0.6, seconds: 3.0 }));
    }
}
