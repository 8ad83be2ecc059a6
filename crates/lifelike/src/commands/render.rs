//! `lifelike render`: motion as a picture or a film, without a display.

use std::path::{Path, PathBuf};

use lifelike_report::film::{self, Camera, Film, ReferenceView, View};
use lifelike_report::{Playback, ReportBuilder};
use lifelike_robot::Robot;
use serde_json::json;

use crate::bounds;
use crate::commands::clips;
use crate::error::CliError;
use crate::output::Output;
use crate::progress::Progress;

/// Longest film (frames): an hour at 60 frames a second is a mistake.
const MAX_FRAMES: usize = 36_000;

/// Render motion to a film or a picture, without a display.
///
/// The input is a folder with a report, a report page, or a clip. An evaluation shows physics with its reference.
/// The page's renderer draws in a headless Chromium where one is installed; elsewhere a software rasterizer does.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  lifelike render report -o walk.mp4 --clip walk     # report: a folder of `lifelike eval`
  lifelike render builtin:wave -o wave.gif --size 480x360
  lifelike render dance.motion.safetensors --robot lima -o dance.png --at 1.5 --dark
  lifelike render report -o beside.mp4 --reference beside --azimuth 90 --fps 60

MP4 is H.264 and needs Chromium. LIFELIKE_BROWSER names another browser; empty, it forces the rasterizer.")]
pub struct Args {
    /// The folder of an evaluation, a report page (*.html), or a clip.
    pub input: PathBuf,
    /// Layout of the motion.
    #[command(flatten)]
    pub layout: clips::LayoutArgument,
    /// The picture (*.png) or film (*.mp4, *.gif).
    #[arg(short, long, value_parser = picture)]
    pub output: PathBuf,
    /// Clip on the page, by its name or number from 0; the first where not given.
    #[arg(long)]
    pub clip: Option<String>,
    /// Robot of a clip: a name, or an MJCF or URDF file [default: lima].
    #[arg(short, long)]
    pub robot: Option<String>,
    /// Width and height (pixels) [default: 1280x720; for a GIF 640x360].
    #[arg(long, value_parser = size, value_name = "WIDTHxHEIGHT")]
    pub size: Option<(u32, u32)>,
    /// Frames per second [default: 30; for a GIF 20].
    #[arg(long, allow_negative_numbers = true)]
    pub fps: Option<f64>,
    /// Begin of the film [default: 0] (s).
    #[arg(long, value_name = "SECONDS")]
    pub from: Option<f64>,
    /// End of the film; that of the clip where not given (s).
    #[arg(long, value_name = "SECONDS")]
    pub to: Option<f64>,
    /// Instant of a picture; the middle of the clip where not given (s).
    #[arg(long, value_name = "SECONDS", conflicts_with_all = ["from", "to", "fps"])]
    pub at: Option<f64>,
    /// Direction of the camera from the robot, 0 along x, counterclockwise (degrees).
    #[arg(long, default_value_t = -52.0, allow_negative_numbers = true, value_name = "DEGREES")]
    pub azimuth: f64,
    /// Angle of the camera above the ground (degrees).
    #[arg(long, default_value_t = 11.5, allow_negative_numbers = true, value_name = "DEGREES")]
    pub elevation: f64,
    /// Distance of the camera (heights of the robot).
    #[arg(long, default_value_t = 2.6, value_name = "HEIGHTS")]
    pub distance: f64,
    /// Place of the reference beside physics.
    #[arg(long, value_enum, default_value_t = Reference::Overlay)]
    pub reference: Reference,
    /// Draw no ground forces and planned contacts.
    #[arg(long)]
    pub no_contacts: bool,
    /// Keep the camera where the clip begins, instead of following the robot.
    #[arg(long)]
    pub still: bool,
    /// Draw on a dark ground.
    #[arg(long)]
    pub dark: bool,
    /// Draw with the software rasterizer although there is a browser.
    #[arg(long)]
    pub software: bool,
}

/// Place of the reference.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Reference {
    /// Transparent over the robot.
    Overlay,
    /// Beside the robot.
    Beside,
    /// Not drawn.
    Off,
}

impl Args {
    fn view(&self, clip: usize) -> View {
        let size = self.size.unwrap_or(if self.ending() == "gif" { (640, 360) } else { (1280, 720) });
        let reference = match self.reference {
            Reference::Overlay => ReferenceView::Overlay,
            Reference::Beside => ReferenceView::Beside,
            Reference::Off => ReferenceView::Off,
        };
        View {
            clip,
            size,
            azimuth: self.azimuth.to_radians(),
            elevation: self.elevation.to_radians(),
            distance: self.distance,
            dark: self.dark,
            reference,
            contacts: !self.no_contacts,
            follow: !self.still,
        }
    }

    fn ending(&self) -> &str {
        self.output.extension().and_then(|e| e.to_str()).unwrap_or_default()
    }

    /// Checks the numbers that the parser does not.
    fn check(&self) -> Result<(), CliError> {
        let within = |name: &str, value: f64, low: f64, high: f64| {
            let good = (low..=high).contains(&value);
            let text = || CliError::Usage(format!("{name}: expected {low} to {high}, got {value}"));
            if good { Ok(()) } else { Err(text()) }
        };
        within("--azimuth", self.azimuth, -360.0, 360.0)?;
        within("--elevation", self.elevation, -5.0, 89.0)?;
        within("--distance", self.distance, 0.2, 100.0)
    }

    /// Returns the instants of a film within a clip of this length (s).
    fn times(&self, seconds: f64, fps: f64) -> Result<Vec<f64>, CliError> {
        let (from, to) = (self.from.unwrap_or(0.0), self.to.unwrap_or(seconds));
        if !(from >= 0.0 && to > from && to <= seconds + 1e-9) {
            let text = format!("--from and --to: expected 0 <= from < to <= {seconds:.2} s, got {from} and {to}");
            return Err(CliError::Usage(text));
        }
        let frames = ((to - from) * fps).round().max(1.0) as usize;
        if frames > MAX_FRAMES {
            let text = format!("expected at most {MAX_FRAMES} frames, got {frames}; take a part with --from and --to");
            return Err(CliError::Usage(text));
        }
        Ok((0..frames).map(|i| from + i as f64 / fps).collect())
    }
}

/// Parses the name of a picture or film.
fn picture(text: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    match path.extension().and_then(|e| e.to_str()) {
        Some("png" | "gif" | "mp4") if !path.is_dir() => crate::destination::has_folder(&path).map(|()| path),
        _ => Err("expected NAME.mp4, NAME.gif or NAME.png".into()),
    }
}

/// Parses a size in pixels. H.264 halves colours, so both numbers are even.
fn size(text: &str) -> Result<(u32, u32), String> {
    let numbers = text.split_once('x').and_then(|(w, h)| Some((w.parse().ok()?, h.parse().ok()?)));
    match numbers {
        Some((w, h)) if [w, h].iter().all(|n: &u32| (16..=4096).contains(n) && n.is_multiple_of(2)) => Ok((w, h)),
        _ => Err("expected WIDTHxHEIGHT with even numbers of 16 to 4096 pixels, such as 1280x720".into()),
    }
}

/// Runs the command.
///
/// # Errors
/// The input has no motion, or the browser fails.
pub fn run(args: &Args, output: &Output) -> Result<(), CliError> {
    bounds::picture_rate("--fps", args.fps)?;
    args.check()?;
    let film = load(args)?;
    let clip = chosen(&film, args.clip.as_deref(), &args.input)?;
    let mut camera = film.camera(&args.view(clip), args.software)?;
    let (bytes, frames) = drawn(args, &mut camera, output)?;
    crate::output::write(&args.output, &bytes)?;
    let (name, _) = &film.clips()[clip];
    let renderer = camera.renderer();
    let value = json!({
        "file": args.output, "clip": name, "frames": frames, "bytes": bytes.len(), "renderer": renderer,
    });
    output.result(&value, || {
        let plural = if frames == 1 { "" } else { "s" };
        let size = bytes.len() as f64 / 1e6;
        let file = args.output.display();
        format!("{file}: {name}, {frames} frame{plural}, {size:.2} MB\ndrawn by {renderer}\n")
    })
}

/// Draws the picture or film; returns its bytes and number of frames.
fn drawn(args: &Args, camera: &mut Camera, output: &Output) -> Result<(Vec<u8>, usize), CliError> {
    if args.ending() == "png" {
        if args.from.is_some() || args.to.is_some() || args.fps.is_some() {
            return Err(CliError::Usage("--from, --to and --fps: expected a film; a picture has --at".into()));
        }
        let time = args.at.unwrap_or(camera.seconds / 2.0);
        if !(0.0..=camera.seconds + 1e-9).contains(&time) {
            return Err(CliError::Usage(format!("--at: expected 0 to {:.2} s, got {time}", camera.seconds)));
        }
        return Ok((film::png(camera, time)?, 1));
    }
    if args.at.is_some() {
        return Err(CliError::Usage("--at: expected a picture (*.png); a film has --from and --to".into()));
    }
    let is_gif = args.ending() == "gif";
    let fps = args.fps.unwrap_or(if is_gif { 20.0 } else { 30.0 });
    let times = args.times(camera.seconds, fps)?;
    let mut progress = Progress::new(output, "rendering", times.len() as u64);
    let total = times.len() as u64;
    let advance = |done: usize| progress.update(done as u64, total, String::new);
    let bytes = if is_gif { film::gif(camera, &times, fps, advance) } else { film::mp4(camera, &times, fps, advance) }?;
    progress.finish();
    Ok((bytes, times.len()))
}

/// Reads the page, or makes one of a clip.
fn load(args: &Args) -> Result<Film, CliError> {
    let page = args.input.join("report.html");
    let is_page = |path: &Path| path.extension().is_some_and(|e| e == "html");
    let page = if page.is_file() { Some(page) } else { Some(args.input.clone()).filter(|path| is_page(path)) };
    if let Some(page) = page {
        if let Some(robot) = &args.robot {
            return Err(CliError::Usage(format!("--robot {robot}: expected a clip, got a page with its own robot")));
        }
        return Ok(Film::read(&page)?);
    }
    let robot = Robot::load(args.robot.as_deref().unwrap_or("lima"))?;
    let mut page = ReportBuilder::new("");
    for clip in clips::load_as(std::slice::from_ref(&args.input), args.layout, &robot)? {
        let playback = Playback::from_clip(&robot.character, &clip)?;
        page = page.playback(&robot.character, &[playback.with_contacts(&robot.character, &robot.anatomy, &clip)]);
    }
    Ok(Film::new(&page)?)
}

/// Returns the number of the clip that is named.
fn chosen(film: &Film, wanted: Option<&str>, input: &Path) -> Result<usize, CliError> {
    let names: Vec<String> = film.clips().into_iter().map(|(name, _)| name).collect();
    let Some(wanted) = wanted else { return Ok(0) };
    let by_name = names.iter().position(|name| name == wanted);
    let number = || wanted.parse().ok().filter(|i| *i < names.len());
    by_name.or_else(number).ok_or_else(|| {
        let listed: Vec<&str> = names.iter().take(12).map(String::as_str).collect();
        let text = format!("{}: expected one of its clips ({}), got '{wanted}'", input.display(), listed.join(", "));
        CliError::Input(text)
    })
}
