//! Clips that are like the motion at a moment, by the codes of a motion prior (thesis 4.3.2, Fig. 4.3).

use std::path::{Path, PathBuf};
use std::sync::Arc;

use lifelike_motion::MotionClip;
use lifelike_motion::features::frames_of;
use lifelike_motion::resample::resample;
use lifelike_representation::latent::Codes;
use lifelike_representation::latent::search::{SearchSpec, search};
use lifelike_representation::{MotionPrior, PriorClip};
use lifelike_robot::{Robot, clips};
use serde::Serialize;

use crate::StudioError;
use crate::files;
use crate::workshop::inside;

/// Most clips that are found.
const COUNT: usize = 6;
/// Most clips that are searched: ours, then those of the folder.
const SEARCHED: usize = 600;

/// A clip with a moment that is alike.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Alike {
    /// The clip, as [`crate::Operation::Add`] takes it.
    pub clip: String,
    /// The moment (s).
    pub time: f64,
    /// Cosine of the angle between the codes.
    pub similarity: f64,
}

/// A search among the clips of the program and of the folder.
pub struct Similar {
    robot: Arc<Robot>,
    prior: Option<Arc<MotionPrior>>,
    folder: PathBuf,
    /// Clips that were read, and their codes.
    known: Option<(Vec<String>, Codes)>,
}

impl Similar {
    /// Returns a search for a robot.
    pub fn new(robot: Arc<Robot>, prior: Option<Arc<MotionPrior>>, folder: PathBuf) -> Self {
        Self { robot, prior, folder, known: None }
    }

    /// Returns the clips that are most like a motion at a moment (s), each once and the best first, but for one clip.
    ///
    /// # Errors
    /// There is no motion prior for the robot, or no clip that it can encode.
    pub fn to(&mut self, motion: &MotionClip, at: f64, but: Option<&str>) -> Result<Vec<Alike>, StudioError> {
        let failed = |error: lifelike_representation::RepresentationError| StudioError::Operation(error.to_string());
        let Some(prior) = self.prior.clone() else {
            let message = format!("no motion prior for '{}' comes with the program", self.robot.name);
            return Err(StudioError::Operation(message));
        };
        let names: Vec<String> = files::clips(&self.folder).into_iter().take(SEARCHED).collect();
        if self.known.as_ref().is_none_or(|(known, _)| *known != names) {
            let clips: Vec<PriorClip> = names.iter().filter_map(|name| self.read(name, &prior)).collect();
            self.known = Some((names, Codes::of_prior(&prior, &clips).map_err(failed)?));
        }
        let Some((_, codes)) = &self.known else { return Ok(Vec::new()) };
        let query = Codes::of_prior(&prior, &[self.prepared("scene", motion, &prior)?]).map_err(failed)?;
        let frame = ((at * prior.windows().frame_rate).round() as usize).min(query.len().saturating_sub(1));
        let spec = SearchSpec { count: codes.len(), ..SearchSpec::default() };
        let mut found: Vec<Alike> = Vec::new();
        for hit in search(codes, query.row(frame), None, &spec).map_err(failed)? {
            if but != Some(hit.clip.as_str()) && found.iter().all(|one| one.clip != hit.clip) {
                found.push(Alike { clip: hit.clip, time: hit.time, similarity: hit.similarity });
            }
            if found.len() == COUNT {
                break;
            }
        }
        Ok(found)
    }

    /// Returns a clip as the prior takes it; none for a file that cannot be read.
    fn read(&self, name: &str, prior: &MotionPrior) -> Option<PriorClip> {
        let path = PathBuf::from(name);
        let path = if clips::is_builtin(&path) { path } else { inside(&self.folder, Path::new(name)).ok()? };
        self.prepared(name, &clips::load_one(&path, &self.robot).ok()?, prior).ok()
    }

    fn prepared(&self, name: &str, clip: &MotionClip, prior: &MotionPrior) -> Result<PriorClip, StudioError> {
        let clip = resample(clip, prior.windows().frame_rate)?;
        Ok(PriorClip { name: name.into(), frames: frames_of(&clip, &self.robot.character, &self.robot.effectors)? })
    }
}
