//! Shared parts of the commands that make motion from motion: robot and clips in, a clip with a name and a report out.

use std::path::{Path, PathBuf};

use lifelike_motion::edit::{TooFast, joints_of, too_fast};
use lifelike_motion::retarget::RetargetOptions;
use lifelike_motion::{MotionClip, container, dataset};
use lifelike_robot::Robot;

use super::file_of;
use crate::commands::clips;
use crate::destination;
use crate::error::CliError;
use crate::next::NextCommand;
use crate::output::{Output, table};
use crate::shipped;

/// Folder, name and robot of the result.
#[derive(Debug, clap::Args)]
pub struct Common {
    /// Folder of the result, or its file (NAME.motion.safetensors).
    #[arg(short, long, value_parser = crate::destination::motion)]
    pub output: PathBuf,
    /// Name of the result, so of its file; told from the inputs where not given.
    #[arg(long)]
    pub name: Option<String>,
    /// A robot's name, or its MJCF or URDF file; the robot that the clip was made for where not given.
    #[arg(short, long)]
    pub robot: Option<String>,
    /// Layout of the motion.
    #[command(flatten)]
    pub layout: clips::LayoutArgument,
}

/// A robot, and how its motion is to be solved for.
pub struct Stage {
    /// Name or file of the robot.
    name: String,
    layout: clips::LayoutArgument,
    pub robot: Robot,
    /// At the robot's rate, with the speeds that its actuators allow.
    pub options: RetargetOptions,
}

/// A clip that was written.
#[derive(Debug, serde::Serialize)]
pub struct Made {
    clip: String,
    fps: f64,
    frames: usize,
    seconds: f64,
    file: PathBuf,
    /// Joints that are faster than retargeting would let them be.
    too_fast: Vec<TooFast>,
    /// The step after this one.
    next: String,
}

impl Common {
    /// The robot that is asked for, else the one of the first clip that names one, else the default of retargeting.
    pub fn stage<'a>(&self, inputs: impl IntoIterator<Item = &'a Path>) -> Result<Stage, CliError> {
        let given = self.robot.is_some();
        let name = match &self.robot {
            Some(name) => name.clone(),
            None => character_of(inputs)?.unwrap_or_else(|| "lima".into()),
        };
        let whose = |error| {
            if given {
                CliError::from(error)
            } else {
                CliError::Input(format!("{error}; name the motion's robot with --robot"))
            }
        };
        let robot = Robot::load(&name).map_err(whose)?;
        let mut options = clips::retarget_options(&robot);
        clips::limit_speeds(&mut options, &robot);
        Ok(Stage { name, layout: self.layout, robot, options })
    }

    /// Changes each clip of the inputs and writes it, under the given name or its own with `suffix`.
    pub fn each(
        &self,
        inputs: &[PathBuf],
        suffix: &str,
        output: &Output,
        change: impl Fn(&MotionClip, &Stage) -> Result<MotionClip, CliError>,
    ) -> Result<(), CliError> {
        let stage = self.stage(inputs.iter().map(PathBuf::as_path))?;
        let clips = stage.clips(inputs)?;
        let one = self.name.as_ref().map(|name| format!("--name '{name}'"));
        let one = one.or(destination::is_motion(&self.output).then(|| format!("-o '{}'", self.output.display())));
        if let (Some(one), true) = (one, clips.len() > 1) {
            let message = format!("{one} is for one clip, but the inputs hold {}; name a folder with -o", clips.len());
            return Err(CliError::Usage(message));
        }
        let mut made = Vec::with_capacity(clips.len());
        for clip in clips {
            let mut changed = change(&clip, &stage)?;
            changed.name = format!("{}-{suffix}", clip.name);
            made.push(self.write(changed, &stage)?);
        }
        output.result(&made, || {
            let lines: String = made.iter().map(Made::line).collect();
            lines + &made.last().map_or_else(String::new, Made::next)
        })
    }

    /// Writes a clip under the given name, else under its own.
    pub fn write(&self, mut clip: MotionClip, stage: &Stage) -> Result<Made, CliError> {
        if let Some(name) = &self.name {
            clip.name.clone_from(name);
        }
        clip.provenance.character.clone_from(&stage.robot.character.name);
        let file = file_of(&self.output, &mut clip)?;
        container::write(&file, &clip)?;
        let too_fast = too_fast(&clip, &stage.options.velocity_limit);
        let next = stage.next(&file);
        Ok(Made { fps: clip.fps, frames: clip.len(), seconds: clip.seconds(), file, too_fast, next, clip: clip.name })
    }
}

impl Stage {
    /// Returns the step with a clip: physics where the robot has a policy, else a check without.
    fn next(&self, file: &Path) -> String {
        let has_policy = shipped::has_controller(&self.robot);
        let line = NextCommand::new(if has_policy { "demo" } else { "motion check" });
        line.word(file.display()).robot(&self.name).to_string()
    }

    /// The clips of the inputs: all of them, since the result would be another motion without one.
    pub fn clips(&self, inputs: &[PathBuf]) -> Result<Vec<MotionClip>, CliError> {
        Ok(lifelike_robot::clips::load_as(inputs, self.layout.layout, &self.robot)?.all()?)
    }

    /// The one clip of an input.
    pub fn clip(&self, input: &Path) -> Result<MotionClip, CliError> {
        Ok(clips::load_one_as(input, self.layout.layout, &self.robot)?)
    }

    /// Joints by the names of joints and parts of the body.
    pub fn joints(&self, names: &[String]) -> Result<Vec<String>, CliError> {
        Ok(joints_of(&self.robot.character, &self.robot.anatomy, names)?)
    }
}

impl Made {
    /// Returns all of it for people.
    pub fn text(&self) -> String {
        self.line() + &self.next()
    }

    fn next(&self) -> String {
        format!("next:\n  {}\n", self.next)
    }

    fn line(&self) -> String {
        let mut text = format!(
            "{}: {:.2} s, {} frames at {} Hz: {}\n",
            self.clip,
            self.seconds,
            self.frames,
            self.fps,
            self.file.display()
        );
        if !self.too_fast.is_empty() {
            let rows = self.too_fast.iter().map(|f| {
                vec![
                    f.joint.clone(),
                    format!("{:.1}", f.speed),
                    format!("{:.1}", f.limit),
                    format!("{:.2}", f.time),
                    f.frames.to_string(),
                ]
            });
            text += "faster than retargeting lets a joint be (80% of what its actuator can):\n";
            text += &table(&["joint", "rad/s", "limit", "at s", "steps"], &rows.collect::<Vec<_>>());
        }
        text
    }
}

/// The character that the first motion file among the inputs was made for.
fn character_of<'a>(inputs: impl IntoIterator<Item = &'a Path>) -> Result<Option<String>, CliError> {
    for input in inputs {
        // What is wrong with an input is told when it is loaded.
        let files = dataset::find_motion(&[input.to_path_buf()], |format| !format.is_source()).unwrap_or_default();
        if let Some(file) = files.iter().find(|file| container::FORMAT.is_named(file)) {
            let character = container::read(file)?.provenance.character;
            if !character.is_empty() {
                return Ok(Some(character));
            }
        }
    }
    Ok(None)
}
