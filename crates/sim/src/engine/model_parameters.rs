//! Constants of a model that may differ between environments.

use lifelike_robot::actuator::ActuatorParameters;

use super::lanes::{Lanes, Scalar};
use super::spatial::Vec3;
use super::tree::Tree;
use crate::batch::EnvironmentParameters;

/// Constants of each environment. They cost a load each, where the model's own would be broadcast.
#[derive(Debug, Clone)]
pub struct ModelParameters<V: Lanes> {
    /// Factor on mass and inertia of each body.
    pub mass: Vec<V>,
    /// Further factor on the inertia of each body.
    pub inertia: Vec<V>,
    /// Centre of mass of each body in its frame (m).
    pub com: Vec<Vec3<V>>,
    /// Gravity (m/s²).
    pub gravity: Vec3<V>,
    /// Armature of each dof.
    pub armature: Vec<V>,
    /// Damping of each dof.
    pub damping: Vec<V>,
    /// Gains of each actuator: κ_P, κ_D.
    pub gains: Vec<[V; 2]>,
    /// Factor on each actuator's motor torque.
    pub strength: Vec<V>,
    /// Friction of every contact; below zero: its own.
    pub friction: V,
    /// Friction of each foot on the ground; below zero: that of all contacts.
    pub feet: Vec<V>,
}

impl<V: Lanes> ModelParameters<V> {
    /// The model's own constants everywhere.
    pub fn nominal(tree: &Tree<V::Scalar>, actuators: &[ActuatorParameters<V>]) -> Self {
        let one = V::splat_f64(1.0);
        Self {
            mass: vec![one; tree.bodies.len()],
            inertia: vec![one; tree.bodies.len()],
            com: tree.bodies.iter().map(|b| b.com.map(V::splat)).collect(),
            gravity: tree.gravity.map(V::splat),
            armature: tree.dofs.iter().map(|d| V::splat(d.armature)).collect(),
            damping: tree.dofs.iter().map(|d| V::splat(d.damping)).collect(),
            gains: actuators.iter().map(|a| [a.kp, a.kd]).collect(),
            strength: vec![one; actuators.len()],
            friction: V::splat_f64(-1.0),
            feet: vec![V::splat_f64(-1.0); tree.feet],
        }
    }

    /// Gives one lane the constants of its environment. `own` are the model's.
    pub fn set(&mut self, lane: usize, tree: &Tree<V::Scalar>, own: &Self, parameters: &EnvironmentParameters) {
        let scaled = |slots: &mut Vec<V>, own: &[V], scale: &[f32]| {
            for (i, (slot, own)) in slots.iter_mut().zip(own).enumerate() {
                slot.set_lane(lane, own.lane(lane) * factor(scale, i));
            }
        };
        scaled(&mut self.mass, &own.mass, &parameters.mass_scale);
        scaled(&mut self.inertia, &own.inertia, &parameters.inertia_scale);
        for (i, (slot, own)) in self.com.iter_mut().zip(&own.com).enumerate() {
            for k in 0..3 {
                let offset = parameters.com_offset.get(i).map_or(0.0, |offset| f64::from(offset[k]));
                slot[k].set_lane(lane, own[k].lane(lane) + V::Scalar::new(offset));
            }
        }
        for k in 0..3 {
            let value = parameters.gravity.map(|gravity| Scalar::new(f64::from(gravity[k])));
            self.gravity[k].set_lane(lane, value.unwrap_or(own.gravity[k].lane(lane)));
        }
        for (i, joint) in tree.driven.iter().enumerate() {
            let [armature, damping, kp, kd] =
                [&parameters.armature_scale, &parameters.damping_scale, &parameters.kp_scale, &parameters.kd_scale]
                    .map(|scale| factor::<V::Scalar>(scale, i));
            self.armature[joint.v].set_lane(lane, own.armature[joint.v].lane(lane) * armature);
            self.damping[joint.v].set_lane(lane, own.damping[joint.v].lane(lane) * damping);
            if let Some((gains, own)) = self.gains.get_mut(i).zip(own.gains.get(i)) {
                gains[0].set_lane(lane, own[0].lane(lane) * kp);
                gains[1].set_lane(lane, own[1].lane(lane) * kd);
            }
        }
        for (i, slot) in self.strength.iter_mut().enumerate() {
            slot.set_lane(lane, factor(&parameters.strength_scale, i));
        }
        let common = parameters.ground_friction.map_or(-1.0, f64::from);
        self.friction.set_lane(lane, Scalar::new(common));
        for (i, slot) in self.feet.iter_mut().enumerate() {
            slot.set_lane(lane, Scalar::new(parameters.foot_friction.get(i).map_or(common, |x| f64::from(*x))));
        }
    }

    /// Numbers per environment.
    pub fn len(&self) -> usize {
        let lists = self.mass.len() + self.inertia.len() + self.armature.len() + self.damping.len();
        lists + 3 * self.com.len() + 2 * self.gains.len() + self.strength.len() + self.feet.len() + 4
    }
}

/// Factor `i` of a list; an empty one is of ones.
fn factor<T: Scalar>(scale: &[f32], i: usize) -> T {
    Scalar::new(scale.get(i).map_or(1.0, |x| f64::from(*x)))
}
