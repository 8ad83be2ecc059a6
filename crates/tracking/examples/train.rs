//! Trains a tracker of `lima` for a few thousand steps on the keyframed walk that comes with the project, and saves it:
//!
//! ```text
//! cargo run --release -p lifelike-tracking --example train -- runs/example
//! ```
//!
//! It is far from walking then: some millions of steps (`budget.steps`) teach it. Run again to go on where it stopped.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use lifelike_motion::keyframes;
use lifelike_motion::retarget::{RetargetOptions, retarget};
use lifelike_report::run::RunFolder;
use lifelike_robot::{ReferenceLibrary, Robot};
use lifelike_sim::LifelikeSimulation;
use lifelike_tracking::{TrackerPlan, Trainer};
use lifelike_train::TrainingRun;
use lifelike_train::collective::Alone;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder = PathBuf::from(std::env::args().nth(1).unwrap_or_else(|| "runs/example".into()));
    let robot = Arc::new(Robot::load("lima")?);

    // The clip: keyframes of a person, retargeted to the robot at its policy's rate.
    let (name, text) = keyframes::builtin().find(|(name, _)| *name == "walk").ok_or("no clip 'walk'")?;
    let source = keyframes::parse(text.as_bytes(), Path::new(name))?;
    let options = RetargetOptions { fps: robot.control_hz, ..RetargetOptions::default() };
    let clip = retarget(&source, &robot.character, &robot.anatomy, &options)?.0;
    let library = Arc::new(ReferenceLibrary::new(&robot, &[clip], None)?);

    let mut plan = TrackerPlan::new("lima", &[]);
    plan.ppo.environments = 64;
    plan.ppo.minibatch = 384;
    plan.budget.steps = 8_000;
    let simulation = Box::new(LifelikeSimulation::new(Arc::clone(&robot), plan.ppo.environments, 0)?);
    let mut trainer = Trainer::new(&plan, robot, library, simulation)?;

    let folder = if folder.exists() { RunFolder::open(&folder)? } else { RunFolder::create(&folder, &plan)? };
    let run = TrainingRun { folder: &folder, stop: &AtomicBool::new(false), collective: &Alone };
    run.run(&mut trainer, |now| {
        println!("{:6} of {} steps: reward {:.3} per step", now.done, now.total, now.metrics.ppo.reward);
    })?;
    println!("{}", Trainer::policy_path(folder.path()).display());
    Ok(())
}
