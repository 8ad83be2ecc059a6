//! Mechanisms whose loops are closed by equality constraints.

use std::sync::Arc;

use lifelike_character::{EqualityKind, Kinematics};
use lifelike_robot::Robot;

use super::from_text;

/// A robot that is told what to do at every physics step.
fn every_step(text: &str) -> Arc<Robot> {
    let mut robot = Robot::clone(&from_text(text));
    (robot.control_hz, robot.substeps) = (200.0, 1);
    Arc::new(robot)
}

/// MuJoCo iterates until nothing changes. Nothing collides.
const HEAD: &str = r#"<compiler angle="radian"/>
  <option timestep="0.005" integrator="Euler" cone="pyramidal" iterations="200" tolerance="1e-14" ls_iterations="100"/>
  <default><joint armature="0.002" damping="0.02"/><geom type="capsule" size="0.02" contype="0" conaffinity="0"/></default>"#;

/// A crank, a coupler and a rocker on a frame, the loop closed by a ball joint: `base` is what moves the frame. All hinges are
/// parallel, so one of the ball joint's three rows says nothing that they do not.
pub fn four_bar(base: &str) -> Arc<Robot> {
    every_step(&format!(
        r#"<mujoco model="four-bar">{HEAD}
  <worldbody>
    <body name="frame" pos="0 0 1">{base}
      <geom type="box" size="0.2 0.03 0.02" mass="3"/>
      <body name="crank" pos="-0.15 0 0">
        <joint name="crank" axis="0 1 0"/><geom fromto="0 0 0 0 0 0.1" mass="0.3"/>
        <body name="coupler" pos="0 0 0.1">
          <joint name="coupler" axis="0 1 0"/><geom fromto="0 0 0 0.3 0 0.1" mass="0.2"/>
        </body>
      </body>
      <body name="rocker" pos="0.15 0 0">
        <joint name="rocker" axis="0 1 0"/><geom fromto="0 0 0 0 0 0.2" mass="0.4"/>
      </body>
    </body>
  </worldbody>
  <equality><connect name="pin" body1="coupler" body2="rocker" anchor="0.3 0 0.1"/></equality>
</mujoco>"#
    ))
}

/// Hinges of a leg's ankle, knee and hip.
fn joints(side: &str, joint: &str, more: &str) -> String {
    let hinge = |name: &str, axis: &str| format!(r#"<joint name="{side}_{name}" axis="{axis}" {more}/>"#);
    match joint {
        "ankle" => hinge("ankle_pitch", "0 1 0") + &hinge("ankle_roll", "1 0 0"),
        "knee" => hinge("knee", "0 1 0"),
        _ => hinge("hip_yaw", "0 0 1") + &hinge("hip_roll", "1 0 0") + &hinge("hip_pitch", "0 1 0"),
    }
}

/// A leg that hangs from the pelvis, knees bent.
fn hanging(side: &str, y: f64, more: &str) -> String {
    let [ankle, knee, hip] = ["ankle", "knee", "hip"].map(|joint| joints(side, joint, more));
    format!(
        r#"<body name="{side}_thigh" pos="0 {y} 0" euler="0 -0.3 0">{hip}<geom fromto="0 0 0 0 0 -0.3" mass="1.5"/>
        <body name="{side}_shank" pos="0 0 -0.3" euler="0 0.6 0">{knee}<geom fromto="0 0 0 0 0 -0.3" mass="0.8"/>
        <body name="{side}_foot" pos="0 0 -0.3" euler="0 -0.3 0">{ankle}<geom type="box" size="0.1 0.05 0.02" mass="0.3"/>
        <site name="{side}_sole" pos="0.02 0 -0.02" euler="0.1 0 0"/></body></body></body>"#
    )
}

fn pelvis(content: &str) -> String {
    format!(r#"<geom type="box" size="0.08 0.1 0.06" mass="5"/><site name="head" pos="0 0 0.3"/>{content}"#)
}

/// Two legs whose left foot is fixed to the world and whose right foot is welded to it. `more` is what all joints have besides.
/// With a `torquescale` of 1 m a weld resists turning as the foot's own inertia says, which is next to nothing beside a
/// leg: it would give way by 0.4 rad.
pub fn standing_on_its_foot(more: &str) -> Arc<Robot> {
    let [ankle, knee, hip] = ["ankle", "knee", "hip"].map(|joint| joints("left", joint, more));
    let trunk = pelvis(&hanging("right", -0.1, more));
    every_step(&format!(
        r#"<mujoco model="dancer">{HEAD}
  <worldbody>
    <body name="left_foot" pos="0 0.1 0.1"><geom type="box" size="0.1 0.05 0.02" mass="0.3"/>
      <body name="left_shank" euler="0 0.3 0">{ankle}<geom fromto="0 0 0 0 0 0.3" mass="0.8"/>
        <body name="left_thigh" pos="0 0 0.3" euler="0 -0.6 0">{knee}<geom fromto="0 0 0 0 0 0.3" mass="1.5"/>
          <body name="pelvis" pos="0 0 0.3" euler="0 0.3 0">{hip}
            <body name="trunk" pos="0 -0.1 0">{trunk}</body></body></body></body></body>
  </worldbody>
  <equality><weld name="right_sole" body1="right_foot" torquescale="10"/></equality>
</mujoco>"#
    ))
}

/// The same robot with a floating base and both feet welded to the world, one of them by sites and the other at an anchor, both
/// turned further than they begin.
pub fn standing_on_welds() -> Arc<Robot> {
    let trunk = pelvis(&(hanging("left", 0.1, "") + &hanging("right", -0.1, "")));
    let height = 0.1 + 0.6 * 0.3_f64.cos();
    every_step(&format!(
        r#"<mujoco model="dancer">{HEAD}
  <worldbody><site name="ground" pos="0.02 0.1 0.08" euler="0.1 0 0.02"/>
    <body name="trunk" pos="0 0 {height}"><freejoint name="root"/>{trunk}</body></worldbody>
  <equality>
    <weld name="left_sole" site1="left_sole" site2="ground" torquescale="3" solref="0.03 0.8"/>
    <weld name="right_sole" body2="right_foot" body1="world" torquescale="10" anchor="0.05 0 0" relpose="0.05 -0.1 0.1 1 0.01 0.02 -0.02"/>
  </equality>
</mujoco>"#
    ))
}

/// The same robot with its left foot welded to the world and its right foot half a millimetre in the ground: exactly on it
/// rounding would decide who has a first contact.
pub fn standing_on_a_weld_and_a_foot() -> Arc<Robot> {
    let solid = hanging("right", -0.1, "").replace(r#"0.02" mass="0.3""#, r#"0.02" mass="0.3" contype="1""#);
    let trunk = pelvis(&(hanging("left", 0.1, "") + &solid));
    let height = 0.1 + 0.6 * 0.3_f64.cos();
    every_step(&format!(
        r#"<mujoco model="dancer">{HEAD}
  <worldbody><geom name="floor" type="plane" size="5 5 1" pos="0 0 0.0805" conaffinity="1"/>
    <body name="trunk" pos="0 0 {height}"><freejoint name="root"/>{trunk}</body></worldbody>
  <equality><weld name="left_sole" body1="left_foot" torquescale="10"/></equality>
</mujoco>"#
    ))
}

/// Greatest distance (m) and angle (rad) between what should be together.
pub fn gap(robot: &Robot, kinematics: &mut Kinematics, q: &[f64]) -> [f64; 2] {
    kinematics.update(&robot.character, q);
    let mut worst = [0.0_f64; 2];
    for e in &robot.character.equalities {
        let [a, b] = [0, 1].map(|k| kinematics.point(e.bodies[k], &e.anchors[k]));
        worst[0] = worst[0].max((a - b).norm());
        if matches!(e.kind, EqualityKind::Weld { .. }) {
            let [a, b] = [0, 1].map(|k| kinematics.body_orientation[e.bodies[k]] * e.orientations[k]);
            worst[1] = worst[1].max(a.angle_to(&b));
        }
    }
    worst
}

/// Waves of targets around the default pose (rad), or torques on the crank of a linkage (N m); and whether they are targets.
/// Environment `e` gets the same whatever the batch.
pub fn waves(robot: &Robot, environments: &[usize], t: usize) -> (bool, Vec<f32>) {
    let (joints, time) = (robot.joints(), t as f32 * robot.timestep() as f32);
    let linkage = joints == 3;
    let one = |e: usize, j: usize| {
        let wave = (3.0 * time + (e * 7 + j * 3) as f32).sin();
        match (linkage, j) {
            (true, 0) => 0.3 + 0.1 * wave,
            (true, _) => 0.0,
            _ => robot.default_pose[j] as f32 + 0.15 * wave,
        }
    };
    (!linkage, environments.iter().flat_map(|e| (0..joints).map(move |j| one(*e, j))).collect())
}
