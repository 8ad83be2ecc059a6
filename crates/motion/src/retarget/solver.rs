//! Damped Gauss-Newton with box constraints on one pose: small, dense, no allocation once it runs.

use lifelike_character::rotation::{from_wxyz, to_wxyz};
use lifelike_character::{Kinematics, Quat, Vec3};

use super::rig::{Rig, Segment, Spot};

/// Task of a body. Residuals are lengths over the leg length, or radians; weights multiply them.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Task {
    /// A segment points this way (unit vector).
    Direction { segment: Segment, target: Vec3, weight: f64 },
    /// A spot is here (m, world); a weight per world axis.
    Position { spot: Spot, target: Vec3, weight: Vec3 },
    /// A body is oriented so.
    Orientation { body: usize, target: Quat, weight: f64 },
    /// Two spots are at least this far apart (m) along a direction (unit, from `b` to `a`).
    Apart { a: Spot, b: Spot, normal: Vec3, distance: f64, weight: f64 },
    /// An axis of a body points this way; a weight per world axis.
    Axis { body: usize, axis: Vec3, target: Vec3, weight: Vec3 },
    /// The centre of mass is above this place of the ground (m, world).
    Centre { target: Vec3, weight: f64 },
}

/// Bounds and wishes of the scalar joints for one frame, in the order of [`Rig::axes`].
#[derive(Debug, Clone)]
pub(crate) struct Limits {
    pub low: Vec<f64>,
    pub high: Vec<f64>,
    pub wish: Vec<f64>,
    pub weight: Vec<f64>,
}

impl Limits {
    /// Returns the joints' own bounds, and no wish.
    pub fn new(rig: &Rig) -> Self {
        Self {
            low: rig.axes.iter().map(|a| a.low).collect(),
            high: rig.axes.iter().map(|a| a.high).collect(),
            wish: rig.axes.iter().map(|a| a.neutral).collect(),
            weight: vec![0.0; rig.axes.len()],
        }
    }
}

/// A reusable workspace for a subset of the degrees of freedom.
pub(crate) struct Solver<'a> {
    rig: &'a Rig<'a>,
    pub kinematics: Kinematics,
    /// Generalised position: input and result.
    pub q: Vec<f64>,
    before: Vec<f64>,
    /// Velocity index → position in the reduced system.
    slot: Vec<Option<usize>>,
    /// Reduced position → index into `rig.axes`, for scalar joints.
    axis: Vec<Option<usize>>,
    hessian: Vec<f64>,
    factor: Vec<f64>,
    gradient: Vec<f64>,
    step: Vec<f64>,
    right: Vec<f64>,
    frozen: Vec<bool>,
    jacobian: Vec<Vec3>,
    touched: Vec<usize>,
    is_touched: Vec<bool>,
}

impl<'a> Solver<'a> {
    /// Returns a solver for the root and those joints that `moves` picks.
    pub fn new(rig: &'a Rig<'a>, moves: impl Fn(usize) -> bool) -> Self {
        let mut slot = vec![None; rig.character.nv];
        let mut axis = Vec::new();
        for i in 0..6 {
            slot[rig.root.v_index + i] = Some(i);
            axis.push(None);
        }
        for (i, a) in rig.axes.iter().enumerate().filter(|(i, _)| moves(*i)) {
            slot[a.v] = Some(axis.len());
            axis.push(Some(i));
        }
        let n = axis.len();
        Self {
            rig,
            kinematics: Kinematics::new(rig.character),
            q: rig.character.reference_position(),
            before: rig.character.reference_position(),
            slot,
            axis,
            hessian: vec![0.0; n * n],
            factor: vec![0.0; n * n],
            gradient: vec![0.0; n],
            step: vec![0.0; n],
            right: vec![0.0; n],
            frozen: vec![false; n],
            jacobian: vec![Vec3::zeros(); n],
            touched: Vec::with_capacity(n),
            is_touched: vec![false; n],
        }
    }

    /// Improves `self.q` in at most `iterations` steps. A step that made things worse is taken back and tried again
    /// with more damping (Levenberg-Marquardt). Targets that cannot be met together therefore do not make the pose
    /// jump about. Returns the cost reached.
    pub fn solve(&mut self, tasks: &[Task], limits: &Limits, iterations: usize) -> f64 {
        let mut damping = 1e-4;
        let mut cost = self.assemble(tasks, limits, damping);
        for _ in 0..iterations {
            self.before.copy_from_slice(&self.q);
            self.find_step(limits);
            let step = self.apply_step(limits);
            let then = self.assemble(tasks, limits, damping);
            if then > cost {
                self.q.copy_from_slice(&self.before);
                damping *= 30.0;
                cost = self.assemble(tasks, limits, damping);
            } else {
                cost = then;
                damping = (damping * 0.3).max(1e-4);
                if step < 2e-4 {
                    break;
                }
            }
        }
        cost
    }

    /// Assembles Hessian and gradient at `self.q`; returns the cost there.
    fn assemble(&mut self, tasks: &[Task], limits: &Limits, damping: f64) -> f64 {
        self.kinematics.update(self.rig.character, &self.q);
        let mut cost = 0.0;
        self.hessian.fill(0.0);
        self.gradient.fill(0.0);
        let scale = 1.0 / self.rig.leg_length;
        for task in tasks {
            match task {
                Task::Direction { segment, target, weight } => {
                    let (a, b) = (segment.from, segment.to);
                    let from = self.kinematics.point(a.body, &a.point);
                    let to = self.kinematics.point(b.body, &b.point);
                    self.columns(b.body, &to, |linear, _| linear);
                    self.columns(a.body, &from, |linear, _| -linear);
                    let inverse = 1.0 / segment.length;
                    cost += self.add(&(target - (to - from) * inverse), &Vec3::repeat(*weight), inverse);
                }
                Task::Position { spot, target, weight } => {
                    let at = self.kinematics.point(spot.body, &spot.point);
                    self.columns(spot.body, &at, |linear, _| linear);
                    cost += self.add(&((target - at) * scale), weight, scale);
                }
                Task::Apart { a, b, normal, distance, weight } => {
                    let (p, q) = (self.kinematics.point(a.body, &a.point), self.kinematics.point(b.body, &b.point));
                    let missing = distance - normal.dot(&(p - q));
                    if missing > 0.0 {
                        self.columns(a.body, &p, |linear, _| Vec3::new(linear.dot(normal), 0.0, 0.0));
                        self.columns(b.body, &q, |linear, _| Vec3::new(-linear.dot(normal), 0.0, 0.0));
                        cost += self.add(&Vec3::new(missing * scale, 0.0, 0.0), &Vec3::repeat(*weight), scale);
                    }
                }
                Task::Orientation { body, target, weight } => {
                    let error = (target * self.kinematics.body_orientation[*body].inverse()).scaled_axis();
                    self.columns(*body, &Vec3::zeros(), |_, angular| angular);
                    cost += self.add(&error, &Vec3::repeat(*weight), 1.0);
                }
                Task::Axis { body, axis, target, weight } => {
                    let axis = self.kinematics.body_orientation[*body] * axis;
                    self.columns(*body, &Vec3::zeros(), |_, angular| angular.cross(&axis));
                    cost += self.add(&(target - axis), weight, 1.0);
                }
                Task::Centre { target, weight } => {
                    let missing = (target - self.centre_columns()) * scale;
                    cost += self.add(&missing, &Vec3::new(*weight, *weight, 0.0), scale);
                }
            }
        }
        let n = self.axis.len();
        for (i, axis) in self.axis.iter().enumerate() {
            let mut pull = damping;
            if let Some(a) = axis {
                let w = limits.weight[*a] * limits.weight[*a];
                pull += w;
                let away = limits.wish[*a] - self.q[self.rig.axes[*a].q];
                self.gradient[i] += w * away;
                cost += w * away * away;
            }
            self.hessian[i * n + i] += pull;
        }
        cost
    }

    /// Adds the Jacobian columns of the centre of mass to `self.jacobian`. Returns its place (m, world).
    fn centre_columns(&mut self) -> Vec3 {
        let character = self.rig.character;
        let total = character.mass();
        let mut centre = Vec3::zeros();
        for (body, own) in character.bodies.iter().enumerate().filter(|(_, body)| body.inertial.mass > 0.0) {
            let share = own.inertial.mass / total;
            let at = self.kinematics.point(body, &own.inertial.com);
            self.columns(body, &at, |linear, _| linear * share);
            centre += at * share;
        }
        centre
    }

    /// Adds the Jacobian columns of a point on a body to `self.jacobian`.
    fn columns(&mut self, body: usize, point: &Vec3, pick: impl Fn(Vec3, Vec3) -> Vec3) {
        let Self { kinematics, rig, slot, jacobian, touched, is_touched, .. } = self;
        kinematics.for_each_column(rig.character, body, point, |column, linear, angular| {
            if let Some(i) = slot[column] {
                if !is_touched[i] {
                    is_touched[i] = true;
                    touched.push(i);
                }
                jacobian[i] += pick(linear, angular);
            }
        });
    }

    /// Adds a residual whose Jacobian is `scale * self.jacobian`, and clears that. Returns its cost.
    fn add(&mut self, residual: &Vec3, weight: &Vec3, scale: f64) -> f64 {
        let n = self.axis.len();
        let weighted = residual.component_mul(weight);
        let factor = weight * scale;
        self.touched.sort_unstable();
        for &i in &self.touched {
            let column = self.jacobian[i].component_mul(&factor);
            self.jacobian[i] = column;
            self.gradient[i] += column.dot(&weighted);
        }
        for (k, &i) in self.touched.iter().enumerate() {
            let column = self.jacobian[i];
            let row = &mut self.hessian[i * n..(i + 1) * n];
            for &j in &self.touched[..=k] {
                row[j] += column.dot(&self.jacobian[j]);
            }
        }
        for &i in &self.touched {
            self.jacobian[i] = Vec3::zeros();
            self.is_touched[i] = false;
        }
        self.touched.clear();
        weighted.norm_squared()
    }

    /// Returns how far a reduced coordinate may still go down and up in one step.
    fn room(&self, i: usize, limits: &Limits) -> (f64, f64) {
        match self.axis[i] {
            None => (-0.5, 0.5),
            Some(a) => {
                let q = self.q[self.rig.axes[a].q];
                ((limits.low[a] - q).clamp(-0.6, 0.0), (limits.high[a] - q).clamp(0.0, 0.6))
            }
        }
    }

    /// Finds a projected Newton step: what would leave its bounds is put on them, and the rest solved again.
    fn find_step(&mut self, limits: &Limits) {
        let n = self.axis.len();
        self.frozen.fill(false);
        self.step.fill(0.0);
        for _ in 0..3 {
            for i in 0..n {
                let row = i * n;
                for j in 0..=i {
                    let apart = self.frozen[i] || self.frozen[j];
                    self.factor[row + j] = match (apart, i == j) {
                        (false, _) => self.hessian[row + j],
                        (true, true) => 1.0,
                        (true, false) => 0.0,
                    };
                }
            }
            for i in 0..n {
                self.right[i] = if self.frozen[i] {
                    self.step[i]
                } else {
                    let held = (0..n).filter(|&j| self.frozen[j]).map(|j| {
                        let h = if i > j { self.hessian[i * n + j] } else { self.hessian[j * n + i] };
                        h * self.step[j]
                    });
                    self.gradient[i] - held.sum::<f64>()
                };
            }
            cholesky_solve(&mut self.factor, &mut self.right, n);
            self.step.copy_from_slice(&self.right);
            let mut again = false;
            for i in 0..n {
                let (low, high) = self.room(i, limits);
                if !self.frozen[i] && !(low..=high).contains(&self.step[i]) {
                    self.step[i] = self.step[i].clamp(low, high);
                    self.frozen[i] = true;
                    again = true;
                }
            }
            if !again {
                break;
            }
        }
    }

    /// Moves by the step; returns its largest component.
    fn apply_step(&mut self, limits: &Limits) -> f64 {
        let at = self.rig.root.q_index;
        let step = &self.step;
        for (q, s) in self.q[at..at + 3].iter_mut().zip(step) {
            *q += s;
        }
        let q = &mut self.q;
        let turned = from_wxyz([q[at + 3], q[at + 4], q[at + 5], q[at + 6]]).unwrap_or_else(Quat::identity)
            * Quat::from_scaled_axis(Vec3::new(step[3], step[4], step[5]));
        q[at + 3..at + 7].copy_from_slice(&to_wxyz(&turned));
        for (i, axis) in self.axis.iter().enumerate() {
            if let Some(a) = axis {
                let value = &mut q[self.rig.axes[*a].q];
                *value = (*value + step[i]).max(limits.low[*a]).min(limits.high[*a]);
            }
        }
        step.iter().fold(0.0, |m, s| m.max(s.abs()))
    }
}

/// Solves `A x = b` in place for a symmetric positive definite `A`, given by its lower triangle (row-major, `n` wide).
/// Pivots that rounding drove to zero are lifted: the caller's damping makes that a formality.
fn cholesky_solve(a: &mut [f64], b: &mut [f64], n: usize) {
    for i in 0..n {
        let (above, row) = a.split_at_mut(i * n);
        let row = &mut row[..=i];
        for j in 0..i {
            let other = &above[j * n..=j * n + j];
            let sum = dot(&row[..j], &other[..j]);
            row[j] = (row[j] - sum) * other[j];
        }
        let pivot = (row[i] - dot(&row[..i], &row[..i])).max(1e-12);
        // The diagonal holds the reciprocal: divisions are what small factorizations spend their time on.
        row[i] = 1.0 / pivot.sqrt();
    }
    for i in 0..n {
        b[i] = (b[i] - dot(&a[i * n..i * n + i], &b[..i])) * a[i * n + i];
    }
    for i in (0..n).rev() {
        let value = b[i] * a[i * n + i];
        b[i] = value;
        for j in 0..i {
            b[j] -= a[i * n + j] * value;
        }
    }
}

/// Returns the inner product in four lanes.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut lanes = [0.0; 4];
    let (a4, b4) = (a.chunks_exact(4), b.chunks_exact(4));
    let tail: f64 = a4.remainder().iter().zip(b4.remainder()).map(|(x, y)| x * y).sum();
    for (x, y) in a4.zip(b4) {
        for lane in 0..4 {
            lanes[lane] += x[lane] * y[lane];
        }
    }
    (lanes[0] + lanes[1]) + (lanes[2] + lanes[3]) + tail
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cholesky_solves_what_nalgebra_solves() {
        for n in 1..12 {
            let seed = nalgebra::DMatrix::from_fn(n, n, |i, j| ((i * 7 + j * 13 + 1) as f64).sin());
            let spd = &seed * seed.transpose() + nalgebra::DMatrix::identity(n, n) * 0.1;
            let b = nalgebra::DVector::from_fn(n, |i, _| (i as f64 + 0.3).cos());
            let mut a: Vec<f64> = (0..n * n).map(|k| spd[(k / n, k % n)]).collect();
            let mut x: Vec<f64> = b.iter().copied().collect();
            cholesky_solve(&mut a, &mut x, n);
            let back = &spd * nalgebra::DVector::from_vec(x);
            assert!((back - b).norm() < 1e-10, "n = {n}");
        }
    }
}
