//! Numbers of sampled motion, before and after it is put on the ground:
//! `cargo run --release -p lifelike-generation --example sampled -- GENERATOR ROBOT PROMPTS...`.
//!
//! Shares of joint values beyond their ranges and by how much, heights of the lowest sole, speed of soles that touch,
//! the way of the root, and how far velocity columns are from the differences of the angles.

use std::path::Path;
use std::time::Instant;

use lifelike_character::Kinematics;
use lifelike_generation::GenerationError;
use lifelike_generation::generator::{Generator, SampleOptions};
use lifelike_motion::MotionClip;
use lifelike_robot::Robot;

fn main() -> Result<(), GenerationError> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [generator, robot, prompts @ ..] = arguments.as_slice() else {
        println!("expected GENERATOR ROBOT PROMPTS...");
        return Ok(());
    };
    let (generator, robot) = (Generator::load(Path::new(generator))?, Robot::load(robot)?);
    for prompt in prompts {
        let began = Instant::now();
        let options = SampleOptions { candidates: 4, ..SampleOptions::default() };
        let all = generator.sample(prompt, &options)?;
        println!("'{prompt}': 4 motions of {} rows in {:.2} s", all[0].rows.n, began.elapsed().as_secs_f64());
        let spec = &generator.header().spec;
        for one in all.iter().take(2) {
            let raw = one.rows.to_clip(spec, prompt, robot.control_hz)?;
            let (j, rows) = (spec.joints(), &one.rows);
            let mut apart = 0.0;
            for i in 1..rows.n.saturating_sub(1) {
                for c in 0..j {
                    let difference = (rows.row(i + 1)[7 + c] - rows.row(i - 1)[7 + c]) * spec.fps as f32 / 2.0;
                    apart += f64::from(difference - rows.row(i)[7 + j + c]).powi(2);
                }
            }
            let apart = (apart / ((rows.n - 2) * j) as f64).sqrt();
            println!("  raw:      {}; velocities off by {apart:.3} rad/s", numbers(&raw, &robot)?);
            println!("  grounded: {}", numbers(&generator.clip(one, prompt, &robot)?, &robot)?);
        }
    }
    Ok(())
}

fn numbers(clip: &MotionClip, robot: &Robot) -> Result<String, GenerationError> {
    let character = &robot.character;
    let columns = clip.columns_for(character)?;
    let (mut beyond, mut worst, mut count) = (0, 0.0_f64, 0);
    for (joint, &column) in character.scalar_joints().zip(&columns) {
        for t in 0..clip.len() {
            let q = clip.joints_at(t)[column];
            let over = joint.range.map_or(0.0, |(low, high)| (low - q).max(q - high).max(0.0));
            beyond += usize::from(over > 1e-6);
            worst = worst.max(over);
            count += 1;
        }
    }
    let mut kinematics = Kinematics::new(character);
    let mut q = character.reference_position();
    let (mut lowest, mut slide, mut touching) = (Vec::new(), 0.0, 0);
    let mut before: Option<Vec<lifelike_character::Vec3>> = None;
    for t in 0..clip.len() {
        clip.write_position(character, &columns, t, &mut q);
        kinematics.update(character, &q);
        let soles = robot.anatomy.soles.values();
        let points: Vec<_> =
            soles.flat_map(|sole| sole.corners.iter().map(|c| kinematics.point(sole.body, c))).collect();
        lowest.push(points.iter().fold(f64::INFINITY, |z, p| z.min(p.z)));
        if let Some(before) = &before {
            for (a, b) in before.iter().zip(&points).filter(|(a, b)| a.z < 0.01 && b.z < 0.01) {
                slide += (a.xy() - b.xy()).norm() * clip.fps;
                touching += 1;
            }
        }
        before = Some(points);
    }
    lowest.sort_by(f64::total_cmp);
    let at = |share: f64| 100.0 * lowest[((lowest.len() - 1) as f64 * share) as usize];
    let way = clip.root_position[clip.len() - 1] - clip.root_position[0];
    Ok(format!(
        "{:.2}% of joint values out of range (worst {:.1} deg), lowest sole {:.1}/{:.1}/{:.1} cm (min/median/max), \
         touching soles slide {:.1} cm/s, way ({:.2}, {:.2}) m",
        100.0 * f64::from(beyond as u32) / f64::from(count as u32),
        worst.to_degrees(),
        at(0.0),
        at(0.5),
        at(1.0),
        100.0 * slide / f64::from(touching.max(1)),
        way.x,
        way.y,
    ))
}
