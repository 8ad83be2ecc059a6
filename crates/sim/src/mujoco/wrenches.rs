//! Constraint wrenches of one environment, read from MuJoCo's recursive Newton-Euler after the constraint solver.

use lifelike_character::Vec3;

use super::tuning::Tuning;
use super::worker::Worker;
use crate::constraint_wrenches::WrenchRows;
use crate::simulation::Drive;

/// Torque and force; MuJoCo's own are about the centre of mass of a whole kinematic tree.
pub(super) type Wrench = (Vec3, Vec3);

fn wrench(x: &[f64; 6]) -> Wrench {
    (Vec3::new(x[0], x[1], x[2]), Vec3::new(x[3], x[4], x[5]))
}

/// A wrench about another point.
fn moved((torque, force): Wrench, from: Vec3, to: Vec3) -> Wrench {
    (torque + (from - to).cross(&force), force)
}

/// Writes a wrench about another point.
fn write(out: &mut [f32], wrench: Wrench, from: Vec3, to: Vec3) {
    let (torque, force) = moved(wrench, from, to);
    for (slot, x) in out.iter_mut().zip(torque.iter().chain(&force)) {
        *slot = *x as f32;
    }
}

impl Worker {
    /// Writes the constraint wrenches of an environment under a drive; nothing where it has diverged or the drive is not
    /// finite.
    pub fn constraint_wrenches(
        &mut self,
        row: &[f64],
        tuning: Option<&Tuning>,
        drive: Drive<'_>,
        out: &mut WrenchRows<'_>,
    ) {
        let layout = self.layout.clone();
        if row[layout.diverged] != 0.0 || !drive.values().iter().all(|x| x.is_finite()) {
            return;
        }
        self.tune(tuning);
        self.load(row);
        self.apply_drive(drive);
        self.data.forward();
        self.data.rne_post_constraint();
        let data = &self.data;
        let (model, interaction, closures) = (data.model(), data.cfrc_int(), self.closure_wrenches());
        for b in 1..layout.bodies {
            let from = Vec3::from(data.subtree_com()[model.body_rootid()[b].max(0) as usize]);
            let (origin, com) = (Vec3::from(data.xpos()[b]), Vec3::from(data.xipos()[b]));
            let rows = 6 * b..6 * b + 6;
            let own = wrench(&interaction[b]);
            write(&mut out.joint[rows.clone()], own, from, origin);
            let closing = moved(closures[b], Vec3::zeros(), com);
            // All joints of a body: the one above less those below, and those that close loops.
            let children = (1..layout.bodies).filter(|c| model.body_parentid()[*c] == b as i32);
            let all = children.map(|c| wrench(&interaction[c])).fold(own, |sum, x| (sum.0 - x.0, sum.1 - x.1));
            let all = moved(all, from, com);
            write(&mut out.constraint[rows.clone()], (all.0 + closing.0, all.1 + closing.1), com, com);
            // MuJoCo counts these among the external forces, and pushes, which act at the centre of mass.
            let push = &row[layout.pushes + 6 * b..layout.pushes + 6 * b + 6];
            let (torque, force) = moved(wrench(&data.cfrc_ext()[b]), from, com);
            let torque = torque - Vec3::new(push[3], push[4], push[5]) - closing.0;
            let force = force - Vec3::new(push[0], push[1], push[2]) - closing.1;
            write(&mut out.contact[rows], (torque, force), com, com);
        }
        for (slot, joint) in out.joint_load.iter_mut().zip(&layout.joints) {
            let body = model.dof_bodyid()[joint.v].max(0) as usize;
            *slot = data.cdof()[joint.v].iter().zip(&interaction[body]).map(|(s, f)| s * f).sum::<f64>() as f32;
        }
    }
}
