//! Trains a motion prior straight from captures and tells how well windows come back:
//! `prior PLAN OUT.prior.safetensors ROBOT FILES...`, `PLAN` the TOML of a `VaePlan` (`-` for `VaePlan::cpu()`).
//!
//! Files are BVH, AMC, DeepMimic or keyframes; those that cannot be retargeted are named and left out.

use std::path::{Path, PathBuf};
use std::time::Instant;

use lifelike_checkpoint::rng::stream;
use lifelike_motion::features::frames_of;
use lifelike_motion::retarget::{RetargetOptions, retarget};
use lifelike_motion::{MotionError, formats};
use lifelike_representation::prior::vae::{VaePlan, VaeTrainer};
use lifelike_representation::prior::{FeatureStatistics, PriorClip, ReconstructionReport, Windows, split};
use lifelike_robot::Robot;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    if std::env::var_os("NO_TUNE").is_none() {
        lifelike_nn::memory::tune_allocator();
    }
    let mut args = std::env::args().skip(1);
    let plan = args.next().ok_or("PLAN")?;
    let plan = if plan == "-" { VaePlan::cpu() } else { VaePlan::from_toml(&std::fs::read_to_string(plan)?)? };
    let out = PathBuf::from(args.next().ok_or("OUT")?);
    let robot = Robot::load(&args.next().ok_or("ROBOT")?)?;

    let mut clips = Vec::new();
    let start = Instant::now();
    for file in args {
        match convert(Path::new(&file), &robot, plan.windows.frame_rate) {
            Ok(clip) => clips.push(clip),
            Err(e) => println!("left out: {e}"),
        }
    }
    let frames: usize = clips.iter().map(|c| c.frames.len()).sum();
    let minutes = frames as f64 / plan.windows.frame_rate / 60.0;
    println!("{} clips, {minutes:.1} min, retargeted in {:.1} s", clips.len(), start.elapsed().as_secs_f64());

    let (training, held_out) = split(&plan.windows, clips);
    println!("held out: {}", held_out.iter().map(|c| c.name.as_str()).collect::<Vec<_>>().join(" "));
    time_windows(&plan, &robot, &training)?;
    let mut trainer = VaeTrainer::new(plan, robot.layout.clone(), training, held_out)?;
    println!("{} parameters", trainer.parameters());
    let start = Instant::now();
    let every = (trainer.plan().iterations / 20).max(1);
    while trainer.iteration() < trainer.plan().iterations {
        let m = trainer.step()?;
        if m.step.iteration % every == 0 || m.step.iteration == 1 {
            let ms = start.elapsed().as_secs_f64() * 1e3 / m.step.iteration as f64;
            println!(
                "{:6}  {ms:6.1} ms/iteration  reconstruction {:8.3}  KL {:8.2}  rate {:.5}  gradient {:.2}",
                m.step.iteration, m.reconstruction, m.kl, m.step.learning_rate, m.step.gradient_norm
            );
            if m.step.iteration % (5 * every) == 0
                && let Ok(report) = trainer.report()
            {
                print(&report);
            }
        }
    }
    println!("trained in {:.0} s", start.elapsed().as_secs_f64());
    let report = trainer.report()?;
    print(&report);
    report.clips.iter().for_each(|(name, e)| println!("  {name}: {e:.2?}"));
    trainer.prior().save(&out)?;
    Ok(())
}

fn convert(file: &Path, robot: &Robot, fps: f64) -> Result<PriorClip, MotionError> {
    let source = formats::read_source(file, &formats::ReadOptions::default())?;
    let mut options = RetargetOptions { fps, ..RetargetOptions::default() };
    for (name, p) in robot.actuators.joints.iter().zip(&robot.actuators.parameters) {
        options.velocity_limit.insert(name.clone(), 0.8 * p.velocity_max);
    }
    let (clip, _) = retarget(&source, &robot.character, &robot.anatomy, &options)?;
    let frames = frames_of(&clip, &robot.character, &robot.effectors)?;
    Ok(PriorClip { name: file.display().to_string(), frames })
}

fn time_windows(
    plan: &VaePlan,
    robot: &Robot,
    clips: &[PriorClip],
) -> Result<(), lifelike_representation::RepresentationError> {
    let windows = Windows::new(&plan.windows, &robot.layout, clips.to_vec())?;
    let frames = clips.iter().flat_map(|c| &c.frames);
    let statistics = FeatureStatistics::of(&robot.layout, &plan.windows.floors, frames);
    let start = Instant::now();
    for i in 0..20 {
        std::hint::black_box(windows.sample(&statistics, plan.batch, &mut stream(0, "bench", 0, i))?);
    }
    println!("drawing a batch of {}: {:.2} ms", plan.batch, start.elapsed().as_secs_f64() * 1e3 / 20.0);
    Ok(())
}

fn print(report: &ReconstructionReport) {
    for (name, e) in [("windows", &report.window), ("centres", &report.centre)] {
        println!(
            "        {name}: joints {:.2} deg, end effectors {:.1} mm, height {:.1} mm, root {:.2} deg",
            e.joints_deg, e.effectors_mm, e.height_mm, e.orientation_deg
        );
    }
}
