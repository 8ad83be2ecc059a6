//! The right-invariant extended Kalman filter of a root and its contact points.
//!
//! Hartley, Ghaffari, Eustice and Grizzle, "Contact-aided invariant extended Kalman filtering for robot state estimation",
//! International Journal of Robotics Research 39(4), 2020. The state is an element (R, v, p, d_1..d_K) of SE_{2+K}(3), and
//! the biases of gyroscope and accelerometer. The error is right-invariant: η = X̂ X⁻¹ = exp(ξ), in the world frame.
//!
//! The covariance is a matrix of 3 x 3 blocks. Both steps touch it in place, so neither allocates.

use lifelike_character::rotation::{Mat3, Quat, Vec3};

/// Blocks of the error: rotation, velocity, position, biases of gyroscope and accelerometer; then the contacts.
const ROTATION: usize = 0;
const VELOCITY: usize = 1;
const POSITION: usize = 2;
const GYROSCOPE: usize = 3;
const ACCELEROMETER: usize = 4;
const CONTACTS: usize = 5;

/// Gravity (m/s², world).
pub(super) const GRAVITY: f64 = 9.81;
/// Noise density of the gyroscope (rad/s/√Hz) and the accelerometer (m/s²/√Hz): those of a MEMS IMU and its vibrations.
const GYROSCOPE_NOISE: f64 = 0.005;
const ACCELEROMETER_NOISE: f64 = 0.05;
/// Random walks of the biases (rad/s/√s and m/s²/√s).
const GYROSCOPE_WALK: f64 = 1e-3;
const ACCELEROMETER_WALK: f64 = 1e-2;
/// Standard deviations at the start: tilt (rad), velocity (m/s), biases (rad/s, m/s²).
const START: [f64; 4] = [0.05, 0.2, 0.02, 0.2];

/// Mean and covariance.
#[derive(Debug, Clone)]
pub(super) struct Filter {
    /// Root orientation in the world.
    pub(super) orientation: Quat,
    /// Root linear velocity (m/s, world).
    pub(super) velocity: Vec3,
    /// Root position (m, world).
    pub(super) position: Vec3,
    /// Contact points, `[K]` (m, world).
    pub(super) contacts: Vec<Vec3>,
    /// Bias of the gyroscope (rad/s, frame of the root).
    pub(super) gyroscope_bias: Vec3,
    /// Bias of the accelerometer (m/s², frame of the root).
    accelerometer_bias: Vec3,
    /// Covariance of the error, `[5 + K, 5 + K]` blocks.
    covariance: Vec<Mat3>,
    /// Covariance of the error and a residual, `[5 + K]` blocks.
    column: Vec<Mat3>,
    /// The same times the inverse of the residual's covariance.
    gain: Vec<Mat3>,
}

impl Filter {
    /// A root with `contacts` contact points at the origin.
    pub(super) fn new(contacts: usize) -> Self {
        let blocks = CONTACTS + contacts;
        Self {
            orientation: Quat::identity(),
            velocity: Vec3::zeros(),
            position: Vec3::zeros(),
            contacts: vec![Vec3::zeros(); contacts],
            gyroscope_bias: Vec3::zeros(),
            accelerometer_bias: Vec3::zeros(),
            covariance: vec![Mat3::zeros(); blocks * blocks],
            column: vec![Mat3::zeros(); blocks],
            gain: vec![Mat3::zeros(); blocks],
        }
    }

    /// Begins at a pose and a velocity. Heading and place are exact: they are the origin of the estimate.
    pub(super) fn begin(&mut self, orientation: Quat, velocity: Vec3, position: Vec3) {
        (self.orientation, self.velocity, self.position) = (orientation, velocity, position);
        (self.gyroscope_bias, self.accelerometer_bias) = (Vec3::zeros(), Vec3::zeros());
        self.covariance.fill(Mat3::zeros());
        let [tilt, velocity, gyroscope, accelerometer] = START.map(|std| std * std);
        *self.block(ROTATION, ROTATION) = Mat3::from_diagonal(&Vec3::new(tilt, tilt, 0.0));
        *self.block(VELOCITY, VELOCITY) = Mat3::from_diagonal_element(velocity);
        *self.block(GYROSCOPE, GYROSCOPE) = Mat3::from_diagonal_element(gyroscope);
        *self.block(ACCELEROMETER, ACCELEROMETER) = Mat3::from_diagonal_element(accelerometer);
    }

    fn blocks(&self) -> usize {
        self.column.len()
    }

    fn at(&self, row: usize, column: usize) -> Mat3 {
        self.covariance[row * self.blocks() + column]
    }

    fn block(&mut self, row: usize, column: usize) -> &mut Mat3 {
        let blocks = self.blocks();
        &mut self.covariance[row * blocks + column]
    }

    /// Integrates angular velocity (rad/s) and specific force (m/s²), both in the frame of the root, over `dt` (s): equations
    /// 51 and 58. `slip` is the variance by which each contact point may move in this time, `[K]` (m²).
    pub(super) fn propagate(&mut self, angular_velocity_b: Vec3, force_b: Vec3, dt: f64, slip: &[f64]) {
        let turn = self.orientation.to_rotation_matrix().into_inner();
        let (velocity, position) = (self.velocity.cross_matrix(), self.position.cross_matrix());
        let gravity = Vec3::new(0.0, 0.0, -GRAVITY);
        // Φ = I + A dt. A row reads rows that come later here, so that each is still the old one.
        for contact in 0..self.contacts.len() {
            let lever = self.contacts[contact].cross_matrix();
            self.transform(CONTACTS + contact, GYROSCOPE, &(-lever * turn * dt));
        }
        self.transform(POSITION, GYROSCOPE, &(-position * turn * dt));
        self.transform(POSITION, VELOCITY, &Mat3::from_diagonal_element(dt));
        self.transform(VELOCITY, GYROSCOPE, &(-velocity * turn * dt));
        self.transform(VELOCITY, ACCELEROMETER, &(-turn * dt));
        self.transform(VELOCITY, ROTATION, &(gravity.cross_matrix() * dt));
        self.transform(ROTATION, GYROSCOPE, &(-turn * dt));
        // The gyroscope's noise turns everything about the world's origin.
        let noise = GYROSCOPE_NOISE.powi(2) * dt;
        for row in 0..self.blocks() {
            let Some(left) = self.lever(row) else { continue };
            for column in 0..self.blocks() {
                let Some(right) = self.lever(column) else { continue };
                *self.block(row, column) += left * right.transpose() * noise;
            }
        }
        *self.block(VELOCITY, VELOCITY) += Mat3::from_diagonal_element(ACCELEROMETER_NOISE.powi(2) * dt);
        *self.block(GYROSCOPE, GYROSCOPE) += Mat3::from_diagonal_element(GYROSCOPE_WALK.powi(2) * dt);
        *self.block(ACCELEROMETER, ACCELEROMETER) += Mat3::from_diagonal_element(ACCELEROMETER_WALK.powi(2) * dt);
        for (contact, variance) in slip.iter().enumerate() {
            *self.block(CONTACTS + contact, CONTACTS + contact) += Mat3::from_diagonal_element(*variance);
        }
        let rate = (angular_velocity_b - self.gyroscope_bias) * dt;
        let middle = self.orientation * Quat::from_scaled_axis(rate * 0.5);
        let acceleration = middle * (force_b - self.accelerometer_bias) + gravity;
        self.position += self.velocity * dt + acceleration * (0.5 * dt * dt);
        self.velocity += acceleration * dt;
        self.orientation *= Quat::from_scaled_axis(rate);
    }

    /// Adds `factor` times block row `from` to block row `to`, and the same for columns.
    fn transform(&mut self, to: usize, from: usize, factor: &Mat3) {
        for column in 0..self.blocks() {
            let added = factor * self.at(from, column);
            *self.block(to, column) += added;
        }
        for row in 0..self.blocks() {
            let added = self.at(row, from) * factor.transpose();
            *self.block(row, to) += added;
        }
    }

    /// Returns the matrix by which the gyroscope's noise, turned to the world, enters a block; none for the biases.
    fn lever(&self, block: usize) -> Option<Mat3> {
        match block {
            ROTATION => Some(Mat3::identity()),
            VELOCITY => Some(self.velocity.cross_matrix()),
            POSITION => Some(self.position.cross_matrix()),
            GYROSCOPE | ACCELEROMETER => None,
            contact => Some(self.contacts[contact - CONTACTS].cross_matrix()),
        }
    }

    /// Puts a contact point where the leg has it now (m, frame of the root), with its covariance (m², world): equation 39.
    pub(super) fn place(&mut self, contact: usize, point_b: Vec3, noise: &Mat3) {
        self.contacts[contact] = self.position + self.orientation * point_b;
        let own = CONTACTS + contact;
        for other in 0..self.blocks() {
            let block = self.at(POSITION, other);
            (*self.block(own, other), *self.block(other, own)) = (block, block.transpose());
        }
        *self.block(own, own) = self.at(POSITION, POSITION) + noise;
    }

    /// Corrects the state by the place of a contact point that the leg's joints measure (m, frame of the root), with its
    /// covariance (m², world): equations 26 to 28.
    pub(super) fn correct(&mut self, contact: usize, point_b: Vec3, noise: &Mat3) {
        let own = CONTACTS + contact;
        let residual = self.orientation * point_b - (self.contacts[contact] - self.position);
        for block in 0..self.blocks() {
            self.column[block] = self.at(block, POSITION) - self.at(block, own);
        }
        let variance = self.column[POSITION] - self.column[own] + noise;
        let Some(inverse) = variance.try_inverse() else { return };
        for block in 0..self.blocks() {
            self.gain[block] = self.column[block] * inverse;
        }
        // One half and its mirror image: rounding must not make the covariance asymmetric, which grows.
        for row in 0..self.blocks() {
            for column in 0..=row {
                let left = self.at(row, column) - self.gain[row] * self.column[column].transpose();
                let right = self.at(column, row) - self.gain[column] * self.column[row].transpose();
                let mean = (left + right.transpose()) * 0.5;
                (*self.block(row, column), *self.block(column, row)) = (mean, mean.transpose());
            }
        }
        // X⁺ = exp(-ξ) X.
        let turned = -self.gain[ROTATION] * residual;
        let (turn, left) = (Quat::from_scaled_axis(turned), left_jacobian(turned));
        self.orientation = turn * self.orientation;
        self.velocity = turn * self.velocity - left * self.gain[VELOCITY] * residual;
        self.position = turn * self.position - left * self.gain[POSITION] * residual;
        for (i, point) in self.contacts.iter_mut().enumerate() {
            *point = turn * *point - left * self.gain[CONTACTS + i] * residual;
        }
        self.gyroscope_bias -= self.gain[GYROSCOPE] * residual;
        self.accelerometer_bias -= self.gain[ACCELEROMETER] * residual;
    }

    /// Returns whether every number of the mean is finite.
    pub(super) fn is_finite(&self) -> bool {
        let all = self.orientation.coords.iter().chain(&self.velocity).chain(&self.position);
        all.chain(&self.gyroscope_bias).all(|x| x.is_finite())
    }
}

/// The left Jacobian of SO(3) at a rotation vector (rad).
fn left_jacobian(vector: Vec3) -> Mat3 {
    let (angle, cross) = (vector.norm(), vector.cross_matrix());
    if angle < 1e-6 {
        return Mat3::identity() + cross * 0.5;
    }
    let square = angle * angle;
    Mat3::identity()
        + cross * ((1.0 - angle.cos()) / square)
        + cross * cross * ((angle - angle.sin()) / (square * angle))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_left_jacobian_is_the_integral_of_the_exponential() {
        let vector = Vec3::new(0.3, -0.5, 0.7);
        let steps = 20_000;
        let middle = |i: usize| Quat::from_scaled_axis(vector * ((i as f64 + 0.5) / f64::from(steps)));
        let sum: Mat3 = (0..steps as usize).map(|i| middle(i).to_rotation_matrix().into_inner()).sum();
        assert!((sum / f64::from(steps) - left_jacobian(vector)).norm() < 1e-8);
    }

    /// A covariance of rank one is the outer product of an error. After a step it is that of the error after the step, which
    /// two filters that are apart by the error show without any derivative.
    #[test]
    fn the_covariance_goes_on_as_small_errors_do() {
        use lifelike_checkpoint::rng::stream;
        use rand::Rng;
        let mut truth = Filter::new(1);
        truth.begin(
            Quat::from_scaled_axis(Vec3::new(0.2, 0.1, 0.5)),
            Vec3::new(0.3, 0.1, 0.0),
            Vec3::new(1.0, 2.0, 0.5),
        );
        let point = Vec3::new(0.1, 0.0, -0.5);
        truth.place(0, point, &Mat3::from_diagonal_element(1e-6));
        let (rate, force) = (Vec3::new(0.5, -0.3, 0.2), Vec3::new(0.5, 0.2, 9.7));
        let mut rng = stream(3, "filter", 0, 0);
        for _ in 0..20 {
            let mut draw = |size: f64| Vec3::from_fn(|_, _| size * rng.random_range(-1.0..=1.0));
            let error: [Vec3; 6] = [draw(1e-4), draw(1e-4), draw(1e-4), draw(1e-4), draw(1e-4), draw(1e-4)];
            let turn = Quat::from_scaled_axis(error[0]);
            let mut estimate = truth.clone();
            estimate.orientation = turn * truth.orientation;
            estimate.velocity = turn * truth.velocity + error[1];
            estimate.position = turn * truth.position + error[2];
            estimate.gyroscope_bias += error[3];
            estimate.accelerometer_bias += error[4];
            estimate.contacts[0] = turn * truth.contacts[0] + error[5];
            for (row, a) in error.iter().enumerate() {
                for (column, b) in error.iter().enumerate() {
                    *estimate.block(row, column) = a * b.transpose();
                }
            }
            let (mut later, mut noise, before) = (truth.clone(), estimate.clone(), estimate.covariance.clone());
            noise.covariance.fill(Mat3::zeros());
            noise.propagate(rate, force, 0.001, &[0.0]);
            later.propagate(rate, force, 0.001, &[0.0]);
            estimate.propagate(rate, force, 0.001, &[0.0]);
            let turned = (estimate.orientation * later.orientation.inverse()).scaled_axis();
            let back = Quat::from_scaled_axis(turned);
            let after = [
                turned,
                estimate.velocity - back * later.velocity,
                estimate.position - back * later.position,
                error[3],
                error[4],
                estimate.contacts[0] - back * later.contacts[0],
            ];
            let mut change: f64 = 0.0;
            for row in 0..6 {
                for column in 0..6 {
                    let own = estimate.at(row, column) - noise.at(row, column);
                    let expected = after[row] * after[column].transpose();
                    // The step's second order: 1e-6 s² times 10 m/s² times both errors of 1e-4; twice, for rows and columns.
                    assert!((own - expected).norm() < 1e-12, "{row} {column}: {own} {expected}");
                    change = change.max((expected - before[row * 6 + column]).norm());
                }
            }
            assert!(change > 1e-11, "the first order: 1e-3 s times 10 m/s² times both errors");
        }
    }
}
