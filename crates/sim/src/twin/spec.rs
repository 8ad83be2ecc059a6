//! Distribution of a twin's hidden truth.

use lifelike_character::{Character, Kinematics, Quat, Vec3};
use lifelike_checkpoint::rng::stream;
use lifelike_robot::Robot;
use lifelike_robot::actuator::{ActuatorParameters, DcMotor, ExtendedFriction};
use rand::Rng;
use rand_distr::StandardNormal;

/// The stall torque of the servo whose friction is taken (N m).
const MX64_STALL: f64 = 6.0;

/// Friction of a Dynamixel MX-64 as BAM identified it (model M6; github.com/Rhoban/bam, params/mx64/m6.json, commit af22604, MIT):
/// a servo built like the XM430, with the same kind of gear. Torques are for its stall torque.
const MX64_FRICTION: ExtendedFriction = ExtendedFriction {
    base: 6.2e-7,
    stribeck: 0.1227,
    stribeck_velocity: 2.575,
    stribeck_exponent: 0.841,
    load: [0.3115, 0.0],
    load_stribeck: [0.1877, 0.0141],
    load_quadratic: [0.0069, 0.01],
    viscous: 0.0253,
};

/// Supply of the twin's servos (V).
const SUPPLY: f64 = 12.0;
/// Stall torque for the largest torque that a profile allows: data sheets' stall is above what servos are let do.
const STALL: f64 = 1.3;

/// Distribution of the hidden truth of a twin. One seed is one physical robot: servos and parts are drawn by their
/// names, so a robot that is attached elsewhere keeps its own.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct TwinSpec {
    /// Key of everything that is drawn.
    pub seed: u64,
    /// Physics steps per second (Hz), and so those of the servos' firmware; a little more where the control rate does not divide it.
    pub physics_hz: f64,
    /// Standard deviation of each part's mass, as a share.
    pub mass: f64,
    /// Standard deviation of each coordinate of a part's centre of mass (m).
    pub center_of_mass: f64,
    /// Standard deviation of how far each part sits from where the model has it (m), and how it is turned (rad): printing and
    /// assembly.
    pub assembly: [f64; 2],
    /// Standard deviation of each servo's own parameters, as a share.
    pub spread: f64,
    /// Factor on all friction.
    pub friction: f64,
    /// Factor on the windings' resistance, of which training sees nothing.
    pub resistance: f64,
    /// Share of the supply that is lost when all servos stall together.
    pub sag: f64,
    /// Play of the gear (rad), to both sides together.
    pub backlash: f64,
    /// Turn of the gear under the largest torque (rad): the encoder, on its output, does see it.
    pub gear_flex: f64,
    /// Turn of the part behind the encoder under the largest torque (rad).
    pub link_flex: f64,
    /// Bounds of each servo's delay of commands (s).
    pub delay: [f64; 2],
    /// Bits of a turn of the encoder.
    pub encoder_bits: u32,
    /// Time over which the firmware differences its encoder for the velocity that a servo reports (s), in whole control steps, at least
    /// one. 64 ms are 16 steps at 250 Hz.
    pub velocity_window: f64,
    /// Step of the reported velocity (rad/s), applied after the window.
    pub velocity_step: f64,
    /// Step of the current that a servo tells, as a share of its stall current.
    pub current_step: f64,
}

impl Default for TwinSpec {
    fn default() -> Self {
        Self {
            seed: 1,
            physics_hz: 2000.0,
            mass: 0.05,
            center_of_mass: 0.003,
            assembly: [0.001, 0.008],
            spread: 0.08,
            friction: 1.0,
            resistance: 1.0,
            sag: 0.15,
            backlash: 0.25_f64.to_radians(),
            gear_flex: 0.008,
            link_flex: 0.012,
            delay: [0.004, 0.008],
            encoder_bits: 12,
            // XM430's registers: 0.229 rpm and 2.69 mA of 2.3 A. One count of 4096 in 64 ms is 0.2289 rpm, the velocity's unit.
            velocity_window: 0.064,
            velocity_step: 0.229 * std::f64::consts::TAU / 60.0,
            current_step: 0.00117,
        }
    }
}

/// One servo as it is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TwinServo {
    /// Firmware and motor.
    pub motor: DcMotor,
    /// Friction in the gear, on the motor's side of its play.
    pub friction: ExtendedFriction,
    /// Inertia of the rotor, at the output (kg m²).
    pub rotor: f64,
    /// Torque for a turn between rotor and part (N m/rad).
    pub stiffness: f64,
    /// Torque against their relative velocity where teeth touch (N m s/rad).
    pub damping: f64,
    /// Play to either side (rad).
    pub play: f64,
    /// Turn between encoder and part for a torque (rad/(N m)).
    pub link_compliance: f64,
    /// Delay of commands (s).
    pub delay: f64,
    /// Step of the current it tells (A).
    pub current_step: f64,
}

/// Mounts what closes loops where it comes to lie in the reference pose: a crooked robot is not strained by its own mounting.
fn close(character: &mut Character) {
    let mut kinematics = Kinematics::new(character);
    kinematics.update(character, &character.reference_position());
    for equality in &mut character.equalities {
        let [a, b] = equality.bodies;
        let place = kinematics.point(b, &equality.anchors[1]);
        let turn = kinematics.body_orientation[b] * equality.orientations[1];
        let back = kinematics.body_orientation[a].inverse();
        equality.anchors[0] = back * (place - kinematics.body_position[a]);
        equality.orientations[0] = back * turn;
    }
}

/// Returns the torque constant (N m/A) that a profile's figures say: the back-EMF takes the whole supply at the largest velocity.
pub fn nominal_torque_constant(nominal: &ActuatorParameters) -> f64 {
    SUPPLY / nominal.velocity_max
}

/// Share of a servo's reflected inertia that sits on the output's side of the play.
pub(super) const OUTPUT_SHARE: f64 = 0.2;
/// Share of the critical damping of teeth that touch.
const TEETH: f64 = 0.2;

impl TwinSpec {
    /// Returns the hidden servo of a joint.
    pub(super) fn servo(&self, joint: &str, nominal: &ActuatorParameters, armature: f64) -> TwinServo {
        let mut draw = stream(self.seed, &format!("twin's servo {joint}"), 0, 0);
        let mut about =
            |x: f64| x * (1.0 + self.spread * draw.sample::<f64, _>(StandardNormal).clamp(-2.5, 2.5)).max(0.1);
        let stall = STALL * nominal.torque_max;
        let torque_constant = about(nominal_torque_constant(nominal));
        let resistance = about(self.resistance * torque_constant * SUPPLY / stall);
        // Eq. 4.9's gains as the duty that gives them; the back-EMF is a derivative gain by itself.
        let duty = resistance / (torque_constant * SUPPLY);
        let derivative = (nominal.kd - torque_constant * torque_constant / resistance).max(0.0) * duty;
        let scale = self.friction * stall / MX64_STALL;
        let friction = ExtendedFriction {
            base: MX64_FRICTION.base * scale,
            stribeck: about(MX64_FRICTION.stribeck * scale),
            load: [about(MX64_FRICTION.load[0] * self.friction), 0.0],
            load_stribeck: MX64_FRICTION.load_stribeck.map(|x| x * self.friction),
            load_quadratic: MX64_FRICTION.load_quadratic.map(|x| x * self.friction / scale.max(1e-9)),
            viscous: about(MX64_FRICTION.viscous * scale),
            ..MX64_FRICTION
        };
        let gear = about(self.gear_flex / nominal.torque_max);
        let link_compliance = about(self.link_flex / nominal.torque_max);
        let stiffness = 1.0 / (gear + link_compliance).max(1e-9);
        TwinServo {
            motor: DcMotor {
                proportional: nominal.kp * duty,
                integral: 0.0,
                derivative,
                duty_max: 1.0,
                supply: SUPPLY,
                supply_resistance: 0.0,
                resistance,
                torque_constant,
                current_max: nominal.torque_max / torque_constant,
            },
            friction,
            rotor: about(armature) * (1.0 - OUTPUT_SHARE),
            stiffness,
            damping: 2.0 * TEETH * (stiffness * armature * OUTPUT_SHARE).sqrt(),
            play: 0.5 * about(self.backlash),
            link_compliance,
            delay: draw.random_range(self.delay[0]..=self.delay[1].max(self.delay[0])),
            current_step: self.current_step * SUPPLY / resistance,
        }
    }

    /// Returns the resistance (ohm) that the servos share.
    pub(super) fn shared_resistance(&self, servos: &[TwinServo]) -> f64 {
        let all: f64 = servos.iter().map(|servo| SUPPLY / servo.motor.resistance).sum();
        self.sag * SUPPLY / all.max(1e-9)
    }

    /// Returns the robot of the twin's physics: masses and centres of mass as they are, joints that nothing slows but what the
    /// servos do, one physics step a step.
    pub(super) fn robot(&self, robot: &Robot) -> Robot {
        let mut own = robot.clone();
        let mut character = (*robot.character).clone();
        for body in character.bodies.iter_mut().skip(1) {
            let mut draw = stream(self.seed, &format!("twin's part {}", body.name), 0, 0);
            let mut normal = || draw.sample::<f64, _>(StandardNormal).clamp(-2.5, 2.5);
            let factor = (1.0 + self.mass * normal()).max(0.05);
            body.inertial.mass *= factor;
            body.inertial.diagonal *= factor;
            if body.inertial.mass > 0.0 {
                body.inertial.com.iter_mut().for_each(|x| *x += self.center_of_mass * normal());
            }
            if body.parent != 0 {
                body.position.iter_mut().for_each(|x| *x += self.assembly[0] * normal());
                body.orientation *= Quat::from_scaled_axis(Vec3::from_fn(|_, _| self.assembly[1] * normal()));
            }
        }
        close(&mut character);
        let actuated: Vec<usize> = character.scalar_joints().map(|joint| joint.v_index).collect();
        for joint in character.joints.iter_mut().filter(|joint| actuated.contains(&joint.v_index)) {
            joint.armature *= OUTPUT_SHARE;
        }
        own.character = character.into();
        own.control_hz = self.physics_hz;
        own.substeps = 1;
        own
    }
}
