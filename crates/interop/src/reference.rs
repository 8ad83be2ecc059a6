//! The motion in a file: rows of a clip, addressed by `time_step`.

use lifelike_character::rotation::to_wxyz;
use lifelike_motion::MotionClip;
use lifelike_motion::formats::robot_motion::{BodyStates, body_states};
use lifelike_motion::resample::resample;
use lifelike_robot::{Robot, RobotError};

use crate::dialect::Dialect;
use crate::graph::{Builder, whole};
use crate::proto::Attribute;

/// ONNX's number for whole numbers, as `Cast` wants it.
const TO_INT64: i64 = crate::proto::INT64 as i64;

/// A clip at the policy's rate, with the states of the bodies that the stack wants.
pub(crate) struct Reference {
    states: BodyStates,
    frames: usize,
    bodies: usize,
    /// Place of the anchor among the bodies.
    anchor: usize,
}

impl Reference {
    pub(crate) fn new(robot: &Robot, clip: &MotionClip, bodies: &[usize], anchor: usize) -> Result<Self, RobotError> {
        let clip = resample(clip, robot.control_hz)?;
        let states = body_states(&clip, &robot.character, bodies)?;
        Ok(Self { states, frames: clip.len(), bodies: bodies.len(), anchor })
    }

    /// Adds the outputs of a dialect.
    pub(crate) fn write(&self, builder: &mut Builder, dialect: Dialect, joints: &[usize]) {
        builder.input("time_step", &[1, 1]);
        let first = builder.floats("time_step.first", &[], &[0.0]);
        let last = builder.floats("time_step.last", &[], &[(self.frames.max(1) - 1) as f32]);
        let step = builder.node("Clip", &["time_step", &first, &last], &[]);
        let step = builder.node("Cast", &[&step], &[whole("to", TO_INT64)]);
        let shape = builder.whole("time_step.shape", &[1], &[1]);
        let step = builder.node("Reshape", &[&step, &shape], &[] as &[Attribute]);

        let ordered = |values: &[f64]| -> Vec<f32> {
            let rows = values.chunks_exact(joints.len().max(1));
            rows.flat_map(|row| joints.iter().map(|joint| row[*joint] as f32)).collect()
        };
        let mut rows = |name: &str, shape: &[usize], values: Vec<f32>| {
            let whole: Vec<usize> = [self.frames].into_iter().chain(shape.iter().copied()).collect();
            let all = builder.floats(&format!("motion.{name}"), &whole, &values);
            builder.node("Gather", &[&all, &step], &[crate::graph::whole("axis", 0)]);
            builder.named(name);
            let one: Vec<usize> = [1].into_iter().chain(shape.iter().copied()).collect();
            builder.output(name, &one);
        };
        let states = &self.states;
        rows("joint_pos", &[joints.len()], ordered(&states.joints));
        rows("joint_vel", &[joints.len()], ordered(&states.joint_velocity));
        if dialect == Dialect::Holosoma {
            let of_anchor = |i: usize| i % self.bodies == self.anchor;
            let anchors = (0..self.frames * self.bodies).filter(|i| of_anchor(*i));
            let places = anchors.clone().flat_map(|i| <[f64; 3]>::from(states.position[i])).map(|x| x as f32);
            rows("ref_pos_xyz", &[3], places.collect());
            let xyzw = |i: usize| {
                let [w, x, y, z] = to_wxyz(&states.orientation[i]);
                [x, y, z, w].map(|x| x as f32)
            };
            rows("ref_quat_xyzw", &[4], anchors.flat_map(xyzw).collect());
            return;
        }
        let vectors = |of: &[lifelike_character::Vec3]| -> Vec<f32> {
            of.iter().flat_map(|v| <[f64; 3]>::from(*v)).map(|x| x as f32).collect()
        };
        let turns = states.orientation.iter().flat_map(to_wxyz).map(|x| x as f32).collect();
        rows("body_pos_w", &[self.bodies, 3], vectors(&states.position));
        rows("body_quat_w", &[self.bodies, 4], turns);
        rows("body_lin_vel_w", &[self.bodies, 3], vectors(&states.linear));
        rows("body_ang_vel_w", &[self.bodies, 3], vectors(&states.angular));
    }
}
