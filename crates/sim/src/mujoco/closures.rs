//! Wrenches of welds and ball joints that close loops, from the forces that MuJoCo's solver found: in `cfrc_ext` they are in
//! one sum with contacts and pushes.

use lifelike_character::{Quat, Vec3};
use nalgebra::Quaternion;

use super::native::{CNSTR_EQUALITY, EQ_JOINT, EQ_WELD, OBJ_SITE};
use super::worker::Worker;
use super::wrenches::Wrench;

fn quaternion([w, x, y, z]: [f64; 4]) -> Quaternion<f64> {
    Quaternion::new(w, x, y, z)
}

impl Worker {
    /// Returns the wrenches on every body about the world's origin, after a forward step; what acts on the world is left out.
    pub(super) fn closure_wrenches(&self) -> Vec<Wrench> {
        let (data, model) = (&self.data, self.data.model());
        let mut out = vec![Wrench::default(); self.layout.bodies];
        if model.neq() == 0 {
            return out;
        }
        let forces = data.efc_force();
        let index = |id: i32| id.max(0) as usize;
        let mut row = 0;
        while data.efc_type().get(row) == Some(&CNSTR_EQUALITY) {
            let id = index(data.efc_id()[row]);
            let (objects, numbers) = ([model.eq_obj1id()[id], model.eq_obj2id()[id]].map(index), model.eq_data()[id]);
            // A joint that follows another pulls through its own axis.
            if model.eq_type()[id] == EQ_JOINT {
                row += 1;
                continue;
            }
            let weld = model.eq_type()[id] == EQ_WELD;
            let of_sites = model.eq_objtype()[id] == OBJ_SITE;
            let bodies = if of_sites { objects.map(|site| index(model.site_bodyid()[site])) } else { objects };
            let orientation = bodies.map(|body| quaternion(data.xquat()[body]));
            let force = Vec3::from_column_slice(&forces[row..row + 3]);
            let mut torque = Vec3::zeros();
            if weld {
                let own = match of_sites {
                    true => objects.map(|site| quaternion(model.site_quat()[site])),
                    false => [quaternion([6, 7, 8, 9].map(|i| numbers[i])), Quaternion::identity()],
                };
                let frames = [orientation[0] * own[0], orientation[1] * own[1]];
                // The rows are of the vector part of a quaternion: see `engine::closure` for the torque.
                let error = frames[1].conjugate() * frames[0];
                let along = Vec3::from_column_slice(&forces[row + 3..row + 6]);
                let along = along * error.w + error.imag().cross(&along);
                torque = Quat::new_unchecked(frames[1]) * along * (0.5 * numbers[10]);
            }
            for (k, sign) in [1.0, -1.0].into_iter().enumerate() {
                // The anchors of a weld stand in the other order.
                let at = if weld { 3 - 3 * k } else { 3 * k };
                let local = if of_sites { model.site_pos()[objects[k]] } else { [0, 1, 2].map(|i| numbers[at + i]) };
                let turned = Quat::new_unchecked(orientation[k]) * Vec3::from(local);
                let point = Vec3::from(data.xpos()[bodies[k]]) + turned;
                let (all, sum) = &mut out[bodies[k]];
                *all += (torque + point.cross(&force)) * sign;
                *sum += force * sign;
            }
            row += if weld { 6 } else { 3 };
        }
        out[0] = Wrench::default();
        out
    }
}
