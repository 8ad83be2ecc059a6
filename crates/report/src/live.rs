//! A page that follows a run while it goes on: `live.html`, which reads the scripts beside it again and again.

use std::path::{Path, PathBuf};

use serde_json::json;

use super::ReportBuilder;
use crate::{ReportError, write_atomically};

const STATE: &str = "live-state.js";
const MOTION: &str = "live-motion.js";

/// The files of a live page. They need no server: a browser that has the page open as a file loads them.
#[derive(Debug)]
pub struct LivePage {
    folder: PathBuf,
    /// Number of the motion that was written last, from 1.
    motion: u64,
}

impl LivePage {
    /// Writes a page that is still empty, with the title of `report`.
    ///
    /// # Errors
    /// [`ReportError::Input`].
    pub fn begin(folder: &Path, report: &ReportBuilder) -> Result<Self, ReportError> {
        let live = Self { folder: folder.to_path_buf(), motion: 0 };
        live.show(report, false)?;
        let page = report.page(&json!({ "state": STATE, "motion": MOTION }));
        write_atomically(&live.path(), page.as_bytes())?;
        Ok(live)
    }

    /// Returns the page to open.
    pub fn path(&self) -> PathBuf {
        self.folder.join("live.html")
    }

    /// Shows facts and curves; with `done` the page stops asking for more.
    ///
    /// # Errors
    /// [`ReportError::Input`].
    pub fn show(&self, report: &ReportBuilder, done: bool) -> Result<(), ReportError> {
        write_atomically(&self.folder.join(STATE), report.state(self.motion, done).as_bytes())
    }

    /// Shows the playbacks of a report in place of those before, from the next [`Self::show`] on.
    ///
    /// # Errors
    /// [`ReportError::Input`].
    pub fn show_motion(&mut self, report: &ReportBuilder) -> Result<(), ReportError> {
        write_atomically(&self.folder.join(MOTION), report.motion().as_bytes())?;
        self.motion += 1;
        Ok(())
    }
}
