//! Robots, states and targets that the tests of engines share.
#![allow(dead_code, clippy::unwrap_used, clippy::expect_used)]

pub mod closed;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use lifelike_character::{Character, JointKind};
use lifelike_robot::{Profile, Robot};
use lifelike_sim::{EnvironmentParameters, Simulation};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// The project's folder.
pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// A model of `cargo xtask fetch ROBOT`. A gate that cannot run has failed.
pub fn fetched(robot: &str, model: &str) -> PathBuf {
    let path = root().join("third_party/robots").join(robot).join(model);
    assert!(path.is_file(), "no {}: run `cargo xtask fetch {robot} --without-meshes`", path.display());
    path
}

/// A file of the robots that nobody offers as one exact download; only ignored tests ask for it.
pub fn shared(name: &str) -> PathBuf {
    let data = std::env::var_os("LIFELIKE_DATA").map_or_else(|| root().join("../shared/data"), PathBuf::from);
    let path = data.join("robots").join(name);
    assert!(path.exists(), "no {}: let LIFELIKE_DATA name the data folder (CONTRIBUTING.md)", path.display());
    path
}

/// The text without what needs files that are not there: includes of pictures, and materials from them.
pub fn without_pictures(path: &Path) -> String {
    let text = std::fs::read_to_string(path).unwrap();
    let lines = text.lines().filter(|l| !l.contains("<include file=\"./common"));
    let mut out = String::new();
    for line in lines {
        let mut rest = line;
        while let Some(at) = rest.find(" material=\"") {
            let end = at + 11 + rest[at + 11..].find('"').unwrap() + 1;
            out.push_str(&rest[..at]);
            rest = &rest[end..];
        }
        out.push_str(rest);
        out.push('\n');
    }
    out
}

/// A robot from text, with a guessed profile.
pub fn from_text(text: &str) -> Arc<Robot> {
    let character = Character::from_mjcf(text, "test.xml", None).unwrap();
    Arc::new(Robot::from_character(character, Profile::default()).unwrap())
}

/// A robot whose text asks MuJoCo to iterate until nothing changes: with lima's own ten iterations MuJoCo is 0.04 rad off
/// in this test where friction is 0.05.
pub fn exactly_solved(name: &str) -> Robot {
    let mut robot = Robot::load(name).unwrap();
    let text = robot.character.mjcf.clone().unwrap();
    let exact = text.replace(
        "iterations=\"10\" ls_iterations=\"10\" tolerance=\"1e-6\"",
        "iterations=\"500\" ls_iterations=\"100\" tolerance=\"1e-14\"",
    );
    assert_ne!(text, exact);
    robot.character = Character::from_mjcf(&exact, name, None).unwrap().into();
    robot
}

/// The robots that the engine is held to MuJoCo on: ours, Unitree's G1, and dm_control's humanoid. The G1's text has no armature (mjlab adds it when it makes actuators: 0.0036 to 0.025 kg m²), and bare hands
/// weigh too little beside the trunk for single precision; so it gets the least of it.
pub fn robots() -> Vec<(&'static str, Arc<Robot>)> {
    let mut robots: Vec<_> = ["lima", "humanoid"].map(|name| (name, Arc::new(Robot::load(name).unwrap()))).into();
    let path = fetched("unitree_g1", "g1.xml");
    let text = std::fs::read_to_string(&path).unwrap();
    let class = "<default class=\"g1\">";
    let text = text.replacen(class, &format!("{class}<joint armature=\"0.0036\"/>"), 1);
    let character = Character::from_mjcf(&text, "g1.xml", path.parent()).unwrap();
    robots.push(("G1", Arc::new(Robot::from_character(character, Profile::default()).unwrap())));
    robots.push(("dm humanoid", from_text(&without_pictures(&fetched("dm_control", "humanoid.xml")))));
    robots
}

/// A position anywhere within the ranges, the root at a height and turned anyhow, and velocities.
pub fn random_state(robot: &Robot, rng: &mut ChaCha8Rng, height: f64) -> (Vec<f64>, Vec<f64>) {
    let character = &robot.character;
    let mut q = robot.default_position();
    for joint in &character.joints {
        match joint.kind {
            JointKind::Free => {
                let wxyz: [f64; 4] = std::array::from_fn(|_| rng.random_range(-1.0..1.0));
                let norm = wxyz.iter().map(|x| x * x).sum::<f64>().sqrt();
                q[joint.q_index] = rng.random_range(-3.0..3.0);
                q[joint.q_index + 1] = rng.random_range(-3.0..3.0);
                q[joint.q_index + 2] = height;
                for (k, x) in wxyz.into_iter().enumerate() {
                    q[joint.q_index + 3 + k] = x / norm;
                }
            }
            _ => {
                let (low, high) = joint.range.unwrap_or((-1.0, 1.0));
                q[joint.q_index] = rng.random_range(low..high);
            }
        }
    }
    let v = (0..character.nv).map(|_| rng.random_range(-3.0..3.0)).collect();
    (q, v)
}

/// States near standing, feet about on the ground.
pub fn near_standing(robot: &Robot, n: usize, seed: u64) -> (Vec<f64>, Vec<f64>) {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let (mut positions, mut velocities) = (Vec::new(), Vec::new());
    for _ in 0..n {
        let mut q = robot.default_position();
        for x in &mut q[7..] {
            *x += rng.random_range(-0.1..0.1);
        }
        q[2] += rng.random_range(-0.003..0.01);
        positions.extend(q);
        velocities.extend((0..robot.character.nv).map(|_| rng.random_range(-0.3..0.3)));
    }
    (positions, velocities)
}

pub fn random_targets(robot: &Robot, n: usize, seed: u64) -> Vec<f32> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let joints = robot.joints();
    (0..n * joints).map(|i| robot.default_pose[i % joints] as f32 + rng.random_range(-0.3..0.3)).collect()
}

pub fn all(n: usize) -> Vec<usize> {
    (0..n).collect()
}

pub fn rms(a: &[f32], b: &[f32]) -> f64 {
    (a.iter().zip(b).map(|(a, b)| f64::from(a - b).powi(2)).sum::<f64>() / a.len() as f64).sqrt()
}

/// Something of 2 kg with a small arm, so that there is a joint, above a plane.
pub fn toy(gravity: &str, plane: &str, place: &str, geom: &str) -> Arc<Robot> {
    from_text(&format!(
        r#"<mujoco model="toy">
  <compiler angle="radian"/>
  <option timestep="0.005" integrator="Euler" gravity="{gravity}" cone="pyramidal" iterations="100" tolerance="1e-12"/>
  <worldbody>
    <geom name="floor" type="plane" size="5 5 1" {plane}/>
    <body name="body" pos="{place}">
      <freejoint name="root"/>
      <geom name="body" {geom} mass="2"/>
      <body name="arm" pos="0 0 0.05">
        <joint name="arm" axis="0 0 1" range="-1 1" limited="true" armature="0.01"/>
        <geom name="arm" type="sphere" size="0.01" mass="0.01" contype="0" conaffinity="0"/>
      </body>
    </body>
  </worldbody>
</mujoco>"#
    ))
}

/// A box on ground that gravity makes a slope.
pub fn sliding_box(friction: f64, slope: f64) -> Arc<Robot> {
    let (x, z) = (9.81 * slope.sin(), -9.81 * slope.cos());
    let friction = format!(r#"friction="{friction}""#);
    let geom = format!(r#"type="box" size="0.1 0.08 0.05" {friction}"#);
    toy(&format!("{x} 0 {z}"), &friction, "0 0 0.05", &geom)
}

/// A trunk with a shape, and another shape at the end of two light limbs that can reach it. In the air.
pub fn self_touching(trunk: &str, hand: &str) -> Arc<Robot> {
    let text = format!(
        r#"<mujoco model="crab">
  <compiler angle="radian"/>
  <option timestep="0.005" integrator="Euler" gravity="0 0 -9.81" cone="pyramidal" iterations="100" tolerance="1e-12"/>
  <worldbody>
    <geom name="floor" type="plane" size="5 5 1"/>
    <body name="trunk" pos="0 0 50">
      <freejoint name="root"/>
      <geom name="trunk" {trunk} mass="3" solref="0.1 1"/>
      <body name="upper" pos="0.25 0 0">
        <joint name="shoulder_yaw" axis="0 0 1" range="-1 1" limited="true" armature="0.01"/>
        <joint name="shoulder_pitch" axis="0 1 0" range="-1 1" limited="true" armature="0.01"/>
        <geom name="upper" type="sphere" size="0.03" mass="0.5" contype="0" conaffinity="0"/>
        <body name="hand" pos="0 0.1 0">
          <joint name="elbow" axis="1 0 0" range="-3 3" limited="true" armature="0.01"/>
          <joint name="wrist" axis="0 1 0" range="-3 3" limited="true" armature="0.01"/>
          <geom name="hand" {hand} mass="0.5" solref="0.1 1"/>
        </body>
      </body>
    </body>
  </worldbody>
</mujoco>"#
    );
    from_text(&text)
}

/// Targets around the default pose; environment `e` of step `t` gets the same whatever the batch.
pub fn targets(robot: &Robot, environments: &[usize], t: usize) -> Vec<f32> {
    let mut out = Vec::new();
    for &e in environments {
        let mut rng = ChaCha8Rng::seed_from_u64((e * 10_000 + t) as u64);
        out.extend(robot.default_pose.iter().map(|&q| q as f32 + rng.random_range(-0.3..0.3)));
    }
    out
}

/// Different masses, friction and pushes, by the environment's own number.
pub fn vary(simulation: &mut dyn Simulation, environments: &[usize]) {
    let bodies = simulation.robot().character.bodies.len();
    for (id, &e) in environments.iter().enumerate() {
        let mut rng = ChaCha8Rng::seed_from_u64(e as u64);
        if e % 3 != 0 {
            let parameters = EnvironmentParameters {
                mass_scale: (0..bodies).map(|_| rng.random_range(0.9..1.1)).collect(),
                ground_friction: (e % 2 == 0).then(|| rng.random_range(0.3..1.2)),
                inertia_scale: (0..bodies).map(|_| rng.random_range(0.9..1.1)).collect(),
                com_offset: (0..bodies).map(|_| std::array::from_fn(|_| rng.random_range(-0.01..0.01))).collect(),
                gravity: Some([0.0, rng.random_range(-1.0..1.0), -9.0]),
                kp_scale: (0..simulation.robot().joints()).map(|_| rng.random_range(0.8..1.2)).collect(),
                strength_scale: (0..simulation.robot().joints()).map(|_| rng.random_range(0.8..1.2)).collect(),
                foot_friction: if e % 2 == 1 { vec![rng.random_range(0.3..1.2), 0.7] } else { vec![] },
                ..EnvironmentParameters::default()
            };
            simulation.set_parameters(id, parameters).unwrap();
        }
        if e % 4 == 1 {
            simulation.push(id, 1, [rng.random_range(-30.0..30.0), 5.0, 0.0], [0.0, 1.0, 0.0]).unwrap();
        }
    }
}
