//! `train --watch`: a page that follows the training, with the robot moved by the newest policy.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant, SystemTime};

use lifelike_evaluation::EvaluationOptions;
use lifelike_motion::MotionClip;
use lifelike_report::run::RunFolder;
use lifelike_report::{LivePage, ReportBuilder, curves_from};
use lifelike_robot::Robot;

use crate::commands::controller_file::Loaded;
use crate::commands::eval::Job;
use crate::commands::physics::Physics;
use crate::error::CliError;
use crate::output::Output;

/// Time between two looks at the curves.
const EVERY: Duration = Duration::from_secs(4);
/// Clips that the newest policy follows.
const CLIPS: usize = 4;
/// Longest time that it follows one (s).
const SECONDS: f64 = 6.0;

/// The policy of a training, to be seen at each checkpoint.
pub struct Look<'a> {
    /// File of the policy, written with each checkpoint.
    pub policy: PathBuf,
    /// Its motion prior, where it has one.
    pub prior: Option<&'a Path>,
    /// The robot.
    pub robot: Arc<Robot>,
    /// Clips to follow.
    pub clips: Vec<MotionClip>,
    /// The physics.
    pub physics: &'a Physics,
}

impl<'a> Look<'a> {
    /// Chooses a few clips of those that are learned, spread over them.
    pub fn new(
        policy: PathBuf,
        prior: Option<&'a Path>,
        robot: Arc<Robot>,
        clips: Vec<MotionClip>,
        physics: &'a Physics,
    ) -> Self {
        let every = clips.len().div_ceil(CLIPS).max(1);
        Self { policy, prior, robot, clips: clips.into_iter().step_by(every).collect(), physics }
    }

    /// Lets the policy follow the clips; returns a report that plays them.
    fn play(&self) -> Result<ReportBuilder, CliError> {
        let loaded = Loaded::new(&self.policy, Arc::clone(&self.robot), self.prior)?;
        let options = EvaluationOptions { seconds: SECONDS, starts: 1, ..EvaluationOptions::default() };
        let quiet = Output { json: false, quiet: true, silent: true };
        let evaluation = Job { loaded: &loaded, physics: self.physics }.run(&self.clips, &options, &quiet)?;
        Ok(ReportBuilder::new("").playback(&self.robot.character, &evaluation.playbacks()))
    }
}

/// A live page and what it shows.
pub struct Watch<'a> {
    page: LivePage,
    folder: &'a RunFolder,
    headlines: &'static [&'static str],
    look: Option<&'a Look<'a>>,
    /// When the policy that was seen last was written.
    seen: Option<SystemTime>,
    last: Instant,
}

impl<'a> Watch<'a> {
    /// Writes the page, and says where it is.
    pub fn begin(
        folder: &'a RunFolder,
        headlines: &'static [&'static str],
        look: Option<&'a Look<'a>>,
    ) -> Result<Self, CliError> {
        let title = format!("Training of {}", folder.path().display());
        let page = LivePage::begin(folder.path(), &ReportBuilder::new(title).fact("state", "begins"))?;
        let path = std::path::absolute(page.path()).unwrap_or_else(|_| page.path());
        tracing::info!("open this in a browser: {}", path.display());
        Ok(Self { page, folder, headlines, look, seen: None, last: Instant::now() })
    }

    /// Returns whether it is time to show more.
    pub fn is_due(&self) -> bool {
        self.last.elapsed() >= EVERY
    }

    /// Shows these facts and the curves so far; a policy that was not seen yet, too.
    pub fn show(&mut self, facts: &[(&str, String)], done: bool) -> Result<(), CliError> {
        self.last = Instant::now();
        if let Some(look) = self.look
            && let Some(written) = std::fs::metadata(&look.policy).and_then(|file| file.modified()).ok()
            && self.seen != Some(written)
        {
            self.seen = Some(written);
            self.page.show_motion(&look.play()?)?;
        }
        let report = facts.iter().fold(ReportBuilder::new(""), |report, (name, text)| report.fact(name, text.as_str()));
        let curves = curves_from(&self.folder.metrics()?);
        self.page.show(&report.headlines(self.headlines).curves(curves), done)?;
        Ok(())
    }
}
