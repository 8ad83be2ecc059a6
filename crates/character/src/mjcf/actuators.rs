//! `<actuator>`: the force law that MuJoCo compiles from each of its shortcuts.
//!
//! A default class has one force law: that of its last actuator. An actuator begins with the law of the innermost class around it
//! that has its own tag, or `<general>`, whose numbers reach every shortcut.

use crate::error::CharacterError;
use crate::kinematics::Kinematics;
use crate::mjcf::attributes::Attributes;
use crate::mjcf::compiler::Compiler;
use crate::mjcf::defaults::Defaults;
use crate::mjcf::document::Element;
use crate::mjcf::tendons;
use crate::model::{Actuator, Character, Joint};

/// Force law of one actuator or default class.
#[derive(Debug, Clone, Copy)]
struct Law {
    /// Force per control: constant, per length, per velocity.
    gain: [f64; 3],
    /// Force without control: constant, per length, per velocity (a positive last number of a position servo is its damping ratio).
    bias: [f64; 3],
    /// Flag that the second and third number of `gain` count.
    gain_is_affine: bool,
    /// Flag that `bias` counts.
    bias_is_affine: bool,
    /// Flag that an integral or filtered value of the control acts.
    filtered: bool,
    inherited_range: f64,
}

impl Law {
    const MOTOR: Self = Self {
        gain: [1.0, 0.0, 0.0],
        bias: [0.0; 3],
        gain_is_affine: false,
        bias_is_affine: false,
        filtered: false,
        inherited_range: 0.0,
    };

    /// Returns the law of an element within classes, given from the inside out.
    fn of(element: &Element, classes: &[&[Element]]) -> Result<Self, CharacterError> {
        let tag = element.name.as_str();
        let is_alone = matches!(tag, "pid" | "damper" | "dcmotor");
        for (i, class) in classes.iter().enumerate() {
            if let Some((last, before)) = class.split_last()
                && (tag == "general" || last.name == tag || (last.name == "general" && !is_alone))
            {
                let mut around = classes[i..].to_vec();
                around[0] = before;
                return Self::of(last, &around)?.with(element);
            }
        }
        match tag {
            "pid" => Self { bias: [0.0, -1.0, 0.0], ..Self::MOTOR }.with(element),
            _ => Self::MOTOR.with(element),
        }
    }

    /// Returns the law that the element makes of this one.
    fn with(self, element: &Element) -> Result<Self, CharacterError> {
        let a = Attributes::own(element);
        match element.name.as_str() {
            "motor" => Ok(Self { inherited_range: self.inherited_range, ..Self::MOTOR }),
            "general" => self.general(&a),
            "position" | "intvelocity" | "pid" => self.servo(&a, &element.name),
            "velocity" => {
                let kv = a.number("kv")?.unwrap_or(self.gain[0]);
                Ok(Self { gain: [kv, 0.0, 0.0], bias: [0.0, 0.0, -kv], bias_is_affine: true, ..Self::MOTOR })
            }
            "damper" => {
                let kv = not_negative(&a, "kv")?.unwrap_or(-self.gain[2]);
                Ok(Self { gain: [0.0, 0.0, -kv], gain_is_affine: true, ..Self::MOTOR })
            }
            "dcmotor" => self.direct_current(&a),
            "cylinder" => {
                let area = a.number("area")?.unwrap_or(self.gain[0]);
                let diameter = a.number("diameter")?.filter(|diameter| *diameter > 0.0);
                let area = diameter.map_or(area, |d| 0.25 * std::f64::consts::PI * d * d);
                let bias = a.prefix("bias", self.bias)?;
                Ok(Self { gain: [area, 0.0, 0.0], bias, bias_is_affine: true, filtered: true, ..Self::MOTOR })
            }
            kind => Err(element.unsupported(format!(
                "kind of actuator '{kind}': its force is none of a motor, servo or damper; use <motor>, <position> or <general>"
            ))),
        }
    }

    fn general(mut self, a: &Attributes) -> Result<Self, CharacterError> {
        let affine = |name: &str, constant: &str, now: bool| match a.text(name) {
            None => Ok(now),
            Some("affine") => Ok(true),
            Some(text) if text == constant => Ok(false),
            Some(other) => Err(a.unsupported(format!("{name} '{other}'; expected '{constant}' or 'affine'"))),
        };
        self.gain_is_affine = affine("gaintype", "fixed", self.gain_is_affine)?;
        self.bias_is_affine = affine("biastype", "none", self.bias_is_affine)?;
        self.filtered = a.text("dyntype").map_or(self.filtered, |kind| kind != "none");
        self.gain = first_three(a, "gainprm", self.gain)?;
        self.bias = first_three(a, "biasprm", self.bias)?;
        Ok(self)
    }

    /// Returns the law of a motor behind its voltage: its current is what the voltage leaves over the back EMF, by its resistance.
    fn direct_current(mut self, a: &Attributes) -> Result<Self, CharacterError> {
        let other =
            ["cogging", "saturation", "thermal", "lugre", "controller"].into_iter().find(|n| a.text(n).is_some());
        if let Some(name) = other {
            return Err(a.unsupported(format!("attribute '{name}'")));
        }
        if a.text("input").is_some_and(|input| input != "voltage") {
            return Err(a.unsupported("attribute 'input' other than 'voltage'"));
        }
        let given = a.prefix("motorconst", [0.0; 2])?;
        let nominal = a.numbers::<3>("nominal")?;
        let inherited = -self.bias[2] / self.gain[0];
        let constant = match (given, nominal) {
            ([torque, emf], _) if torque > 0.0 && emf > 0.0 => (torque * emf).sqrt(),
            ([torque, emf], _) if torque > 0.0 || emf > 0.0 => torque.max(emf),
            (_, Some([voltage, _, speed])) => voltage / speed,
            _ => inherited,
        };
        let resistance = match (a.number("resistance")?.filter(|r| *r > 0.0), nominal) {
            (Some(resistance), _) => resistance,
            (None, Some([voltage, stall, _])) => constant * voltage / stall,
            (None, None) => inherited / self.gain[0],
        };
        let per_volt = constant / resistance;
        if !(constant > 0.0 && per_volt > 0.0 && per_volt.is_finite()) {
            return Err(a.invalid("'motorconst' and 'resistance', or 'nominal', above zero", "none"));
        }
        (self.gain, self.bias) = ([per_volt, 0.0, 0.0], [0.0, 0.0, -constant * per_volt]);
        (self.gain_is_affine, self.bias_is_affine) = (false, true);
        if let Some(time) = not_negative(a, "inductance")? {
            self.filtered = time > 0.0;
        }
        Ok(self)
    }

    fn servo(mut self, a: &Attributes, kind: &str) -> Result<Self, CharacterError> {
        let inherited = if kind == "pid" { -self.bias[1] } else { self.gain[0] };
        let kp = a.number("kp")?.unwrap_or(inherited);
        let (kv, ratio) = (not_negative(a, "kv")?, not_negative(a, "dampratio")?);
        if kv.is_some() && ratio.is_some() {
            return Err(a.invalid("'kv' or 'dampratio'", "both"));
        }
        (self.gain, self.bias) = ([kp, 0.0, 0.0], [0.0, -kp, ratio.or(kv.map(|kv| -kv)).unwrap_or(self.bias[2])]);
        (self.gain_is_affine, self.bias_is_affine) = (false, true);
        if let Some(time) = not_negative(a, "timeconst")? {
            self.filtered = time > 0.0;
        }
        self.filtered |= kind == "intvelocity";
        self.inherited_range = a.number("inheritrange")?.unwrap_or(self.inherited_range);
        Ok(self)
    }

    /// Returns gain, bias and damping per control that are in force.
    fn in_force(&self, a: &Attributes) -> Result<(f64, [f64; 3], f64), CharacterError> {
        let bias = if self.bias_is_affine { self.bias } else { [0.0; 3] };
        match self.gain {
            [gain, ..] if !self.gain_is_affine => Ok((gain, bias, 0.0)),
            [gain, 0.0, per_velocity] => Ok((gain, bias, -per_velocity)),
            _ => Err(a.unsupported("gain that depends on the joint's position")),
        }
    }
}

fn not_negative(a: &Attributes, name: &str) -> Result<Option<f64>, CharacterError> {
    match a.number(name)? {
        Some(value) if value < 0.0 => Err(a.invalid(format!("'{name}' that is not negative"), value.to_string())),
        value => Ok(value),
    }
}

/// Returns the first three of up to ten numbers over the given ones.
fn first_three(a: &Attributes, name: &str, otherwise: [f64; 3]) -> Result<[f64; 3], CharacterError> {
    let mut all = [0.0; 10];
    all[..3].copy_from_slice(&otherwise);
    let [first, second, third, ..] = a.prefix(name, all)?;
    Ok([first, second, third])
}

/// Reads every actuator that drives one joint, by itself or by a tendon; others become notes or warnings. Damping ratios are
/// resolved by [`resolve_damping`].
pub(crate) fn read(
    root: &Element,
    defaults: &Defaults,
    compiler: &Compiler,
    joints: &mut [Joint],
    notes: &mut Vec<String>,
    warnings: &mut Vec<String>,
) -> Result<Vec<Actuator>, CharacterError> {
    let mut actuators: Vec<Actuator> = Vec::new();
    let (mut shared, mut pushing) = (Vec::new(), Vec::new());
    for element in root.children_named("actuator").flat_map(|s| &s.children) {
        let a = defaults.resolve(element, None)?;
        let law = Law::of(element, &defaults.actuators(element))?;
        let name = a.text("name").unwrap_or("");
        let (target, arm) = match (a.text("joint").or(a.text("jointinparent")), a.text("tendon")) {
            (Some(joint), _) => (joint, None),
            (None, Some(tendon)) => match tendons::only_joint(root, tendon, &a)? {
                Some((joint, coefficient)) => (joint, Some(coefficient)),
                None => {
                    shared.push(if name.is_empty() { tendon } else { name }.to_string());
                    continue;
                }
            },
            (None, None) => {
                notes.push(format!("{}: actuator '{name}' does not drive a joint: left out", a.at));
                continue;
            }
        };
        let joint = joints
            .iter()
            .position(|j| j.name == target)
            .ok_or_else(|| a.invalid("the name of a joint", format!("'{target}'")))?;
        let mut actuator = one(&a, &element.name, &law, joint, joints, compiler)?;
        actuator.gear *= arm.unwrap_or(1.0);
        if actuator.bias[0] != 0.0 {
            pushing.push(format!("{target} ({} N m)", actuator.bias[0] * actuator.gear));
        }
        if law.filtered || a.number("delay")?.is_some_and(|delay| delay > 0.0) {
            notes.push(format!(
                "actuator of '{target}' ({}) filters, integrates or delays its control: our engine applies the control at once",
                element.name
            ));
        }
        joints[joint].armature += actuator.gear * actuator.gear * a.number("armature")?.unwrap_or(0.0);
        actuators.push(actuator);
    }
    for (what, which) in [
        (
            "actuators that pull several joints by a tendon are left out, give these joints actuators of their own",
            shared,
        ),
        ("constant forces of actuators, which MuJoCo has and our engine has not", pushing),
    ] {
        if !which.is_empty() {
            warnings.push(format!("{what}: {}", which.join(", ")));
        }
    }
    for i in 0..actuators.len() {
        if actuators[i].name.is_empty() {
            actuators[i].name =
                super::names::made_up(format!("actuator{i}"), actuators.iter().map(|a| a.name.as_str()));
        }
    }
    Ok(actuators)
}

fn one(
    a: &Attributes,
    kind: &str,
    law: &Law,
    joint: usize,
    joints: &[Joint],
    compiler: &Compiler,
) -> Result<Actuator, CharacterError> {
    let mut ctrl_range = a.limits("ctrlrange", "ctrllimited", compiler.autolimits)?;
    let share = Some(law.inherited_range).filter(|s| *s > 0.0 && a.text("ctrlrange").is_none());
    if let (Some(share), Some((low, high))) = (share, joints[joint].range) {
        let (middle, half) = (0.5 * (low + high), 0.5 * (high - low) * share);
        ctrl_range = Some((middle - half, middle + half));
    }
    let (gain, mut bias, damper) = law.in_force(a)?;
    let gear = a.prefix("gear", [1.0, 0.0, 0.0, 0.0, 0.0, 0.0])?[0];
    bias[2] -= first_three(a, "damping", [0.0; 3])?[0];
    Ok(Actuator {
        name: a.text("name").unwrap_or("").to_string(),
        kind: kind.to_string(),
        joint,
        gear,
        ctrl_range,
        force_range: a.limits("forcerange", "forcelimited", compiler.autolimits)?,
        gain,
        bias,
        damper,
    })
}

/// Turns damping ratios of position servos into damping, as MuJoCo's compiler does. It takes the inertia that each
/// joint's actuator feels in the reference position (kg m²).
pub(crate) fn resolve_damping(character: &mut Character) {
    let is_ratio = |a: &Actuator| a.bias[2] > 0.0 && a.gain == -a.bias[1];
    if !character.actuators.iter().any(is_ratio) {
        return;
    }
    let inertias = Kinematics::new(character).effective_inertias(character);
    let inertias = inertias.unwrap_or_else(|| vec![0.0; character.nv]);
    for actuator in character.actuators.iter_mut().filter(|a| is_ratio(a)) {
        let inertia = inertias[character.joints[actuator.joint].v_index] / (actuator.gear * actuator.gear);
        actuator.bias[2] *= -2.0 * (actuator.gain * inertia).max(0.0).sqrt();
    }
}
