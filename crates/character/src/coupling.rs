//! Joints that follow others: fingers of one motor, linkages, MuJoCo's `<equality><joint>` and URDF's `<mimic>`.
//!
//! In physics a coupling is a soft constraint, as in MuJoCo. In kinematics it holds exactly: a follower is where its leader puts
//! it, and no motion, policy or target has a number for it.

use crate::model::{Character, Joint};

/// A joint whose displacement from its reference is a polynomial of another's.
#[derive(Debug, Clone, PartialEq)]
pub struct Coupling {
    /// The joint that follows, as an index into [`Character::joints`].
    pub follower: usize,
    /// The joint that leads, likewise; `None`: the follower is held at the polynomial's first number.
    pub leader: Option<usize>,
    /// Coefficients of the leader's displacement to the powers 0 to 4 (rad or m).
    pub polynomial: [f64; 5],
    /// Constraint solver reference (MuJoCo's `solref`).
    pub solref: [f64; 2],
    /// Constraint solver impedance (MuJoCo's `solimp`).
    pub solimp: [f64; 5],
}

impl Coupling {
    /// Returns the follower's displacement for the leader's, and its derivative.
    pub fn displacement(&self, leader: f64) -> (f64, f64) {
        let value = self.polynomial.iter().rev().fold(0.0, |sum, c| sum * leader + c);
        let powers = self.polynomial.iter().enumerate().skip(1).rev();
        (value, powers.fold(0.0, |sum, (k, c)| sum * leader + k as f64 * c))
    }
}

impl Character {
    /// Returns the position of a hinge or slide (rad or m), with the joint that leads it and the derivative by that joint's
    /// position. A joint that moves by itself leads itself; one that is held has no leader.
    pub(crate) fn led<'a>(&'a self, joint: &'a Joint, q: &[f64]) -> (f64, Option<&'a Joint>, f64) {
        let Some(coupling) = joint.coupling.map(|index| &self.couplings[index]) else {
            return (q[joint.q_index], Some(joint), 1.0);
        };
        let (moved, leader, slope) = match coupling.leader.map(|leader| &self.joints[leader]) {
            None => (0.0, None, 0.0),
            Some(next) => {
                let (position, leader, slope) = self.led(next, q);
                (position - next.reference, leader, slope)
            }
        };
        let (value, own) = coupling.displacement(moved);
        (joint.reference + value, leader, own * slope)
    }

    /// Puts every joint that follows another where its leader has it, with the leader's velocity.
    pub fn follow(&self, q: &mut [f64], v: &mut [f64]) {
        for joint in self.joints.iter().filter(|joint| joint.coupling.is_some()) {
            let (position, leader, slope) = self.led(joint, q);
            q[joint.q_index] = position;
            v[joint.v_index] = leader.map_or(0.0, |leader| slope * v[leader.v_index]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_polynomial_and_its_derivative_by_hand() {
        let (solref, solimp) = ([0.02, 1.0], [0.9, 0.95, 0.001, 0.5, 2.0]);
        let coupling = Coupling { follower: 1, leader: Some(0), polynomial: [1.0, 2.0, 3.0, 4.0, 5.0], solref, solimp };
        // 1 + 4 + 12 + 32 + 80 and 2 + 12 + 48 + 160.
        assert_eq!(coupling.displacement(2.0), (129.0, 222.0));
    }
}
