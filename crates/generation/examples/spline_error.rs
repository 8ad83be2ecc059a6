//! What is lost by control points, at several distances between knots:
//! `cargo run --release -p lifelike-generation --example spline_error -- ROBOT FILES...`.
//!
//! Root mean square over all rows (20 Hz) and joints: joint angles (degrees), joint velocities (degrees per second),
//! root height (cm), tilt (degrees), and how far the summed path is off at the end (cm, mean over clips).

use std::path::PathBuf;

use lifelike_generation::GenerationError;
use lifelike_generation::representation::{FeatureMatrix, RepresentationSpec};
use lifelike_generation::space::{MotionSpace, SpaceKind};
use lifelike_robot::{Robot, clips};
use rayon::prelude::*;

fn main() -> Result<(), GenerationError> {
    let mut arguments = std::env::args().skip(1);
    let robot = Robot::load(&arguments.next().unwrap_or_else(|| "lima".into()))?;
    let mut inputs: Vec<PathBuf> = arguments.map(PathBuf::from).collect();
    if inputs.is_empty() {
        inputs.push("builtin".into());
    }
    let spec = RepresentationSpec::of(&robot.layout);
    let loaded = clips::load(&inputs, &robot)?;
    let motions: Vec<FeatureMatrix> =
        loaded.clips.par_iter().map(|clip| windows(clip, &spec)).collect::<Result<Vec<_>, _>>()?.concat();
    println!("{} clips, {} stretches of at most 10 s", loaded.clips.len(), motions.len());
    println!("knots (s)  joints (deg)  velocities (deg/s)  height (cm)  tilt (deg)  path's end (cm)");
    for knot_seconds in [0.1, 0.2, 0.3, 0.4] {
        let space = MotionSpace::new(spec.clone(), SpaceKind::Spline { knot_seconds });
        let all: Vec<[f64; 6]> = motions.par_iter().map(|m| errors(m, &space, &spec)).collect::<Result<_, _>>()?;
        let mut sums = [0.0; 6];
        all.iter().for_each(|own| sums.iter_mut().zip(own).for_each(|(sum, x)| *sum += x));
        let rows = sums[0];
        let root = |sum: f64, count: f64| (sum / count).sqrt();
        println!(
            "{knot_seconds:9}  {:12.3}  {:18.2}  {:11.3}  {:10.3}  {:15.2}",
            root(sums[1], rows * spec.joints() as f64).to_degrees(),
            root(sums[2], rows * spec.joints() as f64).to_degrees(),
            100.0 * root(sums[3], rows),
            root(sums[4], rows).to_degrees(),
            100.0 * sums[5] / motions.len() as f64,
        );
    }
    Ok(())
}

/// Stretches of at most 10 s, as training takes them.
fn windows(
    clip: &lifelike_motion::MotionClip,
    spec: &RepresentationSpec,
) -> Result<Vec<FeatureMatrix>, GenerationError> {
    let all = FeatureMatrix::from_clip(clip, spec)?;
    let parts = all.rows.chunks(201 * all.width).filter(|rows| rows.len() >= 10 * all.width);
    parts.map(|rows| FeatureMatrix::new(rows.to_vec(), all.width)).collect()
}

/// Rows; squares of joints, velocities, height, tilt; distance of the ends of the paths.
fn errors(motion: &FeatureMatrix, space: &MotionSpace, spec: &RepresentationSpec) -> Result<[f64; 6], GenerationError> {
    let back = space.decode(&space.encode(motion)?, motion.n)?;
    let mut sums = [motion.n as f64, 0.0, 0.0, 0.0, 0.0, 0.0];
    for i in 0..motion.n {
        let (a, b) = (motion.row(i), back.row(i));
        let squares = |columns: std::ops::Range<usize>| columns.map(|c| f64::from(a[c] - b[c]).powi(2)).sum::<f64>();
        sums[1] += squares(spec.angles());
        sums[2] += squares(spec.velocities());
        sums[3] += squares(0..1);
        sums[4] += squares(RepresentationSpec::UP);
    }
    let end = |rows: &FeatureMatrix| -> Result<_, GenerationError> {
        Ok(rows.to_clip(spec, "end", spec.fps)?.root_position[motion.n - 1])
    };
    let (a, b) = (end(motion)?, end(&back)?);
    sums[5] = (a.xy() - b.xy()).norm();
    Ok(sums)
}
