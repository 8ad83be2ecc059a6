//! A test bench for one servo: it turns a weight on an arm, as benches for identification do.
//!
//! The main path: [`PendulumBench`] (what hangs on the servo, and what is believed of the servo) → [`PendulumBench::run`] along
//! the commands of a log → [`BenchMotion`].

use lifelike_robot::actuator::{DcMotor, ExtendedFriction};

/// Gravity (m/s²).
pub const GRAVITY: f64 = 9.806_65;

/// A servo with a weight on an arm; at angle 0 the arm hangs.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PendulumBench {
    /// Weight (kg).
    pub mass: f64,
    /// Mass of the arm, a uniform rod (kg).
    #[serde(default, skip_serializing_if = "is_zero")]
    pub arm_mass: f64,
    /// From the axis to the weight (m).
    pub arm: f64,
    /// The controller's own reference follows commands no faster (rad/s); it begins where the servo does.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub goal_speed: Option<f64>,
    /// Inertia of rotor and gears at the output (kg m²).
    pub armature: f64,
    /// Added to the servo's angle it is the arm's (rad): how crooked the arm sits.
    pub offset: f64,
    /// Controller and motor.
    pub motor: DcMotor,
    /// Friction of the gears.
    pub friction: ExtendedFriction,
    /// Commands take effect so much later (s).
    pub delay: f64,
}

fn is_zero(x: &f64) -> bool {
    *x == 0.0
}

/// Commands along a log, at equal time steps.
#[derive(Debug, Clone, Copy)]
pub struct BenchCommands<'a> {
    /// Time step (s).
    pub step: f64,
    /// Commanded positions (rad).
    pub goal: &'a [f64],
    /// True while the motor is on.
    pub enabled: &'a [bool],
}

/// Motion of the servo, a number for each command.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct BenchMotion {
    /// Position (rad).
    pub position: Vec<f64>,
    /// Velocity (rad/s).
    pub velocity: Vec<f64>,
    /// Voltage on the winding (V).
    pub voltage: Vec<f64>,
    /// Current (A).
    pub current: Vec<f64>,
    /// Torque from outside (N m): f_C of the servo as a building block (thesis 2.3.1).
    pub load: Vec<f64>,
}

/// No servo turns faster (rad/s); what does has a model that explodes.
const FASTEST: f64 = 100.0;

impl PendulumBench {
    /// Simulates the bench from a position (rad) and a velocity (rad/s), as BAM does it: the velocity first, then the position by
    /// the mean of both. The state of a step is that before its command acts.
    pub fn run(&self, commands: BenchCommands<'_>, position: f64, velocity: f64) -> BenchMotion {
        let dt = commands.step;
        let inertia = (self.mass + self.arm_mass / 3.0) * self.arm * self.arm + self.armature;
        let weight = (self.mass + 0.5 * self.arm_mass) * GRAVITY;
        let (mut q, mut v, mut integral) = (position, velocity, 0.0);
        let mut motion = BenchMotion::default();
        let (mut goal, farthest) = (position, self.goal_speed.map_or(f64::INFINITY, |speed| speed * dt));
        for (i, enabled) in commands.enabled.iter().enumerate() {
            goal = self.delayed(commands.goal, i, dt).clamp(goal - farthest, goal + farthest);
            let load = -weight * self.arm * (q + self.offset).sin();
            let error = goal - q;
            let state = match enabled {
                true => self.motor.drive(self.motor.duty(error, integral, v), v),
                false => Default::default(),
            };
            motion.position.push(q);
            motion.velocity.push(v);
            motion.voltage.push(state.voltage);
            motion.current.push(state.current);
            motion.load.push(load);
            integral = if *enabled { integral + error * dt } else { 0.0 };
            let torque = state.torque + load + self.friction.torque(state.torque, load, v, inertia, dt);
            let acceleration = torque / inertia;
            v = (v + acceleration * dt).clamp(-FASTEST, FASTEST);
            q += v * dt + 0.5 * acceleration * dt * dt;
        }
        motion
    }

    /// The command that acts at a step, between two where the delay is no whole number of steps.
    fn delayed(&self, goal: &[f64], i: usize, step: f64) -> f64 {
        let at = (i as f64 - self.delay / step).max(0.0);
        let (before, share) = (at.floor() as usize, at.fract());
        let next = goal.get(before + 1).copied().unwrap_or(goal[before]);
        goal[before] + share * (next - goal[before])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_arm_swings_as_a_rod() {
        // Without a weight a rod swings by 2 pi sqrt(2 l / 3 g); with one of 0.2 kg on a rod of 0.3 kg, by
        // 2 pi sqrt((0.2 + 0.3 / 3) l / ((0.2 + 0.3 / 2) g)).
        for (mass, arm_mass, length) in [(0.0, 0.3, 2.0 / 3.0 * 0.2), (0.2, 0.3, 0.3 / 0.35 * 0.2), (0.2, 0.0, 0.2)] {
            let motor = DcMotor {
                proportional: 0.0,
                integral: 0.0,
                derivative: 0.0,
                duty_max: 1.0,
                supply: 7.4,
                supply_resistance: 0.0,
                resistance: 4.0,
                torque_constant: 0.35,
                current_max: f64::INFINITY,
            };
            let friction = ExtendedFriction::default();
            let bench = PendulumBench {
                mass,
                arm_mass,
                arm: 0.2,
                goal_speed: None,
                armature: 0.0,
                offset: 0.0,
                motor,
                friction,
                delay: 0.0,
            };
            let (step, quarter) = (1e-5, 0.25 * std::f64::consts::TAU * f64::sqrt(length / GRAVITY));
            let rows = (quarter / step) as usize;
            let (goal, enabled) = (vec![0.0; rows + 2], vec![false; rows + 2]);
            let motion = bench.run(BenchCommands { step, goal: &goal, enabled: &enabled }, 1e-3, 0.0);
            // A quarter of a period after the small angle it hangs.
            assert!(motion.position[rows].abs() < 1e-6, "{mass} {arm_mass}: {}", motion.position[rows]);
        }
    }
}
