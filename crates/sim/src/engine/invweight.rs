//! Inverse weights at the reference position (MuJoCo's `invweight0`): the scale of soft constraints.

use super::model_parameters::ModelParameters;
use super::rigid_body::RigidBodyDynamics;
use super::solver_context::InvWeight;
use super::spatial::Vec3;
use super::tree::Tree;

/// Greatest acceleration of a dof per unit force (1/kg): beyond it nothing is there to be moved.
const MAX_INVWEIGHT: f64 = 1e9;
/// Inverse weight up to which nothing moves (MuJoCo's `mjMINVAL`).
const NOTHING: f64 = 1e-15;

/// Inverse weights at the reference position.
///
/// # Errors
/// The last dof that moves no mass, or none that the dofs below it do not move alike.
pub fn invweight(
    tree: &Tree<f64>,
    reference: &[f64],
    parameters: &ModelParameters<f64>,
) -> Result<InvWeight<f64>, usize> {
    let zero = vec![0.0; tree.nv];
    let mut dynamics = RigidBodyDynamics::new(tree);
    dynamics.kinematics(tree, reference);
    dynamics.bias(tree, parameters, &zero);
    dynamics.mass_matrix(tree, parameters);
    let RigidBodyDynamics { factors, mass, .. } = &mut dynamics;
    factors.factorise(tree, mass, &[]);
    if let Some(dof) = factors.inverse.iter().rposition(|x| !(0.0..MAX_INVWEIGHT).contains(x)) {
        return Err(dof);
    }
    // J M⁻¹ Jᵀ of a row is the square of its half solution.
    let weight = |dynamics: &RigidBodyDynamics<f64>, row: Vec<f64>| {
        let mut y = row;
        dynamics.factors.half_solve(tree, &mut y);
        y.iter().map(|x| x * x).sum::<f64>()
    };
    // The mean over the axes of a motion that each dof gives a body.
    let mean = |last: usize, motion: &dyn Fn(usize) -> Vec3<f64>| {
        let mut sum = 0.0;
        for axis in 0..3 {
            let mut row = zero.clone();
            for d in &tree.dofs[last].chain {
                row[*d] = motion(*d)[axis];
            }
            sum += weight(&dynamics, row);
        }
        sum / 3.0
    };
    let (mut body, mut turn) = (vec![0.0; tree.bodies.len()], vec![0.0; tree.bodies.len()]);
    for b in 0..tree.bodies.len() {
        let Some(last) = tree.bodies[b].last_dof else { continue };
        body[b] = mean(last, &|d| dynamics.point_velocity(d, &dynamics.com[b]));
        if !tree.closures.turn(b) && body[b] > NOTHING {
            continue;
        }
        let own = mean(last, &|d| [dynamics.motion[d][0], dynamics.motion[d][1], dynamics.motion[d][2]]);
        // What can only turn about its centre of mass, or not turn at all, has the other weight for both.
        turn[b] = if own > NOTHING { own } else { body[b] };
        if body[b] <= NOTHING {
            body[b] = own;
        }
    }
    let own: Vec<f64> = (0..tree.nv)
        .map(|d| {
            let mut row = zero.clone();
            row[d] = 1.0;
            weight(&dynamics, row)
        })
        .collect();
    let mut dof = own.clone();
    for joint in &tree.joints {
        // The dofs of a free joint and of a ball share their mean, turns and translations apart.
        for first in (0..joint.kind.nv()).step_by(3).filter(|_| joint.kind.nv() >= 3) {
            let at = joint.v + first;
            let mean = own[at..at + 3].iter().sum::<f64>() / 3.0;
            dof[at..at + 3].fill(mean);
        }
    }
    Ok(InvWeight { body, turn, dof })
}
