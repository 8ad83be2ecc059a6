//! Forces that hold the bodies of a robot together: what thesis chapter 2 calls constraint forces.

/// Wrenches on every body of every environment, `[N, B, 6]`: torque (N m), then force (N), axes of the world. Row 0 of each
/// environment, the world, is zero, and so is everything in an environment that has diverged.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ConstraintWrenches {
    /// Wrench of each parent on its child through the joints between them: constraint, motor, friction and limit
    /// together; equality constraints left out. About the origin of the child's frame.
    pub joint: Vec<f32>,
    /// Wrench of all joints of a body on it together, and of what closes loops (equality constraints, which are joints that no
    /// tree has): f_C of thesis eq. 2.1. About its centre of mass.
    pub constraint: Vec<f32>,
    /// Wrench of the ground and of other parts of the robot where they touch. About the centre of mass.
    pub contact: Vec<f32>,
    /// Torque (N m; force for slides) of each scalar joint's actuator side on the part that it drives, `[N, J]`: the component
    /// of [`Self::joint`] along the joint's axis, so the joint's own friction, damping and armature are already taken off.
    /// It is f_C of an actuator as a building block (thesis 2.3.1).
    pub joint_load: Vec<f32>,
}

impl ConstraintWrenches {
    /// No forces on so many environments of so many bodies and scalar joints.
    pub fn zeros(environments: usize, bodies: usize, joints: usize) -> Self {
        let wrenches = vec![0.0; environments * bodies * 6];
        Self {
            joint: wrenches.clone(),
            constraint: wrenches.clone(),
            contact: wrenches,
            joint_load: vec![0.0; environments * joints],
        }
    }

    /// Cuts the rows into groups of `n` environments that can be written side by side.
    pub(crate) fn chunks_mut(&mut self, n: usize, bodies: usize, joints: usize) -> Vec<WrenchRows<'_>> {
        let wrenches = (n * bodies * 6).max(1);
        let wrenches = self
            .joint
            .chunks_mut(wrenches)
            .zip(self.constraint.chunks_mut(wrenches))
            .zip(self.contact.chunks_mut(wrenches));
        // A robot without scalar joints has no loads to cut.
        let mut loads = self.joint_load.chunks_mut((n * joints).max(1));
        wrenches
            .map(|((joint, constraint), contact)| {
                let joint_load = loads.next().unwrap_or_default();
                WrenchRows { joint, constraint, contact, joint_load }
            })
            .collect()
    }
}

/// [`ConstraintWrenches`] of some environments that lie side by side.
pub(crate) struct WrenchRows<'a> {
    pub joint: &'a mut [f32],
    pub constraint: &'a mut [f32],
    pub contact: &'a mut [f32],
    pub joint_load: &'a mut [f32],
}
