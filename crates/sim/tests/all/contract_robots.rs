//! Other people's robots run too, as far as they have a floating base.
use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::world::{fetched, shared};
use lifelike_robot::Robot;
use lifelike_sim::engine::LifelikeSimulation;
use lifelike_sim::{Drive, MujocoSimulation, SimError, Simulation};

/// Models below a folder.
fn models(folder: &Path) -> Vec<PathBuf> {
    let paths = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let is_model = |p: &Path| p.extension().is_some_and(|e| e == "xml" || e == "urdf");
    let mut found: Vec<PathBuf> =
        paths.flat_map(|p| if p.is_dir() { models(&p) } else { vec![p] }).filter(|p| is_model(p)).collect();
    found.sort();
    found
}

#[test]
fn fetched_robots_are_simulated_or_refused_with_a_reason() {
    for (robot, model) in [("unitree_g1", "g1.xml"), ("dm_control", "humanoid.xml"), ("dm_control", "humanoid_CMU.xml")]
    {
        simulated_or_refused(&fetched(robot, model));
    }
}

#[test]
#[ignore = "needs robots that nobody offers as one exact download: LIFELIKE_DATA"]
fn shared_robots_are_simulated_or_refused_with_a_reason() {
    let models = models(&shared("."));
    assert!(!models.is_empty());
    models.iter().for_each(|path| simulated_or_refused(path));
}

fn simulated_or_refused(path: &Path) {
    let robot = match Robot::load(path.to_str().unwrap()) {
        Ok(robot) => Arc::new(robot),
        Err(error) => {
            println!("{}: refused: {error}", path.display());
            assert!(error.to_string().len() > 20, "{error}");
            return;
        }
    };
    for engine in ["lifelike", "mujoco"] {
        match simulation(engine, &robot) {
            Ok(mut simulation) => stands_or_falls_quietly(path, simulation.as_mut()),
            // Only ours leaves something out, and it says what.
            Err(error) => {
                println!("{}: refused by {engine}: {error}", path.display());
                assert!(engine == "lifelike" && error.to_string().len() > 20, "{error}");
            }
        }
    }
}

fn simulation(engine: &str, robot: &Arc<Robot>) -> Result<Box<dyn Simulation>, SimError> {
    Ok(match engine {
        "mujoco" => Box::new(MujocoSimulation::new(robot.clone(), 2, 1)?),
        _ => Box::new(LifelikeSimulation::new(robot.clone(), 2, 1)?),
    })
}

/// Holding the default pose, standing or falling, no joint shakes: the guessed gains are stable.
fn stands_or_falls_quietly(path: &Path, simulation: &mut dyn Simulation) {
    let robot = simulation.robot().clone();
    let target: Vec<f32> = robot.default_pose.iter().map(|&q| q as f32).collect();
    for _ in 0..25 {
        simulation.step(Drive::Targets(&target.repeat(2))).unwrap();
    }
    let state = simulation.state();
    let engine = simulation.engine();
    assert_eq!(state.diverged, [false, false], "{} in {engine}", path.display());
    let n = robot.joints();
    let fastest = state.joint_velocity[..n].iter().fold(0.0_f32, |a, v| a.max(v.abs()));
    assert!(fastest < 5.0, "{} in {engine}: a joint at {fastest} rad/s", path.display());
    println!(
        "{} in {engine}: {n} joints, {:.1} kg, end effectors {:?}, root at {:.3} m after 0.5 s, feet {:?} N, fastest joint {:.1} rad/s",
        path.display(),
        robot.character.mass(),
        robot.layout.end_effectors,
        state.root_position[2],
        &state.foot_force[..robot.anatomy.soles.len()],
        fastest,
    );
}
