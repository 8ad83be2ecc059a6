//! `<joint>` and `<freejoint>`.

use crate::error::CharacterError;
use crate::kinematics::Kinematics;
use crate::mjcf::attributes::Attributes;
use crate::mjcf::compiler::Compiler;
use crate::mjcf::pose::Pose;
use crate::model::{Character, Joint, JointKind};
use crate::rotation::Vec3;

/// Reads a joint of `body`. Its name may be empty and its coordinates are not counted yet.
pub(crate) fn read(
    a: &Attributes,
    free: bool,
    body: usize,
    frame: &Pose,
    compiler: &Compiler,
) -> Result<Joint, CharacterError> {
    if free {
        a.only(&["name", "group", "align", "class"])?;
        return Ok(blank(a, JointKind::Free, body));
    }
    a.only(&[
        "name",
        "class",
        "type",
        "group",
        "pos",
        "axis",
        "springdamper",
        "limited",
        "actuatorfrclimited",
        "solreflimit",
        "solimplimit",
        "solreffriction",
        "solimpfriction",
        "stiffness",
        "range",
        "actuatorfrcrange",
        "actuatorgravcomp",
        "margin",
        "ref",
        "springref",
        "armature",
        "damping",
        "frictionloss",
        "user",
    ])?;
    let kind = match a.text("type") {
        None | Some("hinge") => JointKind::Hinge,
        Some("slide") => JointKind::Slide,
        Some("ball") => JointKind::Ball,
        Some("free") => JointKind::Free,
        Some(other) => return Err(a.invalid("'free', 'ball', 'slide' or 'hinge' for 'type'", format!("'{other}'"))),
    };
    if a.boolean("actuatorgravcomp", false)? {
        return Err(a.unsupported("attribute 'actuatorgravcomp' that is true"));
    }
    let mut joint = blank(a, kind, body);
    let scale = if matches!(kind, JointKind::Hinge | JointKind::Ball) { compiler.angle } else { 1.0 };
    joint.armature = a.number("armature")?.unwrap_or(0.0);
    joint.damping = linear(a, "damping")?;
    joint.frictionloss = a.number("frictionloss")?.unwrap_or(0.0);
    joint.stiffness = linear(a, "stiffness")?;
    for (name, value) in
        [("armature", joint.armature), ("damping", joint.damping), ("frictionloss", joint.frictionloss)]
    {
        if value < 0.0 {
            return Err(a.invalid(format!("'{name}' that is not negative"), value.to_string()));
        }
    }
    if kind == JointKind::Free {
        return Ok(joint);
    }
    let own = a.numbers::<3>("pos")?.map_or_else(Vec3::zeros, Vec3::from);
    joint.position = frame.position + frame.orientation * own;
    if matches!(kind, JointKind::Hinge | JointKind::Slide) {
        let axis = a.numbers::<3>("axis")?.map_or_else(Vec3::z, Vec3::from);
        let axis = axis.try_normalize(1e-14).filter(|u| u.iter().all(|c| c.is_finite()));
        joint.axis = frame.orientation * axis.ok_or_else(|| a.invalid("'axis' with a direction", "a zero vector"))?;
        joint.reference = a.number("ref")?.unwrap_or(0.0) * scale;
        joint.spring_reference = a.number("springref")?.unwrap_or(0.0) * scale;
    }
    let range = a.limits("range", "limited", compiler.autolimits)?;
    joint.range = range.map(|(low, high)| (low * scale, high * scale));
    if kind == JointKind::Ball && joint.range.is_some_and(|(low, _)| low != 0.0) {
        return Err(a.invalid("a ball joint's range that starts at 0", a.text("range").unwrap_or("").to_string()));
    }
    joint.actuator_force_range = a.limits("actuatorfrcrange", "actuatorfrclimited", compiler.autolimits)?;
    Ok(joint)
}

/// Gives joints the spring and the damping of a time constant (s) and a damping ratio, as MuJoCo's compiler does. It
/// takes the mean inertia that each feels in the reference position.
pub(crate) fn resolve_springs(character: &mut Character, given: &[(usize, [f64; 2])]) {
    let inertias = match given {
        [] => return,
        _ => Kinematics::new(character).effective_inertias(character),
    };
    let inertias = inertias.unwrap_or_else(|| vec![0.0; character.nv]);
    for (joint, [time, ratio]) in given {
        let joint = &mut character.joints[*joint];
        let dofs = &inertias[joint.v_index..joint.v_index + joint.kind.nv()];
        let inertia = dofs.len() as f64 / dofs.iter().map(|inertia| 1.0 / inertia).sum::<f64>();
        joint.stiffness = inertia / (time * time * ratio * ratio);
        joint.damping = 2.0 * inertia / time;
    }
}

/// Returns a coefficient that may be followed by those of higher powers, which must be zero.
fn linear(a: &Attributes, name: &str) -> Result<f64, CharacterError> {
    match a.prefix(name, [0.0; 3])? {
        [first, 0.0, 0.0] => Ok(first),
        _ => Err(a.unsupported(format!("'{name}' with more than a linear term; keep its first number"))),
    }
}

fn blank(a: &Attributes, kind: JointKind, body: usize) -> Joint {
    Joint {
        name: a.text("name").unwrap_or("").to_string(),
        body,
        kind,
        position: Vec3::zeros(),
        axis: Vec3::z(),
        range: None,
        q_index: 0,
        v_index: 0,
        reference: 0.0,
        armature: 0.0,
        damping: 0.0,
        frictionloss: 0.0,
        stiffness: 0.0,
        spring_reference: 0.0,
        actuator_force_range: None,
        velocity_limit: None,
        coupling: None,
    }
}
