//! Fields of a MuJoCo model that an environment's parameters change.

use super::model::Layout;
use super::native::{Model, ModelMut};
use super::worker::Worker;
use crate::batch::EnvironmentParameters;

/// The fields of a model that the parameters of an environment change, dependent ones included.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Tuning {
    body_mass: Vec<f64>,
    body_inertia: Vec<[f64; 3]>,
    body_subtreemass: Vec<f64>,
    body_invweight0: Vec<[f64; 2]>,
    dof_invweight0: Vec<f64>,
    dof_m0: Vec<f64>,
    tendon_invweight0: Vec<f64>,
    geom_friction: Vec<[f64; 3]>,
    mean_inertia: f64,
    mean_mass: f64,
    body_ipos: Vec<[f64; 3]>,
    dof_armature: Vec<f64>,
    gravity: [f64; 3],
    /// Damping of each scalar joint's dof, and its actuator's gains.
    pub damping: Vec<f64>,
    pub gains: Vec<[f64; 2]>,
    pub strength: Vec<f64>,
}

/// Friction of the ground where each foot brings its own: MuJoCo takes the larger of two, so the ground's gives way.
const YIELDING: f64 = 1e-5;

impl Tuning {
    pub fn of(model: &Model, layout: &Layout) -> Self {
        Self {
            body_ipos: model.body_ipos().to_vec(),
            dof_armature: model.dof_armature().to_vec(),
            gravity: model.opt_gravity(),
            damping: layout.joints.iter().map(|j| j.damping).collect(),
            gains: layout.joints.iter().map(|j| [j.actuator.kp, j.actuator.kd]).collect(),
            strength: vec![1.0; layout.joints.len()],
            body_mass: model.body_mass().to_vec(),
            body_inertia: model.body_inertia().to_vec(),
            body_subtreemass: model.body_subtreemass().to_vec(),
            body_invweight0: model.body_invweight0().to_vec(),
            dof_invweight0: model.dof_invweight0().to_vec(),
            dof_m0: model.dof_m0().to_vec(),
            tendon_invweight0: model.tendon_invweight0().to_vec(),
            geom_friction: model.geom_friction().to_vec(),
            mean_inertia: model.stat_meaninertia(),
            mean_mass: model.stat_meanmass(),
        }
    }

    pub fn apply(&self, mut model: ModelMut<'_>) {
        model.body_mass_mut().copy_from_slice(&self.body_mass);
        model.body_inertia_mut().copy_from_slice(&self.body_inertia);
        model.body_subtreemass_mut().copy_from_slice(&self.body_subtreemass);
        model.body_invweight0_mut().copy_from_slice(&self.body_invweight0);
        model.dof_invweight0_mut().copy_from_slice(&self.dof_invweight0);
        model.dof_m0_mut().copy_from_slice(&self.dof_m0);
        model.tendon_invweight0_mut().copy_from_slice(&self.tendon_invweight0);
        model.geom_friction_mut().copy_from_slice(&self.geom_friction);
        *model.stat_meaninertia_mut() = self.mean_inertia;
        *model.stat_meanmass_mut() = self.mean_mass;
        model.body_ipos_mut().copy_from_slice(&self.body_ipos);
        model.dof_armature_mut().copy_from_slice(&self.dof_armature);
        *model.opt_gravity_mut() = self.gravity;
    }
}

impl Worker {
    /// Returns the fields of the model that `parameters` change; `None` for none.
    ///
    /// MuJoCo takes the larger friction of two geoms that touch, so a friction of the ground is set on all of them: the
    /// ground then has exactly this friction for every part of the robot, and so have the robot's parts for each other.
    pub fn tuning(&mut self, parameters: &EnvironmentParameters) -> Option<Tuning> {
        if *parameters
            == (EnvironmentParameters { joint_offset: parameters.joint_offset.clone(), ..Default::default() })
        {
            return None;
        }
        let base = self.base.clone();
        let layout = self.layout.clone();
        let factor = |scale: &[f32], i: usize| scale.get(i).map_or(1.0, |x| f64::from(*x));
        let p = parameters;
        base.apply(self.data.model_mut());
        let mut model = self.data.model_mut();
        for body in 0..layout.bodies {
            let mass = factor(&p.mass_scale, body);
            model.body_mass_mut()[body] *= mass;
            let turning = mass * factor(&p.inertia_scale, body);
            model.body_inertia_mut()[body].iter_mut().for_each(|moment| *moment *= turning);
            for (slot, offset) in
                model.body_ipos_mut()[body].iter_mut().zip(p.com_offset.get(body).into_iter().flatten())
            {
                *slot += f64::from(*offset);
            }
        }
        for (i, joint) in layout.joints.iter().enumerate() {
            model.dof_armature_mut()[joint.v] *= factor(&p.armature_scale, i);
        }
        if let Some(gravity) = p.gravity {
            *model.opt_gravity_mut() = gravity.map(f64::from);
        }
        if let Some(friction) = p.ground_friction {
            model.geom_friction_mut().iter_mut().for_each(|geom| geom[0] = f64::from(friction));
        }
        if !p.foot_friction.is_empty() {
            // What else touches the ground still does so with the larger of the two.
            let ground = model.geom_friction().iter().zip(&layout.ground).filter(|(_, ground)| **ground);
            let ground = ground.map(|(friction, _)| friction[0]).fold(0.0, f64::max);
            for (geom, friction) in model.geom_friction_mut().iter_mut().enumerate() {
                match layout.foot_of_geom[geom] {
                    _ if layout.ground[geom] => friction[0] = YIELDING,
                    Some(foot) => friction[0] = f64::from(p.foot_friction[foot]),
                    None => friction[0] = friction[0].max(ground),
                }
            }
        }
        // Inverse weights at the reference pose follow from the masses; contacts and limits use them.
        for joint in 0..layout.joints.len() {
            self.set_damping(joint, 0.0);
        }
        self.data.set_const();
        let mut tuning = Tuning::of(self.data.model(), &layout);
        for i in 0..layout.joints.len() {
            tuning.damping[i] *= factor(&p.damping_scale, i);
            tuning.gains[i][0] *= factor(&p.kp_scale, i);
            tuning.gains[i][1] *= factor(&p.kd_scale, i);
            tuning.strength[i] = factor(&p.strength_scale, i);
        }
        base.apply(self.data.model_mut());
        self.tuned = false;
        Some(tuning)
    }
}
