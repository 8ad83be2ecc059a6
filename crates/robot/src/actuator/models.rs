//! Models of actuators: the law of thesis eqs. 4.9-4.11, with friction under load where one has it, by the numbers that a
//! data sheet, another simulator or an identification gives.
//!
//! A profile chooses one by `model = "..."` beside `[actuator.NAME.parameters]`. Each is the law with certain parameters, so
//! engine, MuJoCo, controller and identification see nothing else. A new model is a file and a line in [`MODELS`].

use toml::{Table, Value};

use super::ActuatorParameters;
use super::bam::Bam;
use super::dc_servo::DcServo;
use super::ideal_pd::IdealPd;

/// A description of an actuator that determines the law's parameters.
pub trait ActuatorModel: serde::de::DeserializeOwned {
    /// Name in profiles.
    const NAME: &'static str;

    /// Returns the parameters of the law.
    ///
    /// # Errors
    /// The first number out of range: key, expected and got.
    fn law(&self) -> Result<ActuatorParameters, String>;

    /// Returns the inertia of the rotor through its gear (kg m²), where the model knows it.
    fn armature(&self) -> Option<f64> {
        None
    }
}

/// The law itself: the default.
impl ActuatorModel for ActuatorParameters {
    const NAME: &'static str = "thesis";

    fn law(&self) -> Result<ActuatorParameters, String> {
        Ok(*self)
    }
}

type Law = fn(Table) -> Result<(ActuatorParameters, Option<f64>), String>;

/// All models by name.
pub const MODELS: &[(&str, Law)] = &[
    (ActuatorParameters::NAME, law::<ActuatorParameters>),
    (IdealPd::NAME, law::<IdealPd>),
    (DcServo::NAME, law::<DcServo>),
    (Bam::NAME, law::<Bam>),
];

fn law<M: ActuatorModel>(parameters: Table) -> Result<(ActuatorParameters, Option<f64>), String> {
    let model: M = parameters.try_into().map_err(|error: toml::de::Error| error.to_string())?;
    Ok((model.law()?, model.armature()))
}

/// Returns a profile whose actuators all have the law's parameters; none where no actuator names a model.
///
/// # Errors
/// An unknown model, and what its parameters lack, with the group's name.
pub(crate) fn resolve(text: &str) -> Result<Option<Table>, String> {
    let Ok(mut profile) = text.parse::<Table>() else { return Ok(None) };
    let mut found = false;
    for (name, group) in profile.get_mut("actuator").and_then(Value::as_table_mut).into_iter().flatten() {
        let Some(group) = group.as_table_mut() else { continue };
        let Some(model) = group.remove("model") else { continue };
        found = true;
        let Some((_, law)) = MODELS.iter().find(|(own, _)| model.as_str() == Some(*own)) else {
            let names: Vec<&str> = MODELS.iter().map(|(name, _)| *name).collect();
            return Err(format!("[actuator.{name}]: model: expected one of {}, got {model}", names.join(", ")));
        };
        let parameters = group.get("parameters").and_then(Value::as_table).cloned().unwrap_or_default();
        let (law, armature) =
            law(parameters).map_err(|error| format!("[actuator.{name}.parameters]: {}", error.trim_end()))?;
        if let Some(armature) = armature {
            group.entry("armature").or_insert(armature.into());
        }
        let law = Value::try_from(law).map_err(|error| format!("[actuator.{name}.parameters]: {error}"))?;
        group.insert("parameters".into(), law);
    }
    Ok(found.then_some(profile))
}

/// Checks that a number is finite and not below a bound.
pub(super) fn at_least(key: &str, value: f64, bound: f64) -> Result<(), String> {
    if value.is_finite() && value >= bound {
        Ok(())
    } else {
        Err(format!("{key}: expected a number of at least {bound}, got {value}"))
    }
}

/// Checks that a number is finite and above zero.
pub(super) fn above_zero(key: &str, value: f64) -> Result<(), String> {
    if value.is_finite() && value > 0.0 {
        Ok(())
    } else {
        Err(format!("{key}: expected a number above 0, got {value}"))
    }
}
