//! `lifelike motion convert`: the motion of a robot at another rate, or as a table.

use std::fmt::Write as _;
use std::path::PathBuf;

use clap::ValueEnum;
use lifelike_character::rotation::to_wxyz;
use lifelike_motion::resample::resample;
use lifelike_motion::{MotionClip, container, dataset};
use serde_json::json;

use super::container_in;
use crate::destination;
use crate::error::CliError;
use crate::output::{Output, table};

/// Convert the motion of robots: to another rate, or to a table that spreadsheets and scripts read.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  lifelike motion convert motions/lima --fps 100 -o motions/lima-100
  lifelike motion convert wave.motion.safetensors --to csv -o tables")]
pub struct Args {
    /// *.motion.safetensors files, folders of them, or patterns such as 'lima/walk*.safetensors'.
    #[arg(required = true)]
    pub inputs: Vec<PathBuf>,
    /// Folder of the results.
    #[arg(short, long, value_parser = crate::destination::folder)]
    pub output: PathBuf,
    /// Frames per second; as they are where not given.
    #[arg(long)]
    pub fps: Option<f64>,
    /// Format of the results.
    #[arg(long, value_enum, default_value = "motion")]
    pub to: Format,
}

/// Formats of results.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Format {
    /// *.motion.safetensors
    Motion,
    /// Comma-separated: time, root position (m), root quaternion (wxyz), then the joints by name (rad).
    Csv,
}

/// Runs the command.
pub fn run(args: &Args, output: &Output) -> Result<(), CliError> {
    let clips = dataset::load_clips(&args.inputs)?;
    std::fs::create_dir_all(&args.output).map_err(CliError::write(&args.output))?;
    let mut done = Vec::new();
    for clip in clips {
        let clip = args.fps.map_or_else(|| Ok(clip.clone()), |fps| resample(&clip, fps))?;
        let path = match args.to {
            Format::Motion => {
                let path = container_in(&args.output, &clip.name)?;
                container::write(&path, &clip)?;
                path
            }
            Format::Csv => {
                let path = destination::named(&args.output, &clip.name, ".csv")?;
                crate::output::write(&path, csv(&clip))?;
                path
            }
        };
        done.push((clip.name, clip.fps, clip.root_position.len(), path));
    }
    let value: Vec<_> = done
        .iter()
        .map(|(name, fps, frames, path)| json!({ "clip": name, "fps": fps, "frames": frames, "file": path }))
        .collect();
    output.result(&value, || {
        let rows: Vec<Vec<String>> = done
            .iter()
            .map(|(name, fps, frames, path)| {
                vec![name.clone(), fps.to_string(), frames.to_string(), path.display().to_string()]
            })
            .collect();
        table(&["clip", "frames/s", "frames", "file"], &rows)
    })
}

/// One row per frame. Numbers are written so that they read back to the same value.
fn csv(clip: &MotionClip) -> String {
    let mut text = String::from("time_s,root_x_m,root_y_m,root_z_m,root_qw,root_qx,root_qy,root_qz");
    for name in &clip.joint_names {
        let _ = write!(text, ",{}", name.replace([',', '"', '\n'], "_"));
    }
    text.push('\n');
    for i in 0..clip.len() {
        let _ = write!(text, "{}", i as f64 / clip.fps);
        let root = clip.root_position[i].iter().copied().chain(to_wxyz(&clip.root_orientation[i]));
        root.chain(clip.joints_at(i).iter().copied()).for_each(|v| {
            let _ = write!(text, ",{v}");
        });
        text.push('\n');
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use lifelike_character::{Quat, Vec3};
    use lifelike_motion::Provenance;

    #[test]
    fn a_table_has_a_head_and_a_row_per_frame() {
        let clip = MotionClip {
            name: "c".into(),
            fps: 4.0,
            joint_names: vec!["knee".into(), "a,b".into()],
            root_position: vec![Vec3::new(1.0, 2.0, 0.1), Vec3::zeros()],
            root_orientation: vec![Quat::identity(); 2],
            joints: vec![0.5, -0.25, 1.0, 2.0],
            contacts: None,
            cyclic: false,
            provenance: Provenance::default(),
        };
        let text = csv(&clip);
        let lines: Vec<&str> = text.lines().collect();
        assert!(lines[0].ends_with("root_qz,knee,a_b"));
        assert_eq!(lines[1], "0,1,2,0.1,1,0,0,0,0.5,-0.25");
        assert_eq!(lines[2], "0.25,0,0,0,1,0,0,0,1,2");
    }
}
