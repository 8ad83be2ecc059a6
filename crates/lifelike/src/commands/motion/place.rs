//! `lifelike motion place`: this point of the body at this place at this time.

use std::path::PathBuf;

use lifelike_character::Vec3;
use lifelike_motion::edit::{self, Key, PlaceReport, Target};
use serde_json::json;

use super::direct::Common;
use crate::error::CliError;
use crate::output::{Output, table};

/// Put points of the body at given places at given times; the rest of the motion follows as little as it takes.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  lifelike motion place builtin:point --key right_hand@1.6+=0.05,0,0.05 \\
      -o data/directed --name point_higher
  lifelike motion place data/lima/wave.motion.safetensors --key right_hand@2=0.2,-0.25,0.7 \\
      --key left_hand@2=0.2,0.1,0.6 --before 0.6 --after 0.4 -o data/directed --name both_hands
  lifelike motion place data/lima/wave.motion.safetensors \\
      --key 'left_forearm[0,0,-0.1]@1.5+=0,0,0.1' -o data/directed

A key is BODY@SECONDS=X,Y,Z (m, world) or BODY@SECONDS+=X,Y,Z (m from where the clip has it). BODY is a site, a body, or
a role such as right_hand; a point in its frame may follow in brackets. Feet that stand stay where they are, joints
within their ranges and speeds. A place out of reach is approached; the table says how much is missing.
The result is called NAME-placed where no --name is given.")]
pub struct Args {
    /// The clip.
    pub input: PathBuf,
    /// A body, its time and its target; may be given several times.
    #[arg(short, long = "key", value_name = "BODY@SECONDS[+]=X,Y,Z", value_parser = key, required = true)]
    pub keys: Vec<Key>,
    /// Time before each key at which the motion begins to deviate (s).
    #[arg(long, default_value_t = 0.5)]
    pub before: f64,
    /// Time after each key at which the motion is its own again (s).
    #[arg(long, default_value_t = 0.5)]
    pub after: f64,
    /// Folder, name and robot of the result.
    #[command(flatten)]
    pub common: Common,
}

/// Reads a key; its windows are filled in later.
fn key(text: &str) -> Result<Key, String> {
    let read = || {
        let (left, place) = text.split_once('=')?;
        let (left, by) = left.strip_suffix('+').map_or((left, false), |left| (left, true));
        let (body, time) = left.rsplit_once('@')?;
        let (body, point) = match body.strip_suffix(']').and_then(|b| b.split_once('[')) {
            Some((body, point)) => (body, Some(vector(point)?)),
            None => (body, None),
        };
        let place = vector(place)?;
        let target = if by { Target::By(place) } else { Target::At(place) };
        let time = time.trim().parse().ok()?;
        Some(Key { body: body.trim().into(), point, time, target, before: 0.0, after: 0.0 })
    };
    read().ok_or_else(|| format!("expected BODY@SECONDS=X,Y,Z or BODY@SECONDS+=X,Y,Z, got '{text}'"))
}

fn vector(text: &str) -> Option<Vec3> {
    let numbers: Option<Vec<f64>> = text.split(',').map(|n| n.trim().parse().ok()).collect();
    let [x, y, z] = <[f64; 3]>::try_from(numbers?).ok()?;
    Some(Vec3::new(x, y, z))
}

/// Runs the command.
pub fn run(args: &Args, output: &Output) -> Result<(), CliError> {
    let stage = args.common.stage([args.input.as_path()])?;
    let clip = stage.clip(&args.input)?;
    let windows = |key: &Key| Key { before: args.before, after: args.after, ..key.clone() };
    let keys: Vec<Key> = args.keys.iter().map(windows).collect();
    let robot = &stage.robot;
    let (mut out, report) = edit::place(&clip, &robot.character, &robot.anatomy, &keys, &stage.options)?;
    out.name = format!("{}-placed", clip.name);
    let made = args.common.write(out, &stage)?;
    output.result(&json!({ "made": made, "placed": report }), || format!("{}\n{}", made.text(), text(&report)))
}

fn text(report: &PlaceReport) -> String {
    let place = |p: &[f64; 3]| format!("{:.3} {:.3} {:.3}", p[0], p[1], p[2]);
    let row = |k: &edit::place::Placed| {
        let missing = format!("{:.1}", k.residual * 1e3);
        vec![k.body.clone(), format!("{:.2}", k.time), place(&k.was), place(&k.asked), place(&k.reached), missing]
    };
    let rows: Vec<Vec<String>> = report.keys.iter().map(row).collect();
    let mut text = table(&["body", "at s", "was (m)", "asked (m)", "is (m)", "missing mm"], &rows);
    text += &format!("{} frames changed; standing feet moved by {:.2} mm\n", report.frames, report.feet_moved * 1e3);
    let [now, before] = report.self_penetration;
    // A millimetre is within what the shapes are worth.
    if now > before + 1e-3 {
        text += &format!("parts are {:.0} mm deep in each other (before: {:.0} mm)\n", now * 1e3, before * 1e3);
    }
    let [now, before] = report.lowest;
    if now < before.min(0.0) - 1e-3 {
        text += &format!("it reaches {:.0} mm below the ground (before: {:.0} mm)\n", -now * 1e3, -before * 1e3);
    }
    text
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn keys_are_read() {
        let read = key("right_hand@1.5=0.2,-0.25,0.7").unwrap();
        assert_eq!((read.body.as_str(), read.time, read.point), ("right_hand", 1.5, None));
        assert_eq!(read.target, Target::At(Vec3::new(0.2, -0.25, 0.7)));
        let read = key("left_forearm[0,0,-0.1]@2+=0,0,0.1").unwrap();
        assert_eq!((read.body.as_str(), read.point), ("left_forearm", Some(Vec3::new(0.0, 0.0, -0.1))));
        assert_eq!(read.target, Target::By(Vec3::new(0.0, 0.0, 0.1)));
        for bad in
            ["right_hand=1,2,3", "right_hand@x=1,2,3", "right_hand@1=1,2", "right_hand@1=1,2,3,4", "hand[1]@1=1,2,3"]
        {
            assert!(key(bad).unwrap_err().contains(bad), "{bad}");
        }
    }
}
