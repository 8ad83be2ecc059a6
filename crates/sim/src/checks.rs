//! Checks of everything that comes from outside, in the same words for every engine.

use crate::batch::{EnvironmentParameters, IntegrationState};
use crate::error::SimError;
use crate::rows::Sizes;
use crate::simulation::Drive;

/// An environment that exists.
pub(crate) fn environment(id: usize, environments: usize) -> Result<(), SimError> {
    if id < environments {
        return Ok(());
    }
    Err(SimError::State { expected: format!("an environment below {environments}"), got: id.to_string() })
}

/// Another length of an array.
fn length(what: &'static str, expected: usize, got: usize) -> Result<(), SimError> {
    if expected == got { Ok(()) } else { Err(SimError::Length { what, expected, got }) }
}

/// States to reset environments to: as many as there are ids, finite, with a root orientation.
pub(crate) fn reset(
    ids: &[usize],
    environments: usize,
    positions: &[f64],
    velocities: &[f64],
    sizes: &Sizes,
) -> Result<(), SimError> {
    length("positions", ids.len() * sizes.nq, positions.len())?;
    length("velocities", ids.len() * sizes.nv, velocities.len())?;
    for ((&id, q), v) in ids.iter().zip(positions.chunks_exact(sizes.nq)).zip(velocities.chunks_exact(sizes.nv)) {
        environment(id, environments)?;
        let norm = quaternion_norm(q, sizes.root_q);
        let wrong = q.iter().chain(v).find(|x| !x.is_finite()).map(f64::to_string);
        if let Some(got) = wrong.or_else(|| (norm < 1e-6).then(|| format!("a quaternion of length {norm}"))) {
            let expected = format!("finite numbers and a root orientation for environment {id}");
            return Err(SimError::State { expected, got });
        }
    }
    Ok(())
}

/// Length of the root's quaternion; 1 where the root is fixed to the world and has none.
fn quaternion_norm(q: &[f64], root: Option<usize>) -> f64 {
    root.map_or(1.0, |root| q[root + 3..root + 7].iter().map(|x| x * x).sum::<f64>().sqrt())
}

/// A checked position with the root's quaternion of unit length; one that is already stays as it is, to the last bit.
pub(crate) fn normalised(position: &[f64], root: Option<usize>) -> Vec<f64> {
    let mut q = position.to_vec();
    let norm = quaternion_norm(&q, root);
    if let Some(root) = root.filter(|_| (norm - 1.0).abs() > 1e-12) {
        q[root + 3..root + 7].iter_mut().for_each(|x| *x /= norm);
    }
    q
}

/// Parameters of a robot with so many bodies and joints.
pub(crate) fn parameters(p: &EnvironmentParameters, sizes: &Sizes) -> Result<(), SimError> {
    let Sizes { bodies, joints, feet, .. } = *sizes;
    for (what, expected, got) in [
        ("mass_scale", bodies, p.mass_scale.len()),
        ("inertia_scale", bodies, p.inertia_scale.len()),
        ("com_offset", bodies, p.com_offset.len()),
        ("joint_offset", joints, p.joint_offset.len()),
        ("armature_scale", joints, p.armature_scale.len()),
        ("damping_scale", joints, p.damping_scale.len()),
        ("kp_scale", joints, p.kp_scale.len()),
        ("kd_scale", joints, p.kd_scale.len()),
        ("strength_scale", joints, p.strength_scale.len()),
        ("foot_friction", feet, p.foot_friction.len()),
    ] {
        if got != 0 {
            length(what, expected, got)?;
        }
    }
    let refused = |expected: &str, got: f32| SimError::State { expected: expected.into(), got: got.to_string() };
    let positive = [&p.mass_scale, &p.inertia_scale, &p.armature_scale, &p.foot_friction];
    let positive = positive.into_iter().flatten().chain(&p.ground_friction);
    if let Some(value) = positive.copied().find(|x| !(x.is_finite() && *x > 0.0)) {
        return Err(refused("factors on masses, inertias and armature, and friction, above 0", value));
    }
    let others = [&p.damping_scale, &p.kp_scale, &p.kd_scale, &p.strength_scale].into_iter().flatten();
    if let Some(value) = others.copied().find(|x| !(x.is_finite() && *x >= 0.0)) {
        return Err(refused("factors on damping, gains and strength of at least 0", value));
    }
    let vectors = p.com_offset.iter().chain(&p.gravity).flatten().chain(&p.joint_offset);
    match vectors.copied().find(|x| !x.is_finite()) {
        None => Ok(()),
        Some(value) => Err(refused("finite offsets and gravity", value)),
    }
}

/// A finite push on a body that is not the world.
pub(crate) fn push(body: usize, bodies: usize, force_w: &[f32; 3], torque_w: &[f32; 3]) -> Result<(), SimError> {
    if body == 0 || body >= bodies {
        return Err(SimError::State { expected: format!("a body from 1 to {}", bodies - 1), got: body.to_string() });
    }
    match force_w.iter().chain(torque_w).find(|value| !value.is_finite()) {
        None => Ok(()),
        Some(value) => Err(SimError::State { expected: "a finite push".into(), got: value.to_string() }),
    }
}

/// A drive of `expected` numbers.
pub(crate) fn drive(drive: &Drive<'_>, expected: usize) -> Result<(), SimError> {
    let what = match drive {
        Drive::Targets(_) => "targets",
        Drive::Torques(_) => "torques",
    };
    length(what, expected, drive.values().len())
}

/// A state saved by this engine with as many environments of this width.
pub(crate) fn saved(state: &IntegrationState, engine: &str, environments: usize, width: usize) -> Result<(), SimError> {
    let fingerprint =
        |engine: &str, environments, width| format!("{engine}, {environments} environments of {width} numbers");
    let expected = fingerprint(engine, environments, width);
    let got = fingerprint(&state.engine, state.parameters.len(), state.width);
    if expected != got {
        return Err(SimError::State { expected, got });
    }
    length("saved state", environments * width, state.values.len())
}
